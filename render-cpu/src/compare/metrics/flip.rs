//! FLIP: the difference that an observer sees when two images alternate on a screen.
//!
//! LDR-FLIP: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference Evaluator
//! for Alternating Images". HDR-FLIP: Andersson, Nilsson, Shirley and Akenine-Moeller 2021, "Visualizing Errors in
//! Rendered High Dynamic Range Images". Per pixel, from 0 (equal) to 1 (the largest difference of colours there is):
//!
//! 1. colour: to Y Cx Cz, contrast sensitivity filters (sums of Gaussians) at 67.02 pixels per degree, back to RGB clamped
//!    to [0, 1], to CIELab with Hunt's adjustment, HyAB distance to the power 0.7, compressed so that large distances
//!    take the last twentieth of the range;
//! 2. features: edges and points, by first and second derivatives of a Gaussian as wide as the eye's detectors
//!    (0.082 degrees), the larger of the two differences of magnitude;
//! 3. `FLIP = colour^(1 - feature)`.
//!
//! HDR-FLIP is the largest LDR-FLIP over exposures between the one that shows the brightest pixel of the reference and
//! the one that shows its median, tone mapped.
//!
//! A test compares with the figures of NVIDIA's evaluator.

use super::cielab::{lab, normalized_xyz, rgb_from_normalized_xyz};
use super::convolution::{Border, convolve, gaussian};
use super::{RgbImage, assert_same_size};
use std::f64::consts::PI;

/// Pixels per degree of a 0.7 m wide screen of 3840 pixels seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Exponent of the colour distance.
const COLOR_EXPONENT: f64 = 0.7;
/// Distances up to this share of the largest ...
const LINEAR_SHARE: f64 = 0.4;
/// ... take this share of the result's range.
const LINEAR_RANGE: f64 = 0.95;
/// Width of the feature detectors in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// Per-pixel LDR-FLIP of linear RGB, which is clamped to [0, 1].
///
/// # Panics
/// If the sizes differ.
pub fn ldr_flip(image: &RgbImage, reference: &RgbImage) -> Vec<f64> {
    assert_same_size(image, reference);
    let width = image.width;
    let (a, b) = (Perceived::new(image), Perceived::new(reference));
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(COLOR_EXPONENT);
    let (filtered_a, filtered_b) = (a.filtered_lab(width), b.filtered_lab(width));
    let (features_a, features_b) = (a.features(width), b.features(width));
    (0..image.pixels.len())
        .map(|i| {
            let color = redistribute(
                hyab(filtered_a[i], filtered_b[i]).powf(COLOR_EXPONENT),
                largest,
            );
            let edge = (features_a.0[i] - features_b.0[i]).abs();
            let point = (features_a.1[i] - features_b.1[i]).abs();
            let feature = (edge.max(point) / std::f64::consts::SQRT_2).sqrt();
            color.powf(1.0 - feature)
        })
        .collect()
}

/// Per-pixel HDR-FLIP of linear RGB.
///
/// # Panics
/// If the sizes differ.
pub fn hdr_flip(image: &RgbImage, reference: &RgbImage) -> Vec<f64> {
    let mut largest = vec![0.0_f64; image.pixels.len()];
    for exposure in exposures(reference) {
        let shown = |i: &RgbImage| {
            let pixels = i
                .pixels
                .iter()
                .map(|p| p.map(|v| aces(v.max(0.0) * exposure.exp2())))
                .collect();
            RgbImage::new(i.width, i.height, pixels)
        };
        for (largest, error) in largest
            .iter_mut()
            .zip(ldr_flip(&shown(image), &shown(reference)))
        {
            *largest = largest.max(error);
        }
    }
    largest
}

/// Mean of an error map.
pub fn mean(map: &[f64]) -> f64 {
    map.iter().sum::<f64>() / map.len() as f64
}

/// Redistributes a powered distance over [0, 1] (equation 9 of the 2020 paper).
fn redistribute(distance: f64, largest: f64) -> f64 {
    let knee = LINEAR_SHARE * largest;
    if distance < knee {
        LINEAR_RANGE / knee * distance
    } else {
        LINEAR_RANGE + (distance - knee) / (largest - knee) * (1.0 - LINEAR_RANGE)
    }
}

/// An image as the three opponent channels.
struct Perceived {
    y: Vec<f64>,
    cx: Vec<f64>,
    cz: Vec<f64>,
}

