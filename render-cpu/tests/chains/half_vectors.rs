//! Mutations in half-vector space: each alone, in each of its forms, leaves the distribution of paths as it is.
//!
//! As in `full_paths`: chains start from paths drawn with the density that they shall keep.

use crate::agreement::{Batches, compare, report, settings_of};
use crate::brightness::{BALL, DIFFUSE, GLOSSY};
use crate::scenes::{LAMP, NamedFile, PINHOLE, faceted_sphere, room, scene, sky};
use crate::variants::{self, MIRROR, OF_WHOLE_PATHS, lights_cameras_and_masks};
use halflight::film::aov::Aov;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::markov::algorithm::MutationCounts;
use halflight_kernel::transport::settings::{ChainSettings, half_vector_flag, integrator_kind};

const ORIGINAL: u32 = half_vector_flag::ORIGINAL;
const GLOBAL: u32 = half_vector_flag::GLOBAL_ROUGHNESS;
const PROJECTED: u32 = half_vector_flag::PROJECTED;

/// Chains of nothing but these mutations.
fn alone(manifold: f32, half_vector: f32, flags: u32) -> ChainSettings {
    ChainSettings {
        candidates: 2048,
        chains: 16,
        mutations: 128,
        direct_samples: 0,
        bidirectional_weight: 0.0,
        lens_weight: 0.0,
        caustic_weight: 0.0,
        multi_chain_weight: 0.0,
        manifold_weight: manifold,
        half_vector_weight: half_vector,
        half_vector_flags: flags,
        ..ChainSettings::DEFAULT
    }
}

fn manifold() -> ChainSettings {
    alone(1.0, 0.0, 0)
}

fn half_vector(flags: u32) -> ChainSettings {
    alone(0.0, 1.0, flags)
}

/// The bidirectional mutation and all others.
fn all() -> ChainSettings {
    ChainSettings {
        bidirectional_weight: 1.0,
        lens_weight: 1.0,
        caustic_weight: 1.0,
        multi_chain_weight: 1.0,
        ..alone(1.0, 1.0, 0)
    }
}

/// Every mutation alone in every form, and all together.
fn variants() -> Vec<(&'static str, ChainSettings)> {
    vec![
        ("manifold", manifold()),
        ("half vectors", half_vector(0)),
        ("half vectors, original", half_vector(ORIGINAL)),
        ("half vectors, global roughness", half_vector(GLOBAL)),
        ("half vectors, projected", half_vector(PROJECTED)),
        (
            "half vectors, original, projected",
            half_vector(ORIGINAL | PROJECTED),
        ),
        (
            "half vectors, equal steps",
            ChainSettings {
                half_vector_step: 0.1,
                ..half_vector(half_vector_flag::EQUAL_STEPS)
            },
        ),
        (
            "half vectors, original, wide and unstratified",
            ChainSettings {
                half_vector_step: 1.0,
                ..half_vector(ORIGINAL | half_vector_flag::UNSTRATIFIED)
            },
        ),
        ("all", all()),
    ]
}

fn agree_with(
    what: &str,
    scene: &mut Scene,
    kind: u32,
    variants: &[(&str, ChainSettings)],
) -> Vec<Result<(), String>> {
    let kinds = [kind, integrator_kind::VEACH_MLT];
    variants::agree_with(what, scene, kinds, OF_WHOLE_PATHS, variants)
}

/// A sheet of rough glass, a coated ball with the normals of a sphere on eight triangles.
const ROUGH_SHEET: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/>
    <rotate y="1" angle="20"/><translate x="-0.3" y="1" z="1"/></transform>
    <bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf></shape>"#;
const FACETS: &str = r#"<shape type="obj"><string name="filename" value="sphere.obj"/>
    <transform name="to_world"><scale value="0.4"/><rotate x="1" angle="15"/><translate x="0.6" y="0.45" z="0.2"/></transform>
    <bsdf type="roughplastic"><float name="alpha" value="0.15"/></bsdf></shape>"#;
#[test]
fn diffuse_paths_keep_the_image() {
    let mut scene = scene(&[PINHOLE, &room(DIFFUSE), LAMP].concat(), &[]);
    let kind = integrator_kind::PATH;
    let variants = [
        ("manifold", manifold()),
        ("half vectors", half_vector(0)),
        ("half vectors, original", half_vector(ORIGINAL)),
        ("half vectors, projected", half_vector(PROJECTED)),
    ];
    report(agree_with("lamp", &mut scene, kind, &variants));
}

#[test]
fn glass_and_mirrors_keep_the_image() {
    let mut scene = scene(&[PINHOLE, &room(GLOSSY), LAMP, BALL, MIRROR].concat(), &[]);
    let kind = integrator_kind::BIDIRECTIONAL;
    report(agree_with(
        "glass and mirror",
        &mut scene,
        kind,
        &variants(),
    ));
}

