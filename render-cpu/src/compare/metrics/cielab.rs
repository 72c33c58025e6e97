//! CIE L*a*b* of linear sRGB, and the colour difference of 1976.
//!
//! With X/Xn, Y/Yn, Z/Zn relative to the white point D65, which is that of sRGB: RGB (1, 1, 1) is L* = 100, a* = b* = 0,
//!
//! ```text
//! L* = 116 f(Y/Yn) - 16,   a* = 500 (f(X/Xn) - f(Y/Yn)),   b* = 200 (f(Y/Yn) - f(Z/Zn))
//! f(t) = t^(1/3) for t > (6/29)^3, else t / (3 (6/29)^2) + 4/29
//! Delta E = sqrt((L1 - L2)^2 + (a1 - a2)^2 + (b1 - b2)^2)
//! ```
//!
//! (CIE 15:2004, sections 8.2.1.1 and 8.2.1.2). The metric is the mean of Delta E over the pixels. Images are seen as a display
//! shows them: at exposure 0, without a tone curve, linear RGB clamped to [0, 1]; so the difference is between 0 and 258.7
//! (green to blue), about 2.3 is just noticeable, and what is brighter than white differs by nothing.

use super::{RgbImage, assert_same_size};

/// Mean colour difference of 1976.
///
/// # Panics
/// If the sizes differ.
pub fn cie76(image: &RgbImage, reference: &RgbImage) -> f64 {
    assert_same_size(image, reference);
    let pixels = image.pixels.iter().zip(&reference.pixels);
    let sum: f64 = pixels.map(|(a, b)| delta_e(shown(*a), shown(*b))).sum();
    sum / image.pixels.len() as f64
}

/// L*a*b* of a pixel as a display shows it.
fn shown(rgb: [f64; 3]) -> [f64; 3] {
    lab(rgb.map(|v| v.clamp(0.0, 1.0)))
}

/// Euclidean distance of two colours in L*a*b*.
pub fn delta_e(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// L*a*b* of linear sRGB.
pub fn lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = normalized_xyz(rgb).map(|t| {
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear sRGB to CIE XYZ over the white point D65. The matrix is that of the primaries' chromaticities as fractions;
/// its rows are divided by their sums, which are the white point.
const NORMALIZED_XYZ: [[f64; 3]; 3] = {
    let x = [10_135_552.0, 8_788_810.0, 4_435_075.0];
    let y = [2_613_072.0, 8_788_810.0, 887_015.0];
    let z = [1_425_312.0, 8_788_810.0, 70_074_185.0];
    const fn over_sum(row: [f64; 3]) -> [f64; 3] {
        let sum = row[0] + row[1] + row[2];
        [row[0] / sum, row[1] / sum, row[2] / sum]
    }
    [over_sum(x), over_sum(y), over_sum(z)]
};

/// The inverse of [`NORMALIZED_XYZ`], by cofactors.
const RGB_FROM_NORMALIZED_XYZ: [[f64; 3]; 3] = {
    let m = NORMALIZED_XYZ;
    let c = [
        m[1][1] * m[2][2] - m[1][2] * m[2][1],
        m[1][2] * m[2][0] - m[1][0] * m[2][2],
        m[1][0] * m[2][1] - m[1][1] * m[2][0],
    ];
    let determinant = m[0][0] * c[0] + m[0][1] * c[1] + m[0][2] * c[2];
    [
        [
            c[0] / determinant,
            (m[0][2] * m[2][1] - m[0][1] * m[2][2]) / determinant,
            (m[0][1] * m[1][2] - m[0][2] * m[1][1]) / determinant,
        ],
        [
            c[1] / determinant,
            (m[0][0] * m[2][2] - m[0][2] * m[2][0]) / determinant,
            (m[0][2] * m[1][0] - m[0][0] * m[1][2]) / determinant,
        ],
        [
            c[2] / determinant,
            (m[0][1] * m[2][0] - m[0][0] * m[2][1]) / determinant,
            (m[0][0] * m[1][1] - m[0][1] * m[1][0]) / determinant,
        ],
    ]
};

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// CIE XYZ of linear sRGB, each over that of white.
pub fn normalized_xyz(rgb: [f64; 3]) -> [f64; 3] {
    multiply(&NORMALIZED_XYZ, rgb)
}

/// The inverse of [`normalized_xyz`].
pub fn rgb_from_normalized_xyz(xyz: [f64; 3]) -> [f64; 3] {
    multiply(&RGB_FROM_NORMALIZED_XYZ, xyz)
}
