//! Metrics against closed forms and against figures of independent programs.

use halflight::compare::metrics::RgbImage;
use halflight::compare::metrics::cielab::{cie76, delta_e, lab};
use halflight::compare::metrics::flip::{hdr_flip, ldr_flip, mean};
use halflight::compare::metrics::mse::mse;
use halflight::compare::metrics::psnr::psnr;
use halflight::compare::metrics::relative_mse::{
    relative_mse, relative_variance, trimmed_relative_mse,
};
use halflight::compare::metrics::residual_rms::residual_rms;
use halflight::compare::metrics::ssim::ssim;
use halflight::film::luminance;
use halflight::image::png_output::srgb_encode;
use proptest::prelude::*;

fn constant(v: [f64; 3]) -> RgbImage {
    RgbImage::new(16, 12, vec![v; 16 * 12])
}

#[test]
fn closed_forms_of_constant_images() {
    let (a, b) = (constant([0.5, 1.0, 2.0]), constant([0.4, 1.0, 1.0]));
    assert!((mse(&a, &b) - (0.01 + 1.0) / 3.0).abs() < 1e-13);
    let expected = (0.01 / (0.16 + 0.01) + 1.0 / 1.01) / 3.0;
    assert!((relative_mse(&a, &b) - expected).abs() < 1e-13);
    let expected = (((0.1 / 0.45_f64).powi(2) + (1.0 / 1.5_f64).powi(2)) / 3.0).sqrt();
    assert!((residual_rms(&a, &b) - expected).abs() < 1e-13);
    // 2.0 and 1.0 look the same on a display: only red counts.
    let expected = -10.0 * ((srgb_encode(0.5) - srgb_encode(0.4)).powi(2) / 3.0).log10();
    assert!((psnr(&a, &b) - expected).abs() < 1e-12);
    // Constant images have no variance: only the luminance term of SSIM is left.
    let show = |p: [f64; 3]| srgb_encode(luminance(p.map(|v| v.min(1.0))));
    let (x, y) = (show(a.pixels[0]), show(b.pixels[0]));
    let expected = (2.0 * x * y + 1e-4) / (x * x + y * y + 1e-4);
    assert!((ssim(&a, &b).unwrap() - expected).abs() < 1e-12);
}

#[test]
fn a_bright_pixel_is_not_in_the_trimmed_error() {
    let (mut a, b) = (constant([0.5; 3]), constant([0.4; 3]));
    let expected = 0.01 / (0.16 + 0.01);
    assert!((trimmed_relative_mse(&a, &b) - expected).abs() < 1e-13);
    a.pixels[77] = [1e6, 0.5, 0.5];
    assert!((trimmed_relative_mse(&a, &b) - expected).abs() < 1e-13);
    assert!(relative_mse(&a, &b) > 1e6);
    // Two of them are more than one of a thousand.
    a.pixels[3] = [0.4, 0.4, 10.4];
    let with_one = expected + (100.0 / 0.17 / 3.0 - expected) / 191.0;
    assert!((trimmed_relative_mse(&a, &b) - with_one).abs() < 1e-11);
    assert!((relative_variance(&constant([0.1; 3]), &b) - 0.1 / 0.17).abs() < 1e-13);
}