#[test]
fn rough_glass_and_smooth_normals_keep_the_image() {
    let files: &[NamedFile<'_>] = &[("sphere.obj", &faceted_sphere)];
    let content = [PINHOLE, &room(GLOSSY), LAMP, ROUGH_SHEET, FACETS].concat();
    let mut scene = scene(&content, files);
    let kind = integrator_kind::BIDIRECTIONAL;
    report(agree_with("rough glass", &mut scene, kind, &variants()));
}

#[test]
fn every_light_camera_and_mask_keeps_the_image() {
    let files: &[NamedFile<'_>] = &[("sky.exr", &sky)];
    let mut results = Vec::new();
    for (what, content, kind) in lights_cameras_and_masks() {
        let mut scene = scene(&content, files);
        let variants = [
            ("manifold", manifold()),
            ("half vectors", half_vector(0)),
            ("half vectors, original", half_vector(ORIGINAL)),
        ];
        results.extend(agree_with(what, &mut scene, kind, &variants));
    }
    report(results);
}

#[test]
fn limits_of_depth_and_hidden_lamps_keep_the_image() {
    let mut scene = scene(&[PINHOLE, &room(GLOSSY), LAMP, MIRROR].concat(), &[]);
    scene.settings.rules.max_depth = 3;
    scene.settings.rules.hide_emitters = 1;
    let kind = integrator_kind::BIDIRECTIONAL;
    report(agree_with(
        "hidden lamp, three edges",
        &mut scene,
        kind,
        &[("all", all()), ("half vectors", half_vector(0))],
    ));
}

/// Maps of the image count every mutation once, and agree with what is counted beside them.
#[test]
fn maps_count_all_mutations() {
    let mut scene = scene(&[PINHOLE, &room(GLOSSY), LAMP, BALL].concat(), &[]);
    scene.settings.kind = integrator_kind::VEACH_MLT;
    scene.settings.chains = all();
    let options = RenderOptions {
        goal: Goal::Samples(3),
        seed: 4,
        first_sample: 0,
        adaptive: false,
    };
    let layers = Aov::OF_CHAINS.into_iter().collect();
    let film = render_film(&scene, &options, layers).unwrap();
    let pixels = film.statistics().len();
    let of = |aov| -> Vec<f64> { (0..pixels).map(|i| film.aov_mean(aov, 0, i)).collect() };
    let mutations = of(Aov::Mutations);
    let per_group: f64 = mutations.iter().sum();
    assert!((per_group - 128.0 * pixels as f64).abs() < 1e-6);
    let mean = |aov| -> f64 {
        let sum = of(aov)
            .iter()
            .zip(&mutations)
            .map(|(a, n)| a * n)
            .sum::<f64>();
        sum / per_group
    };
    let mut counted = MutationCounts::default();
    for (_, counts) in film.chain_counts().iter() {
        counted.merge(counts);
    }
    let share = |n: u64| n as f64 / counted.proposed as f64;
    assert!((counted.proposed as f64 - 3.0 * per_group).abs() < 1e-6);
    // Accepted at random: 18432 trials.
    assert!((mean(Aov::Acceptance) - share(counted.accepted)).abs() < 0.02);
    assert!((mean(Aov::Jumps) - share(counted.walks.jumps)).abs() < 1e-6);
    assert!(counted.walks.found > 100 && counted.walks.irreversible < counted.walks.found / 2);
    assert!(of(Aov::Iterations).iter().any(|n| *n > 1.0));
}

/// Mutations that step far, so that chains forget where they started and go where a wrong acceptance leads them.
fn far() -> Vec<(&'static str, ChainSettings)> {
    let long = |chains: ChainSettings| ChainSettings {
        chains: 8,
        mutations: 512,
        candidates: 4096,
        ..chains
    };
    let far = |flags: u32| {
        long(ChainSettings {
            half_vector_step: 1.5,
            ..half_vector(flags | half_vector_flag::UNSTRATIFIED)
        })
    };
    let turning = ChainSettings {
        lambda: 4.0,
        ..manifold()
    };
    vec![
        ("manifold", long(turning)),
        ("improved", far(0)),
        ("original", far(ORIGINAL)),
    ]
}

/// The image of paths that all mutations move, from chains that come around: a wrong density of steps, of roughness, of turns or
/// of the measure moves blocks by more than their noise. The probabilities of breaking up are too small a part to be seen here, but not in
/// `broken_up`.
#[test]
fn long_chains_of_far_steps_keep_the_image() {
    let metal = r#"<bsdf type="roughconductor"><string name="distribution" value="ggx"/><float name="alpha" value="0.12"/></bsdf>"#;
    let mut results = Vec::new();
    for (what, content, depth) in [
        ("two edges", [PINHOLE, &room(metal), LAMP].concat(), 2),
        ("three edges", [PINHOLE, &room(metal), LAMP].concat(), 3),
    ] {
        let mut scene = scene(&content, &[]);
        scene.settings.rules.max_depth = depth;
        // A lamp that is seen needs no inner vertex, and its paths would not move.
        scene.settings.rules.hide_emitters = 1;
        let settings = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
        let truth = Batches::render(what, &mut scene, settings, 512);
        for (name, chains) in far() {
            let what = format!("{what}, {name}");
            let settings = IntegratorSettings {
                chains,
                ..settings_of(&scene, integrator_kind::VEACH_MLT)
            };
            let found = Batches::render(&what, &mut scene, settings, 2);
            results.push(compare(&what, &truth, &found));
        }
    }
    report(results);
}

/// Metal of a roughness.
fn metal(alpha: f32) -> String {
    format!(
        r#"<bsdf type="roughconductor"><string name="distribution" value="ggx"/><float name="alpha" value="{alpha}"/></bsdf>"#
    )
}

/// Images by chains that come around, against bidirectional path tracing.
fn come_around(
    what: &str,
    content: &str,
    files: &[NamedFile<'_>],
    depth: u32,
    chains: &[(&str, ChainSettings)],
    truth: u32,
    groups: u32,
) -> Vec<Result<(), String>> {
    let mut scene = scene(content, files);
    scene.settings.rules.max_depth = depth;
    scene.settings.rules.hide_emitters = 1;
    let settings = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
    let truth = Batches::render(what, &mut scene, settings, truth);
    let mut results = Vec::new();
    for (name, chains) in chains {
        let what = format!("{what}, {name}");
        let settings = IntegratorSettings {
            chains: *chains,
            ..settings_of(&scene, integrator_kind::VEACH_MLT)
        };
        let found = Batches::render(&what, &mut scene, settings, groups);
        results.push(compare(&what, &truth, &found));
    }
    results
}

/// Where a path is broken up depends on roughness. Below a narrow mirror that throws all light down, paths go on from paint to metal
/// mostly by keeping the mirror's half vector, which is proposed half as often from metal as from paint.
#[test]
fn breaking_up_between_smooth_and_rough_keeps_the_image() {
    let mirror = format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate x="1" angle="90"/><translate y="2.2"/></transform>
        <bsdf type="twosided">{}</bsdf></shape>"#,
        metal(0.04)
    );
    let lamp = LAMP
        .replace(r#"angle="90""#, r#"angle="-90""#)
        .replace("1.8", "1.2");
    let paint = format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale x="0.75" y="2"/><rotate x="1" angle="-90"/>
        <translate x="0.75" y="0.02"/></transform><bsdf type="twosided">{DIFFUSE}</bsdf></shape>"#
    );
    let down = PINHOLE
        .replace("0.1, 1, 3.5", "0, 0.9, 2.5")
        .replace("0, 0.9, 0", "0, 0, 0");
    let content = [&*down, &room(&metal(0.1)), &lamp, &mirror, &paint].concat();
    let what = "paint on metal below a mirror";
    report(come_around(what, &content, &[], 3, &far()[1..2], 768, 3));
}

/// In hollow mirrors several paths have the same half vectors, and walks do not come back.
#[test]
fn walks_that_do_not_come_back_keep_the_image() {
    let inside = PINHOLE
        .replace("0.1, 1, 3.5", "0.3, 1, 1.2")
        .replace("0, 0.9, 0", "-0.3, 0.7, -1");
    let bowl = format!(
        r#"<shape type="sphere"><point name="center" value="0, 1, 0"/><float name="radius" value="2"/>
        <bsdf type="twosided">{}</bsdf></shape>"#,
        metal(0.3)
    );
    let content = [&inside, LAMP, &bowl].concat();
    report(come_around("bowl", &content, &[], 3, &far()[1..], 384, 1));
}

/// Sub-manifolds end at the edges of facets, and jumps lead on.
#[test]
fn jumps_between_facets_keep_the_image() {
    let files: &[NamedFile<'_>] = &[("sphere.obj", &faceted_sphere)];
    let paint = r#"<bsdf type="roughplastic"><float name="alpha" value="0.15"/></bsdf>"#;
    let facets = FACETS
        .replace(paint, &metal(0.3))
        .replace("0.4", "0.9")
        .replace(r#"x="0.6" y="0.45""#, r#"x="0.1" y="0.9""#);
    let content = [PINHOLE, &room(&metal(0.3)), LAMP, &facets].concat();
    report(come_around(
        "facets",
        &content,
        files,
        3,
        &far()[2..],
        384,
        2,
    ));
}
