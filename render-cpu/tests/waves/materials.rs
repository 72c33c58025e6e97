//! Scattering models with loops of their own, and those without among them.

use crate::files::Files;
use crate::room::{CONSTANT, LAMP, POINT, Room};
use halflight_kernel::scene::{distribution, lobe_kind};

/// A texture in place of a number: 0.04 to 1.
pub const ROUGHNESS: &str = r#"name="alpha" type="bitmap"><string name="filename" value="grey.png"/>
    <boolean name="raw" value="true"/>"#;

/// Compares a room of the material; it must be plain and of a kind and a distribution, so that it has a loop.
fn plain(files: &Files, kind: u32, facets: u32, material: &str) {
    let room = Room::with_material(material);
    let scene = room.build(files);
    let has_loop = scene.tables.materials.iter().any(|m| {
        let lobe = &scene.tables.lobes[m.first_lobe as usize];
        lobe.is_plain() && m.lobe_count == 1 && (lobe.kind, lobe.distribution) == (kind, facets)
    });
    assert!(has_loop, "{material}");
    room.agrees(files);
}

/// [`plain`] of a kind without microfacets.
fn smooth(files: &Files, kind: u32, material: &str) {
    plain(files, kind, distribution::BECKMANN, material);
}

/// [`plain`] with both distributions; `@` stands for the distribution.
fn rough(files: &Files, kind: u32, material: &str) {
    for (facets, name) in [
        (distribution::BECKMANN, "beckmann"),
        (distribution::GGX, "ggx"),
    ] {
        let named = format!(r#"<string name="distribution" value="{name}"/>"#);
        plain(files, kind, facets, &material.replace('@', &named));
    }
}

#[test]
fn diffuse_surfaces() {
    let files = Files::new();
    smooth(
        &files,
        lobe_kind::DIFFUSE,
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.1"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::DIFFUSE,
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="1, 0, 0"/></bsdf>"#,
    );
    for alpha in [0.0, 0.3, 1.0] {
        let alpha =
            format!(r#"<bsdf type="roughdiffuse"><float name="alpha" value="{alpha}"/></bsdf>"#);
        smooth(&files, lobe_kind::ROUGH_DIFFUSE, &alpha);
    }
    let textured = format!(r#"<bsdf type="roughdiffuse"><texture {ROUGHNESS}</texture></bsdf>"#);
    smooth(&files, lobe_kind::ROUGH_DIFFUSE, &textured);
}

#[test]
fn smooth_surfaces() {
    let files = Files::new();
    smooth(
        &files,
        lobe_kind::CONDUCTOR,
        r#"<bsdf type="conductor"><string name="material" value="Au"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::CONDUCTOR,
        r#"<bsdf type="conductor"><rgb name="eta" value="0.2, 0.9, 1.1"/><rgb name="k" value="3.9, 2.4, 2.2"/>
        <rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::DIELECTRIC,
        r#"<bsdf type="dielectric"/>"#,
    );
    smooth(
        &files,
        lobe_kind::DIELECTRIC,
        r#"<bsdf type="dielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1.33"/>
        <rgb name="specular_transmittance" value="0.9, 0.8, 0.7"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::DIELECTRIC,
        r#"<bsdf type="dielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::THIN_DIELECTRIC,
        r#"<bsdf type="thindielectric"><rgb name="specular_reflectance" value="0.5, 1, 1"/></bsdf>"#,
    );
}

#[test]
fn plastic_surfaces() {
    let files = Files::new();
    for nonlinear in [false, true] {
        let material = format!(
            r#"<bsdf type="plastic"><boolean name="nonlinear" value="{nonlinear}"/>
            <rgb name="diffuse_reflectance" value="0.1, 0.6, 0.9"/></bsdf>"#
        );
        smooth(&files, lobe_kind::PLASTIC, &material);
        let material = format!(
            r#"<bsdf type="roughplastic">@<boolean name="nonlinear" value="{nonlinear}"/>
            <rgb name="diffuse_reflectance" value="0.1, 0.6, 0.9"/><float name="alpha" value="0.15"/></bsdf>"#
        );
        rough(&files, lobe_kind::ROUGH_PLASTIC, &material);
    }
    rough(
        &files,
        lobe_kind::ROUGH_PLASTIC,
        r#"<bsdf type="roughplastic">@<boolean name="sample_visible" value="false"/></bsdf>"#,
    );
    rough(
        &files,
        lobe_kind::ROUGH_PLASTIC,
        &format!(r#"<bsdf type="roughplastic">@<texture {ROUGHNESS}</texture></bsdf>"#),
    );
    for one in ["alpha_u", "alpha_v"] {
        let texture = ROUGHNESS.replace("alpha", one);
        rough(
            &files,
            lobe_kind::ROUGH_PLASTIC,
            &format!(r#"<bsdf type="roughplastic">@<texture {texture}</texture></bsdf>"#),
        );
    }
    // Without a table.
    rough(
        &files,
        lobe_kind::ROUGH_PLASTIC,
        r#"<bsdf type="roughplastic">@<string name="transmittance" value="smooth"/></bsdf>"#,
    );
}

#[test]
fn rough_conductors() {
    let files = Files::new();
    for parameters in [
        r#"<string name="material" value="Cu"/>"#,
        r#"<float name="alpha_u" value="0.05"/><float name="alpha_v" value="0.4"/>"#,
        r#"<float name="alpha" value="0.3"/><boolean name="sample_visible" value="false"/>"#,
        r#"<float name="alpha" value="0.0001"/>"#,
        r#"<float name="alpha" value="1"/><rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/>"#,
        &format!("<texture {ROUGHNESS}</texture>"),
        &format!(
            r#"<float name="alpha_u" value="0.3"/><texture {}</texture>"#,
            ROUGHNESS.replace("alpha", "alpha_v")
        ),
        &format!(
            r#"<float name="alpha_v" value="0.3"/><texture {}</texture>"#,
            ROUGHNESS.replace("alpha", "alpha_u")
        ),
    ] {
        let material = format!(r#"<bsdf type="roughconductor">@{parameters}</bsdf>"#);
        rough(&files, lobe_kind::ROUGH_CONDUCTOR, &material);
    }
}

#[test]
fn rough_dielectrics() {
    let files = Files::new();
    for parameters in [
        "",
        r#"<float name="alpha_u" value="0.05"/><float name="alpha_v" value="0.4"/>"#,
        r#"<float name="alpha" value="0.3"/><boolean name="sample_visible" value="false"/>"#,
        r#"<float name="int_ior" value="1"/><float name="ext_ior" value="1.5"/>"#,
        r#"<rgb name="specular_transmittance" value="0.9, 0.8, 0.7"/><float name="alpha" value="0.6"/>"#,
        &format!("<texture {ROUGHNESS}</texture>"),
    ] {
        let material = format!(r#"<bsdf type="roughdielectric">@{parameters}</bsdf>"#);
        rough(&files, lobe_kind::ROUGH_DIELECTRIC, &material);
    }
}

#[test]
fn two_sided_surfaces() {
    let files = Files::new();
    smooth(
        &files,
        lobe_kind::DIFFUSE,
        r#"<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::PLASTIC,
        r#"<bsdf type="twosided"><bsdf type="plastic"/></bsdf>"#,
    );
    smooth(
        &files,
        lobe_kind::CONDUCTOR,
        r#"<bsdf type="twosided"><bsdf type="conductor"/></bsdf>"#,
    );
    rough(
        &files,
        lobe_kind::ROUGH_PLASTIC,
        r#"<bsdf type="twosided"><bsdf type="roughplastic">@</bsdf></bsdf>"#,
    );
    rough(
        &files,
        lobe_kind::ROUGH_CONDUCTOR,
        r#"<bsdf type="twosided"><bsdf type="roughconductor">@</bsdf></bsdf>"#,
    );
    Room::with_material(
        r#"<bsdf type="twosided"><bsdf type="plastic"/><bsdf type="diffuse"/></bsdf>"#,
    )
    .agrees(&files);
    // Seen from behind.
    for sided in [
        r#"<bsdf type="diffuse"/>"#,
        r#"<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>"#,
        r#"<bsdf type="twosided"><bsdf type="roughconductor"/></bsdf>"#,
        r#"<bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="roughplastic"/></bsdf>"#,
    ] {
        let room = Room {
            shapes: format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale x="1.5" y="0.4" z="1"/>
                <rotate y="1" angle="170"/><translate y="0.9" z="1"/></transform>{sided}</shape>"#
            ),
            emitters: format!("{LAMP}{POINT}{CONSTANT}"),
            ..Room::new()
        };
        room.agrees(&files);
    }
}

/// Materials that take the way of a single path.
pub const WITHOUT_VARIANT: [&str; 9] = [
    r#"<bsdf type="null"/>"#,
    r#"<bsdf type="mask"><float name="opacity" value="0.6"/><bsdf type="diffuse"/></bsdf>"#,
    r#"<bsdf type="mask"><texture name="opacity" type="bitmap"><string name="filename" value="grey.png"/></texture>
        <bsdf type="roughconductor"/></bsdf>"#,
    r#"<bsdf type="blendbsdf"><float name="weight" value="0.3"/><bsdf type="diffuse"/><bsdf type="conductor"/></bsdf>"#,
    r#"<bsdf type="blendbsdf"><texture name="weight" type="checkerboard"/><bsdf type="roughplastic"/>
        <bsdf type="dielectric"/></bsdf>"#,
    r#"<bsdf type="bumpmap"><texture type="bitmap"><string name="filename" value="grey.png"/></texture>
        <float name="scale" value="0.2"/><bsdf type="diffuse"/></bsdf>"#,
    r#"<bsdf type="normalmap"><texture name="normalmap" type="bitmap"><string name="filename" value="normals.png"/>
        <boolean name="raw" value="true"/></texture><bsdf type="roughconductor"/></bsdf>"#,
    r#"<bsdf type="coating"><bsdf type="diffuse"/></bsdf>"#,
    r#"<bsdf type="roughconductor"><string name="distribution" value="phong"/></bsdf>"#,
];

#[test]
fn materials_without_loops_among_plain_ones() {
    let files = Files::new();
    for material in WITHOUT_VARIANT {
        let room = Room::with_material(material);
        room.agrees(&files);
        let lit_by_all = Room {
            walls: r#"<bsdf type="plastic"/>"#.into(),
            emitters: format!("{LAMP}{POINT}{CONSTANT}"),
            ..room
        };
        lit_by_all.agrees(&files);
    }
}

#[test]
fn all_materials_together() {
    let files = Files::new();
    let materials = [
        r#"<bsdf type="diffuse"/>"#,
        r#"<bsdf type="roughdiffuse"/>"#,
        r#"<bsdf type="conductor"/>"#,
        r#"<bsdf type="dielectric"/>"#,
        r#"<bsdf type="thindielectric"/>"#,
        r#"<bsdf type="plastic"/>"#,
        r#"<bsdf type="roughconductor"/>"#,
        r#"<bsdf type="roughconductor"><string name="distribution" value="ggx"/></bsdf>"#,
        r#"<bsdf type="roughdielectric"/>"#,
        r#"<bsdf type="roughdielectric"><string name="distribution" value="ggx"/></bsdf>"#,
        r#"<bsdf type="roughplastic"/>"#,
        r#"<bsdf type="roughplastic"><string name="distribution" value="ggx"/></bsdf>"#,
    ];
    let shapes: String = materials
        .iter()
        .chain(&WITHOUT_VARIANT)
        .enumerate()
        .map(|(i, material)| {
            let (x, y) = ((i % 6) as f32 * 0.6 - 1.5, (i / 6) as f32 * 0.6 - 0.8);
            format!(
                r#"<shape type="cube"><transform name="to_world"><scale value="0.2"/><rotate y="1" angle="{i}0"/>
                <translate x="{x}" y="{y}" z="1.2"/></transform>{material}</shape>"#
            )
        })
        .collect();
    let room = Room {
        shapes,
        emitters: format!("{LAMP}{POINT}{CONSTANT}"),
        ..Room::new()
    };
    room.agrees(&files);
}
