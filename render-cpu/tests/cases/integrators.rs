//! Integrators around an integrator run what they hold, with its parameters.

use crate::{Files, text};
use halflight::film::aov::Aov;
use halflight::scene::build::Scene;
use halflight_kernel::transport::integrator_kind;

const INNER: &str = r#"<integrator type="direct" name="image"><boolean name="hide_emitters" value="true"/><integer name="emitter_samples" value="3"/></integrator>"#;

#[track_caller]
fn load(version: &str, integrator: &str, strict: bool) -> Scene {
    Files::new(&[])
        .load(text(version, integrator).as_bytes(), strict)
        .unwrap()
}

#[track_caller]
fn is_inner(scene: &Scene) {
    assert_eq!(scene.integrator, "direct");
    assert_eq!(scene.settings.kind, integrator_kind::DIRECT);
    assert_eq!(scene.settings.rules.hide_emitters, 1);
    assert_eq!(scene.settings.direct.emitter_samples, 3);
}

#[test]
fn what_they_add_becomes_layers() {
    for (version, around, layers) in [
        (
            "3.0.0",
            format!(
                r#"<integrator type="aov"><string name="aovs" value="dd:depth, nn:sh_normal,uv:uv,p:position,a:albedo"/>{INNER}</integrator>"#
            ),
            vec![Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Position, Aov::Uv],
        ),
        (
            "3.0.0",
            format!(r#"<integrator type="moment">{INNER}</integrator>"#),
            vec![Aov::Variance],
        ),
        (
            "3.0.0",
            format!(
                r#"<integrator type="moment"><integrator type="aov"><string name="aovs" value="dd:depth"/>{INNER}</integrator></integrator>"#
            ),
            vec![Aov::Depth, Aov::Variance],
        ),
        (
            "0.6.0",
            format!(
                r#"<integrator type="multichannel">{INNER}<integrator type="field"><string name="field" value="shNormal"/></integrator><integrator type="field"><string name="field" value="distance"/></integrator></integrator>"#
            ),
            vec![Aov::Normal, Aov::Depth],
        ),
    ] {
        let scene = load(version, &around, true);
        is_inner(&scene);
        assert_eq!(scene.layers.iter().collect::<Vec<_>>(), layers, "{around}");
    }
    let plain = load("3.0.0", INNER, true);
    is_inner(&plain);
    assert_eq!(plain.layers.iter().count(), 0);
}

#[test]
fn what_they_would_do_is_said() {
    for (around, words) in [
        (
            format!(
                r#"<integrator type="adaptive"><float name="maxError" value="0.1"/>{INNER}</integrator>"#
            ),
            "--adaptive",
        ),
        (
            format!(r#"<integrator type="irrcache">{INNER}</integrator>"#),
            "nothing is cached",
        ),
        (
            format!(
                r#"<integrator type="aov"><string name="aovs" value="x:dp_du"/>{INNER}</integrator>"#
            ),
            "\"dp_du\"",
        ),
        (
            format!(
                r#"<integrator type="multichannel">{INNER}<integrator type="ao"/></integrator>"#
            ),
            "a second integrator",
        ),
    ] {
        Files::new(&[]).warned("0.6.0", &around, words);
        is_inner(&load("0.6.0", &around, false));
    }
    let empty = Files::new(&[]).error("3.0.0", r#"<integrator type="aov"/>"#);
    assert!(empty.contains("needs a nested integrator"), "{empty}");
}

#[test]
fn the_length_of_rays_of_occlusion_is_one_of_the_world() {
    // A wide ceiling at the height h behind the camera: rays of length l beyond the angle of cosine h / l pass below it, and their
    // share of the cosine-weighted hemisphere is (h / l)^2. There is no light, and none is missed.
    let scene = |integrator: &str, size: u32| {
        let content = format!(
            r#"<scene version="0.6.0">{}<integrator type="ao"><integer name="shadingSamples" value="16"/>{integrator}</integrator>
            <shape type="rectangle"/><shape type="rectangle"><transform name="toWorld"><scale x="{size}" y="{size}"/>
            <translate z="5"/></transform></shape></scene>"#,
            crate::SENSOR
        );
        Files::new(&[]).load(content.as_bytes(), true).unwrap()
    };
    for (length, size) in [(10.0, 100), (10.0, 1000), (7.0, 100)] {
        let scene = scene(
            &format!(r#"<float name="rayLength" value="{length}"/>"#),
            size,
        );
        let expected = (5.0_f64 / length).powi(2);
        crate::assert_mean(&scene, 64, expected, 0.01);
    }
    // Shorter than the way to it, and by default half of the radius, which is far.
    crate::assert_mean(
        &scene(r#"<float name="rayLength" value="4"/>"#, 100),
        4,
        1.0,
        1e-6,
    );
    crate::assert_mean(&scene("", 100), 16, 0.005, 0.005);
}

#[test]
fn other_names_of_an_integrator_have_its_settings() {
    for algorithm in halflight::integrators::INTEGRATORS {
        let settings = |name: &str| {
            let scene = load("3.0.0", &format!(r#"<integrator type="{name}"/>"#), true);
            format!("{:?}", scene.settings)
        };
        for alias in algorithm.aliases {
            assert_eq!(settings(alias), settings(algorithm.name), "{alias}");
        }
    }
}
