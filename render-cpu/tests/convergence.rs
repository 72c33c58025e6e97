//! The comparison of algorithms: its errors by closed forms, its runs, its pictures.

use halflight::accel::Accel;
use halflight::compare::metrics::RgbImage;
use halflight::experiment::convergence::errors::{
    ErrorReference, Errors, Reference, ShownErrors, relative_squares, trimmed_mean,
};
use halflight::experiment::convergence::race::Budget;
use halflight::experiment::convergence::report::{Subject, json, number, plots, slope, table};
use halflight::experiment::convergence::sheet::{Column, draw, most_different_windows};
use halflight::experiment::convergence::{Outcome, Point, Setup, comparable, find, run};
use halflight::image::ExrImage;
use halflight::plot::picture::Picture;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use std::time::Duration;

const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective"><float name="fov" value="45"/>
        <transform name="to_world"><lookat origin="0, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/>
        <rfilter type="box"/></film></sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="diffuse"/></shape>
    <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
        <emitter type="area"><rgb name="radiance" value="9, 8, 7"/></emitter></shape>
</scene>"#;

fn scene(integrator: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, SCENE).unwrap();
    let options = BuildOptions {
        integrator: Some(integrator.into()),
        ..BuildOptions::default()
    };
    let mut scene = build_scene(&parse_scene(&path, &[], true).unwrap(), &options).unwrap();
    // Groups of chains and passes of photons that fit so small a film.
    scene.settings.chains.mutations = 1;
    scene.settings.photon.photon_count = 1000;
    scene
}

fn compare(names: &[&str], budget: Budget, reference: Option<&Reference>) -> Vec<Outcome> {
    let mut first = scene(names[0]);
    let integrators: Vec<_> = names
        .iter()
        .map(|name| (find(name).unwrap().name.to_owned(), scene(name).settings))
        .collect();
    let accel = Accel::build(first.tables.view(), &first.tables.groups);
    let setup = Setup {
        integrators: &integrators,
        budget,
        seed: 3,
        reference,
    };
    run(&mut first, &accel, &setup, |_| ()).unwrap()
}

fn grey(values: &[f64]) -> RgbImage {
    RgbImage::new(values.len(), 1, values.iter().map(|&v| [v; 3]).collect())
}

fn exr(layers: &[(&str, Vec<f32>)]) -> ExrImage {
    let channels = layers.iter().flat_map(|(prefix, values)| {
        ["R", "G", "B"].map(|c| (format!("{prefix}{c}"), values.clone()))
    });
    ExrImage {
        width: layers[0].1.len() as u32,
        height: 1,
        channels: channels.collect(),
        ..ExrImage::default()
    }
}

#[test]
fn errors_have_their_closed_forms() {
    let file = exr(&[("", vec![1.0, 2.0]), ("variance.", vec![0.02, 0.04])]);
    let reference = Reference::new("r", &file, [2, 1]).unwrap();
    let v = (f64::from(0.02_f32) / 1.01 + f64::from(0.04_f32) / 4.01) / 2.0;
    assert!((reference.relative_variance.unwrap() - v).abs() < 1e-12);
    let image = grey(&[1.5, 2.0]);
    let errors = Errors::new(
        &image,
        &[[0.1; 3], [0.3; 3]],
        ErrorReference::Reference(&reference),
    );
    let expected = 0.25 / 1.01 / 2.0;
    assert!((errors.relative_mse - expected).abs() < 1e-12);
    assert_eq!(
        errors.trimmed, errors.relative_mse,
        "two pixels are too few to leave one out"
    );
    let [less, trimmed] = errors.less_reference.unwrap();
    assert!((less - (expected - v)).abs() < 1e-12 && less == trimmed);
    assert!((errors.sigma - ((0.1 / 1.01 + 0.3 / 4.01) / 2.0_f64).sqrt()).abs() < 1e-12);
    assert!((errors.residual_rms - (0.4_f64 * 0.4 / 2.0).sqrt()).abs() < 1e-12);
}

#[test]
fn pairs_state_the_error_of_one() {
    let (a, b) = (grey(&[1.5, 2.0]), grey(&[0.5, 2.0]));
    let errors = Errors::new(&a, &[[0.0; 3]; 2], ErrorReference::Twin(&b));
    // (1.5 - 0.5)^2 / 2 over the mean 1, and one of two pixels.
    assert!((errors.relative_mse - 0.5 / 1.01 / 2.0).abs() < 1e-12);
    assert!((errors.residual_rms - (1.0_f64 / 2.0 / 2.0).sqrt()).abs() < 1e-12);
    assert_eq!((errors.less_reference, errors.sigma), (None, 0.0));
    let shown = ShownErrors::new(&a, ErrorReference::Twin(&a));
    assert_eq!((shown.cie76, shown.ssim, shown.flip), (0.0, None, 0.0));
}

#[test]
fn the_worst_thousandth_is_left_out() {
    let mut values = vec![1.0; 2000];
    values[7] = 1e9;
    values[900] = 1e6;
    assert_eq!(trimmed_mean(values.clone(), 0.001), 1.0);
    values[3] = 1999.0;
    assert_eq!(trimmed_mean(values, 0.001), (1997.0 + 1999.0) / 1998.0);
}

#[test]
fn references_that_do_not_fit_are_refused() {
    let refused = |file: &ExrImage| Reference::new("r.exr", file, [2, 1]).unwrap_err();
    assert!(refused(&exr(&[("", vec![1.0; 3])])).contains("3 x 1"));
    assert!(refused(&exr(&[("", vec![1.0, f32::NAN])])).contains("not finite"));
    assert!(refused(&exr(&[("albedo.", vec![1.0, 2.0])])).contains("R, G, B"));
    assert!(
        find("pathos")
            .unwrap_err()
            .contains("path, mnee, ptracer, bdpt")
    );
}