#[test]
fn colour_differences_of_1976() {
    // L*a*b* under D65 of the primaries, as colour charts print them to two digits.
    for (rgb, expected) in [
        ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
        ([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]),
        ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
        ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
    ] {
        let found = lab(rgb);
        assert!(delta_e(found, expected) < 0.02, "{rgb:?}: {found:?}");
    }
    let difference = |a: [f64; 3], b: [f64; 3]| cie76(&constant(a), &constant(b));
    let grey = |v: f64| [v; 3];
    // Greys differ by lightness alone: 116 * 0.18^(1/3) - 16 = 49.4961, and below (6/29)^3 116 * 841/108 Y.
    assert!((difference(grey(0.18), grey(1.0)) - 50.5039).abs() < 1e-3);
    assert!((difference(grey(0.005), grey(0.0)) - 116.0 * 841.0 / 108.0 * 0.005).abs() < 1e-9);
    // sqrt(53.24^2 + 80.09^2 + 67.20^2), from red to black.
    assert!((difference([1.0, 0.0, 0.0], grey(0.0)) - 117.33).abs() < 0.02);
    // Exposure 0 and no tone curve: what is brighter than white is white, what is negative is black.
    assert_eq!(difference(grey(1.0), grey(7.0)), 0.0);
    assert_eq!(difference(grey(-1.0), grey(0.0)), 0.0);
    // The mean over pixels: half of them white instead of black.
    let half = (0..16 * 12).map(|i| grey(f64::from(i % 2))).collect();
    let half = RgbImage::new(16, 12, half);
    assert!((cie76(&half, &constant(grey(0.0))) - 50.0).abs() < 1e-9);
}

#[test]
fn equal_images_do_not_differ() {
    let a = random(1);
    assert_eq!(
        (mse(&a, &a), relative_mse(&a, &a), residual_rms(&a, &a)),
        (0.0, 0.0, 0.0)
    );
    assert_eq!(psnr(&a, &a), f64::INFINITY);
    assert!((ssim(&a, &a).unwrap() - 1.0).abs() < 1e-12);
    assert!(ldr_flip(&a, &a).iter().all(|&e| e == 0.0));
    assert!(hdr_flip(&a, &a).iter().all(|&e| e == 0.0));
    let black = constant([0.0; 3]);
    assert_eq!(
        (
            residual_rms(&black, &black),
            mean(&hdr_flip(&black, &black))
        ),
        (0.0, 0.0)
    );
}

#[test]
fn a_missing_feature_counts_two_in_the_residual_rms_however_bright() {
    for bright in [1e-3, 1.0, 1e6] {
        assert_eq!(
            residual_rms(&constant([0.0; 3]), &constant([bright; 3])),
            2.0
        );
    }
    assert_eq!(
        residual_rms(&constant([-1.0; 3]), &constant([-2.0; 3])),
        0.0,
        "negative values count as zero"
    );
}

#[test]
fn ssim_needs_a_window() {
    let small = RgbImage::new(10, 40, vec![[0.5; 3]; 400]);
    assert_eq!(ssim(&small, &small), None);
}

/// The hash behind the images that the other programs were given.
fn hash(n: u64) -> f64 {
    let mut n = n & 0xffff_ffff;
    n = ((n ^ (n >> 16)) * 0x7feb_352d) & 0xffff_ffff;
    n = ((n ^ (n >> 15)) * 0x846c_a68b) & 0xffff_ffff;
    (n ^ (n >> 16)) as f64 / 4_294_967_296.0
}

const WIDTH: usize = 72;
const HEIGHT: usize = 56;

fn image(f: impl Fn(usize, usize, usize) -> f64) -> RgbImage {
    let pixels = (0..WIDTH * HEIGHT)
        .map(|i| [0, 1, 2].map(|c| f(i % WIDTH, i / WIDTH, c)))
        .collect();
    RgbImage::new(WIDTH, HEIGHT, pixels)
}

fn random_value(x: usize, y: usize, c: usize, seed: usize) -> f64 {
    hash(((y * WIDTH + x) * 3 + c + seed * 100_003) as u64)
}

fn random(seed: usize) -> RgbImage {
    image(|x, y, c| random_value(x, y, c, seed))
}

/// Waves and a red disk, moved to the right.
fn structured_value(x: usize, y: usize, c: usize, shift: f64) -> f64 {
    let (x, y, c_) = (x as f64, y as f64, c as f64);
    if (x - 30.0 - shift).powi(2) + (y - 25.0).powi(2) < 196.0 {
        [0.9, 0.2, 0.1][c]
    } else {
        0.5 + 0.35 * (0.21 * (x + shift) + 0.9 * c_).sin() * (0.17 * y - 0.4 * c_).cos()
    }
}

