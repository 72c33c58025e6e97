//! False colours, irradiance, spherical plots.

use crate::{ABOVE, SKY, scene, with_view};
use glam::{DVec3, Vec3};
use halflight::expression::PartsRequest;
use halflight::inspect::ColorScale;
use halflight::inspect::false_color::{draw, irradiance_film};
use halflight::inspect::spherical_plot::{Probe, SphericalPlot};
use halflight::scene::build::Scene;
use halflight_kernel::scene::SceneView;
use std::f64::consts::PI;
use std::process::Command;

fn with_plot(
    scene: &Scene,
    probe: impl Fn(&SceneView<'_, halflight::accel::CpuTraverse<'_>>) -> Probe,
    rows: usize,
    samples: u32,
) -> (Probe, SphericalPlot) {
    with_view(scene, |view| {
        let probe = probe(view);
        let expressions = scene.parts.view();
        let settings = &scene.settings;
        let plot = SphericalPlot::measure(
            view,
            settings,
            expressions.as_ref(),
            &probe,
            rows,
            samples,
            3,
        );
        (probe, plot)
    })
}

#[test]
fn the_plot_is_the_radiance_in_every_direction() {
    let lamp = r#"<shape type="sphere" id="lamp"><point name="center" value="5, 0, 2"/><float name="radius" value="2"/>
        <emitter type="area"><rgb name="radiance" value="7, 7, 7"/></emitter></shape>"#;
    let black = ABOVE.replace("roughconductor", "diffuse").replace(
        r#"<float name="alpha" value="0.1"/>"#,
        r#"<rgb name="reflectance" value="0"/>"#,
    );
    let mut scene = scene(&format!("{black}{SKY}{lamp}"));
    let position = Vec3::new(0.0, 0.0, 2.0);
    for only in [None, Some("L[lamp] E")] {
        let request = PartsRequest {
            layers: Vec::new(),
            only: only.map(str::to_owned),
        };
        scene.divide(&request).unwrap();
        let (_, plot) = with_plot(&scene, |_| Probe::free(position), 24, 16);
        let mut seen = [0; 3];
        for (cell, value) in plot.radiance.iter().enumerate() {
            let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.5]];
            let cosines = corners.map(|at| plot.direction(cell, at).dot(DVec3::X));
            let least = cosines.into_iter().fold(f64::MAX, f64::min);
            let most = cosines.into_iter().fold(f64::MIN, f64::max);
            let height = corners.map(|at| plot.direction(cell, at).z);
            let rim = (1.0 - 0.16_f64).sqrt();
            let sky = if only.is_some() { 0.0 } else { 0.5 };
            let expected = if least > rim + 1e-3 {
                seen[0] += 1;
                7.0
            } else if most > rim - 0.05 {
                continue;
            } else if height.iter().all(|z| *z > 1e-3) {
                seen[1] += 1;
                sky
            } else if height.iter().all(|z| *z < -0.4) {
                // The floor is black.
                seen[2] += 1;
                0.0
            } else {
                continue;
            };
            assert!(
                (value[1] - expected).abs() < 1e-5,
                "{cell}: {value:?} {expected}"
            );
        }
        assert!(seen.iter().all(|n| *n > 4), "{seen:?}");
    }
}

#[test]
fn irradiance_is_what_falls_on_a_surface() {
    // All of the sky: pi times its radiance, whatever the floor is made of.
    let film = irradiance_film(&scene(&format!("{ABOVE}{SKY}")), 256, 1).unwrap();
    for pixel in film.mean() {
        // The metal reflects nothing back onto a flat floor.
        assert!((pixel[1] / (0.5 * PI) - 1.0).abs() < 0.1, "{pixel:?}");
    }
    let mean = film.mean().iter().map(|p| p[1]).sum::<f64>() / 24.0;
    assert!((mean / (0.5 * PI) - 1.0).abs() < 0.01, "{mean}");
    // A point light above the middle: I cos / d^2.
    let point = r#"<emitter type="point"><point name="position" value="0, 0, 2"/><rgb name="intensity" value="3"/></emitter>"#;
    let mut lit = scene(&format!("{ABOVE}{point}"));
    let film = irradiance_film(&lit, 64, 2).unwrap();
    for (i, pixel) in film.mean().iter().enumerate() {
        let (x, y) = ((i % 6) as f64 - 2.5, (i / 6) as f64 - 1.5);
        // The film is as wide as the floor that it sees.
        let scale = 2.0 * 4.0 * 20_f64.to_radians().tan() / 6.0;
        let distance2 = (x * x + y * y) * scale * scale + 4.0;
        let expected = 3.0 * 2.0 / distance2.powf(1.5);
        assert!(
            (pixel[1] / expected - 1.0).abs() < 0.02,
            "{i}: {pixel:?} {expected}"
        );
    }
    // Of other paths than those, nothing.
    for (only, is_lit) in [("L D E", true), ("L G E", false), ("L X{2,} E", false)] {
        let request = PartsRequest {
            layers: Vec::new(),
            only: Some(only.to_owned()),
        };
        lit.divide(&request).unwrap();
        let film = irradiance_film(&lit, 8, 2).unwrap();
        let sum: f64 = film.mean().iter().map(|p| p[1]).sum();
        assert_eq!(sum > 0.0, is_lit, "{only}");
    }
}

