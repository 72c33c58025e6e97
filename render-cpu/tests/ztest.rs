//! The z-test raises as many alarms as it says, and finds what is wrong.

use halflight::compare::metrics::RgbImage;
use halflight::compare::metrics::ztest::{Estimate, Outcome, Settings, ztest};

/// A 64-bit counter through a mixing function (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Exponential with mean 1: skewed, as radiance is.
    fn exponential(&mut self) -> f64 {
        -(1.0 - self.next()).ln()
    }
}

const SIZE: usize = 40;

/// Brightness of the true image: from 0.1 to 2 across.
fn truth(i: usize) -> f64 {
    0.1 + 1.9 * (i % SIZE) as f64 / SIZE as f64
}

/// Mean and variance of the mean of `n` samples per pixel.
fn estimate(
    n: usize,
    truth: impl Fn(usize) -> f64,
    mut sample: impl FnMut() -> f64,
) -> (RgbImage, RgbImage) {
    let (mut means, mut variances) = (Vec::new(), Vec::new());
    for i in 0..SIZE * SIZE {
        let (mut mean, mut variance) = ([0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let samples: Vec<f64> = (0..n).map(|_| truth(i) * sample()).collect();
            mean[c] = samples.iter().sum::<f64>() / n as f64;
            variance[c] =
                samples.iter().map(|s| (s - mean[c]).powi(2)).sum::<f64>() / (n * (n - 1)) as f64;
        }
        means.push(mean);
        variances.push(variance);
    }
    (
        RgbImage::new(SIZE, SIZE, means),
        RgbImage::new(SIZE, SIZE, variances),
    )
}

fn exponential(n: usize, seed: u64, truth: impl Fn(usize) -> f64) -> (RgbImage, RgbImage) {
    let mut random = Random(seed);
    estimate(n, truth, || random.exponential())
}

fn test(a: &(RgbImage, RgbImage), b: &(RgbImage, RgbImage), n: usize, alpha: f64) -> Outcome {
    let estimate = |e| {
        let (mean, variance): &(RgbImage, RgbImage) = e;
        Estimate {
            mean,
            variance,
            degrees_of_freedom: (n - 1) as f64,
            samples: None,
        }
    };
    ztest(
        estimate(a),
        estimate(b),
        Settings {
            false_alarm_rate: alpha,
            relative_floor: 0.0,
        },
    )
}

#[test]
fn equal_distributions_raise_no_more_alarms_than_stated() {
    let runs = 200;
    let outcomes: Vec<Outcome> = (0..runs)
        .map(|seed| {
            let a = exponential(16, 2 * seed, truth);
            let b = exponential(16, 2 * seed + 1, truth);
            test(&a, &b, 16, 0.05)
        })
        .collect();
    let alarms = outcomes.iter().filter(|o| !o.passes()).count();
    eprintln!("{alarms} alarms of {runs} at 0.05");
    // More than 22 of 200 at a true rate of 0.05 has a probability below 0.0005.
    assert!(alarms <= 22, "{alarms} alarms");
    // At a rate of one half the test must not sleep either: patience costs, but not everything.
    let half = (0..40)
        .filter(|seed| {
            !test(
                &exponential(16, 2 * seed, truth),
                &exponential(16, 2 * seed + 1, truth),
                16,
                0.5,
            )
            .passes()
        })
        .count();
    eprintln!("{half} alarms of 40 at 0.5");
    assert!((4..=31).contains(&half), "{half} alarms of 40");
    assert!(
        outcomes
            .iter()
            .all(|o| o.correlation < 1.2 && o.mean_z.abs() < 0.1 && o.share_above_3 < 0.01)
    );
}

#[test]
fn a_bias_of_one_percent_is_found() {
    // 1600 pixels of 256 samples: the image's mean is known to 0.16 % per channel, the difference to 0.22 %.
    let found = (0..12)
        .filter(|seed| {
            let a = exponential(256, 2 * seed, |i| 1.01 * truth(i));
            let b = exponential(256, 2 * seed + 1, truth);
            !test(&a, &b, 256, 0.01).passes()
        })
        .count();
    eprintln!("1 % found in {found} of 12");
    assert!(found >= 11, "{found} of 12");
}

#[test]
fn one_wrong_pixel_is_found_and_named() {
    let mut a = exponential(64, 1, truth);
    let b = exponential(64, 2, truth);
    assert!(test(&a, &b, 64, 0.001).passes());
    a.0.pixels[17 * SIZE + 23][1] *= 4.0;
    let outcome = test(&a, &b, 64, 0.001);
    assert!(!outcome.passes());
    let pixels = outcome.levels[0];
    assert_eq!(
        (pixels.block, pixels.x, pixels.y, pixels.channel),
        (1, 23, 17, 1)
    );
    assert!(pixels.z > 5.0 && pixels.severity() > 1.0);
}

#[test]
fn a_wrong_corner_is_found_by_the_blocks() {
    let corner = |i: usize| {
        if i % SIZE >= 32 && i / SIZE < 8 {
            1.1 * truth(i)
        } else {
            truth(i)
        }
    };
    let outcome = test(
        &exponential(64, 1, corner),
        &exponential(64, 2, truth),
        64,
        0.001,
    );
    assert!(outcome.levels[1].severity() > 1.0, "{outcome:?}");
    assert_eq!((outcome.levels[1].x, outcome.levels[1].y), (32, 0));
    assert!(
        outcome.levels[0].severity() < 1.0 && outcome.levels[3].severity() < 1.0,
        "{outcome:?}"
    );
}

/// Rare bright samples: most pixels of the image with few samples miss them, and claim to know it.
#[test]
fn missed_fireflies_are_no_alarm() {
    let rare = |n: usize, seed: u64| {
        let mut random = Random(seed);
        estimate(
            n,
            |_| 1.0,
            move || {
                if random.next() < 0.01 {
                    20.0
                } else {
                    0.5 + 0.1 * random.next()
                }
            },
        )
    };
    let alarms = (0..20)
        .filter(|&seed| {
            let (a, b) = (rare(16, 2 * seed), rare(1024, 2 * seed + 1));
            let outcome = ztest(
                Estimate {
                    mean: &a.0,
                    variance: &a.1,
                    degrees_of_freedom: 15.0,
                    samples: Some(16.0),
                },
                Estimate {
                    mean: &b.0,
                    variance: &b.1,
                    degrees_of_freedom: 1023.0,
                    samples: Some(1024.0),
                },
                Settings {
                    false_alarm_rate: 0.01,
                    relative_floor: 0.0,
                },
            );
            !outcome.passes()
        })
        .count();
    eprintln!("{alarms} alarms of 20 with rare bright samples");
    // More than 2 of 20 at a true rate of 0.01 has a probability of 0.001.
    assert!(alarms <= 2, "{alarms} alarms");
}

/// Splats an image of independent noise with a filter, as a renderer with a wide reconstruction filter does.
#[test]
fn correlated_pixels_are_no_alarm_and_no_excuse() {
    let weights: Vec<f64> = (-2..=2).map(|x| (-2.0 * f64::from(x * x)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let blur = |image: &RgbImage, squared: bool| {
        let pixels = (0..SIZE * SIZE).map(|i| {
            let mut sum = [0.0; 3];
            for (dy, wy) in (0..).zip(&weights) {
                for (dx, wx) in (0..).zip(&weights) {
                    let (x, y) = (
                        (i % SIZE + dx + SIZE - 2) % SIZE,
                        (i / SIZE + dy + SIZE - 2) % SIZE,
                    );
                    let w = wx * wy / (total * total);
                    (0..3).for_each(|c| {
                        sum[c] += image.pixels[y * SIZE + x][c] * if squared { w * w } else { w }
                    });
                }
            }
            sum
        });
        RgbImage::new(SIZE, SIZE, pixels.collect())
    };
    let blurred = |seed, scale: f64| {
        let (mean, variance) = exponential(64, seed, |_| scale);
        (blur(&mean, false), blur(&variance, true))
    };
    let (mut alarms, mut found, mut factors) = (0, 0, 0.0);
    for seed in 0..40 {
        let outcome = test(
            &blurred(2 * seed, 1.0),
            &blurred(2 * seed + 1, 1.0),
            64,
            0.05,
        );
        // (sum w)^2 / sum w^2 of the filter: 1.559 per axis, 2.43.
        assert!(
            (1.8..3.2).contains(&outcome.correlation),
            "{}",
            outcome.correlation
        );
        factors += outcome.correlation / 40.0;
        alarms += usize::from(!outcome.passes());
        found += usize::from(
            !test(
                &blurred(2 * seed, 1.05),
                &blurred(2 * seed + 1, 1.0),
                64,
                0.05,
            )
            .passes(),
        );
    }
    eprintln!("{alarms} alarms, {found} of 40 biases found, correlation {factors}");
    // More than 7 of 40 at a true rate of 0.05 has a probability below 0.001.
    assert!(alarms <= 7, "{alarms} alarms");
    assert!(found >= 38, "{found} of 40");
}

#[test]
fn pixels_without_variance_may_differ_by_rounding_only() {
    let (lamp, zero) = (
        RgbImage::new(4, 4, vec![[17.0; 3]; 16]),
        RgbImage::new(4, 4, vec![[0.0; 3]; 16]),
    );
    fn exact<'a>(mean: &'a RgbImage, zero: &'a RgbImage) -> Estimate<'a> {
        Estimate {
            mean,
            variance: zero,
            degrees_of_freedom: 15.0,
            samples: None,
        }
    }
    let scaled = |factor: f64| RgbImage::new(4, 4, vec![[17.0 * factor; 3]; 16]);
    let test = |factor| {
        ztest(
            exact(&scaled(factor), &zero),
            exact(&lamp, &zero),
            Settings::default(),
        )
    };
    assert!(test(1.0).passes() && test(1.0 + 1e-6).passes());
    assert!(!test(1.01).passes());
    assert_eq!(test(1.0).severity(), 0.0);
    let black = ztest(
        exact(&zero, &zero),
        exact(&zero, &zero),
        Settings::default(),
    );
    assert!(black.passes() && black.mean_z == 0.0);
}

/// With the variance of two or three runs a large deviation is nothing special.
#[test]
fn few_runs_make_the_test_patient() {
    let zero = RgbImage::new(1, 1, vec![[0.0; 3]]);
    let (mean, variance) = (
        RgbImage::new(1, 1, vec![[8.0; 3]]),
        RgbImage::new(1, 1, vec![[1.0; 3]]),
    );
    let test = |degrees_of_freedom| {
        let a = Estimate {
            mean: &mean,
            variance: &variance,
            degrees_of_freedom,
            samples: None,
        };
        let b = Estimate {
            mean: &zero,
            variance: &zero,
            degrees_of_freedom,
            samples: None,
        };
        ztest(
            a,
            b,
            Settings {
                false_alarm_rate: 0.01,
                relative_floor: 0.0,
            },
        )
    };
    assert!(test(2.0).passes() && !test(100.0).passes());
    // Two-sided tail of Student's t at 8 with 2 degrees of freedom: 1 - 8 / sqrt(66).
    assert!((test(2.0).levels[0].p - (1.0 - 8.0 / 66.0_f64.sqrt())).abs() < 1e-9);
}