fn structured(shift: f64) -> RgbImage {
    image(|x, y, c| structured_value(x, y, c, shift))
}

fn noisy() -> RgbImage {
    image(|x, y, c| {
        (structured_value(x, y, c, 0.0) + 0.2 * (random_value(x, y, c, 3) - 0.5)).clamp(0.0, 1.0)
    })
}

fn hdr(f: impl Fn(usize, usize, usize) -> f64) -> RgbImage {
    image(|x, y, c| f(x, y, c) * (6.0 * (x + y) as f64 / (WIDTH + HEIGHT) as f64 - 2.0).exp2())
}

/// Figures of NVIDIA's flip-evaluator 1.7 (single precision) for the same images: the mean, and pixels (20, 10), (0, 0).
#[test]
fn flip_agrees_with_its_authors_program() {
    let ldr = [
        (
            random(1),
            random(2),
            0.403_200_4,
            0.314_249_16,
            0.952_594_16,
        ),
        (
            structured(0.0),
            structured(2.0),
            0.300_056_4,
            0.249_487_06,
            0.372_852_39,
        ),
        (
            noisy(),
            structured(0.0),
            0.105_929_22,
            0.113_002_35,
            0.116_045_64,
        ),
    ];
    let hdr_reference = hdr(|x, y, c| structured_value(x, y, c, 0.0));
    let hdr = [
        (
            hdr(|x, y, c| structured_value(x, y, c, 2.0)),
            0.258_603_99,
            0.211_129_46,
            0.274_982_27,
        ),
        (
            hdr(|x, y, c| structured_value(x, y, c, 0.0) * (0.5 + random_value(x, y, c, 4))),
            0.169_992_01,
            0.221_987_81,
            0.390_621_93,
        ),
    ];
    let check = |map: Vec<f64>, expected: [f64; 3]| {
        let computed = [mean(&map), map[10 * WIDTH + 20], map[0]];
        eprintln!("{computed:?} against {expected:?}");
        for i in 0..3 {
            assert!(
                (computed[i] - expected[i]).abs() < 1e-4,
                "{computed:?} against {expected:?}"
            );
        }
    };
    for (a, b, mean, inner, corner) in ldr {
        check(ldr_flip(&a, &b), [mean, inner, corner]);
    }
    for (a, mean, inner, corner) in hdr {
        check(hdr_flip(&a, &hdr_reference), [mean, inner, corner]);
    }
}

/// Figures of scikit-image for the same images: Gaussian weights of deviation 1.5, population covariance, range 1.
#[test]
fn ssim_agrees_with_scikit_image() {
    let agrees = |a: RgbImage, b: RgbImage, expected: f64| {
        let computed = ssim(&a, &b).unwrap();
        assert!(
            (computed - expected).abs() < 1e-9,
            "{computed} against {expected}"
        );
    };
    agrees(random(1), random(2), 0.054_917_801_013_632_21);
    agrees(structured(0.0), structured(2.0), 0.851_016_954_984_787);
    agrees(noisy(), structured(0.0), 0.776_457_079_744_548_5);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn metrics_are_finite_and_in_range(
        a in prop::collection::vec(prop::array::uniform3(-1.0_f64..1e4), 12 * 11),
        b in prop::collection::vec(prop::array::uniform3(0.0_f64..2.0), 12 * 11),
    ) {
        let (a, b) = (RgbImage::new(12, 11, a), RgbImage::new(12, 11, b));
        prop_assert!(mse(&a, &b).is_finite() && relative_mse(&a, &b).is_finite());
        prop_assert!((0.0..=2.0).contains(&residual_rms(&a, &b)));
        prop_assert!(ssim(&a, &b).unwrap() <= 1.0);
        for e in ldr_flip(&a, &b).into_iter().chain(hdr_flip(&a, &b)) {
            prop_assert!((0.0..=1.0).contains(&e), "{e}");
        }
    }
}
