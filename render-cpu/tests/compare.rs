//! The compare command: tables, thresholds, heatmaps, bad input.

use clap::Parser;
use glam::Vec3;
use halflight::commands::compare::{CompareArgs, run};
use halflight::compare::comparison::{CompareError, Comparison, ErrorMap, Metric, Options};
use halflight::compare::heatmap::{LEGEND_HEIGHT, NOT_FINITE, color};
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSet};
use halflight::image::exr_output::{LayeredImage, write_exr};
use halflight::image::metadata::ImageMetadata;
use halflight::image::{ExrImage, read_exr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    compare: CompareArgs,
}

fn compare(arguments: &[&str]) -> Result<ExitCode, String> {
    let cli = Cli::try_parse_from([&["compare"], arguments].concat()).map_err(|e| e.to_string())?;
    run(&cli.compare).map_err(|e| e.to_string())
}

/// Noise around a value, 16 samples per pixel.
fn write_image(path: &Path, size: u32, value: f32, seed: u32, aovs: AovSet) {
    let mut film = Film::new(size, size, [0, 0], aovs).unwrap();
    let mut state = seed.wrapping_mul(2_654_435_761) ^ 0x9e37_79b9;
    for y in 0..size {
        for x in 0..size {
            for _ in 0..16 {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                let u = state as f32 / u32::MAX as f32;
                film.pixel_mut(x, y)
                    .add_sample(Vec3::new(0.6, 0.8, 1.0) * value * (0.5 + u));
            }
        }
    }
    write_exr(
        path,
        &LayeredImage::from_film(&film, [size, size], ImageMetadata::default()),
        false,
    )
    .unwrap();
}

fn tested() -> AovSet {
    [Aov::Variance, Aov::Samples].into_iter().collect()
}

struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let files = Self { folder };
        write_image(&files.path("a.exr"), 32, 1.0, 1, tested());
        write_image(&files.path("b.exr"), 32, 1.0, 2, tested());
        write_image(&files.path("bright.exr"), 32, 1.2, 3, tested());
        write_image(&files.path("plain.exr"), 32, 1.0, 4, AovSet::NONE);
        write_image(&files.path("small.exr"), 8, 1.0, 5, tested());
        files
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn compare(&self, a: &str, b: &str, rest: &[&str]) -> Result<ExitCode, String> {
        let (a, b) = (
            self.path(a).display().to_string(),
            self.path(b).display().to_string(),
        );
        compare(&[&[a.as_str(), b.as_str()], rest].concat())
    }
}

#[test]
fn thresholds_decide_the_exit_code() {
    let files = Files::new();
    assert_eq!(files.compare("a.exr", "b.exr", &[]), Ok(ExitCode::SUCCESS));
    assert_eq!(
        files.compare("a.exr", "bright.exr", &["--json"]),
        Ok(ExitCode::SUCCESS),
        "no threshold, no failure"
    );
    let pass = [
        "--fail-above",
        "z-test=1",
        "--fail-above",
        "residual-rms=0.5",
        "--fail-below",
        "psnr=20",
    ];
    assert_eq!(
        files.compare("a.exr", "b.exr", &pass),
        Ok(ExitCode::SUCCESS)
    );
    assert_eq!(
        files.compare("a.exr", "bright.exr", &["--fail-above", "z-test=1"]),
        Ok(ExitCode::FAILURE)
    );
    assert_eq!(
        files.compare("a.exr", "b.exr", &["--fail-above", "mse=0"]),
        Ok(ExitCode::FAILURE)
    );
    for (image, limit, expected) in [
        ("bright.exr", "cie76=0.5", ExitCode::FAILURE),
        ("bright.exr", "cie76=100", ExitCode::SUCCESS),
        ("a.exr", "cie76=0", ExitCode::SUCCESS),
    ] {
        assert_eq!(
            files.compare("a.exr", image, &["--fail-above", limit]),
            Ok(expected),
            "{image} {limit}"
        );
    }
    assert_eq!(
        files.compare("a.exr", "a.exr", &["--fail-above", "mse=0"]),
        Ok(ExitCode::SUCCESS)
    );
    assert_eq!(
        files.compare("a.exr", "b.exr", &["--fail-below", "ssim=0.9999"]),
        Ok(ExitCode::FAILURE)
    );
    assert_eq!(
        files.compare("a.exr", "a.exr", &["--fail-below", "psnr=1000"]),
        Ok(ExitCode::SUCCESS)
    );
}

