//! Hotelling's T^2 of the mean of vectors of cells, by the covariance that they show.

/// Cells that are left in fewer groups are one.
const FEWEST: usize = 20;

/// T^2 and its degrees of freedom, of the mean of d; `is_closed` if the entries of each d sum to zero.
pub fn statistic(all: &[Vec<f64>], is_closed: bool) -> (f64, usize) {
    // Cells that change often; the rest is one cell, which the sum of zero makes redundant.
    let often: Vec<usize> = (0..all[0].len())
        .filter(|c| all.iter().filter(|d| d[*c] != 0.0).count() >= FEWEST)
        .collect();
    let rest = all
        .iter()
        .filter(|d| (0..d.len()).any(|c| d[c] != 0.0 && !often.contains(&c)))
        .count();
    let used = if rest >= FEWEST || often.is_empty() || !is_closed {
        &often[..]
    } else {
        &often[..often.len() - 1]
    };
    let (n, m) = (all.len() as f64, used.len());
    let mean = |c: usize| all.iter().map(|d| d[used[c]]).sum::<f64>() / n;
    let means: Vec<f64> = (0..m).map(mean).collect();
    let mut matrix = vec![vec![0.0; m + 1]; m];
    for i in 0..m {
        for j in 0..m {
            let products = all
                .iter()
                .map(|d| (d[used[i]] - means[i]) * (d[used[j]] - means[j]));
            matrix[i][j] = products.sum::<f64>() / ((n - 1.0) * n);
        }
        matrix[i][m] = means[i];
    }
    // Gauss-Jordan: the last column becomes the covariance's inverse times the means.
    let mut rank = 0;
    for i in 0..m {
        let pivot = matrix[i][i];
        if !(pivot > 1e-9 * matrix[0][0].abs()) {
            matrix[i].fill(0.0);
            continue;
        }
        rank += 1;
        matrix[i].iter_mut().for_each(|v| *v /= pivot);
        let row = matrix[i].clone();
        for (j, other) in matrix.iter_mut().enumerate() {
            let factor = other[i];
            if j != i {
                other
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(v, r)| *v -= factor * r);
            }
        }
    }
    let t2 = (0..m).map(|i| means[i] * matrix[i][m]).sum();
    (t2, rank)
}