impl Perceived {
    fn new(image: &RgbImage) -> Self {
        let opponent = |p: &[f64; 3]| {
            let [x, y, z] = normalized_xyz(p.map(|v| v.clamp(0.0, 1.0)));
            [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
        };
        let all: Vec<[f64; 3]> = image.pixels.iter().map(opponent).collect();
        let plane = |c: usize| all.iter().map(|p| p[c]).collect();
        Self {
            y: plane(0),
            cx: plane(1),
            cz: plane(2),
        }
    }

    /// The image filtered by the eye's contrast sensitivity, as Hunt-adjusted CIELab.
    fn filtered_lab(&self, width: usize) -> Vec<[f64; 3]> {
        // Weights and widths of the Gaussians (table 1 of the 2020 paper); the largest width gives the common radius.
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
        let filter = |plane: &[f64], terms: &[(f64, f64)]| {
            // a sqrt(pi / b) exp(-pi^2 d^2 / b) for the distance d in degrees; the sum of all terms is scaled to 1.
            let mut total = 0.0;
            let mut sum = vec![0.0; plane.len()];
            for &(a, b) in terms {
                let deviation = (b / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE;
                let kernel = gaussian(deviation, radius);
                // The sum of the unscaled kernel in two dimensions; its middle is 1 before scaling.
                let weight = a * (PI / b).sqrt() / (kernel[radius] * kernel[radius]);
                total += weight;
                let smooth = convolve(plane, width, &kernel, &kernel, Border::Replicate);
                for (sum, value) in sum.iter_mut().zip(smooth) {
                    *sum += weight * value;
                }
            }
            sum.iter_mut().for_each(|v| *v /= total);
            sum
        };
        let y = filter(&self.y, &[(1.0, 0.0047)]);
        let cx = filter(&self.cx, &[(1.0, 0.0053)]);
        let cz = filter(&self.cz, &[(34.1, 0.04), (13.5, 0.025)]);
        (0..y.len())
            .map(|i| {
                let ny = (y[i] + 16.0) / 116.0;
                let rgb = rgb_from_normalized_xyz([ny + cx[i] / 500.0, ny, ny - cz[i] / 200.0]);
                hunt_lab(rgb.map(|v| v.clamp(0.0, 1.0)))
            })
            .collect()
    }

    /// Magnitudes of edges and of points.
    fn features(&self, width: usize) -> (Vec<f64>, Vec<f64>) {
        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as usize;
        let smooth = gaussian(deviation, radius);
        // Positive weights sum to 1 and negative ones to -1.
        let derivative = |f: &dyn Fn(f64) -> f64| {
            let weights: Vec<f64> = (0..=2 * radius)
                .map(|i| f(i as f64 - radius as f64) * smooth[i])
                .collect();
            let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
            let negative: f64 = -weights.iter().filter(|w| **w < 0.0).sum::<f64>();
            weights
                .iter()
                .map(|w| if *w > 0.0 { w / positive } else { w / negative })
                .collect::<Vec<_>>()
        };
        let first = derivative(&|x| -x);
        let second = derivative(&|x| x * x / (deviation * deviation) - 1.0);
        let y: Vec<f64> = self.y.iter().map(|y| (y + 16.0) / 116.0).collect();
        let magnitude = |kernel: &[f64]| {
            let dx = convolve(&y, width, kernel, &smooth, Border::Replicate);
            let dy = convolve(&y, width, &smooth, kernel, Border::Replicate);
            dx.iter().zip(dy).map(|(x, y)| x.hypot(y)).collect()
        };
        (magnitude(&first), magnitude(&second))
    }
}

/// CIELab of linear RGB with Hunt's adjustment: colours of dark pixels differ less.
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    let [l, a, b] = lab(rgb);
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// Distance of colours: city block between lightness and colour plane (Abasi, Tehran and Fairchild 2020).
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Narkowicz' fit of the ACES tone mapper with its exposure of 0.6: (x (a x + b)) / (x (c x + d) + e).
const ACES: [f64; 5] = [
    0.6 * 0.6 * 2.51,
    0.6 * 0.03,
    0.6 * 0.6 * 2.43,
    0.6 * 0.59,
    0.14,
];

fn aces(x: f64) -> f64 {
    let [a, b, c, d, e] = ACES;
    (x * (a * x + b) / (x * (c * x + d) + e)).clamp(0.0, 1.0)
}

/// Exposures in stops that show the reference from its brightest to its median pixel: those are mapped to 0.85
/// (section 3.2 of the 2021 paper), in steps of at most one stop or so.
fn exposures(reference: &RgbImage) -> Vec<f64> {
    let [a, b, c, d, e] = ACES;
    // The tone mapper's solution for 0.85: a quadratic equation.
    let (qa, qb, qc) = (a - 0.85 * c, b - 0.85 * d, -0.85 * e);
    let shown = (-qb + (qb * qb - 4.0 * qa * qc).sqrt()) / (2.0 * qa);
    let mut luminances: Vec<f64> = reference
        .pixels
        .iter()
        .map(|p| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2])
        .collect();
    luminances.sort_unstable_by(f64::total_cmp);
    let n = luminances.len();
    let brightest = luminances[n - 1];
    if !(brightest > 0.0 && brightest.is_finite()) {
        return vec![0.0];
    }
    let median = 0.5 * (luminances[(n - 1) / 2] + luminances[n / 2]);
    // A black median asks for endless exposure: seventeen stops are more than a display shows.
    let median = median.max(brightest * 2.0_f64.powi(-17));
    let (start, stop) = ((shown / brightest).log2(), (shown / median).log2());
    let count = ((stop - start).ceil() as usize).max(2);
    (0..count)
        .map(|i| start + (stop - start) * i as f64 / (count - 1) as f64)
        .collect()
}
