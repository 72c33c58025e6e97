//! Chains of full paths with edits: each mutation alone keeps the image of other algorithms with the same edits.

use crate::agreement::report;
use crate::brightness::{BALL, DIFFUSE, POINT, SKY, VEIL};
use crate::scenes::{LAMP, NamedFile, PINHOLE, room, scene, sky};
use crate::variants::{self, MIRROR, OF_WHOLE_PATHS};
use halflight::scene::build::{BuildOptions, integrator_settings};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};
use std::path::Path;

const PLASTIC: &str = r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.5, 0.4, 0.3"/><float name="alpha" value="0.3"/></bsdf>"#;

/// What mirrors and glass throw on, moved, scaled and brighter.
const CAUSTIC: &str = r#"<edit type="retarget"><string name="selection" value="L S+ X"/>
    <transform name="source"><scale x="1.2" y="1.2" z="0.1"/><rotate x="1" angle="-90"/><translate x="0.3" y="0.02"/></transform>
    <transform name="target"><scale x="0.9" y="1.4" z="0.1"/><rotate x="1" angle="-90"/><translate x="-0.3" y="0.02" z="0.4"/></transform>
    <float name="intensity" value="2"/></edit>"#;

/// What surfaces that are not specular send onto the floor, stretched and brighter, with the energy that it had.
const BLEEDING: &str = r#"<edit type="retarget"><string name="selection" value="L [DG]+ X"/>
    <transform name="source"><scale x="0.8" y="0.9" z="0.1"/><rotate x="1" angle="-90"/><translate x="-0.6" y="0.02"/></transform>
    <transform name="target"><scale x="1.3" y="0.9" z="0.1"/><rotate x="1" angle="-90"/><translate x="-0.2" y="0.02" z="0.3"/></transform>
    <float name="intensity" value="3"/><string name="keep" value="energy"/></edit>"#;

/// What glossy and specular surfaces show, turned.
const REFLECTION: &str = r#"<edit type="retarget"><string name="selection" value="X [GS] E"/>
    <transform name="map"><scale x="1" y="1.2" z="1"/><rotate y="1" angle="25"/></transform></edit>"#;

const ALONE: [(&str, [f32; 4]); 5] = [
    ("start", [0.0; 4]),
    ("bidirectional", [1.0, 0.0, 0.0, 0.0]),
    ("caustic", [0.0, 0.0, 1.0, 0.0]),
    ("multi-chain", [0.0, 0.0, 0.0, 1.0]),
    ("all", [1.0; 4]),
];

fn chains(weights: [f32; 4]) -> ChainSettings {
    ChainSettings {
        candidates: 2048,
        chains: 16,
        mutations: 128,
        ..variants::of_mutations(weights)
    }
}

fn agree_with(
    what: &str,
    content: &[&str],
    kind: u32,
    variants: &[(&str, ChainSettings)],
) -> Vec<Result<(), String>> {
    let files: &[NamedFile<'_>] = &[("sky.exr", &sky)];
    let mut scene = scene(&content.concat(), files);
    scene.settings.rules.max_depth = 5;
    let kinds = [kind, integrator_kind::VEACH_MLT];
    variants::agree_with(what, &mut scene, kinds, OF_WHOLE_PATHS, variants)
}

#[test]
fn every_mutation_alone_keeps_edited_images() {
    let variants = ALONE.map(|(name, weights)| (name, chains(weights)));
    let room = room(PLASTIC);
    let content = [
        PINHOLE, &room, LAMP, BALL, MIRROR, CAUSTIC, BLEEDING, REFLECTION,
    ];
    let kind = integrator_kind::BIDIRECTIONAL;
    report(agree_with("edits of all kinds", &content, kind, &variants));
}

#[test]
fn half_vectors_move_what_edits_leave_alone() {
    let own = |manifold: f32, half_vector: f32| ChainSettings {
        bidirectional_weight: 0.3,
        manifold_weight: manifold,
        half_vector_weight: half_vector,
        ..chains([0.0; 4])
    };
    let variants = [("manifold", own(1.0, 0.0)), ("half vectors", own(0.0, 1.0))];
    let room = room(PLASTIC);
    let content = [PINHOLE, &room, LAMP, MIRROR, CAUSTIC, REFLECTION];
    let kind = integrator_kind::BIDIRECTIONAL;
    report(agree_with("half vectors", &content, kind, &variants));
}

#[test]
fn chains_of_every_light_have_the_edited_image() {
    let room = room(DIFFUSE);
    let parallel = r#"<emitter type="directional"><vector name="direction" value="0.3, -1, -0.2"/><rgb name="irradiance" value="3, 2, 1"/></emitter>"#;
    let spot = r#"<emitter type="spot"><transform name="to_world"><lookat origin="0.4, 1.7, 0.6" target="0.2, 0.4, 0" up="1, 0, 0"/></transform>
        <rgb name="intensity" value="6, 5, 4"/></emitter>"#;
    let mut results = Vec::new();
    let all = [("all", chains([1.0; 4]))];
    for (what, light) in [
        ("point", POINT),
        ("spot", spot),
        ("sky", SKY),
        ("lamp behind a veil", &[LAMP, VEIL].concat()),
    ] {
        let content = [PINHOLE, &room, light, BALL, CAUSTIC, BLEEDING];
        let kind = integrator_kind::BIDIRECTIONAL;
        results.extend(agree_with(what, &content, kind, &all));
    }
    // Light walks that start all over the scene find few caustics of it.
    let content = [PINHOLE, &room, parallel, BLEEDING];
    let kind = integrator_kind::PATH;
    results.extend(agree_with("directional", &content, kind, &all));
    report(results);
}

/// As users ask for them: with direct illumination apart, and short chains where energy is redistributed.
#[test]
fn algorithms_by_name_have_the_edited_image() {
    let room = room(PLASTIC);
    let content = [
        PINHOLE, &room, LAMP, BALL, MIRROR, CAUSTIC, BLEEDING, REFLECTION,
    ]
    .concat();
    let text = format!("<scene version=\"3.0.0\">{content}</scene>");
    let parsed = parse_scene_from_str(&text, Path::new("scene.xml"), &[], true).unwrap();
    let variants = ["mlt", "erpt", "meerpt"].map(|name| {
        let options = BuildOptions {
            integrator: Some(name.to_owned()),
            ..BuildOptions::default()
        };
        let (settings, _) = integrator_settings(&parsed, &options, 1.0).unwrap();
        let own = ChainSettings {
            mutations: 128,
            ..settings.chains
        };
        (name, own)
    });
    let kind = integrator_kind::BIDIRECTIONAL;
    report(agree_with("by name", &[&content], kind, &variants));
}
