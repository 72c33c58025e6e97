//! Merged parts are the whole; what must not be merged is not.

use glam::Vec3;
use halflight::commands::merge::{MergeArgs, run};
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSample};
use halflight::image::exr_output::{LayeredImage, write_exr};
use halflight::image::merge::Merger;
use halflight::image::metadata::{ImageMetadata, SampleRange};
use halflight::image::{ExrImage, read_exr};
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const LAYERS: [Aov; 5] = [
    Aov::Albedo,
    Aov::Depth,
    Aov::Uv,
    Aov::Variance,
    Aov::Samples,
];

/// A film of the samples of one seed; pixel (2, 1) gets none of the first two.
fn film(seed: u32, samples: std::ops::Range<u32>, aovs: &[Aov]) -> Film {
    let mut film = Film::new(7, 5, [2, 3], aovs.iter().copied().collect()).unwrap();
    for y in 0..5 {
        for x in 0..7 {
            for i in samples.clone() {
                if (x, y) == (2, 1) && i < 2 {
                    continue;
                }
                let v =
                    (((x * 131 + y * 71 + i * 977 + seed * 7919) % 1009) as f32 / 1009.0).powi(3);
                let mut pixel = film.pixel_mut(x, y);
                pixel.add_sample(Vec3::new(v, 10.0 * v - 1.0, 0.5));
                pixel.add_aovs(&AovSample {
                    albedo: [v, 0.2, 1.0 - v],
                    depth: 3.0 + v,
                    ..AovSample::default()
                });
            }
        }
    }
    film
}

fn metadata(seed: u64, from: u32, to: u32) -> ImageMetadata {
    ImageMetadata {
        scene: "häuser/room.xml".into(),
        integrator: "path".into(),
        sampler: "sobol".into(),
        software: "Halflight 0.1.0".into(),
        spp: f64::from(to - from),
        sample_ranges: vec![SampleRange { seed, from, to }],
        render_seconds: 0.5,
        scene_digest: "0123456789abcdef".into(),
        settings: [("max_depth".into(), "8".into())].into(),
        ..ImageMetadata::default()
    }
}

fn write(path: &Path, film: &Film, metadata: ImageMetadata) -> ExrImage {
    write_exr(
        path,
        &LayeredImage::from_film(film, [64, 48], metadata),
        false,
    )
    .unwrap();
    read_exr(path).unwrap()
}

fn args(images: &[PathBuf], output: PathBuf) -> MergeArgs {
    MergeArgs {
        images: images.to_vec(),
        output,
        png: true,
        force: false,
    }
}

#[test]
fn files_of_parts_merge_to_the_file_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let whole = write(
        &at("whole.exr"),
        &film(1, 0..30, &LAYERS),
        metadata(1, 0, 30),
    );
    let parts: Vec<PathBuf> = [(0, 1), (1, 13), (13, 30)]
        .into_iter()
        .map(|(from, to)| {
            let path = at(&format!("part{from}.exr"));
            write(&path, &film(1, from..to, &LAYERS), metadata(1, from, to));
            path
        })
        .collect();
    assert_eq!(
        run(&args(&parts, at("merged.exr"))).unwrap(),
        ExitCode::SUCCESS
    );
    let merged = read_exr(at("merged.exr")).unwrap();
    assert!(image::open(at("merged.png")).is_ok());

    assert_eq!(
        (merged.origin, merged.display_size),
        (whole.origin, whole.display_size)
    );
    let names = |image: &ExrImage| {
        image
            .channels
            .iter()
            .map(|(name, _)| name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(&merged), names(&whole));
    for (name, values) in &whole.channels {
        for (i, (merged, whole)) in merged.channel(name).unwrap().iter().zip(values).enumerate() {
            // The parts are rounded to f32 once and the result again.
            let tolerance = if name == "samples" {
                0.0
            } else {
                4e-7 * (1.0 + whole.abs())
            };
            assert!(
                (merged - whole).abs() <= tolerance,
                "{name} of pixel {i}: {merged} and {whole}"
            );
        }
    }
    let find = |name: &str| merged.attribute(name).map(str::to_owned);
    let read = ImageMetadata::from_attributes(find).unwrap();
    // 30 samples, but one pixel of 35 has 28.
    let expected = ImageMetadata {
        render_seconds: 1.5,
        spp: 30.0 - 2.0 / 35.0,
        ..metadata(1, 0, 30)
    };
    assert_eq!(read, expected);
}

