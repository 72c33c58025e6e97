//! Every emitter before every camera over a diffuse, a rough and a specular scene.

use crate::agreement::{Algorithms, agree, report};
use crate::scenes::{scene, sky};

/// A room of two walls and a floor behind which, seen from the lamp, stands a mirror: the lamp does not light it, so that
/// path tracing finds all light also of lamps that no ray meets.
pub fn room(material: &str, object: &str) -> String {
    format!(
        r#"<bsdf type="twosided" id="wall">{material}</bsdf>
        <shape type="rectangle"><transform name="to_world"><scale value="1.5"/><rotate x="1" angle="-90"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="1.5"/><translate z="-1.5"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="1.5"/><rotate y="1" angle="90"/>
            <translate x="-1.5"/></transform><ref id="wall"/></shape>{object}"#
    )
}

pub const DIFFUSE: &str =
    r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf>"#;

const ROUGH: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.35"/>
    <rgb name="specular_reflectance" value="0.8, 0.6, 0.5"/></bsdf>"#;

/// One side reflects, the other does not.
const MIRROR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/>
    <rotate y="1" angle="-45"/><translate x="1" y="0.6" z="-0.3"/></transform>
    <bsdf type="conductor"><rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/></bsdf></shape>"#;

pub const BLOCK: &str = r#"<shape type="cube"><transform name="to_world"><scale value="0.25"/><rotate y="1" angle="30"/>
    <translate x="-0.3" y="0.25" z="-0.4"/></transform><ref id="wall"/></shape>"#;

/// A shape that shines, at the lamp's place.
pub fn lamp(shape: &str, transform: &str, radiance: &str) -> String {
    format!(
        r#"<shape type="{shape}"><transform name="to_world">{transform}
        <translate x="0.6" y="1.5" z="-0.9"/></transform><emitter type="area">{radiance}</emitter></shape>"#
    )
}

pub const WARM: &str = r#"<rgb name="radiance" value="9, 7, 5"/>"#;

const PICTURE: &str =
    r#"<texture type="bitmap" name="radiance"><string name="filename" value="sky.exr"/></texture>"#;

pub const DOWN: &str = r#"<rotate x="1" angle="90"/><rotate z="1" angle="-20"/>"#;

const AT: &str = r#"<transform name="to_world"><lookat origin="0.6, 1.5, -0.9" target="-0.4, 0.2, -0.6" up="0, 0, 1"/></transform>"#;

