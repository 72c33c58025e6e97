//! Path tracing beside chains: what it keeps and what it leaves make the image, however much it keeps.

use crate::agreement::{report, settings_of};
use crate::brightness::{BALL, DIFFUSE, GLOSSY, POINT, SKY, camera};
use crate::scenes::{LAMP, NamedFile, PINHOLE, room, scene, sky, with_view};
use crate::variants::{MIRROR, Samples, agree_with};
use halflight::processor;
use halflight::scene::build::Scene;
use halflight_kernel::math::luminance;
use halflight_kernel::path::PathRules;
use halflight_kernel::path::remainder::{LEAST_EDGES, MOST_EDGES, Remainder};
use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::transport::markov::{ChainAlgorithm, VeachChains};
use halflight_kernel::transport::settings::{ChainSettings, IntegratorSettings, integrator_kind};
use halflight_kernel::transport::wavefront::Wavefront;

/// Mean and its deviation.
struct Estimate {
    mean: f64,
    deviation: f64,
}

impl Estimate {
    fn of(values: impl Iterator<Item = f32>) -> Estimate {
        let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for value in values {
            let value = f64::from(value);
            n += 1.0;
            sum += value;
            squares += value * value;
        }
        let mean = sum / n;
        Estimate {
            mean,
            deviation: ((squares / n - mean * mean) / n).sqrt(),
        }
    }
}

/// Luminances of samples of path tracing that keep what a remainder says.
fn kept(scene: &Scene, remainder: Remainder, seed: u32, most_edges: u32) -> Estimate {
    let mut values = Vec::new();
    with_view(scene, |view| {
        let settings = IntegratorSettings {
            rules: PathRules {
                max_depth: scene.settings.rules.max_depth.min(most_edges),
                rr_depth: u32::MAX,
                ..scene.settings.rules
            },
            ..settings_of(scene, integrator_kind::PATH)
        };
        let mut wave: Box<Wavefront<IndependentSampler, 512>> = bytemuck::zeroed_box();
        wave.keep(remainder);
        for sample in 0..2000 {
            for pixel in 0..48 {
                let sampler = IndependentSampler::new(seed, pixel, sample);
                wave.push([pixel % 8, pixel / 8], sampler);
                if wave.is_full() {
                    let found = wave.run(processor::simd_level(), view, &settings);
                    values.extend(found.iter().map(|value| luminance(*value)));
                }
            }
        }
        let found = wave.run(processor::simd_level(), view, &settings);
        values.extend(found.iter().map(|value| luminance(*value)));
    });
    Estimate::of(values.into_iter())
}

/// Weights of candidates less what path tracing keeps.
fn left(scene: &Scene, remainder: Remainder, seed: u32) -> Estimate {
    let mut values = Vec::new();
    with_view(scene, |view| {
        let settings = settings_of(scene, integrator_kind::VEACH_MLT);
        let chains = VeachChains::new(view, &settings, LEAST_EDGES, seed, 0);
        let chains = chains.with_path_tracing(Some(remainder));
        for candidate in 0..40_000 {
            let mut sum = 0.0;
            chains.candidate_weights(candidate, &mut |weight| sum += weight);
            values.push(sum);
        }
    });
    Estimate::of(values.into_iter())
}

/// Kept and left together are all, for every scale; the share that moves from one to the other must be more than the noise.
#[test]
fn kept_and_left_are_all() {
    let files: &[NamedFile<'_>] = &[("sky.exr", &sky)];
    let thin = camera(
        "thinlens",
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="3"/>"#,
    );
    for (what, content) in [
        (
            "glass",
            [PINHOLE, &room(GLOSSY), LAMP, BALL, MIRROR].concat(),
        ),
        (
            "coats",
            [&thin, &room(r#"<bsdf type="plastic"/>"#), LAMP].concat(),
        ),
        ("sky", [PINHOLE, &room(GLOSSY), SKY].concat()),
        ("point light", [PINHOLE, &room(DIFFUSE), POINT].concat()),
    ] {
        let mut scene = scene(&content, files);
        // Bright dots would hide everything.
        scene.settings.rules.max_depth = 5;
        let all = kept(&scene, Remainder { scale: 0.0 }, 1, MOST_EDGES);
        let direct = kept(&scene, Remainder { scale: 0.0 }, 2, LEAST_EDGES - 1);
        let indirect = all.mean - direct.mean;
        for s in [1.0, 30.0] {
            let remainder = Remainder {
                scale: s / indirect as f32,
            };
            let kept = kept(&scene, remainder, 3, MOST_EDGES);
            let left = left(&scene, remainder, 4);
            let noise = all.deviation.hypot(kept.deviation).hypot(left.deviation);
            let error = kept.mean + left.mean - all.mean;
            let share = left.mean / indirect;
            println!(
                "{what}, scale {s}: {share:.3} left, {error:.5} of {:.5} off, noise {noise:.5}",
                all.mean
            );
            assert!(
                error.abs() < 4.0 * noise,
                "{what}: {error} off, noise {noise}"
            );
            assert!(
                share > 0.05 && 3.0 * noise < left.mean,
                "{what} shows nothing"
            );
        }
    }
}

/// The same of whole images by chains.
#[test]
fn chains_beside_path_tracing_keep_the_image() {
    let variant = |manifold: f32, half_vector: f32| ChainSettings {
        candidates: 2048,
        chains: 16,
        mutations: 64,
        lens_weight: 0.0,
        caustic_weight: 0.0,
        multi_chain_weight: 0.0,
        manifold_weight: manifold,
        half_vector_weight: half_vector,
        ..ChainSettings::DEFAULT
    };
    let variants = [("memlt", variant(1.0, 0.0)), ("hslt", variant(0.0, 1.0))];
    let mut scene = scene(&[PINHOLE, &room(GLOSSY), LAMP, BALL, MIRROR].concat(), &[]);
    let kinds = [integrator_kind::BIDIRECTIONAL, integrator_kind::VEACH_MLT];
    let samples = Samples {
        truth: 384,
        chains: 6,
    };
    report(agree_with(
        "glass and mirror",
        &mut scene,
        kinds,
        samples,
        &variants,
    ));
}
