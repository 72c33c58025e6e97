//! Every strategy by itself, without weights, against path tracing for the paths of its length.
//!
//! In a diffuse room all strategies with a camera subpath that can exist make every path of k = s + t - 1 edges, so each of
//! them gives the image of exactly k edges, which is the difference of path tracing with at most k and with at most k - 1.

use crate::agreement::{Batches, compare, report, settings_of, settings_of_strategy};
use crate::scenes::{scene, sky};
use halflight_kernel::transport::settings::integrator_kind;

const LONGEST: u32 = 4;

/// A floor and a wall that do not meet, because connections of near points are noisy, around a large lamp before a sensor.
fn text(sensor: &str, emitter: &str, material: &str) -> String {
    format!(
        r#"<integrator type="path"><integer name="rr_depth" value="100"/></integrator>
        {sensor}<bsdf type="twosided" id="wall">{material}</bsdf>
        <shape type="rectangle"><transform name="to_world"><scale value="1.4"/><rotate x="1" angle="-90"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="1.5"/><translate y="0.9" z="-1.9"/></transform>
            <ref id="wall"/></shape>{emitter}"#
    )
}

fn sensor(kind: &str, parameters: &str, scale: f32) -> String {
    format!(
        r#"<sensor type="{kind}">{parameters}<transform name="to_world"><scale x="{scale}" y="{scale}"/>
        <lookat origin="0.3, 1.3, 2.6" target="-0.1, 0.6, -0.3" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
        <rfilter type="tent"/></film></sensor>"#
    )
}

/// The strategies with s of the given light vertices, and t of the given camera vertices.
fn check(
    what: &str,
    text: &str,
    light: std::ops::RangeInclusive<u32>,
    camera: std::ops::RangeInclusive<u32>,
) {
    let mut scene = scene(text, &[("sky.exr", &sky)]);
    let mut path = |depth: u32| {
        let mut settings = settings_of(&scene, integrator_kind::PATH);
        settings.rules.max_depth = depth;
        Batches::render(what, &mut scene, settings, 96)
    };
    let images: Vec<Batches> = (0..=LONGEST).map(&mut path).collect();
    let mut results = Vec::new();
    for edges in 1..=LONGEST {
        let expected = images[edges as usize].minus(&images[edges as usize - 1]);
        for s in light.clone() {
            let t = (edges + 1).wrapping_sub(s);
            // A point of an emitter without a surface is not seen.
            if t > edges + 1 || !camera.contains(&t) {
                continue;
            }
            let mut settings = settings_of_strategy(&scene, s, t);
            settings.rules.max_depth = edges;
            let name = format!("{what}: s = {s}, t = {t}");
            let found = Batches::render(&name, &mut scene, settings, 48);
            results.push(if found.relative_error() < 0.25 {
                compare(&name, &found, &expected)
            } else {
                Err(format!(
                    "{name}: noise of {} hides everything",
                    found.relative_error()
                ))
            });
        }
    }
    assert!(results.len() >= 4);
    report(results);
}

const LAMP: &str = r#"<shape type="rectangle"><transform name="to_world"><scale x="0.5" y="0.4"/><rotate x="1" angle="60"/>
    <translate x="0.2" y="1.4" z="-0.6"/></transform><emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>"#;

const BALL: &str = r#"<shape type="sphere"><point name="center" value="0.2, 1.1, -0.4"/><float name="radius" value="0.4"/>
    <emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>"#;

const DIFFUSE: &str =
    r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.6, 0.5"/></bsdf>"#;

const BUMPS: &str = r#"<bsdf type="bumpmap"><texture type="bitmap"><string name="filename" value="sky.exr"/>
    <boolean name="raw" value="true"/></texture><float name="scale" value="0.2"/><bsdf type="diffuse">
    <rgb name="reflectance" value="0.8, 0.6, 0.5"/></bsdf></bsdf>"#;

const ROUGH: &str = r#"<bsdf type="roughplastic"><float name="alpha" value="0.4"/></bsdf>"#;

#[test]
fn before_a_pinhole() {
    let pinhole = sensor("perspective", r#"<float name="fov" value="50"/>"#, 1.0);
    check(
        "lamp",
        &text(&pinhole, LAMP, DIFFUSE),
        0..=LONGEST,
        1..=LONGEST + 1,
    );
    check(
        "ball",
        &text(&pinhole, BALL, ROUGH),
        0..=LONGEST,
        1..=LONGEST + 1,
    );
    check(
        "bumps",
        &text(&pinhole, LAMP, BUMPS),
        0..=LONGEST,
        1..=LONGEST + 1,
    );
}

#[test]
fn before_a_wide_lens() {
    let lens = r#"<float name="fov" value="50"/><float name="aperture_radius" value="1"/><float name="focus_distance" value="2.5"/>"#;
    let lens = sensor("thinlens", lens, 1.0);
    check(
        "lamp",
        &text(&lens, LAMP, DIFFUSE),
        0..=LONGEST + 1,
        0..=LONGEST + 1,
    );
    check(
        "bumps",
        &text(&lens, LAMP, BUMPS),
        0..=LONGEST + 1,
        0..=LONGEST + 1,
    );
}

#[test]
fn before_parallel_rays() {
    let parallel = sensor("orthographic", "", 1.2);
    check(
        "lamp",
        &text(&parallel, LAMP, DIFFUSE),
        0..=LONGEST,
        1..=LONGEST + 1,
    );
}

#[test]
fn of_emitters_without_a_surface() {
    let pinhole = sensor("perspective", r#"<float name="fov" value="50"/>"#, 1.0);
    // No ray meets them, and they are not seen themselves.
    let lights = [
        (
            "point",
            r#"<emitter type="point"><point name="position" value="0.2, 1.4, 0.2"/></emitter>"#,
        ),
        (
            "directional",
            r#"<emitter type="directional"><vector name="direction" value="-0.3, -1, -0.4"/></emitter>"#,
        ),
    ];
    for (name, light) in lights {
        check(
            name,
            &text(&pinhole, light, DIFFUSE),
            1..=LONGEST,
            2..=LONGEST,
        );
    }
    let sky = r#"<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>"#;
    check(
        "sky",
        &text(&pinhole, sky, DIFFUSE),
        0..=LONGEST,
        2..=LONGEST + 1,
    );
}
