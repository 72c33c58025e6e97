//! Layered and mixed BSDFs of scene files: what is left of them after flattening.

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::error::SceneError;
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::bsdf::rough_transmittance::{ROW, ROWS};
use halflight_kernel::scene::{NONE, lobe_flag, lobe_kind};
use std::path::Path;

/// A sphere with the given BSDF.
fn build(bsdf: &str) -> Result<Scene, SceneError> {
    let text = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/><shape type=\"sphere\">{bsdf}</shape></scene>"
    );
    let parsed = parse_scene_from_str(&text, Path::new("scene.xml"), &[], false)?;
    build_scene(&parsed, &BuildOptions::default())
}

#[track_caller]
fn error(bsdf: &str) -> String {
    match build(bsdf) {
        Ok(_) => panic!("accepted: {bsdf}"),
        Err(error) => error.to_string(),
    }
}

const ROUGH_GOLD: &str =
    "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Au\"/></bsdf>";

#[test]
fn coating_becomes_its_reflection_and_the_base_below() {
    let scene = build(&format!(
        "<bsdf type=\"coating\"><float name=\"intIOR\" value=\"1.5\"/><float name=\"extIOR\" value=\"1\"/>
            <float name=\"thickness\" value=\"2\"/><rgb name=\"sigmaA\" value=\"0.1, 0.2, 0.3\"/>
            <rgb name=\"specularReflectance\" value=\"0.5\"/>{ROUGH_GOLD}</bsdf>"
    ))
    .unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let [surface, base] = scene.tables.lobes[..] else {
        panic!("{} lobes", scene.tables.lobes.len());
    };
    assert_eq!((surface.kind, surface.coat_count), (lobe_kind::COAT, 0));
    assert_eq!(surface.eta.value, [1.5; 3]);
    assert_eq!(surface.specular_reflectance.value, [0.5; 3]);
    assert_eq!(
        (base.kind, base.coat_count),
        (lobe_kind::ROUGH_CONDUCTOR, 1)
    );
    assert_eq!(base.coats[0].eta, 1.5);
    assert_eq!(base.coats[0].optical_depth.value, [0.2, 0.4, 0.6]);
    assert_eq!(base.coats[0].table, NONE);
}

#[test]
fn nested_coatings_are_listed_from_outside() {
    let scene = build(&format!(
        "<bsdf type=\"roughcoating\"><float name=\"int_ior\" value=\"1.3\"/><float name=\"ext_ior\" value=\"1\"/>
            <float name=\"alpha\" value=\"0.2\"/>
            <bsdf type=\"coating\"><float name=\"int_ior\" value=\"1.6\"/><float name=\"ext_ior\" value=\"1.3\"/>
                <bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.25\"/>
                    <bsdf type=\"diffuse\"/>{ROUGH_GOLD}</bsdf></bsdf></bsdf>"
    ))
    .unwrap();
    let lobes = &scene.tables.lobes;
    let found: Vec<_> = lobes
        .iter()
        .map(|l| (l.kind, l.coat_count, l.factor_count))
        .collect();
    assert_eq!(
        found,
        [
            (lobe_kind::ROUGH_COAT, 0, 0),
            (lobe_kind::COAT, 1, 0),
            (lobe_kind::DIFFUSE, 2, 1),
            (lobe_kind::ROUGH_CONDUCTOR, 2, 1),
        ]
    );
    for lobe in &lobes[2..] {
        assert_eq!(lobe.coats[0].eta, 1.3);
        assert!((lobe.coats[1].eta - 1.6 / 1.3).abs() < 1e-6);
        assert!(lobe.coats[0].table != NONE && lobe.coats[1].table == NONE);
    }
    let smooth = build(
        "<bsdf type=\"roughcoating\"><string name=\"transmittance\" value=\"smooth\"/><bsdf type=\"diffuse\"/></bsdf>",
    )
    .unwrap();
    assert_eq!(smooth.tables.lobes[1].coats[0].table, NONE);
}

