//! The mean of chains is that of path tracing or bidirectional path tracing: every technique of primary samples, every kind of
//! camera and light, by a test that knows the noise of both.

use crate::agreement::report;
use crate::scenes::{LAMP, PINHOLE, room, scene, sky};
use crate::variants::{self, Samples};
use halflight::scene::build::Scene;
use halflight_kernel::transport::markov::primary_space::technique;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};

pub const DIFFUSE: &str =
    r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf>"#;

pub const GLOSSY: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>"#;

pub const BALL: &str = r#"<shape type="sphere"><point name="center" value="0.2, 0.5, 0"/><float name="radius" value="0.4"/>
    <bsdf type="dielectric"/></shape>"#;

pub const VEIL: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.8"/><translate z="0.8" y="1"/></transform>
    <bsdf type="mask"><float name="opacity" value="0.4"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>"#;

pub const POINT: &str = r#"<emitter type="point"><point name="position" value="0, 1.7, 0"/>
    <rgb name="intensity" value="3, 2, 1"/></emitter>"#;

pub const SKY: &str =
    r#"<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>"#;

pub fn camera(kind: &str, own: &str) -> String {
    PINHOLE.replace("perspective", kind).replace(
        r#"<float name="fov""#,
        &format!(r#"{own}<float name="fov""#),
    )
}

/// Short chains, so that whatever is wrong with their start shows.
fn chains(kind: u32) -> ChainSettings {
    ChainSettings {
        technique: kind,
        p_large: 0.3,
        // One strategy at a time finds less than all together.
        candidates: if kind == technique::MULTIPLEXED {
            1024
        } else {
            256
        },
        chains: 16,
        mutations: 96,
        direct_samples: 0,
        ..ChainSettings::DEFAULT
    }
}

/// Compares the techniques with the algorithm of `kind`.
fn agree_with(
    what: &str,
    scene: &mut Scene,
    kind: u32,
    variants: &[(&str, ChainSettings)],
) -> Vec<Result<(), String>> {
    let kinds = [kind, integrator_kind::PRIMARY_SAMPLE_MLT];
    let samples = Samples {
        truth: 256,
        chains: 8,
    };
    variants::agree_with(what, scene, kinds, samples, variants)
}

fn all() -> [(&'static str, ChainSettings); 3] {
    [
        ("path", chains(technique::PATH)),
        ("bdpt", chains(technique::BIDIRECTIONAL)),
        ("multiplexed", chains(technique::MULTIPLEXED)),
    ]
}

#[test]
fn every_technique_has_the_brightness_of_path_tracing() {
    let files: &[crate::scenes::NamedFile<'_>] = &[("sky.exr", &sky)];
    let mut results = Vec::new();
    for (what, content, kind) in [
        (
            "lamp",
            [PINHOLE, &room(DIFFUSE), LAMP].concat(),
            integrator_kind::PATH,
        ),
        (
            "lamp over glossy walls, glass and a veil",
            [PINHOLE, &room(GLOSSY), LAMP, BALL, VEIL].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
        (
            "point light behind a veil",
            [PINHOLE, &room(DIFFUSE), POINT, VEIL].concat(),
            integrator_kind::PATH,
        ),
        (
            "sky",
            [PINHOLE, &room(GLOSSY), SKY].concat(),
            integrator_kind::PATH,
        ),
    ] {
        let mut scene = scene(&content, files);
        results.extend(agree_with(what, &mut scene, kind, &all()));
    }
    report(results);
}

#[test]
fn every_camera_and_filter_has_the_brightness_of_path_tracing() {
    let thin = camera(
        "thinlens",
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="3"/>"#,
    );
    let wide = PINHOLE.replace(r#"<rfilter type="box"/>"#, r#"<rfilter type="mitchell"/>"#);
    let cropped = PINHOLE.replace(
        r#"<rfilter type="box"/>"#,
        r#"<integer name="crop_offset_x" value="1"/><integer name="crop_width" value="5"/>
        <rfilter type="gaussian"/>"#,
    );
    let mut results = Vec::new();
    for (what, camera) in [
        ("thin lens", thin),
        ("wide filter", wide),
        ("crop window", cropped),
        (
            "parallel rays",
            PINHOLE
                .replace("perspective", "orthographic")
                .replace(r#"<float name="fov" value="60"/>"#, ""),
        ),
    ] {
        let mut scene = scene(&[camera.as_str(), &room(DIFFUSE), LAMP].concat(), &[]);
        let kind = integrator_kind::PATH;
        results.extend(agree_with(what, &mut scene, kind, &all()));
    }
    report(results);
}

#[test]
fn options_leave_the_mean_as_it_is() {
    let mut scene = scene(&[PINHOLE, &room(GLOSSY), LAMP].concat(), &[]);
    let usual = chains(technique::BIDIRECTIONAL);
    let multiplexed = chains(technique::MULTIPLEXED);
    let mut results = agree_with(
        "options",
        &mut scene,
        integrator_kind::PATH,
        &[
            (
                "small steps only",
                ChainSettings {
                    p_large: 0.0,
                    ..usual
                },
            ),
            (
                "large steps only",
                ChainSettings {
                    p_large: 1.0,
                    ..usual
                },
            ),
            ("long chains", ChainSettings { chains: 2, ..usual }),
            (
                "few candidates",
                ChainSettings {
                    candidates: 32,
                    chains: 64,
                    ..usual
                },
            ),
            (
                "direct illumination apart",
                ChainSettings {
                    direct_samples: 4,
                    ..usual
                },
            ),
            (
                "direct illumination apart, path",
                ChainSettings {
                    direct_samples: 4,
                    technique: technique::PATH,
                    ..usual
                },
            ),
            (
                "direct illumination apart, multiplexed",
                ChainSettings {
                    direct_samples: 4,
                    ..multiplexed
                },
            ),
        ],
    );
    scene.settings.rules.max_depth = 3;
    scene.settings.rules.hide_emitters = 1;
    results.extend(agree_with(
        "hidden lamp, three edges",
        &mut scene,
        integrator_kind::PATH,
        &all(),
    ));
    report(results);
}