#[test]
fn what_cannot_be_compared_is_an_error_that_says_why() {
    let files = Files::new();
    let error = |a: &str, b: &str, rest: &[&str]| files.compare(a, b, rest).unwrap_err();
    let size = error("a.exr", "small.exr", &[]);
    assert!(
        size.contains("32 x 32 and 8 x 8") && size.contains("small.exr"),
        "{size}"
    );
    assert!(error("a.exr", "none.exr", &[]).contains("none.exr"));
    assert!(error("a.exr", "plain.exr", &["--fail-above", "z-test=1"]).contains("variance"));
    assert!(error("small.exr", "small.exr", &["--fail-below", "ssim=0.5"]).contains("too small"));
    assert!(error("a.exr", "b.exr", &["--fail-above", "psnr=20"]).contains("--fail-below"));
    assert!(error("a.exr", "b.exr", &["--fail-below", "mse=20"]).contains("--fail-above"));
    assert!(error("a.exr", "b.exr", &["--fail-above", "mse"]).contains("METRIC=VALUE"));
    assert!(error("a.exr", "b.exr", &["--fail-above", "rmse=1"]).contains("residual-rms"));
    assert!(error("a.exr", "b.exr", &["--fail-above", "mse=nan"]).contains("no number"));
    std::fs::write(files.path("text.exr"), "no image").unwrap();
    assert!(error("text.exr", "a.exr", &[]).contains("text.exr"));
    let grey = ExrImage {
        width: 1,
        height: 1,
        channels: vec![("Y".into(), vec![1.0])],
        ..ExrImage::default()
    };
    let error = Comparison::new(("g", &grey), ("g", &grey), &Options::default()).unwrap_err();
    assert_eq!(
        error,
        CompareError::NoColour {
            name: "g".into(),
            channels: "Y".into()
        }
    );
}

#[test]
fn pixels_that_are_not_finite_are_counted_and_taken_out() {
    let files = Files::new();
    let (mut a, b) = (
        read_exr(files.path("a.exr")).unwrap(),
        read_exr(files.path("b.exr")).unwrap(),
    );
    let of = |a: &ExrImage| Comparison::new(("a", a), ("b", &b), &Options::default());
    let before = of(&a).unwrap();
    let red = a.channels.iter_mut().find(|(name, _)| name == "R").unwrap();
    red.1[5] = f32::NAN;
    red.1[77] = f32::INFINITY;
    let after = of(&a).unwrap();
    assert_eq!(
        (
            before.value(Metric::NonFinite),
            after.value(Metric::NonFinite)
        ),
        (Some(0.0), Some(2.0))
    );
    for metric in Metric::ALL {
        assert!(after.value(metric).unwrap().is_finite(), "{metric}");
    }
    let map = after.error_map(ErrorMap::Relative);
    assert_eq!(map.iter().filter(|e| e.is_nan()).count(), 2);
    a.channels
        .iter_mut()
        .for_each(|(_, values)| values.fill(f32::NAN));
    assert_eq!(of(&a).unwrap_err(), CompareError::NothingFinite);
}

#[test]
fn the_reference_can_say_how_many_runs_it_is_of() {
    let files = Files::new();
    let (a, b) = (
        read_exr(files.path("a.exr")).unwrap(),
        read_exr(files.path("bright.exr")).unwrap(),
    );
    let severity = |runs| {
        let options = Options {
            reference_runs: runs,
            ..Options::default()
        };
        Comparison::new(("a", &a), ("b", &b), &options)
            .unwrap()
            .ztest
            .unwrap()
            .levels[0]
            .severity()
    };
    assert_eq!(severity(None), severity(Some(16)));
    assert!(severity(Some(2)) < severity(Some(1000)));
}

#[test]
fn heatmaps_have_the_size_of_the_image_and_a_legend() {
    let files = Files::new();
    for kind in ["flip", "hdr-flip", "relative"] {
        let path = files.path(&format!("{kind}.png"));
        let name = path.display().to_string();
        files
            .compare(
                "a.exr",
                "bright.exr",
                &["--heatmap", &name, "--heatmap-of", kind],
            )
            .unwrap();
        let picture = image::open(&path).unwrap().into_rgb8();
        assert_eq!(picture.dimensions(), (64, 32 + LEGEND_HEIGHT as u32));
        // The legend runs from the first colour to the last.
        assert_eq!(
            (picture.get_pixel(4, 38).0, picture.get_pixel(59, 38).0),
            (color(0.0), color(1.0))
        );
    }
    let name = files.path("equal.png").display().to_string();
    files
        .compare("a.exr", "a.exr", &["--heatmap", &name])
        .unwrap();
    assert_eq!(
        image::open(&name).unwrap().into_rgb8().get_pixel(31, 31).0,
        color(0.0)
    );
    assert!(
        files
            .compare("a.exr", "b.exr", &["--heatmap", "/does/not/exist/x.png"])
            .is_err()
    );
}

#[test]
fn the_colour_map_rises_in_luminance() {
    let luminance = |c: [u8; 3]| {
        0.2126 * f64::from(c[0]).powf(2.2)
            + 0.7152 * f64::from(c[1]).powf(2.2)
            + 0.0722 * f64::from(c[2]).powf(2.2)
    };
    let mut last = -1.0;
    for i in 0..=64 {
        let l = luminance(color(f64::from(i) / 64.0));
        assert!(l > last, "step {i}: {:?}", color(f64::from(i) / 64.0));
        last = l;
    }
    assert_eq!(color(f64::NAN), NOT_FINITE);
    assert_eq!((color(-1.0), color(7.0)), (color(0.0), color(1.0)));
}