#[test]
fn perturbed_frames_lie_above_or_below_coats() {
    let map = |bsdf: &str| {
        format!("<bsdf type=\"bumpmap\"><texture type=\"checkerboard\"/>{bsdf}</bsdf>")
    };
    let coated = |bsdf: &str| format!("<bsdf type=\"coating\">{bsdf}</bsdf>");
    let flags = |bsdf: &str| {
        let scene = build(bsdf).unwrap();
        let lobes = &scene.tables.lobes;
        let outside = |i: usize| lobes[i].flags & lobe_flag::COATS_OUTSIDE_FRAME != 0;
        (lobes[0].frame != NONE, lobes[1].frame != NONE, outside(1))
    };
    assert_eq!(flags(&map(&coated(ROUGH_GOLD))), (true, true, false));
    assert_eq!(flags(&coated(&map(ROUGH_GOLD))), (false, true, true));
    let both = map(&coated(&map(ROUGH_GOLD)));
    assert!(
        error(&both).contains("normal or bump map"),
        "{}",
        error(&both)
    );
    let between = coated(&map(&coated(ROUGH_GOLD)));
    assert!(error(&between).contains("between two coatings"));
}

#[test]
fn what_cannot_be_coated_is_refused() {
    let glass = "<bsdf type=\"coating\"><bsdf type=\"dielectric\"/></bsdf>";
    assert!(error(glass).contains("cannot be coated"));
    let hole = "<bsdf type=\"coating\"><bsdf type=\"mask\"><bsdf type=\"diffuse\"/></bsdf></bsdf>";
    assert!(error(hole).contains("mask"));
    let three = "<bsdf type=\"coating\"><bsdf type=\"coating\"><bsdf type=\"coating\"><bsdf type=\"diffuse\"/></bsdf></bsdf></bsdf>";
    assert!(error(three).contains("at most 2"));
    let unknown =
        "<bsdf type=\"roughplastic\"><string name=\"transmittance\" value=\"odd\"/></bsdf>";
    assert!(error(unknown).contains("odd"));
}

#[test]
fn mixture_weights_become_factors() {
    let mixture = |weights: &str| {
        format!(
            "<bsdf type=\"mixturebsdf\"><string name=\"weights\" value=\"{weights}\"/>
                <bsdf type=\"diffuse\"/><bsdf type=\"plastic\"/>{ROUGH_GOLD}</bsdf>"
        )
    };
    let scene = build(&mixture("0.2, 0.3 0.4")).unwrap();
    assert!(scene.warnings.is_empty());
    let factors = |scene: &Scene| -> Vec<f32> {
        scene
            .tables
            .factors
            .iter()
            .map(|f| f.parameter.value)
            .collect()
    };
    assert_eq!(factors(&scene), [0.2, 0.3, 0.4]);
    assert_eq!(scene.tables.lobes.len(), 3);
    // More than one would create energy.
    let scene = build(&mixture("1, 2, 1")).unwrap();
    assert_eq!(factors(&scene), [0.25, 0.5, 0.25]);
    assert_eq!(scene.warnings.len(), 1);
    assert!(error(&mixture("0.5, 0.5")).contains("2 weights for 3"));
    assert!(error(&mixture("0.5, x, 0.1")).contains("\"x\""));
    assert!(error(&mixture("0.5, -0.1, 0.1")).contains("at least 0"));
}

#[test]
fn rough_plastic_takes_a_texture_of_roughness() {
    let plastic = |alpha: &str| {
        build(&format!(
            "<bsdf type=\"roughplastic\"><float name=\"thickness\" value=\"0.5\"/>
                <rgb name=\"sigma_a\" value=\"1, 2, 4\"/>{alpha}</bsdf>"
        ))
        .unwrap()
    };
    let constant = plastic("<float name=\"alpha\" value=\"0.3\"/>");
    let textured = plastic("<texture name=\"alpha\" type=\"checkerboard\"/>");
    for (scene, rows) in [(&constant, 1), (&textured, ROWS)] {
        let lobe = scene.tables.lobes[0];
        assert_eq!(lobe.optical_depth.value, [0.5, 1.0, 2.0]);
        assert_eq!(lobe.table_rows as usize, rows);
        assert!(scene.tables.data.len() >= lobe.table as usize + rows * ROW);
    }
    assert_ne!(textured.tables.lobes[0].alpha_u.texture, NONE);
}

#[test]
fn equal_boundaries_share_a_table() {
    let part = "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.3\"/></bsdf>";
    let scene = build(&format!("<bsdf type=\"blendbsdf\">{part}{part}</bsdf>")).unwrap();
    let [a, b] = scene.tables.lobes[..] else {
        panic!("{} lobes", scene.tables.lobes.len());
    };
    assert_eq!(a.table, b.table);
}
