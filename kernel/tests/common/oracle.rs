//! Tables of BSDF values from an independent renderer: one comment line, a header, then wi, wo, f, pdf.

use glam::Vec3;

/// One row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Known direction.
    pub wi: Vec3,
    /// Sampled direction.
    pub wo: Vec3,
    /// BSDF without a cosine.
    pub f: Vec3,
    /// Density of wo per solid angle.
    pub pdf: f32,
}

/// All rows of `text`.
///
/// # Panics
/// When a line does not hold ten numbers, or there is none.
pub fn rows(text: &str) -> Vec<Row> {
    let rows: Vec<Row> = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.starts_with("wi_x"))
        .map(|line| {
            let v: Vec<f32> = line.split(',').map(|x| x.parse().unwrap()).collect();
            assert_eq!(v.len(), 10, "{line}");
            Row {
                wi: Vec3::new(v[0], v[1], v[2]),
                wo: Vec3::new(v[3], v[4], v[5]),
                f: Vec3::new(v[6], v[7], v[8]),
                pdf: v[9],
            }
        })
        .collect();
    assert!(
        !rows.is_empty(),
        "an oracle table without rows tests nothing"
    );
    rows
}

/// Largest deviation of `a` from `b`, relative to `b` with the floor `floor` on the denominator.
pub fn relative_error(a: f32, b: f32, floor: f32) -> f32 {
    (a - b).abs() / b.abs().max(floor)
}
