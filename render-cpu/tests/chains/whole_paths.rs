//! Chains of whole paths: each mutation alone leaves the distribution of paths as it is.
//!
//! Chains start from paths drawn with the density that they shall keep, so the image stays that of path tracing whichever mutations
//! they make, if each keeps detailed balance, and drifts away if one does not: the longer the chains, the farther.

use crate::agreement::{Batches, compare, report, settings_of};
use crate::brightness::{BALL, DIFFUSE, GLOSSY, POINT, SKY, VEIL, camera};
use crate::scenes::{LAMP, NamedFile, PINHOLE, room, scene, sky};
use halflight::scene::build::Scene;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};

/// A floor of metal, so that light has far to go between diffuse surfaces.
const MIRROR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.6"/>
    <rotate y="1" angle="-40"/><translate x="1" y="0.7" z="-0.3"/></transform>
    <bsdf type="twosided"><bsdf type="conductor"/></bsdf></shape>"#;

fn chains([bidirectional, lens, caustic, multi_chain]: [f32; 4]) -> ChainSettings {
    ChainSettings {
        candidates: 2048,
        chains: 16,
        mutations: 128,
        direct_samples: 0,
        bidirectional_weight: bidirectional,
        lens_weight: lens,
        caustic_weight: caustic,
        multi_chain_weight: multi_chain,
        ..ChainSettings::DEFAULT
    }
}

const ALL: [f32; 4] = [1.0; 4];

fn agree_with(
    what: &str,
    scene: &mut Scene,
    kind: u32,
    variants: &[(&str, [f32; 4])],
) -> Vec<Result<(), String>> {
    let settings = settings_of(scene, kind);
    let truth = Batches::render(what, scene, settings, 384);
    variants
        .iter()
        .map(|(name, weights)| {
            let what = format!("{what}, {name}");
            let settings = IntegratorSettings {
                chains: chains(*weights),
                ..settings_of(scene, integrator_kind::VEACH_MLT)
            };
            let found = Batches::render(&what, scene, settings, 6);
            let error = truth.relative_error().hypot(found.relative_error());
            if error > 0.03 {
                return Err(format!("{what}: noise of {error:.3} hides everything"));
            }
            compare(&what, &truth, &found)
        })
        .collect()
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
    let thin = camera(
        "thinlens",
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="3"/>"#,
    );
    let parallel = PINHOLE
        .replace("perspective", "orthographic")
        .replace(r#"<float name="fov" value="60"/>"#, "");
    let coated = r#"<bsdf type="plastic"/>"#;
    let mut results = Vec::new();
    for (what, content, kind) in [
        (
            "point light through glass",
            [PINHOLE, &room(DIFFUSE), POINT, BALL].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
        (
            "sky through glass",
            [PINHOLE, &room(DIFFUSE), SKY, BALL].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
        (
            "veil",
            [PINHOLE, &room(DIFFUSE), LAMP, VEIL].concat(),
            integrator_kind::PATH,
        ),
        (
            "coats through a thin lens",
            [&thin, &room(coated), LAMP].concat(),
            integrator_kind::PATH,
        ),
        (
            "parallel rays",
            [&parallel, &room(coated), LAMP, MIRROR].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
    ] {
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