/// Every emitter, by name.
pub fn emitters() -> Vec<(&'static str, String)> {
    vec![
        (
            "mesh",
            lamp(
                "rectangle",
                &format!(r#"<scale x="0.3" y="0.2"/>{DOWN}"#),
                WARM,
            ),
        ),
        (
            "cube",
            lamp(
                "cube",
                r#"<scale x="0.15" y="0.1" z="0.2"/><rotate y="1" angle="25"/>"#,
                WARM,
            ),
        ),
        (
            "disk",
            lamp("disk", &format!(r#"<scale x="0.35" y="0.2"/>{DOWN}"#), WARM),
        ),
        ("sphere", lamp("sphere", r#"<scale value="0.2"/>"#, WARM)),
        (
            "ellipsoid",
            lamp(
                "sphere",
                r#"<scale x="0.1" y="0.25" z="0.2"/><rotate z="1" angle="30"/>"#,
                WARM,
            ),
        ),
        (
            "cylinder",
            lamp(
                "cylinder",
                r#"<translate z="-0.5"/><scale x="0.1" y="0.1" z="0.6"/><rotate y="1" angle="50"/>"#,
                WARM,
            ),
        ),
        (
            "textured mesh",
            lamp(
                "rectangle",
                &format!(r#"<scale x="0.3" y="0.2"/>{DOWN}"#),
                PICTURE,
            ),
        ),
        (
            "textured sphere",
            lamp("sphere", r#"<scale value="0.2"/>"#, PICTURE),
        ),
        (
            "point",
            r#"<emitter type="point"><point name="position" value="0.6, 1.5, -0.9"/>
            <rgb name="intensity" value="3, 2, 1"/></emitter>"#
                .into(),
        ),
        (
            "spot",
            format!(
                r#"<emitter type="spot"><float name="cutoff_angle" value="40"/><float name="beam_width" value="25"/>
            <rgb name="intensity" value="3, 2, 4"/>{AT}</emitter>"#
            ),
        ),
        (
            "projector",
            format!(
                r#"<emitter type="projector"><float name="fov" value="60"/>
            <texture type="bitmap" name="irradiance"><string name="filename" value="sky.exr"/></texture>
            {AT}</emitter>"#
            ),
        ),
        (
            "directional",
            r#"<emitter type="directional"><vector name="direction" value="-0.6, -1, 0.1"/>
            <rgb name="irradiance" value="2, 3, 1"/></emitter>"#
                .into(),
        ),
        (
            "constant",
            r#"<emitter type="constant"><rgb name="radiance" value="0.5, 0.7, 0.9"/></emitter>"#
                .into(),
        ),
        (
            "environment",
            r#"<emitter type="envmap"><string name="filename" value="sky.exr"/>
            <transform name="to_world"><rotate y="1" angle="40"/></transform></emitter>"#
                .into(),
        ),
        (
            "several",
            format!(
                r#"{}<emitter type="point"><point name="position" value="0.9, 1.2, -1.0"/>
            <rgb name="intensity" value="1, 0, 1"/></emitter><emitter type="constant">
            <rgb name="radiance" value="0.1, 0.1, 0.3"/></emitter>"#,
                lamp("sphere", r#"<scale value="0.15"/>"#, WARM)
            ),
        ),
    ]
}

/// A sensor of the kind.
pub fn sensor(kind: &str) -> String {
    if kind == "irradiancemeter" {
        // Under the lamp, turned towards the block or mirror.
        return r#"<shape type="disk"><transform name="to_world"><scale x="0.3" y="0.2"/><rotate x="1" angle="-70"/>
            <translate x="0.2" y="0.3" z="-0.6"/></transform><bsdf type="diffuse"/>
            <sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="4"/>
            <integer name="height" value="2"/><rfilter type="box"/></film></sensor></shape>"#
            .into();
    }
    if kind == "spherical" {
        return r#"<sensor type="spherical"><transform name="to_world">
            <lookat origin="-0.4, 0.9, 0.3" target="-0.1, 0.6, -0.3" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="8"/>
            <rfilter type="box"/></film></sensor>"#
            .into();
    }
    let (parameters, size) = match kind {
        "perspective" => (r#"<float name="fov" value="45"/>"#, ""),
        "thinlens" => (
            r#"<float name="fov" value="45"/><float name="aperture_radius" value="0.25"/>
            <float name="focus_distance" value="3.2"/>"#,
            "",
        ),
        _ => ("", r#"<scale x="1.4" y="1.4"/>"#),
    };
    format!(
        r#"<sensor type="{kind}">{parameters}<transform name="to_world">{size}
        <lookat origin="0.3, 1.3, 3.2" target="-0.1, 0.6, -0.3" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="8"/>
        <rfilter type="box"/></film></sensor>"#
    )
}

fn check(kind: &str) {
    let surfaces = [
        ("diffuse", DIFFUSE, BLOCK),
        ("rough", ROUGH, BLOCK),
        ("specular", DIFFUSE, MIRROR),
    ];
    let mut results = Vec::new();
    for (emitter, lamp) in emitters() {
        for (surface, material, object) in surfaces {
            // Light walks hardly ever hit a meter by way of glossy walls.
            if kind == "irradiancemeter" && surface == "rough" {
                continue;
            }
            let algorithms = if surface == "specular"
                || matches!(emitter, "constant" | "environment" | "several")
            {
                // The light image sees neither what is behind a mirror nor emitters without a surface.
                Algorithms::PathAndBidirectional
            } else {
                Algorithms::All
            };
            let integrator = r#"<integrator type="path"><integer name="max_depth" value="5"/>
                <integer name="rr_depth" value="3"/></integrator>"#;
            let text = format!(
                "{integrator}{}{lamp}{}",
                sensor(kind),
                room(material, object)
            );
            let mut scene = scene(&text, &[("sky.exr", &sky)]);
            let what = format!("{emitter}, {kind}, {surface}");
            let samples = match kind {
                "spherical" => 16,
                // It has few pixels.
                "irradiancemeter" => 400,
                _ => 8,
            };
            results.extend(agree(&what, &mut scene, algorithms, samples));
        }
    }
    report(results);
}

#[test]
fn every_emitter_before_a_pinhole() {
    check("perspective");
}

#[test]
fn every_emitter_before_a_thin_lens() {
    check("thinlens");
}

#[test]
fn every_emitter_before_a_panorama() {
    check("spherical");
}

#[test]
fn every_emitter_before_an_irradiance_meter() {
    check("irradiancemeter");
}

#[test]
fn every_emitter_before_parallel_rays() {
    check("orthographic");
}