#[test]
fn a_probe_on_a_surface_integrates_to_the_irradiance() {
    let lamp = r#"<shape type="rectangle"><transform name="to_world"><scale value="1.5"/><rotate y="1" angle="180"/>
        <translate x="2" z="3"/></transform><emitter type="area"><rgb name="radiance" value="4"/></emitter></shape>"#;
    let scene = scene(&format!("{ABOVE}{SKY}{lamp}"));
    let (probe, plot) = with_plot(&scene, |v| Probe::of_pixel(v, [2, 2]).unwrap(), 48, 64);
    assert!(probe.is_on_surface && probe.frame.n.z > 0.99);
    let film = irradiance_film(&scene, 4096, 5).unwrap();
    let irradiance = film.pixel(2, 2).mean[1];
    let integral = plot.integral();
    assert!(
        (integral / irradiance - 1.0).abs() < 0.03,
        "{integral} {irradiance}"
    );
}

#[test]
fn pictures_show_the_scale() {
    let scale = ColorScale {
        least: 0.0,
        most: 2.0,
        is_logarithmic: false,
    };
    let mean = [[0.0; 3], [2.0; 3], [1.0; 3], [f64::NAN; 3]];
    let canvas = draw(&mean, 2, |_| scale, "radiance, W/(m² sr)").unwrap();
    let [width, height] = canvas.size();
    assert_eq!([width, height], [32 + 150, 160]);
    let pixel = |x: usize, y: usize| {
        let at = 3 * (y * width as usize + x);
        &canvas.rgb()[at..at + 3]
    };
    assert_eq!(pixel(4, 4), scale.color(0.0));
    assert_eq!(pixel(20, 4), scale.color(2.0));
    assert_eq!(pixel(4, 20), scale.color(1.0));
    assert_eq!(pixel(20, 20), [0, 255, 255]);
    // The bar, from its first colour to its last.
    assert_eq!(pixel(32 + 20, 141), scale.color(0.0));
    assert_eq!(pixel(32 + 20, 44), scale.color(2.0));

    let scene = scene(&format!("{ABOVE}{SKY}"));
    let (_, plot) = with_plot(&scene, |_| Probe::free(Vec3::new(0.0, 0.0, 1.0)), 8, 2);
    let canvas = plot
        .draw(scale, 200, DVec3::new(1.0, -2.0, 1.0), "test")
        .unwrap();
    let [width, height] = canvas.size();
    assert_eq!([width, height], [350, 200]);
    // A sphere of a quarter of the rim's radiance covers the middle, and not the corners.
    let at = |x: usize, y: usize| {
        let at = 3 * (y * width as usize + x);
        canvas.rgb()[at..at + 3].to_vec()
    };
    assert_ne!(at(96, 98), [255; 3]);
    assert_eq!(at(190, 190), [255; 3]);
}

#[test]
fn the_command_writes_pictures_and_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("<scene version=\"3.0.0\">{ABOVE}{SKY}</scene>");
    std::fs::write(folder.path().join("s.xml"), text).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
        command.args(["inspect", "s.xml", "--spp", "2", "-o", "out.png"]);
        command.args(arguments).current_dir(folder.path());
        command.output().unwrap()
    };
    for arguments in [
        &["--tool", "false-color", "--log"][..],
        &[
            "--tool",
            "false-color",
            "--quantity",
            "irradiance",
            "--only",
            "L D E",
        ],
        &["--tool", "spherical-plot", "--at", "0,0,-1.5", "--json"],
        &[
            "--tool",
            "spherical-plot",
            "--pixel",
            "3,2",
            "--rows",
            "8",
            "--view",
            "0,0,1",
        ],
    ] {
        let output = run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?} {message}");
        let path = folder.path().join("out.png");
        let picture = image::open(&path).unwrap().to_rgb8();
        assert!(picture.width() > 200 && picture.pixels().any(|p| p.0 != [255; 3]));
        std::fs::remove_file(path).unwrap();
    }
    for (arguments, message) in [
        (&["--tool", "spherical-plot"][..], "needs a place"),
        (
            &[
                "--tool",
                "spherical-plot",
                "--at",
                "0,0,1",
                "--view",
                "0,0,0",
            ],
            "expected a direction",
        ),
        (
            &["--tool", "false-color", "--only", "C.*Q"],
            "'Q' is none of",
        ),
    ] {
        let output = run(arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?} {text}");
        assert!(text.contains(message), "{text}");
    }
}