#[test]
fn variances_of_different_means_are_pooled() {
    // One pixel: 1, 3 and 5, 9, 10. Mean 5.6, squared deviations 59.2, variance of the mean 59.2 / 20.
    let folder = tempfile::tempdir().unwrap();
    let one = |samples: &[f32]| {
        let mut film = Film::new(
            1,
            1,
            [0, 0],
            [Aov::Variance, Aov::Samples].into_iter().collect(),
        )
        .unwrap();
        samples
            .iter()
            .for_each(|&v| film.pixel_mut(0, 0).add_sample(Vec3::splat(v)));
        film
    };
    let a = write(
        &folder.path().join("a.exr"),
        &one(&[1.0, 3.0]),
        metadata(1, 0, 2),
    );
    let b = write(
        &folder.path().join("b.exr"),
        &one(&[5.0, 9.0, 10.0]),
        metadata(2, 0, 3),
    );
    let mut merger = Merger::new("a", &a, false).unwrap();
    merger.add("b", &b).unwrap();
    assert!(merger.warnings().is_empty());
    write_exr(&folder.path().join("c.exr"), &merger.finish(), false).unwrap();
    let c = read_exr(folder.path().join("c.exr")).unwrap();
    assert_eq!(c.channel("samples").unwrap(), [5.0]);
    assert!((c.channel("G").unwrap()[0] - 5.6).abs() < 1e-6);
    assert!((c.channel("variance.G").unwrap()[0] - 2.96).abs() < 1e-6);
    assert_eq!(c.attribute("sampleRanges"), Some("1:0..2 2:0..3"));
    assert_eq!(c.attribute("seed"), Some("1 2"));
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let image = |name: &str, film: &Film, metadata| write(&at(name), film, metadata);
    let first = image("first.exr", &film(1, 0..4, &LAYERS), metadata(1, 0, 4));
    let refuse = |other: &ExrImage| {
        let mut merger = Merger::new("first.exr", &first, false).unwrap();
        let error = merger.add("other.exr", other).unwrap_err().to_string();
        assert!(error.contains("other.exr"), "{error}");
        error
    };
    let overlap = image("o.exr", &film(1, 3..8, &LAYERS), metadata(1, 3, 8));
    assert!(refuse(&overlap).contains("1:3..8"));
    let scene = ImageMetadata {
        scene: "hall.xml".into(),
        ..metadata(2, 0, 4)
    };
    let scene = image("s.exr", &film(2, 0..4, &LAYERS), scene);
    assert!(refuse(&scene).contains("hall.xml"));
    let size = LayeredImage::from_film(&film(2, 0..4, &LAYERS), [32, 24], metadata(2, 0, 4));
    write_exr(&at("z.exr"), &size, false).unwrap();
    assert!(refuse(&read_exr(at("z.exr")).unwrap()).contains("its size is 32 x 24"));
    let sampler = ImageMetadata {
        sampler: "independent".into(),
        ..metadata(2, 0, 4)
    };
    assert!(
        refuse(&image("i.exr", &film(2, 0..4, &LAYERS), sampler))
            .contains("its sampler is independent")
    );
    assert!(refuse(&image("n.exr", &film(2, 0..4, &[]), metadata(2, 0, 4))).contains("samples"));
    let mut broken = image("b.exr", &film(2, 0..4, &LAYERS), metadata(2, 0, 4));
    broken
        .channels
        .iter_mut()
        .find(|(name, _)| name == "G")
        .unwrap()
        .1[9] = f32::NAN;
    assert!(refuse(&broken).contains("pixel (2, 1)"));
    broken
        .attributes
        .iter_mut()
        .find(|(name, _)| name == "sampleRanges")
        .unwrap()
        .1 = "1:x".into();
    assert!(refuse(&broken).contains("1:x"));

    // With force, shared samples and other scenes are warnings.
    for other in [&overlap, &scene] {
        let mut merger = Merger::new("first.exr", &first, true).unwrap();
        merger.add("other.exr", other).unwrap();
        assert_eq!(merger.warnings().len(), 1, "{:?}", merger.warnings());
    }
    // The command leaves no file, and names the one that it cannot read.
    let error = run(&args(&[at("first.exr"), at("o.exr")], at("out.exr")))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("o.exr") && error.contains("first.exr"),
        "{error}"
    );
    let error = run(&args(&[at("first.exr"), at("none.exr")], at("out.exr")))
        .unwrap_err()
        .to_string();
    assert!(error.contains("none.exr"), "{error}");
    assert!(!at("out.exr").exists());
}

#[test]
fn images_are_told_apart_by_what_they_carry() {
    let folder = tempfile::tempdir().unwrap();
    let image = |name: &str, seed: u32, change: &dyn Fn(&mut ImageMetadata)| {
        let mut metadata = metadata(seed.into(), 0, 4);
        change(&mut metadata);
        write(
            &folder.path().join(name),
            &film(seed, 0..4, &LAYERS),
            metadata,
        )
    };
    let first = image("a.exr", 1, &|_| {});
    let add = |other: &ExrImage, force| {
        let mut merger = Merger::new("a.exr", &first, force).unwrap();
        merger
            .add("b.exr", other)
            .map(|()| merger.warnings().to_vec())
    };
    // The same names, but the scene was edited between the two.
    let edited = image("b.exr", 2, &|m| m.scene_digest = "fedcba9876543210".into());
    let error = add(&edited, false).unwrap_err().to_string();
    assert!(error.contains("has changed between them"), "{error}");
    assert_eq!(add(&edited, true).unwrap().len(), 1);
    let deeper = image("c.exr", 2, &|m| {
        m.settings.insert("max_depth".into(), "-1".into());
    });
    let error = add(&deeper, false).unwrap_err().to_string();
    assert!(
        error.contains("its max_depth is -1, that of a.exr is 8"),
        "{error}"
    );
    let other = image("d.exr", 2, &|m| m.integrator = "bdpt".into());
    let error = add(&other, false).unwrap_err().to_string();
    assert!(error.contains("its integrator is bdpt"), "{error}");
    // Of earlier programs, which did not say.
    let silent = image("e.exr", 2, &|m| m.scene_digest.clear());
    assert_eq!(add(&silent, false).unwrap().len(), 1);
    assert!(add(&image("f.exr", 2, &|_| {}), false).unwrap().is_empty());
}