#[test]
fn equal_samples_give_the_same_numbers_twice() {
    let names: Vec<_> = comparable().map(|i| i.name).collect();
    let first = compare(&names, Budget::Samples(128), None);
    let again = compare(&names, Budget::Samples(128), None);
    for (a, b) in first.iter().zip(&again) {
        let samples: Vec<_> = a.curve.iter().map(|p| p.samples).collect();
        assert_eq!(samples, [1, 2, 4, 8, 16, 32, 64, 128], "{}", a.name);
        assert_eq!(
            (&a.image, a.shown, &a.error_map),
            (&b.image, b.shown, &b.error_map)
        );
        let [start, end] = [0, 7].map(|i| a.curve[i].errors.relative_mse);
        assert!(end > 0.0 && end < start, "{}: {start} {end}", a.name);
        let total: f64 = a.error_map.iter().sum();
        let mean = total / a.error_map.len() as f64;
        assert!((mean - a.curve[7].errors.relative_mse).abs() < 1e-12);
    }
}

#[test]
fn processor_time_is_kept() {
    let path = &compare(&["path"], Budget::Time(Duration::from_millis(400)), None)[0];
    assert_eq!(path.name, "path");
    assert!(
        path.curve
            .windows(2)
            .all(|p| p[0].samples < p[1].samples && p[0].seconds < p[1].seconds)
    );
    assert!(path.curve.last().is_some_and(|p| p.seconds > 0.0));
}

#[test]
fn a_reference_of_the_same_algorithm_leaves_its_noise() {
    let long = &compare(&["path"], Budget::Samples(1024), None)[0];
    let reference = Reference {
        image: long.image.clone(),
        relative_variance: None,
    };
    let found = &compare(&["bdpt"], Budget::Samples(64), Some(&reference))[0];
    let last = found.curve.last().unwrap();
    // The image's own variance foretells the error, within what 192 pixels leave open.
    let ratio = last.errors.relative_mse.sqrt() / last.errors.sigma;
    assert!((0.6..1.6).contains(&ratio), "{ratio}");
    let again = relative_squares(&found.image, ErrorReference::Reference(&reference));
    assert_eq!(again, found.error_map);
}

fn outcome(name: &str, error: f64, bright: usize) -> Outcome {
    let curve = [1.0, 2.0, 4.0].map(|seconds| Point {
        seconds,
        samples: (8.0 * seconds) as u32,
        errors: Errors {
            relative_mse: error / seconds,
            trimmed: error / seconds,
            less_reference: None,
            residual_rms: 0.1,
            sigma: 0.1,
        },
    });
    let mut error_map = vec![0.0; 64 * 48];
    error_map[bright] = 100.0 * error;
    Outcome {
        name: name.into(),
        curve: curve.into(),
        shown: ShownErrors {
            cie76: 1.0,
            ssim: None,
            flip: 0.5,
        },
        image: RgbImage::new(64, 48, vec![[0.5; 3]; 64 * 48]),
        error_map,
    }
}

#[test]
fn numbers_are_reported() {
    let outcomes = [outcome("path", 1.0, 64 * 40 + 60), outcome("bdpt", 0.25, 0)];
    let subject = Subject {
        scene: "room".into(),
        size: [64, 48],
        reference: None,
        reference_variance: None,
        budget: "4 s of processor time".into(),
    };
    let slope = slope(&outcomes[0].curve, |e| e.relative_mse).unwrap();
    assert!((slope + 1.0).abs() < 1e-9);
    let text = table(&subject, &outcomes);
    assert!(
        text.contains("by pairs") && text.contains("0.250") && text.contains("-1.00"),
        "{text}"
    );
    let json = json(&subject, &outcomes);
    assert_eq!(json["integrators"][1]["curve"][2]["relative_mse"], 0.0625);
    assert_eq!(json["integrators"][0]["ssim"], serde_json::Value::Null);
    let plots = plots(&subject, &outcomes);
    assert_eq!(plots[0].series[0].label, "path, slope -1.00");
    assert_eq!(
        plots[1].series[2].points,
        [(1.0, 0.25), (2.0, 0.125), (4.0, 0.0625)]
    );
    let numbers = [0.0, 0.01234, 123.4, 1e-6, 2e7].map(number);
    assert_eq!(numbers, ["0", "0.0123", "123", "1.00e-6", "2.00e7"]);
}

#[test]
fn the_sheet_enlarges_where_algorithms_differ() {
    let outcomes = [outcome("path", 1.0, 64 * 40 + 60), outcome("bdpt", 0.25, 0)];
    let windows = most_different_windows(&outcomes, [64, 48]);
    let [x, y, w, h] = windows[0];
    assert!(
        (x..x + w).contains(&60) && (y..y + h).contains(&40),
        "{windows:?}"
    );
    for (i, a) in windows.iter().enumerate() {
        for b in &windows[..i] {
            assert!(
                a[0].abs_diff(b[0]) >= w || a[1].abs_diff(b[1]) >= h,
                "{windows:?}"
            );
        }
    }
    let picture = Picture::new(64, 48, vec![90; 3 * 64 * 48]);
    let columns = ["path", "bdpt"].map(|name| Column {
        label: [name.into(), String::new()],
        picture: picture.clone(),
    });
    let canvas = draw(&columns, &windows).unwrap();
    assert!(canvas.size()[0] > 2 * 240);
    assert!(draw(&[], &windows).is_err());
}
