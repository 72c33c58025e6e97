//! Algorithms that build paths from either end agree on edited images.

use crate::scenes::{PLAIN, PLASTIC, room};
use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::markov::primary_space::technique;

/// Side of the blocks of pixels whose sums are compared.
const BLOCK: usize = 4;

/// What the mirror throws onto the floor, moved, scaled and brighter.
const CAUSTIC: &str = r#"<edit type="retarget"><string name="selection" value="L S^R X"/>
    <transform name="source"><scale x="1.5" y="1.5" z="0.1"/><rotate x="1" angle="-90"/><translate x="-0.2"/></transform>
    <transform name="target"><scale x="1" y="1.6" z="0.1"/><rotate x="1" angle="-90"/><translate x="0.6" z="0.5"/></transform>
    <float name="intensity" value="4"/></edit>"#;

/// What diffuse surfaces send onto the floor, stretched, brighter and green.
const BLEEDING: &str = r#"<edit type="retarget"><string name="selection" value="L D^R+ X"/>
    <transform name="source"><scale x="0.9" y="0.9" z="0.1"/><rotate x="1" angle="-90"/><translate x="-1"/></transform>
    <transform name="target"><scale x="1.5" y="0.9" z="0.1"/><rotate x="1" angle="-90"/><translate x="-0.4" z="0.3"/></transform>
    <float name="intensity" value="8"/><float name="hue" value="120"/><float name="saturation" value="0.5"/></edit>"#;

/// What glossy surfaces show, turned.
const REFLECTION: &str = r#"<edit type="retarget"><string name="selection" value="X G^R E"/>
    <transform name="map"><scale x="1" y="1.2" z="1"/><rotate y="1" angle="25"/></transform></edit>"#;

/// All that goes into a ball, with the energy that it had.
const BALL: &str = r#"<edit type="retarget"><string name="shape" value="sphere"/>
    <transform name="source"><scale value="0.8"/><translate x="-0.8" y="0.4" z="0.5"/></transform>
    <transform name="target"><scale value="0.6"/><translate x="0.3" y="0.3" z="0.9"/></transform>
    <string name="keep" value="energy"/></edit>"#;

fn sums(scene: &Scene, samples: u32, seed: u32) -> Vec<f64> {
    let options = RenderOptions {
        goal: Goal::Samples(samples),
        seed,
        first_sample: 0,
        adaptive: false,
    };
    let film = render_film(scene, &options, AovSet::NONE).unwrap();
    let (width, height) = (film.width() as usize, film.height() as usize);
    let mean = film.mean();
    let mut sums = Vec::new();
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            for channel in 0..3 {
                let rows =
                    (top..top + BLOCK).flat_map(|y| (left..left + BLOCK).map(move |x| (x, y)));
                sums.push(rows.map(|(x, y)| mean[y * width + x][channel]).sum());
            }
        }
    }
    sums
}

/// Mean and variance of the mean of each sum, over independent runs.
fn statistics(scene: &Scene, samples: u32, runs: u32) -> Vec<(f64, f64)> {
    let all: Vec<Vec<f64>> = (0..runs)
        .map(|run| sums(scene, samples, 50 + run))
        .collect();
    let n = f64::from(runs);
    (0..all[0].len())
        .map(|i| {
            let mean = all.iter().map(|v| v[i]).sum::<f64>() / n;
            let square: f64 = all.iter().map(|v| (v[i] - mean).powi(2)).sum();
            (mean, square / (n - 1.0) / n)
        })
        .collect()
}

/// How far two sums are apart, in deviations; `bias` is a share of the sum that counts as one.
fn apart(a: &(f64, f64), b: &(f64, f64), bias: f64) -> f64 {
    let deviation = (a.1 + b.1).sqrt();
    (a.0 - b.0) / deviation.max(bias * a.0).max(1e-9)
}

/// An algorithm, how it makes paths of primary samples, samples, and the share of its bias.
type Other = (u32, u32, u32, f64);

const BOTH: [Other; 2] = [
    (integrator_kind::BIDIRECTIONAL, 0, 16, 1e-3),
    (integrator_kind::LIGHT_TRACING, 0, 48, 1e-3),
];

const MORE: [Other; 6] = [
    // Photons are gathered from around a point.
    (integrator_kind::VERTEX_MERGING, 0, 6, 0.015),
    (integrator_kind::PROGRESSIVE_PHOTONS, 0, 8, 0.02),
    (integrator_kind::VEACH_MLT, 0, 1, 1e-3),
    (
        integrator_kind::PRIMARY_SAMPLE_MLT,
        technique::PATH,
        1,
        1e-3,
    ),
    (
        integrator_kind::PRIMARY_SAMPLE_MLT,
        technique::BIDIRECTIONAL,
        1,
        1e-3,
    ),
    (
        integrator_kind::PRIMARY_SAMPLE_MLT,
        technique::MULTIPLEXED,
        1,
        1e-3,
    ),
];

fn all_agree(name: &str, floor: &str, edits: &str, others: &[Other]) {
    let mut scene = room(floor, edits);
    let scale: u32 = std::env::var("HALFLIGHT_LONG").map_or(1, |_| 16);
    let path = statistics(&scene, 32 * scale, 12);
    for (i, (kind, technique, samples, bias)) in others.iter().enumerate() {
        scene.settings.kind = *kind;
        scene.settings.chains.technique = *technique;
        scene.settings.chains.mutations = 300;
        scene.settings.chains.direct_samples = 16;
        scene.settings.photon.photon_count = 20_000;
        scene.settings.photon.initial_radius = 0.04;
        let other = statistics(&scene, samples * scale, 12);
        if i == 0 && *kind == integrator_kind::BIDIRECTIONAL {
            let mut plain = room(floor, "");
            plain.settings.kind = *kind;
            let plain = statistics(&plain, samples * scale, 12);
            let pairs = other.iter().zip(&plain);
            let changed = pairs.filter(|(a, b)| apart(a, b, 1e-3).abs() > 6.0);
            assert!(changed.count() > 0, "{name}: the edit changes the image");
        }
        for (i, (a, b)) in path.iter().zip(&other).enumerate() {
            let z = apart(a, b, *bias);
            // Of a t distribution of about twenty degrees, 5.5 in none of a thousand suites.
            assert!(
                z.abs() < 5.5,
                "{name} {kind} {technique} {i}: {a:?} {b:?} z {z}"
            );
        }
    }
}

#[test]
fn of_light_turned_at_discrete_events() {
    all_agree("caustic", PLAIN, CAUSTIC, &BOTH);
}

#[test]
fn of_light_turned_at_diffuse_surfaces() {
    all_agree("bleeding", PLAIN, BLEEDING, &BOTH);
}

#[test]
fn of_importance() {
    all_agree("reflection", PLAIN, REFLECTION, &BOTH);
}

#[test]
fn of_all_light_into_a_ball() {
    all_agree("ball", PLAIN, BALL, &BOTH);
}

#[test]
fn of_several_edits_where_surfaces_are_diffuse_and_glossy_at_once() {
    let all = [CAUSTIC, BLEEDING, REFLECTION].concat();
    all_agree("several", PLASTIC, &all, &[BOTH.as_slice(), &MORE].concat());
}
