//! Masks count for nothing: on the last edge of a path, in any number, for every integrator and light.

use crate::{Files, assert_mean, text};

const SUN: &str = r#"<emitter type="directional"><vector name="direction" value="0 0 -1"/><rgb name="irradiance" value="3.14159265"/></emitter>"#;
const LAMP: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="500"/><rotate y="1" angle="180"/><translate z="9"/></transform>
    <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#;

/// A wall of albedo one half that the camera sees past a sheet before the light, of which a half passes.
fn behind_a_sheet(integrator: &str, light: &str, sheet: &str) -> String {
    let sensor = crate::SENSOR
        .replace("0, 0, 4", "0, 0, 2")
        .replace("28.07", "53.13");
    format!(
        r#"<scene version="3.0.0">{integrator}{sensor}{light}
        <shape type="rectangle"><transform name="to_world"><scale value="50"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>{sheet}</scene>"#
    )
}

/// A sheet above the camera, of the given surface.
fn sheet(bsdf: &str) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="2000"/><translate z="5"/></transform>{bsdf}</shape>"#
    )
}

const HALF: &str = r#"<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></bsdf>"#;

#[test]
fn light_behind_a_mask_arrives_on_the_last_edge() {
    let files = Files::new(&[]);
    let path = |depth: u32| {
        format!(
            r#"<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>"#
        )
    };
    let blend = r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="null"/><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></bsdf>"#;
    for integrator in [path(2), path(3), r#"<integrator type="direct"/>"#.into()] {
        for (name, light) in [("sky", crate::SKY), ("sun", SUN), ("lamp", LAMP)] {
            for bsdf in [HALF, blend] {
                let scene = behind_a_sheet(&integrator, light, &sheet(bsdf));
                let scene = files.load(scene.as_bytes(), true).unwrap();
                // Half of the light, half reflected; the variance of a sample is below a sixteenth.
                println!("{name} {integrator}");
                assert_mean(&scene, 256, 0.25, 5.0 * 0.25 / 128.0);
            }
        }
    }
}

#[test]
fn instanced_and_curved_masks_let_light_pass_on_the_last_edge() {
    let files = Files::new(&[]);
    let instanced = format!(
        r#"<shape type="shapegroup" id="g"><shape type="rectangle">{HALF}</shape></shape>
        <shape type="instance"><ref id="g"/><transform name="to_world"><scale value="2000"/><translate z="5"/></transform></shape>"#
    );
    // Light passes a sphere twice, in and out, from everywhere.
    let sphere = format!(
        r#"<shape type="sphere"><float name="radius" value="400"/>{}</shape>"#,
        HALF
    );
    let integrator =
        r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>"#;
    for content in [instanced, sphere] {
        let scene = behind_a_sheet(integrator, crate::SKY, &content);
        let scene = files.load(scene.as_bytes(), true).unwrap();
        assert_mean(&scene, 256, 0.25, 5.0 * 0.25 / 128.0);
    }
}

#[test]
fn a_mask_before_the_light_is_seen_through_at_depth_one() {
    let files = Files::new(&[]);
    for integrator in ["path", "direct"] {
        let content = format!(
            r#"<integrator type="{integrator}"><integer name="max_depth" value="1"/></integrator>
            <shape type="rectangle"><bsdf type="mask"><float name="opacity" value="0.25"/><bsdf type="diffuse"/></bsdf></shape>"#
        );
        let scene = files
            .load(text("3.0.0", &content).as_bytes(), true)
            .unwrap();
        assert_mean(&scene, 4, 0.75, 1e-6);
    }
}

#[test]
fn any_number_of_sheets_is_transparent() {
    let files = Files::new(&[]);
    for (count, integrator) in [(64, "path"), (65, "path"), (300, "path"), (300, "direct")] {
        let mut content = format!(r#"<integrator type="{integrator}"/>"#);
        for i in 0..count {
            content += &format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="{}"/></transform>
                <bsdf type="mask"><float name="opacity" value="0"/><bsdf type="diffuse"/></bsdf></shape>"#,
                -0.01 * f64::from(i)
            );
        }
        let scene = files
            .load(text("3.0.0", &content).as_bytes(), true)
            .unwrap();
        assert_mean(&scene, 1, 1.0, 1e-6);
        // A wall behind them is lit and seen as without.
        let wall = r#"<shape type="rectangle"><transform name="to_world"><translate z="-4"/><scale x="9" y="9"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>"#;
        let scene = files
            .load(text("3.0.0", &(content + wall)).as_bytes(), true)
            .unwrap();
        assert_mean(&scene, 1, 0.5, 0.1);
    }
}
