//! Where the sky and the sun of a day stand in a scene.

use crate::pixels;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use std::path::Path;

/// A meter at the origin that looks along `direction`.
fn seen(version: &str, emitter: &str, direction: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = direction;
    let text = format!(
        r#"<scene version="{version}"><sensor type="radiancemeter"><point name="origin" value="0 0 0"/><vector name="direction" x="{x}" y="{y}" z="{z}"/>
        <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/><rfilter type="box"/></film></sensor>{emitter}</scene>"#
    );
    let parsed = parse_scene_from_str(&text, Path::new("scene.xml"), &[], true).unwrap();
    let scene: Scene = build_scene(&parsed, &BuildOptions::default()).unwrap();
    pixels(&scene, 1)[0]
}

/// Radiance of Mitsuba 3.9.1 in the directions of a table, with the sun in the plane y = 0 and z up.
#[test]
fn the_sky_of_version_3_has_its_zenith_along_z() {
    for line in include_str!("../oracle/sky.csv").lines() {
        if line.starts_with(['#', 't']) {
            continue;
        }
        let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let elevation = v[1].to_radians();
        let emitter = format!(
            r#"<emitter type="sunsky"><float name="turbidity" value="{}"/><rgb name="albedo" value="{}"/><float name="sun_scale" value="0"/>
            <integer name="resolution" value="1024"/><vector name="sun_direction" x="{}" y="0" z="{}"/></emitter>"#,
            v[0],
            v[2],
            elevation.cos(),
            elevation.sin()
        );
        let radiance = seen("3.0.0", &emitter, [v[3], v[4], v[5]]);
        for c in 0..3 {
            // The image is bilinear between texels of a third of a degree.
            let error = (radiance[c] / v[6 + c] - 1.0).abs();
            assert!(error < 0.01, "{line}: {radiance:?}");
        }
    }
}

#[test]
fn the_sun_is_where_its_direction_says() {
    let properties = r#"<float name="{radius}" value="{value}"/>"#;
    let sun = |version: &str, name: &str, direction: [f64; 3]| {
        let [x, y, z] = direction;
        let size = properties
            .replace(
                "{radius}",
                if version == "0.6.0" {
                    "sunRadiusScale"
                } else {
                    "sun_aperture"
                },
            )
            .replace("{value}", if version == "0.6.0" { "10" } else { "5" });
        format!(
            r#"<emitter type="{name}">{size}<vector name="sun_direction" x="{x}" y="{y}" z="{z}"/></emitter>"#
        )
    };
    for (version, name, direction) in [
        ("0.6.0", "sun", [0.6, 0.7, 0.4]),
        ("0.6.0", "sunsky", [-0.6, 0.7, 0.1]),
        ("3.0.0", "sunsky", [0.3, -0.6, 0.7]),
    ] {
        let emitter = sun(version, name, direction);
        let [x, y, z] = direction;
        let bright = seen(version, &emitter, direction)[1];
        for other in [[-x, y, z], [x, -y, z], [x, y, -z], [x + 0.3, y, z]] {
            if other != direction {
                let dark = seen(version, &emitter, other)[1];
                assert!(
                    bright > 20.0 * dark,
                    "{version} {other:?}: {bright}, {dark}"
                );
            }
        }
    }
}

#[test]
fn a_direction_is_one_of_the_world() {
    // Turning the sky leaves a sun whose direction is given, as in Mitsuba 0.6 and 3.
    for (version, transform) in [("0.6.0", "toWorld"), ("3.0.0", "to_world")] {
        let plugin = if version == "0.6.0" { "sun" } else { "sunsky" };
        let emitter = format!(
            r#"<emitter type="{plugin}"><vector name="sun_direction" x="0.5" y="0.6" z="0.7"/>
            <transform name="{transform}"><rotate x="0.1" y="0.2" z="0.3" angle="40"/></transform></emitter>"#
        );
        let bright = seen(version, &emitter, [0.5, 0.6, 0.7])[1];
        assert!(
            bright > 20.0 * seen(version, &emitter, [0.7, 0.6, 0.5])[1],
            "{bright}"
        );
    }
}

#[test]
fn a_sun_without_a_size_is_a_directional_light_of_the_same_irradiance() {
    let lit = |scale: f64| {
        let emitter = format!(
            r#"<emitter type="sun"><float name="sunRadiusScale" value="{scale}"/><vector name="sunDirection" x="0" y="1" z="0"/></emitter>
            <shape type="rectangle"><transform name="toWorld"><rotate x="1" angle="-90"/><translate y="-1"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>"#
        );
        seen("0.6.0", &emitter, [0.1, -1.0, 0.1])
    };
    let (point, disk) = (lit(0.0), lit(1.0));
    for c in 0..3 {
        // One sample of a disk that is spread over four texels.
        assert!(
            point[c] > 0.0 && (disk[c] / point[c] - 1.0).abs() < 0.3,
            "{point:?} {disk:?}"
        );
    }
}
