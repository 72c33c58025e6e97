//! From the object tree to tables: what plugins and their properties become.

use halflight::film::aov::{Aov, AovSet};
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::error::SceneError;
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::scene::{lobe_flag, lobe_kind, quadric_kind, scene_flag, shape_flag};
use std::path::Path;

const SENSOR: &str = r#"<sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 1, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="24"/><rfilter type="box"/></film></sensor>"#;

fn build(version: &str, content: &str) -> Result<Scene, SceneError> {
    let text = format!(r#"<scene version="{version}">{content}</scene>"#);
    let parsed = parse_scene_from_str(&text, Path::new("test.xml"), &[], false)?;
    build_scene(&parsed, &BuildOptions::default())
}

/// Builds content beside a sensor, without a warning.
fn clean(content: &str) -> Scene {
    let scene = build(
        "3.0.0",
        &format!("{SENSOR}{content}<emitter type=\"constant\"/>"),
    )
    .expect("tables");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene
}

fn error(content: &str) -> String {
    build("3.0.0", &format!("{SENSOR}{content}"))
        .expect_err("an error")
        .to_string()
}

/// First-surface position and normal of every pixel.
fn features(scene: &Scene) -> Vec<f64> {
    let options = RenderOptions {
        goal: Goal::Samples(1),
        seed: 3,
        first_sample: 0,
        adaptive: false,
    };
    let aovs = AovSet::NONE.with(Aov::Position).with(Aov::Normal);
    let film = render_film(scene, &options, aovs).expect("a film");
    film.aov_sums().to_vec()
}

#[test]
fn instances_are_where_copies_would_be() {
    let cube = |name: &str, transform: &str| {
        format!(
            r#"<shape type="{name}"><transform name="to_world">{transform}</transform><bsdf type="diffuse"/></shape>"#
        )
    };
    let places = [
        r#"<rotate y="1" angle="30"/><translate x="-1.2"/>"#,
        r#"<scale x="0.5" y="1.2" z="-0.7"/><rotate z="1" angle="-20"/><translate x="1.4" y="0.3"/>"#,
    ];
    let group = format!(
        r#"<shape type="shapegroup" id="group">{}{}</shape>"#,
        cube("cube", r#"<scale value="0.5"/>"#),
        cube("sphere", r#"<scale value="0.4"/><translate y="0.9"/>"#)
    );
    let mut instanced = group;
    let mut copied = String::new();
    for place in places {
        instanced += &format!(
            r#"<shape type="instance"><ref id="group"/><transform name="to_world">{place}</transform></shape>"#
        );
        copied += &cube("cube", &format!(r#"<scale value="0.5"/>{place}"#));
        copied += &cube(
            "sphere",
            &format!(r#"<scale value="0.4"/><translate y="0.9"/>{place}"#),
        );
    }
    let (instanced, copied) = (clean(&instanced), clean(&copied));
    assert_eq!(instanced.tables.instances.len(), 3);
    assert_eq!(instanced.tables.groups.len(), 2);
    let (a, b) = (features(&instanced), features(&copied));
    assert!(a.iter().any(|v| *v != 0.0));
    let differing = a
        .iter()
        .zip(&b)
        .filter(|(x, y)| (x.abs() - y.abs()).abs() > 1e-3)
        .count();
    // A ray at a silhouette may fall on the other side by rounding.
    assert!(
        differing <= a.len() / 200,
        "{differing} of {} values differ",
        a.len()
    );
}

#[test]
fn both_generations_of_the_format_mean_the_same() {
    let new = format!(
        r#"{SENSOR}<shape type="sphere"><transform name="to_world"><translate x="1"/></transform>
        <bsdf type="roughdielectric"><float name="int_ior" value="1.6"/><float name="ext_ior" value="1.1"/>
        <float name="alpha" value="0.2"/><string name="distribution" value="ggx"/></bsdf></shape>
        <emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/><rgb name="irradiance" value="2"/></emitter>"#
    );
    let old = new
        .replace("to_world", "toWorld")
        .replace("int_ior", "intIOR")
        .replace("ext_ior", "extIOR");
    let new = build("3.0.0", &new).expect("tables");
    let old = build("0.6.0", &old).expect("tables");
    assert_eq!(old.tables.fingerprint(), new.tables.fingerprint());
    assert!(old.warnings.is_empty(), "{:?}", old.warnings);
}

#[test]
fn wrappers_flatten_to_weighted_lobes() {
    let scene = clean(
        r#"<shape type="sphere"><bsdf type="mask"><float name="opacity" value="0.25"/>
        <bsdf type="twosided"><bsdf type="blendbsdf"><float name="weight" value="0.3"/>
        <bsdf type="diffuse"/><bsdf type="roughconductor"/></bsdf></bsdf></bsdf></shape>"#,
    );
    let tables = &scene.tables;
    assert_ne!(tables.info.flags & scene_flag::HAS_NULL, 0);
    let material = tables.materials[tables.shapes[0].material as usize];
    let lobes = &tables.lobes[material.first_lobe as usize..][..material.lobe_count as usize];
    let kinds: Vec<_> = lobes.iter().map(|l| l.kind).collect();
    assert_eq!(
        kinds,
        [
            lobe_kind::DIFFUSE,
            lobe_kind::ROUGH_CONDUCTOR,
            lobe_kind::NULL
        ]
    );
    let weight = |i: usize| -> f32 {
        tables.factors[lobes[i].first_factor as usize..][..lobes[i].factor_count as usize]
            .iter()
            .map(|f| {
                if f.complement == 1 {
                    1.0 - f.parameter.value
                } else {
                    f.parameter.value
                }
            })
            .product()
    };
    for (i, expected) in [0.25 * 0.7, 0.25 * 0.3, 0.75].into_iter().enumerate() {
        assert!(
            (weight(i) - expected).abs() < 1e-6,
            "lobe {i}: {}",
            weight(i)
        );
    }
    assert_ne!(lobes[0].flags & lobe_flag::FLIP_BACK, 0);
    assert_eq!(lobes[2].flags & lobe_flag::FLIP_BACK, 0);
}

#[test]
fn a_material_is_built_once() {
    let scene = clean(
        r#"<bsdf type="diffuse" id="grey"/>
        <shape type="sphere"><ref id="grey"/></shape><shape type="cube"><ref id="grey"/></shape><shape type="disk"/>"#,
    );
    assert_eq!(scene.tables.materials.len(), 2);
    assert_eq!(
        scene.tables.shapes[0].material,
        scene.tables.shapes[1].material
    );
}

#[test]
fn spheres_and_cylinders_keep_their_outside() {
    let scene = clean(
        r#"<shape type="sphere"/>
        <shape type="sphere"><transform name="to_world"><scale x="-1" y="1" z="1"/></transform></shape>
        <shape type="sphere"><boolean name="flip_normals" value="true"/></shape>
        <shape type="cylinder"><point name="p0" x="0" y="1" z="0"/><point name="p1" x="0" y="3" z="0"/><float name="radius" value="0.5"/></shape>"#,
    );
    let flipped: Vec<_> = scene
        .tables
        .shapes
        .iter()
        .map(|s| s.flags & shape_flag::FLIP_NORMALS != 0)
        .collect();
    // Mitsuba turns a mirrored sphere inside out.
    assert_eq!(flipped, [false, true, true, false]);
    let cylinder = &scene.tables.quadrics[3];
    assert_eq!(cylinder.kind, quadric_kind::CYLINDER);
    let m = cylinder.to_world;
    // The canonical axis goes from p0 to p1.
    assert_eq!([m[3], m[7], m[11]], [0.0, 1.0, 0.0]);
    assert_eq!([m[2], m[6], m[10]], [0.0, 2.0, 0.0]);
}

#[test]
fn a_focal_length_is_a_field_of_view() {
    let by_length = SENSOR.replace(
        r#"<float name="fov" value="40"/>"#,
        r#"<string name="focal_length" value="50mm"/>"#,
    );
    let scene = build("3.0.0", &by_length).expect("tables");
    let camera = &scene.tables.camera;
    let diagonal = camera.tan_half_width.hypot(camera.tan_half_height);
    assert!((diagonal - 43.2666 / 100.0).abs() < 1e-5, "{diagonal}");
}

#[test]
fn every_filter_and_sampler_is_known() {
    for filter in [
        "box",
        "tent",
        "gaussian",
        "mitchell",
        "catmullrom",
        "lanczos",
    ] {
        let sensor = SENSOR.replace(
            "rfilter type=\"box\"",
            &format!("rfilter type=\"{filter}\""),
        );
        let scene =
            build("3.0.0", &format!("{sensor}<emitter type=\"constant\"/>")).expect("tables");
        assert!(scene.warnings.is_empty(), "{filter}: {:?}", scene.warnings);
    }
    for sampler in [
        "independent",
        "stratified",
        "multijitter",
        "orthogonal",
        "ldsampler",
        "sobol",
        "halton",
        "hammersley",
    ] {
        let sensor = SENSOR.replace("<film", &format!("<sampler type=\"{sampler}\"/><film"));
        let scene =
            build("3.0.0", &format!("{sensor}<emitter type=\"constant\"/>")).expect("tables");
        assert!(scene.warnings.is_empty(), "{sampler}: {:?}", scene.warnings);
    }
}

#[test]
fn what_cannot_be_built_is_named() {
    let sphere = |bsdf: &str| format!(r#"<shape type="sphere">{bsdf}</shape>"#);
    let cases = [
        (
            sphere(r#"<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>"#),
            "two-sided",
        ),
        (
            sphere(r#"<bsdf type="blendbsdf"><bsdf type="diffuse"/></bsdf>"#),
            "nested BSDF",
        ),
        (
            sphere(
                r#"<bsdf type="conductor"><string name="material" value="Unobtainium"/></bsdf>"#,
            ),
            "Unobtainium",
        ),
        (
            sphere(r#"<bsdf type="dielectric"><string name="int_ior" value="warer"/></bsdf>"#),
            "water",
        ),
        (
            sphere(r#"<bsdf type="roughconductor"><float name="alpha" value="-0.1"/></bsdf>"#),
            "negative",
        ),
        (r#"<shape type="instance"/>"#.to_string(), "shape group"),
        (
            r#"<emitter type="constant"/><emitter type="constant"/>"#.to_string(),
            "more than one environment",
        ),
    ];
    for (content, part) in cases {
        let message = error(&content);
        assert!(
            message.contains(part) && message.starts_with("test.xml:"),
            "{message}"
        );
    }
}

#[test]
fn too_many_lobes_are_refused() {
    let mut bsdf = r#"<bsdf type="diffuse"/>"#.to_string();
    for _ in 0..8 {
        bsdf = format!(r#"<bsdf type="blendbsdf"><bsdf type="conductor"/>{bsdf}</bsdf>"#);
    }
    assert!(error(&format!(r#"<shape type="sphere">{bsdf}</shape>"#)).contains("9 lobes"));
}

#[test]
fn unused_properties_are_warned_of() {
    let scene = build(
        "3.0.0",
        &format!(r#"{SENSOR}<shape type="sphere"><float name="radios" value="2"/></shape><emitter type="constant"/>"#),
    )
    .expect("tables");
    let warnings: Vec<_> = scene.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].contains("radios") && warnings[0].starts_with("test.xml:3"),
        "{warnings:?}"
    );
}
