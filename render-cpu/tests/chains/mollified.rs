//! Chains whose target is mollified have the image of mollified bidirectional path tracing, also when the radius shrinks within a
//! chain.

use crate::agreement::{Batches, compare, report, settings_of};
use crate::brightness::{BALL, DIFFUSE, POINT};
use crate::scenes::{PINHOLE, room, scene};
use crate::variants::{self, MIRROR, Samples};
use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use halflight::scene::build::regularization::{parse_mollify, parse_regularize};
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::markov::annealing::STAGE;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};

const PRIMARY: u32 = integrator_kind::PRIMARY_SAMPLE_MLT;
const WHOLE: u32 = integrator_kind::VEACH_MLT;
const BDPT: u32 = integrator_kind::BIDIRECTIONAL;

const SAMPLES: Samples = Samples {
    truth: 512,
    chains: 6,
};

/// Chains of a length that is a whole number of stages; full paths by nothing but these mutations.
fn chains(weights: [f32; 4]) -> ChainSettings {
    ChainSettings {
        candidates: 1024,
        chains: 12,
        mutations: STAGE,
        ..variants::of_mutations(weights)
    }
}

const ALL: [f32; 4] = [1.0; 4];

/// Light that only blurred paths carry, behind a ball of glass and in a mirror.
fn mollified(light: &str, wall: &str, text: &str) -> Scene {
    let mut scene = scene(&[PINHOLE, &room(wall), light, BALL, MIRROR].concat(), &[]);
    scene.settings.regularization = parse_mollify(text).unwrap();
    scene.settings.rules.max_depth = 4;
    scene
}

