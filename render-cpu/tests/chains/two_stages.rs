//! A two-stage start: chains come more often to dark parts, and the image stays what it is.

use crate::agreement::report;
use crate::brightness::{BALL, DIFFUSE};
use crate::scenes::{LAMP, PINHOLE, room, scene};
use crate::variants::{self, MIRROR, Samples};
use halflight::film::aov::{Aov, AovSet};
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use halflight_kernel::math::luminance;
use halflight_kernel::transport::markov::primary_space::technique;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};

const PRIMARY: u32 = integrator_kind::PRIMARY_SAMPLE_MLT;
const WHOLE: u32 = integrator_kind::VEACH_MLT;
const BDPT: u32 = integrator_kind::BIDIRECTIONAL;

fn chains(kind: u32) -> ChainSettings {
    ChainSettings {
        technique: kind,
        candidates: 1024,
        chains: 16,
        mutations: 16,
        direct_samples: 0,
        two_stage: 1,
        ..ChainSettings::DEFAULT
    }
}

/// A room with bright and dark parts.
fn large_room([width, height]: [u32; 2]) -> Scene {
    let size = |name: &str, value: u32| format!(r#"name="{name}" value="{value}""#);
    let view = PINHOLE
        .replace(&size("width", 8), &size("width", width))
        .replace(&size("height", 6), &size("height", height));
    scene(&[&view, &room(DIFFUSE), LAMP, BALL, MIRROR].concat(), &[])
}

#[test]
fn two_stages_keep_the_image() {
    let of_samples = [
        ("path", chains(technique::PATH)),
        ("bdpt", chains(technique::BIDIRECTIONAL)),
        ("multiplexed", chains(technique::MULTIPLEXED)),
    ];
    let beside = ChainSettings {
        direct_samples: ChainSettings::SOME,
        ..chains(0)
    };
    let apart = ChainSettings {
        direct_samples: 1,
        ..chains(0)
    };
    let short = ChainSettings {
        bidirectional_weight: 0.0,
        chain_length: 100,
        ..chains(0)
    };
    let of_paths = [
        ("mlt", chains(0)),
        ("mlt, direct illumination apart", apart),
        ("mlt, path tracing beside", beside),
        ("erpt", short),
    ];
    let samples = Samples {
        truth: 24,
        chains: 8,
    };
    let mut scene = large_room([32, 24]);
    let mut results = Vec::new();
    for (kind, variants) in [(PRIMARY, &of_samples[..]), (WHOLE, &of_paths)] {
        let kinds = [BDPT, kind];
        results.extend(variants::agree_with(
            "two stages",
            &mut scene,
            kinds,
            samples,
            variants,
        ));
    }
    report(results);
}

#[test]
fn dark_parts_are_visited_more_often() {
    let mut scene = large_room([96, 72]);
    scene.settings.kind = WHOLE;
    let options = RenderOptions {
        goal: Goal::Samples(2),
        seed: 3,
        first_sample: 0,
        adaptive: false,
    };
    let mut share_of_dark = |two_stage: u32| {
        scene.settings.chains = ChainSettings {
            two_stage,
            ..chains(0)
        };
        let aovs = [Aov::Mutations].into_iter().collect::<AovSet>();
        let film = render_film(&scene, &options, aovs).unwrap();
        let light = film.mean();
        let visits: Vec<f64> = (0..light.len())
            .map(|i| film.aov_mean(Aov::Mutations, 0, i))
            .collect();
        let light = |i: usize| luminance(glam::DVec3::from_array(light[i]).as_vec3());
        let mean = (0..visits.len()).map(light).sum::<f32>() / visits.len() as f32;
        let dark = (0..visits.len()).filter(|i| light(*i) < 0.25 * mean);
        let of_dark: f64 = dark.map(|i| visits[i]).sum();
        of_dark / visits.iter().sum::<f64>()
    };
    let (one, two) = (share_of_dark(0), share_of_dark(1));
    assert!(two > 1.5 * one, "{one} and {two} of the visits");
}
