//! Weights by recursion against densities of all strategies that are multiplied out, path by path.

use crate::matrix::{emitters, sensor};
use crate::scenes::{LAMP, PINHOLE, room, scene, sky};
use crate::weight_counts::{Checked, Weighting};
use crate::weight_samples::check;

/// Both heuristics, without and with merging.
const WEIGHTINGS: [Weighting; 4] = [
    Weighting {
        is_power: false,
        radius: 0.0,
        emitted: 0,
    },
    Weighting {
        is_power: true,
        radius: 0.0,
        emitted: 0,
    },
    Weighting {
        is_power: false,
        radius: 0.05,
        emitted: 1000,
    },
    Weighting {
        is_power: true,
        radius: 0.02,
        emitted: 1000,
    },
];

#[test]
fn weights_are_those_of_the_densities() {
    let materials = [
        r#"<bsdf type="diffuse"/>"#,
        r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>"#,
        r#"<bsdf type="roughplastic"><float name="alpha" value="0.2"/></bsdf>"#,
    ];
    for material in materials {
        for weighting in WEIGHTINGS {
            let scene = scene(&format!("{PINHOLE}{LAMP}{}", room(material)), &[]);
            let checked = check(&scene, 2000, weighting);
            assert!(checked.all() > 5000, "{checked:?}");
        }
    }
}

/// Emitters with discrete ends, from infinity and with surfaces, cameras with discrete ends and with a lens that can be hit,
/// and vertices of discrete scattering.
#[test]
fn weights_of_every_emitter_and_camera_are_those_of_the_densities() {
    let mirror = r#"<shape type="sphere"><point name="center" value="0.2, 0.5, -0.6"/><float name="radius" value="0.5"/>
        <bsdf type="conductor"/></shape>
        <shape type="sphere"><point name="center" value="-0.8, 0.4, 0.1"/><float name="radius" value="0.4"/>
        <bsdf type="dielectric"/></shape>"#;
    for camera in ["perspective", "thinlens", "orthographic"] {
        let mut of_camera = Checked::default();
        for (name, lamp) in emitters() {
            let content = format!(
                "{}{lamp}{mirror}{}",
                // A lens so wide that hitting it weighs something.
                sensor(camera).replace("0.25", "1.5"),
                room(r#"<bsdf type="diffuse"/>"#)
            );
            let scene = scene(&content, &[("sky.exr", &sky)]);
            for weighting in WEIGHTINGS {
                let checked = check(&scene, 300, weighting);
                assert!(checked.all() > 200, "{name}, {camera}: {checked:?}");
                of_camera.lens_hit += checked.lens_hit;
                of_camera.emitted += checked.emitted;
                of_camera.to_lens += checked.to_lens;
            }
        }
        assert!(
            of_camera.emitted > 50 && of_camera.to_lens > 1000,
            "{camera}: {of_camera:?}"
        );
        let has_lens = camera == "thinlens";
        assert_eq!(of_camera.lens_hit > 0, has_lens, "{of_camera:?}");
    }
}
