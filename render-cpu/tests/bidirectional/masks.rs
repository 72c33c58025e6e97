//! Masks, and emitters that are hidden from the sensor.

use crate::agreement::{Batches, compare, report, settings_of};
use crate::case::{Case, ball, check};
use crate::scenes::scene;
use halflight::scene::build::Scene;
use halflight_kernel::transport::settings::integrator_kind;

#[test]
fn masks_and_hidden_emitters() {
    let leaf = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.6"/><rotate x="1" angle="80"/>
        <translate x="0.4" y="1" z="-0.7"/></transform><bsdf type="mask"><texture name="opacity" type="bitmap">
        <string name="filename" value="ripples.exr"/><boolean name="raw" value="true"/></texture>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>"#;
    let gauze = r#"<shape type="cube"><transform name="to_world"><scale value="0.3"/>
        <translate x="-0.2" y="0.5" z="0.3"/></transform><bsdf type="mask"><float name="opacity" value="0.4"/>
        <bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf></bsdf></bsdf></shape>"#;
    let hidden = r#"<boolean name="hide_emitters" value="true"/>"#;
    let ball = ball!(
        r#"<bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="0.3, 0.6, 0.9"/></emitter>"#
    );
    let wide =
        r#"<float name="aperture_radius" value="0.5"/><float name="focus_distance" value="3"/>"#;
    check([
        Case {
            object: leaf,
            ..Case::new("leaf")
        },
        Case {
            object: gauze,
            ..Case::new("gauze")
        },
        Case {
            object: gauze,
            sensor: wide,
            ..Case::new("gauze before a wide lens")
        },
        Case {
            object: ball,
            integrator: hidden,
            ..Case::new("hidden emitters")
        },
        Case {
            object: ball,
            integrator: hidden,
            sensor: wide,
            ..Case::new("hidden emitters before a wide lens")
        },
    ]);
}

/// A black sheet above a floor that lets half of the light pass, under a sky or a lamp.
fn half_lit(lamp: &str, sensor: &str) -> Scene {
    let text = format!(
        r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>
        <sensor type="thinlens"><float name="fov" value="30"/>{sensor}<float name="focus_distance" value="1"/>
        <transform name="to_world"><lookat origin="0, 0.9, 0.5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film>
        </sensor>{lamp}
        <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="300"/><rotate x="1" angle="-90"/>
        <translate y="1.5"/></transform><bsdf type="mask"><float name="opacity" value="0.5"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="300"/><rotate x="1" angle="-90"/>
        <translate y="0.1"/></transform><bsdf type="mask"><float name="opacity" value="0"/>
        <bsdf type="diffuse"/></bsdf></shape>"#
    );
    scene(&text, &[])
}

#[test]
fn light_behind_masks_on_the_last_edge_counts_once() {
    let sky = r#"<emitter type="constant"/>"#;
    let panel = r#"<shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate x="1" angle="90"/>
        <translate y="2"/></transform><emitter type="area"/></shape>"#;
    let mut results = Vec::new();
    for (name, lamp) in [("sky", sky), ("panel", panel)] {
        for (aperture, settings) in [(1e-3, 1), (0.3, 1), (0.3, 0)] {
            let sensor = format!(r#"<float name="aperture_radius" value="{aperture}"/>"#);
            let mut scene = half_lit(lamp, &sensor);
            let direct = settings_of(&scene, integrator_kind::DIRECT);
            let reference = Batches::render(name, &mut scene, direct, 64);
            let mut both = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
            both.bidirectional.sample_direct = settings;
            let what = format!("{name}, aperture {aperture}, sampled directly {settings}");
            let image = Batches::render(&what, &mut scene, both, 64);
            assert!(
                image.relative_error() < 0.01,
                "{what}: {}",
                image.relative_error()
            );
            if name == "sky" {
                let mean = image.mean()[0];
                assert!(
                    (mean - 0.25).abs() < 0.005,
                    "{what}: {mean} instead of 0.25"
                );
            }
            results.push(compare(&what, &image, &reference));
        }
    }
    report(results);
}

#[test]
fn any_number_of_masks_may_stand_in_a_row() {
    for count in [63, 64, 65, 100] {
        let sheets: String = (0..count)
            .map(|i| {
                format!(
                    r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><translate z="{}"/></transform>
                    <bsdf type="mask"><float name="opacity" value="0"/><bsdf type="diffuse"/></bsdf></shape>"#,
                    -0.01 * f64::from(i)
                )
            })
            .collect();
        let text = format!(
            r#"<integrator type="path"/><sensor type="perspective"><float name="fov" value="10"/>
            <transform name="to_world"><lookat origin="0, 0, 3" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>
            {sheets}<shape type="rectangle"><transform name="to_world"><scale value="9"/><translate z="-3"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
            <emitter type="directional"><vector name="direction" value="0, 0, -1"/>
            <rgb name="irradiance" value="3.14159265"/></emitter>"#
        );
        let mut scene = scene(&text, &[]);
        let both = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
        let image = Batches::render("sheets", &mut scene, both, 16);
        let (mean, error) = (image.mean()[0], image.relative_error());
        assert!(
            (mean - 0.5).abs() < 6.0 * error * mean + 1e-4,
            "{count} sheets: {mean} +- {:.1} %",
            100.0 * error
        );
    }
}
