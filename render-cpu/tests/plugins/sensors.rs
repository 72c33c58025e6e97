//! Sensors and beams of light: values of Mitsuba 3.9.1, and what follows from their definitions.

use crate::{build_as_it_is, pixels};
use glam::Vec2;
use halflight_kernel::scene::camera;
use std::f64::consts::PI;

/// A meter in front of a lamp, a wall and a dim sky.
fn meter(shape: &str, parameters: &str, size: [u32; 2]) -> String {
    let [width, height] = size;
    format!(
        r#"<integrator type="path"><integer name="max_depth" value="4"/></integrator>
        <shape type="{shape}">{parameters}<bsdf type="diffuse"><rgb name="reflectance" value="0.3"/></bsdf>
        <sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="{width}"/>
        <integer name="height" value="{height}"/><rfilter type="box"/></film></sensor></shape>
        <shape type="sphere"><point name="center" value="0.5, 0.3, 2"/><float name="radius" value="0.5"/>
        <emitter type="area"><rgb name="radiance" value="3, 2, 1"/></emitter></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="1.5"/><rotate y="1" angle="90"/>
        <translate x="-1.5" z="0.5"/></transform><bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.5, 0.2"/></bsdf></shape>
        <emitter type="constant"><rgb name="radiance" value="0.1, 0.1, 0.2"/></emitter>"#
    )
}

#[test]
fn irradiance_is_that_of_mitsuba() {
    // Of 1 million samples per pixel, with an error below 0.003.
    let rectangle = [
        [0.72997, 0.54359, 0.61455],
        [0.82926, 0.63288, 0.7152],
        [0.76394, 0.56546, 0.62409],
        [0.88301, 0.66779, 0.7294],
    ];
    let scene = build_as_it_is(
        "3.0.0",
        &meter(
            "rectangle",
            r#"<transform name="to_world"><scale y="0.5"/></transform>"#,
            [2, 2],
        ),
    );
    for (pixel, expected) in pixels(&scene, 200_000).iter().zip(rectangle) {
        for c in 0..3 {
            let error = pixel[c] / expected[c] - 1.0;
            assert!(error.abs() < 0.015, "{pixel:?}, not {expected:?}");
        }
    }
    for (shape, parameters, expected) in [
        (
            "sphere",
            r#"<point name="center" value="0, 0, 0.2"/><float name="radius" value="0.4"/>"#,
            [0.49882, 0.4075, 0.59038],
        ),
        (
            "disk",
            r#"<transform name="to_world"><scale value="0.7"/><rotate y="1" angle="30"/></transform>"#,
            DISK,
        ),
    ] {
        let scene = build_as_it_is("3.0.0", &meter(shape, parameters, [1, 1]));
        let pixel = pixels(&scene, 400_000)[0];
        for c in 0..3 {
            let error = pixel[c] / expected[c] - 1.0;
            assert!(error.abs() < 0.015, "{shape}: {pixel:?}, not {expected:?}");
        }
    }
}

const DISK: [f64; 3] = [0.78915879, 0.61885329, 0.74108006];

#[test]
fn a_panorama_sees_directions_at_their_places() {
    // A sky that is white above the horizon only has no simple form: a small sun stands for it.
    let scene = build_as_it_is(
        "0.6.0",
        r#"<integrator type="path"/><sensor type="spherical"><film type="hdrfilm"><integer name="width" value="16"/>
        <integer name="height" value="8"/><rfilter type="box"/></film></sensor>
        <shape type="sphere"><point name="center" x="5" y="0.7" z="5.3"/><float name="radius" value="0.1"/>
        <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"#,
    );
    let pixels = pixels(&scene, 256);
    let lit: Vec<usize> = (0..pixels.len()).filter(|i| pixels[*i][0] > 0.0).collect();
    // In front of the camera and to its left, a little above the horizon.
    assert_eq!(lit, [3 * 16 + 6], "{lit:?}");
    // Its share of the film by its solid angle.
    let distance2 = 5.0_f64.powi(2) + 0.7_f64.powi(2) + 5.3_f64.powi(2);
    let across = 5.0_f64.hypot(5.3) / distance2.sqrt();
    let share = PI * 0.01 / distance2 / (2.0 * PI * PI * across) * 128.0;
    let found = pixels[lit[0]][0];
    assert!((found / share - 1.0).abs() < 0.25, "{found}, not {share}");
}

#[test]
fn a_beam_brings_its_power() {
    // Straight down on a diffuse floor; the camera sees the one point that is lit.
    let scene = build_as_it_is(
        "0.6.0",
        r#"<integrator type="ptracer"><integer name="maxDepth" value="3"/></integrator>
        <sensor type="perspective"><float name="fov" value="40"/><transform name="toWorld">
        <lookat origin="1, 2, 3" target="0, 0, 0" up="0, 0, 1"/></transform><film type="hdrfilm">
        <integer name="width" value="9"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>
        <emitter type="collimated"><spectrum name="power" value="7"/><transform name="toWorld">
        <lookat origin="0.1, 0.2, 4" target="0.1, 0.2, 0" up="0, 1, 0"/></transform></emitter>
        <shape type="rectangle"><bsdf type="diffuse"><spectrum name="reflectance" value="0.6"/></bsdf></shape>"#,
    );
    let lit = glam::Vec3::new(0.1, 0.2, 0.0);
    let seen = camera::film_position(&scene.tables.view(), lit, Vec2::ZERO);
    let cosine = f64::from(seen.direction.z);
    let mean = 7.0 * 0.6 / PI * cosine * f64::from(seen.importance);
    let pixels = pixels(&scene, 4);
    let index = seen.film.y as usize * 9 + seen.film.x as usize;
    for (i, pixel) in pixels.iter().enumerate() {
        let expected = if i == index { mean * 81.0 } else { 0.0 };
        let error = (pixel[0] - expected).abs();
        assert!(
            error <= 1e-4 * expected,
            "pixel {i}: {pixel:?}, not {expected}"
        );
    }
}

#[test]
fn what_an_algorithm_or_sensor_cannot_do_is_said() {
    let beam = r#"<emitter type="collimated"/><shape type="rectangle"/>"#;
    let view = r#"<sensor type="perspective"/>"#;
    for (integrator, is_warned) in [
        ("path", true),
        ("direct", true),
        ("mlt", true),
        ("ptracer", false),
        ("bdpt", false),
        ("sppm", false),
        ("mmlt", false),
    ] {
        let content = format!(r#"<integrator type="{integrator}"/>{view}{beam}"#);
        let warnings = crate::warnings("0.6.0", &content);
        let found = warnings.iter().any(|w| w.contains("collimated"));
        assert_eq!(found, is_warned, "{integrator}: {warnings:?}");
    }
    let meter = r#"<shape type="rectangle"><sensor type="irradiancemeter"/></shape>"#;
    for (content, message) in [
        (
            format!(r#"<integrator type="mlt"/>{meter}"#),
            "which an irradiance meter does not have",
        ),
        (
            r#"<sensor type="irradiancemeter"/>"#.into(),
            "needs a shape around it",
        ),
        (
            format!(r#"<shape type="disk">{view}</shape>"#),
            "only an irradiance meter can be part of a shape",
        ),
        (
            r#"<sensor type="spherical"><transform name="to_world"><scale x="2"/></transform></sensor>"#.into(),
            "must not stretch",
        ),
    ] {
        let error = crate::error("3.0.0", &format!("{content}<emitter type=\"constant\"/>"));
        assert!(error.contains(message), "{error}");
    }
}