#[test]
fn crops_come_to_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let part = |name: &str, offset: [u32; 2], size: [u32; 2], value: f32, samples: u32| {
        let layers = [Aov::Variance, Aov::Samples].into_iter().collect();
        let mut film = Film::new(size[0], size[1], offset, layers).unwrap();
        for y in 0..size[1] {
            for x in 0..size[0] {
                (0..samples).for_each(|_| film.pixel_mut(x, y).add_sample(Vec3::splat(value)));
            }
        }
        write(&folder.path().join(name), &film, metadata(1, 0, samples))
    };
    let left = part("a.exr", [2, 3], [3, 2], 1.0, 2);
    let right = part("b.exr", [6, 1], [2, 3], 5.0, 2);
    let mut merger = Merger::new("a.exr", &left, false).unwrap();
    merger.add("b.exr", &right).unwrap();
    write_exr(&folder.path().join("c.exr"), &merger.finish(), false).unwrap();
    let both = read_exr(folder.path().join("c.exr")).unwrap();
    assert_eq!((both.origin, both.width, both.height), ([2, 1], 6, 4));
    assert_eq!(both.attribute("sampleRanges"), Some("1:0..2"));
    let expected = [
        [0.0, 0.0, 0.0, 0.0, 5.0, 5.0],
        [0.0, 0.0, 0.0, 0.0, 5.0, 5.0],
        [1.0, 1.0, 1.0, 0.0, 5.0, 5.0],
        [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
    ]
    .concat();
    assert_eq!(both.channel("G").unwrap(), expected);
    let counts = both.channel("samples").unwrap();
    assert!(
        counts
            .iter()
            .zip(&expected)
            .all(|(n, v)| *n == if *v > 0.0 { 2.0 } else { 0.0 })
    );
    // Where crops meet, the same samples would count twice.
    let above = part("d.exr", [3, 4], [1, 5], 1.0, 2);
    let mut merger = Merger::new("a.exr", &left, false).unwrap();
    let error = merger.add("d.exr", &above).unwrap_err().to_string();
    assert!(error.contains("hold the same samples"), "{error}");
}

#[test]
fn layers_that_some_image_lacks_are_left_out_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let all = write(
        &folder.path().join("all.exr"),
        &film(1, 0..4, &LAYERS),
        metadata(1, 0, 4),
    );
    let few = write(
        &folder.path().join("few.exr"),
        &film(2, 0..4, &[Aov::Samples, Aov::Depth]),
        metadata(2, 0, 4),
    );
    let mut merger = Merger::new("all.exr", &all, false).unwrap();
    merger.add("few.exr", &few).unwrap();
    // albedo 3, uv 2, variance 3.
    assert_eq!(merger.warnings().len(), 8, "{:?}", merger.warnings());
    let mut names: Vec<String> = merger
        .finish()
        .channels
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    names.sort();
    assert_eq!(names, ["B", "G", "R", "depth.Z", "samples"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn the_order_of_merging_does_not_matter(splits in prop::collection::vec(1_u32..9, 2..5), turn in 0_usize..5) {
        let folder = tempfile::tempdir().unwrap();
        let mut images: Vec<ExrImage> = splits
            .iter()
            .enumerate()
            .map(|(i, &n)| {
                let path = folder.path().join(format!("{i}.exr"));
                write(&path, &film(i as u32, 0..n, &LAYERS), metadata(i as u64, 0, n))
            })
            .collect();
        let merge = |images: &[ExrImage]| {
            let mut merger = Merger::new("0", &images[0], false).unwrap();
            images[1..].iter().for_each(|image| merger.add("i", image).unwrap());
            write_exr(&folder.path().join("m.exr"), &merger.finish(), false).unwrap();
            read_exr(folder.path().join("m.exr")).unwrap()
        };
        let forward = merge(&images);
        let turn = turn % images.len();
        images.rotate_left(turn);
        let rotated = merge(&images);
        for ((name, a), (_, b)) in forward.channels.iter().zip(&rotated.channels) {
            for (a, b) in a.iter().zip(b) {
                prop_assert!((a - b).abs() <= 2e-7 * (1.0 + a.abs()), "{name}: {a} {b}");
            }
        }
        prop_assert_eq!(forward.attribute("sampleRanges"), rotated.attribute("sampleRanges"));
    }
}
