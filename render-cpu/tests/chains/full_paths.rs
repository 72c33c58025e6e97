//! Chains of full paths: each mutation alone leaves the distribution of paths as it is.
//!
//! Chains start from paths drawn with the density that they shall keep, so the image stays that of path tracing whichever mutations
//! they make, if each keeps detailed balance, and drifts away if one does not: the longer the chains, the farther.

use crate::agreement::report;
use crate::brightness::{BALL, DIFFUSE, GLOSSY};
use crate::scenes::{LAMP, NamedFile, PINHOLE, room, scene, sky};
use crate::variants::{self, MIRROR, OF_WHOLE_PATHS, lights_cameras_and_masks};
use halflight::scene::build::Scene;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};

fn chains(weights: [f32; 4]) -> ChainSettings {
    ChainSettings {
        candidates: 2048,
        chains: 16,
        mutations: 128,
        ..variants::of_mutations(weights)
    }
}

const ALL: [f32; 4] = [1.0; 4];

fn agree_with(
    what: &str,
    scene: &mut Scene,
    kind: u32,
    variants: &[(&str, [f32; 4])],
) -> Vec<Result<(), String>> {
    let kinds = [kind, integrator_kind::VEACH_MLT];
    let variants: Vec<_> = variants.iter().map(|(n, w)| (*n, chains(*w))).collect();
    variants::agree_with(what, scene, kinds, OF_WHOLE_PATHS, &variants)
}

#[test]
fn every_mutation_alone_and_all_together_keep_the_image() {
    let mut results = Vec::new();
    let mut diffuse = scene(&[PINHOLE, &room(DIFFUSE), LAMP].concat(), &[]);
    results.extend(agree_with(
        "lamp",
        &mut diffuse,
        integrator_kind::PATH,
        &[
            ("start", [0.0; 4]),
            ("bidirectional", [1.0, 0.0, 0.0, 0.0]),
            ("lens", [0.0, 1.0, 0.0, 0.0]),
            ("all", ALL),
        ],
    ));
    let mut glass = scene(&[PINHOLE, &room(GLOSSY), LAMP, BALL, MIRROR].concat(), &[]);
    results.extend(agree_with(
        "glass and mirror",
        &mut glass,
        integrator_kind::BIDIRECTIONAL,
        &[
            ("start", [0.0; 4]),
            ("bidirectional", [1.0, 0.0, 0.0, 0.0]),
            ("lens", [0.0, 1.0, 0.0, 0.0]),
            ("caustic", [0.0, 0.0, 1.0, 0.0]),
            ("multi-chain", [0.0, 0.0, 0.0, 1.0]),
            ("all", ALL),
        ],
    ));
    report(results);
}

#[test]
fn every_light_camera_and_mask_keeps_the_image() {
    let files: &[NamedFile<'_>] = &[("sky.exr", &sky)];
    let mut results = Vec::new();
    for (what, content, kind) in lights_cameras_and_masks() {
        let mut scene = scene(&content, files);
        results.extend(agree_with(what, &mut scene, kind, &[("all", ALL)]));
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
        &[("all", ALL)],
    ));
}