#[test]
fn mollified_chains_have_the_image_of_mollified_bidirectional_path_tracing() {
    let beside = ChainSettings {
        direct_samples: ChainSettings::SOME,
        ..chains(ALL)
    };
    let on_manifolds = ChainSettings {
        half_vector_weight: 1.0,
        manifold_weight: 1.0,
        ..chains(ALL)
    };
    let apart = ChainSettings {
        direct_samples: 2,
        ..chains(ALL)
    };
    let caustic = ("caustic", chains([0.0, 0.0, 1.0, 0.0]));
    let bidirectional = ("bidirectional", chains([1.0, 0.0, 0.0, 0.0]));
    let of_samples = [("pssmlt", chains(ALL))];
    let all = ("all", chains(ALL));
    let every = [
        ("start", chains([0.0; 4])),
        bidirectional,
        ("lens", chains([0.0, 1.0, 0.0, 0.0])),
        caustic,
        ("multi-chain", chains([0.0, 0.0, 0.0, 1.0])),
        all,
        ("all and those on manifolds", on_manifolds),
        ("all, direct illumination apart", apart),
        ("all, path tracing beside", beside),
    ];
    let even = || mollified(POINT, DIFFUSE, "r0=0.3,kernel=constant,constant");
    let coats = mollified(POINT, r#"<bsdf type="plastic"/>"#, "r0=0.4,constant");
    let wide = "r0=0.8,constant";
    let sun = r#"<emitter type="directional"><vector name="direction" value="0.3, -1, -0.4"/>
        <rgb name="irradiance" value="3, 2, 1"/></emitter>"#;
    let sun = mollified(sun, DIFFUSE, wide);
    let mut deep = mollified(POINT, DIFFUSE, wide);
    deep.settings.rules.max_depth = 5;
    let mut results = Vec::new();
    for (what, mut scene, kind, variants) in [
        ("even kernel", even(), PRIMARY, &of_samples[..]),
        ("even kernel", even(), WHOLE, &every),
        ("coats", coats, WHOLE, &[bidirectional, all]),
        ("sun", sun, WHOLE, &[all]),
        ("caustic in a mirror", deep, WHOLE, &[caustic, all]),
    ] {
        let kinds = [BDPT, kind];
        results.extend(variants::agree_with(
            what, &mut scene, kinds, SAMPLES, variants,
        ));
    }
    report(results);
}

/// A point light in a ball of glass, seen in a mirror that fills most of the view (as in Kaplanyan 2017, figure 6.6).
fn light_behind_glass_in_a_mirror() -> Scene {
    let view = PINHOLE
        .replace(r#"value="60""#, r#"value="20""#)
        .replace("0, 0.9, 0", "1.122, 1.2, -1.337");
    let light = POINT.replace("0, 1.7, 0", "0, 1.2, 0");
    let glass = BALL
        .replace("0.2, 0.5, 0", "0, 1.2, 0")
        .replace("0.4", "0.25");
    let content = [&view, &room(DIFFUSE), &light, &glass, MIRROR].concat();
    let mut scene = scene(&content, &[]);
    scene.settings.rules.max_depth = 5;
    scene.settings.photon.photon_count = 2000;
    scene
}

#[test]
fn a_light_behind_glass_is_seen_in_a_mirror_by_mollified_chains_alone() {
    let mut scene = light_behind_glass_in_a_mirror();
    scene.settings.regularization = parse_mollify("r0=0.3,kernel=constant,constant").unwrap();
    let settings = settings_of(&scene, BDPT);
    let truth = Batches::render("in a mirror", &mut scene, settings, 512);
    let mut results = Vec::new();
    for (name, kind) in [("pssmlt", PRIMARY), ("mlt", WHOLE)] {
        let settings = IntegratorSettings {
            chains: chains(ALL),
            ..settings_of(&scene, kind)
        };
        let found = Batches::render(name, &mut scene, settings, 4);
        results.push(compare(name, &truth, &found));
    }
    report(results);
    // Others do not come near.
    scene.settings.regularization = parse_mollify("r0=0").unwrap();
    for (name, kind, samples) in [
        ("mlt", WHOLE, 4),
        ("vcm", integrator_kind::VERTEX_MERGING, 64),
        ("mcppm", integrator_kind::METROPOLIS_PHOTONS, 64),
    ] {
        let settings = IntegratorSettings {
            chains: chains(ALL),
            ..settings_of(&scene, kind)
        };
        let found = Batches::render(name, &mut scene, settings, samples);
        let (found, all) = (found.mean(), truth.mean());
        assert!(found[0] < 0.2 * all[0], "{name}: {found:?} of {all:?}");
    }
}

#[test]
fn chains_of_primary_samples_have_the_image_of_regularised_bidirectional_path_tracing() {
    let wall = r#"<bsdf type="roughconductor"><float name="alpha" value="0.05"/></bsdf>"#;
    let mut scene = scene(&[PINHOLE, &room(wall), POINT, BALL].concat(), &[]);
    scene.settings.regularization = parse_regularize("tau=10,constant").unwrap();
    scene.settings.rules.max_depth = 4;
    report(variants::agree_with(
        "tau",
        &mut scene,
        [BDPT, PRIMARY],
        Samples {
            truth: 256,
            chains: 4,
        },
        &[("pssmlt", chains(ALL))],
    ));
}

#[test]
fn a_radius_that_shrinks_within_a_chain_gives_the_mean_of_the_targets() {
    // Four stages, each with about half the radius of the one before.
    let text = "r0=1.6,kernel=constant,constant,gamma=0.99";
    let mut scene = mollified(POINT, DIFFUSE, text);
    let chains = chains(ALL);
    let start = scene.settings.regularization;
    let stages: Vec<_> = (0..4)
        .map(|stage| {
            let mut settings = settings_of(&scene, BDPT);
            settings.regularization.radius = start.radius * 0.99_f32.powi((stage * STAGE) as i32);
            Batches::render(&format!("stage {stage}"), &mut scene, settings, 512)
        })
        .collect();
    let truth = Batches::mean_of(&stages);
    assert!(compare("first and last", &stages[0], &stages[3]).is_err());
    let mut results = Vec::new();
    for (name, kind) in [("pssmlt", PRIMARY), ("mlt", WHOLE)] {
        let settings = IntegratorSettings {
            chains,
            ..settings_of(&scene, kind)
        };
        let found = Batches::render(name, &mut scene, settings, 16);
        let error = found.relative_error();
        assert!(error < 0.03, "{name}: noise of {error} hides everything");
        results.push(compare(name, &truth, &found));
    }
    report(results);
}

#[test]
fn without_a_radius_or_a_specular_surface_not_a_bit_changes() {
    let options = RenderOptions {
        goal: Goal::Samples(3),
        seed: 5,
        first_sample: 0,
        adaptive: false,
    };
    for (content, text) in [
        (
            [PINHOLE, &room(DIFFUSE), POINT, BALL, MIRROR].concat(),
            "r0=0,gamma=0.9",
        ),
        ([PINHOLE, &room(DIFFUSE), POINT].concat(), "r0=0.3,gamma=1"),
    ] {
        let mut scene = scene(&content, &[]);
        scene.settings.chains = chains(ALL);
        for kind in [PRIMARY, WHOLE] {
            scene.settings.kind = kind;
            let plain = render_film(&scene, &options, AovSet::NONE).unwrap();
            let mut other = scene.settings;
            other.regularization = parse_mollify(text).unwrap();
            let before = std::mem::replace(&mut scene.settings, other);
            let film = render_film(&scene, &options, AovSet::NONE).unwrap();
            scene.settings = before;
            assert!(plain.mean().iter().any(|m| m[0] > 0.0));
            assert_eq!(plain.mean(), film.mean(), "{kind}, {text}");
        }
    }
}
