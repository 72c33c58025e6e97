//! Random scenes.

use crate::files::Files;
use crate::materials::{ROUGHNESS, WITHOUT_VARIANT};
use crate::room::{CONSTANT, LAMP, POINT, Room, path};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::cell::Cell;

fn runner(cases: u32) -> TestRunner {
    TestRunner::new_with_rng(
        Config {
            cases,
            failure_persistence: None,
            max_shrink_iters: 64,
            ..Config::default()
        },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    )
}

/// Any number for a roughness or a reflectance.
fn unit() -> impl Strategy<Value = f32> {
    prop_oneof![4 => 0.0f32..1.0, 1 => Just(0.0), 1 => Just(1.0)]
}

/// A colour, or a texture of one kind or another.
fn color(name: &'static str) -> impl Strategy<Value = String> {
    let file = select(vec![
        "color.png",
        "grey.png",
        "deep.png",
        "alpha.png",
        "sky.hdr",
    ]);
    let filter = select(vec!["nearest", "bilinear"]);
    let wrap = select(vec!["repeat", "mirror", "clamp", "zero", "one"]);
    let bitmap = (file, filter, wrap, 0.3f32..4.0, -1.0f32..1.0).prop_map(
        |(file, filter, wrap, scale, offset)| {
            format!(
                r#"type="bitmap"><string name="filename" value="{file}"/>
                <string name="filter_type" value="{filter}"/><string name="wrap_mode" value="{wrap}"/>
                <transform name="to_uv"><scale value="{scale}"/><translate x="{offset}"/></transform>"#
            )
        },
    );
    let texture = bitmap.prop_recursive(3, 6, 2, |inner| {
        (inner.clone(), inner, prop::array::uniform3(unit()), any::<bool>()).prop_map(
            |(first, second, [r, g, b], is_scale)| {
                if is_scale {
                    format!(
                        r#"type="scale"><rgb name="scale" value="{r}, {g}, {b}"/><texture name="a" {first}</texture>"#
                    )
                } else {
                    format!(
                        r#"type="checkerboard"><texture name="color0" {first}</texture>
                        <texture name="color1" {second}</texture>"#
                    )
                }
            },
        )
    });
    prop_oneof![
        Just(String::new()),
        prop::array::uniform3(unit())
            .prop_map(move |[r, g, b]| format!(r#"<rgb name="{name}" value="{r}, {g}, {b}"/>"#)),
        texture.prop_map(move |text| format!(r#"<texture name="{name}" {text}</texture>"#)),
    ]
}

fn roughness() -> impl Strategy<Value = String> {
    let alpha = prop_oneof![
        unit().prop_map(|a| format!(r#"<float name="alpha" value="{a}"/>"#)),
        (unit(), unit()).prop_map(|(u, v)| format!(
            r#"<float name="alpha_u" value="{u}"/><float name="alpha_v" value="{v}"/>"#
        )),
        select(vec!["alpha", "alpha_u", "alpha_v"])
            .prop_map(|name| format!("<texture {}</texture>", ROUGHNESS.replace("alpha", name))),
    ];
    (alpha, select(vec!["beckmann", "ggx"]), any::<bool>()).prop_map(|(alpha, facets, visible)| {
        format!(
            r#"{alpha}<string name="distribution" value="{facets}"/><boolean name="sample_visible" value="{visible}"/>"#
        )
    })
}

/// A material of any plugin.
fn material() -> impl Strategy<Value = String> {
    let reflecting = prop_oneof![
        color("reflectance").prop_map(|c| format!(r#"<bsdf type="diffuse">{c}</bsdf>"#)),
        (color("reflectance"), unit()).prop_map(|(c, a)| format!(
            r#"<bsdf type="roughdiffuse">{c}<float name="alpha" value="{a}"/></bsdf>"#
        )),
        color("specular_reflectance").prop_map(|c| format!(r#"<bsdf type="conductor">{c}</bsdf>"#)),
        (color("specular_reflectance"), roughness())
            .prop_map(|(c, r)| format!(r#"<bsdf type="roughconductor">{c}{r}</bsdf>"#)),
        (color("diffuse_reflectance"), any::<bool>()).prop_map(|(c, n)| format!(
            r#"<bsdf type="plastic">{c}<boolean name="nonlinear" value="{n}"/></bsdf>"#
        )),
        (color("diffuse_reflectance"), roughness(), any::<bool>()).prop_map(|(c, r, n)| format!(
            r#"<bsdf type="roughplastic">{c}{r}<boolean name="nonlinear" value="{n}"/></bsdf>"#
        )),
    ]
    .boxed();
    let transmitting = (
        select(vec!["dielectric", "thindielectric", "roughdielectric"]),
        color("specular_transmittance"),
        roughness(),
        prop_oneof![Just(1.5f32), 0.6f32..2.0, Just(1.0)],
    )
        .prop_map(|(plugin, c, r, ior)| {
            let r = if plugin == "roughdielectric" { r } else { String::new() };
            format!(
                r#"<bsdf type="{plugin}">{c}{r}<float name="int_ior" value="{ior}"/><float name="ext_ior" value="1"/></bsdf>"#
            )
        });
    prop_oneof![
        4 => reflecting.clone(),
        1 => reflecting.clone().prop_map(|b| format!(r#"<bsdf type="twosided">{b}</bsdf>"#)),
        1 => (reflecting.clone(), reflecting)
            .prop_map(|(a, b)| format!(r#"<bsdf type="twosided">{a}{b}</bsdf>"#)),
        2 => transmitting,
        1 => select(WITHOUT_VARIANT.to_vec()).prop_map(String::from),
    ]
}

/// Several emitters of which at least one is on.
fn emitters() -> impl Strategy<Value = String> {
    let around = prop_oneof![
        Just(String::new()),
        Just(CONSTANT.to_string()),
        (0.0f32..360.0, prop::array::uniform3(-1.0f32..1.0)).prop_map(|(angle, [x, y, z])| format!(
            r#"<emitter type="envmap"><string name="filename" value="sky.hdr"/><transform name="to_world">
            <rotate x="{x}" y="{y}" z="{z}" angle="{angle}"/></transform></emitter>"#
        )),
    ];
    let shape = (
        select(vec!["rectangle", "cube", "sphere", "disk"]),
        prop::array::uniform3(-1.5f32..1.5),
        0.05f32..0.6,
        color("radiance"),
    )
        .prop_map(|(plugin, [x, y, z], size, radiance)| {
            format!(
                r#"<shape type="{plugin}"><transform name="to_world"><scale value="{size}"/>
                <rotate x="1" angle="80"/><translate x="{x}" y="{y}" z="{z}"/></transform>
                <emitter type="area">{radiance}</emitter></shape>"#
            )
        });
    let delta = select(vec![
        POINT.to_string(),
        r#"<emitter type="directional"><vector name="direction" x="0.4" y="-1" z="-0.7"/></emitter>"#.into(),
        r#"<emitter type="spot"><transform name="to_world"><lookat origin="1, 2, 3" target="0, 0, 0"
            up="0, 1, 0"/></transform><rgb name="intensity" value="9"/></emitter>"#
            .into(),
    ]);
    let rest = prop::collection::vec(prop_oneof![shape, delta], 0..4);
    (around, rest).prop_map(|(around, rest)| [LAMP, &around, &rest.concat()].concat())
}

fn integrator() -> impl Strategy<Value = String> {
    let depth = select(vec![-1, 2, 3, 5, 12]);
    (depth, 1..8, prop::array::uniform2(prop::bool::weighted(0.2))).prop_map(
        |(depth, rr_depth, [hides, is_strict])| {
            path(&format!(
                r#"<integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="{rr_depth}"/>
                <boolean name="hide_emitters" value="{hides}"/><boolean name="strict_normals" value="{is_strict}"/>"#
            ))
        },
    )
}

fn sensor() -> impl Strategy<Value = [String; 3]> {
    let filter = select(vec!["box", "tent", "gaussian", "mitchell"])
        .prop_map(|name| format!(r#"<rfilter type="{name}"/>"#));
    let plugin = prop_oneof![
        Just(("perspective", r#"<float name="fov" value="55"/>"#)),
        Just((
            "thinlens",
            r#"<float name="fov" value="55"/><float name="aperture_radius" value="0.1"/>
            <float name="focus_distance" value="4"/>"#
        )),
        Just(("orthographic", r#"<float name="near_clip" value="0.1"/>"#)),
    ];
    (plugin, filter).prop_map(|((plugin, inside), filter)| [plugin.into(), inside.into(), filter])
}

/// More things, on which textures and normals are those of their kind of shape.
fn shapes() -> impl Strategy<Value = String> {
    let plugin = select(vec![
        ("cube", ""),
        ("sphere", ""),
        ("cylinder", ""),
        ("obj", "ball.obj"),
        ("ply", "tinted.ply"),
    ]);
    let shape = (plugin, material(), any::<Index>(), -0.5f32..0.5, any::<bool>()).prop_map(
        |((plugin, file), material, place, height, flips)| {
            let file = if file.is_empty() {
                String::new()
            } else {
                format!(r#"<string name="filename" value="{file}"/>"#)
            };
            let x = place.index(7) as f32 * 0.4 - 1.2;
            format!(
                r#"<shape type="{plugin}">{file}<boolean name="flip_normals" value="{flips}"/>
                <transform name="to_world"><scale value="0.25"/><rotate x="1" y="0.3" z="0" angle="50"/>
                <translate x="{x}" y="{height}" z="1.4"/></transform>{material}</shape>"#
            )
        },
    );
    prop::collection::vec(shape, 0..4).prop_map(|shapes| shapes.concat())
}

#[test]
fn random_scenes() {
    const CASES: u32 = 32;
    let files = Files::new();
    let scene = (
        integrator(),
        sensor(),
        material(),
        material(),
        emitters(),
        shapes(),
    );
    // Some may be dark.
    let sum = Cell::new(0.0);
    runner(CASES)
        .run(
            &scene,
            |(integrator, sensor, walls, material, emitters, shapes)| {
                let room = Room {
                    integrator,
                    sensor,
                    walls,
                    material,
                    emitters,
                    shapes,
                    ..Room::new()
                };
                sum.set(sum.get() + room.lit_share(&files));
                Ok(())
            },
        )
        .unwrap();
    let share = sum.get() / CASES as f32;
    assert!(share > 0.4, "{share} of the samples are lit");
}
