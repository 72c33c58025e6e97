//! The film, its files, and what a broken write leaves behind.

use glam::Vec3;
use halflight::atomic_file::write_atomically;
use halflight::film::aov::{Aov, AovSample, AovSet};
use halflight::film::{Film, FilmError, PixelStatistics};
use halflight::image::exr_output::{LayeredImage, write_exr};
use halflight::image::metadata::{ImageMetadata, SampleRange, join_ranges};
use halflight::image::png_output::{Exposure, srgb_encode, tone_curve, tone_map, write_png};
use proptest::prelude::*;
use std::io::Write;

/// A number in [0, 1) from two counters (a linear congruential step and a bit mix; quality does not matter here).
fn noise(a: u32, b: u32) -> f32 {
    let mut h = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    (h ^ (h >> 15)) as f32 / 4_294_967_808.0
}

fn sample(x: u32, y: u32, i: u32) -> (Vec3, AovSample) {
    let u = |k| noise(y * 1000 + x, i * 16 + k);
    let sample = AovSample {
        albedo: [u(3), u(4), u(5)],
        normal: [u(6), u(7), u(8)],
        depth: u(9),
        position: [u(10), u(11), u(12)],
        uv: [u(13), u(14)],
    };
    (Vec3::new(u(0), u(1) * 10.0, u(2) - 0.25), sample)
}

fn fill(film: &mut Film, tile: u32, samples: std::ops::Range<u32>) {
    for mut tile in film.tiles_mut(tile) {
        for y in tile.y()..tile.y() + tile.height() {
            for x in tile.x()..tile.x() + tile.width() {
                for i in samples.clone() {
                    let (radiance, features) = sample(x, y, i);
                    let mut pixel = tile.pixel_mut(x, y);
                    pixel.add_sample(radiance);
                    pixel.add_aovs(&features);
                }
            }
        }
    }
}

fn all() -> AovSet {
    Aov::ALL.into_iter().collect()
}

#[test]
fn statistics_are_those_of_two_passes() {
    let values: Vec<Vec3> = (0..1000)
        .map(|i| sample(1, 2, i).0 + Vec3::splat(100.0))
        .collect();
    let mut pixel = PixelStatistics::default();
    values.iter().for_each(|&v| pixel.add(v));
    let n = values.len() as f64;
    for c in 0..3 {
        let mean = values.iter().map(|v| f64::from(v[c])).sum::<f64>() / n;
        let m2 = values
            .iter()
            .map(|v| (f64::from(v[c]) - mean).powi(2))
            .sum::<f64>();
        assert!((pixel.mean[c] - mean).abs() < 1e-11 * mean.abs());
        assert!((pixel.variance_of_mean()[c] - m2 / (n * (n - 1.0))).abs() < 1e-11 * m2);
    }
    let mean = halflight::film::luminance(pixel.mean);
    let m2: f64 = values
        .iter()
        .map(|v| (halflight::film::luminance(v.to_array().map(f64::from)) - mean).powi(2))
        .sum();
    assert!((pixel.luminance_variance_of_mean() - m2 / (n * (n - 1.0))).abs() < 1e-11 * m2);
}

#[test]
fn samples_that_are_not_finite_count_as_black() {
    let mut pixel = PixelStatistics::default();
    pixel.add(Vec3::new(f32::NAN, 1.0, 1.0));
    pixel.add(Vec3::new(1.0, f32::INFINITY, 1.0));
    pixel.add(Vec3::splat(3.0));
    assert_eq!((pixel.count, pixel.rejected), (3, 2));
    assert_eq!(pixel.mean, [1.0; 3]);
    assert!(pixel.variance_of_mean().iter().all(|v| v.is_finite()));
}

#[test]
fn tiles_cover_every_pixel_once_and_do_not_change_the_film() {
    let mut one = Film::new(21, 13, [0, 0], all()).unwrap();
    fill(&mut one, 64, 0..5);
    for size in [1, 4, 5, 13, 16, 21] {
        let mut other = Film::new(21, 13, [0, 0], all()).unwrap();
        fill(&mut other, size, 0..2);
        fill(&mut other, size.max(3), 2..5);
        assert_eq!(one, other, "tiles of {size}");
    }
    let mut single = Film::new(21, 13, [0, 0], all()).unwrap();
    for i in 0..5 {
        let (radiance, features) = sample(20, 12, i);
        single.pixel_mut(20, 12).add_sample(radiance);
        single.pixel_mut(20, 12).add_aovs(&features);
    }
    assert_eq!(one.pixel(20, 12), single.pixel(20, 12));
    assert_eq!(
        one.aov_sums()[one.aov_sums().len() - 12..],
        single.aov_sums()[one.aov_sums().len() - 12..]
    );
    assert_eq!(one.total_samples(), 21 * 13 * 5);
}

proptest! {
    #[test]
    fn merged_runs_are_the_whole_run(split in 0_u32..40, total in 1_u32..40) {
        let split = split.min(total);
        let mut whole = Film::new(3, 2, [0, 0], all()).unwrap();
        fill(&mut whole, 8, 0..total);
        let mut merged = Film::new(3, 2, [0, 0], all()).unwrap();
        fill(&mut merged, 8, 0..split);
        let mut rest = Film::new(3, 2, [0, 0], all()).unwrap();
        fill(&mut rest, 8, split..total);
        merged.merge(&rest);
        for (a, b) in whole.statistics().iter().zip(merged.statistics()) {
            prop_assert_eq!(a.count, b.count);
            for c in 0..3 {
                prop_assert!((a.mean[c] - b.mean[c]).abs() <= 1e-14 * 10.0);
                prop_assert!((a.m2[c] - b.m2[c]).abs() <= 1e-13 * (1.0 + a.m2[c]));
            }
            prop_assert!((a.luminance_m2 - b.luminance_m2).abs() <= 1e-13 * (1.0 + a.luminance_m2));
        }
        for (a, b) in whole.aov_sums().iter().zip(merged.aov_sums()) {
            prop_assert!((a - b).abs() <= 1e-12);
        }
    }
}

#[test]
fn noise_falls_with_the_root_of_the_samples() {
    let noise_of = |n| {
        let mut film = Film::new(16, 16, [0, 0], AovSet::NONE).unwrap();
        fill(&mut film, 16, 0..n);
        film.relative_noise()
    };
    assert_eq!(noise_of(1), 1.0);
    let ratio = noise_of(64) / noise_of(1024);
    assert!((ratio - 4.0).abs() < 0.1, "ratio {ratio}");
}

#[test]
fn absurd_sizes_are_errors() {
    assert_eq!(
        Film::new(0, 5, [0, 0], AovSet::NONE).unwrap_err(),
        FilmError::Empty(0, 5)
    );
    let error = Film::new(u32::MAX, u32::MAX, [0, 0], all()).unwrap_err();
    assert_eq!(error, FilmError::TooLarge(u32::MAX, u32::MAX));
}

fn metadata() -> ImageMetadata {
    ImageMetadata {
        scene: "Küche/room.xml".into(),
        integrator: "path".into(),
        sampler: "sobol".into(),
        software: "Halflight 0.1.0".into(),
        spp: 7.0,
        sample_ranges: vec![SampleRange {
            seed: 3,
            from: 0,
            to: 7,
        }],
        render_seconds: 1.5,
        scene_digest: "0123456789abcdef".into(),
        settings: [("max_depth".into(), "-1".into())].into(),
    }
}

#[test]
fn exr_holds_every_layer_the_windows_and_the_metadata() {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    let mut film = Film::new(19, 11, [5, 6], all()).unwrap();
    fill(&mut film, 16, 0..7);
    let image = LayeredImage::from_film(&film, [64, 48], metadata());
    write_exr(&path, &image, false).unwrap();

    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer();
    let exr = read.all_attributes().from_file(&path).unwrap();
    assert_eq!(exr.attributes.display_window.size, exr::math::Vec2(64, 48));
    assert_eq!(
        exr.layer_data.attributes.layer_position,
        exr::math::Vec2(5, 6)
    );
    assert_eq!(exr.layer_data.size, exr::math::Vec2(19, 11));
    let names: Vec<String> = exr
        .layer_data
        .channel_data
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    let mut expected: Vec<&str> =
        "R G B albedo.R albedo.G albedo.B normal.X normal.Y normal.Z depth.Z position.X \
        position.Y position.Z uv.U uv.V variance.R variance.G variance.B samples"
            .split_whitespace()
            .collect();
    expected.sort_unstable();
    assert_eq!(names, expected);
    for channel in &exr.layer_data.channel_data.list {
        for (i, p) in film.statistics().iter().enumerate() {
            let expected = match channel.name.to_string().as_str() {
                "R" => p.mean[0],
                "G" => p.mean[1],
                "B" => p.mean[2],
                "samples" => 7.0,
                name => {
                    let (layer, suffix) = name.split_once('.').unwrap();
                    let aov: Aov = layer.parse().unwrap();
                    film.aov_mean(
                        aov,
                        aov.channels().iter().position(|c| *c == suffix).unwrap(),
                        i,
                    )
                }
            };
            match &channel.sample_data {
                FlatSamples::F32(values) => {
                    assert_eq!(values[i], expected as f32, "{}", channel.name)
                }
                FlatSamples::U32(values) => {
                    assert_eq!(values[i], expected as u32, "{}", channel.name)
                }
                FlatSamples::F16(_) => panic!("no half floats were asked for"),
            }
        }
    }
    let other = &exr.layer_data.attributes.other;
    let find = |name: &str| match other.get(&exr::prelude::Text::from(name)) {
        Some(exr::prelude::AttributeValue::Text(t)) => {
            Some(String::from_utf8(t.as_slice().to_vec()).unwrap())
        }
        _ => (name == "software").then(|| {
            exr.layer_data
                .attributes
                .software_name
                .clone()
                .unwrap()
                .to_string()
        }),
    };
    assert_eq!(ImageMetadata::from_attributes(find).unwrap(), metadata());
}

#[test]
fn half_floats_are_for_colours_only_and_do_not_overflow() {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.exr");
    let mut film = Film::new(2, 1, [0, 0], all()).unwrap();
    film.pixel_mut(0, 0).add_sample(Vec3::splat(1e9));
    write_exr(
        &path,
        &LayeredImage::from_film(&film, [2, 1], metadata()),
        true,
    )
    .unwrap();
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer();
    for channel in read
        .all_attributes()
        .from_file(&path)
        .unwrap()
        .layer_data
        .channel_data
        .list
    {
        match (&channel.sample_data, channel.name.to_string().as_str()) {
            (FlatSamples::F16(values), "R" | "G" | "B") => assert_eq!(values[0].to_f32(), 65504.0),
            (FlatSamples::F16(_), name) => {
                assert!(name.starts_with("albedo") || name.starts_with("normal"))
            }
            (_, name) => assert!(!matches!(name, "R" | "G" | "B")),
        }
    }
}

#[test]
fn a_failed_write_leaves_the_previous_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.bin");
    let half_written = |file: &mut std::io::BufWriter<std::fs::File>| {
        file.write_all(&[1; 100_000])?;
        Err(std::io::Error::other("disk full"))
    };
    let error = write_atomically(&path, half_written).unwrap_err();
    assert!(
        error.to_string().contains("image.bin") && error.to_string().contains("disk full"),
        "{error}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);

    write_atomically(&path, |file| file.write_all(b"first")).unwrap();
    write_atomically(&path, half_written).unwrap_err();
    assert_eq!(std::fs::read(&path).unwrap(), b"first");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    // While the write runs, the final name still shows the previous file.
    write_atomically(&path, |file| {
        file.write_all(b"second")?;
        file.flush()?;
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        Ok(())
    })
    .unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"second");
    assert!(
        write_atomically(folder.path(), |_| Ok(())).is_err(),
        "a folder is no file"
    );
    assert!(write_atomically(&folder.path().join("none/x"), |_| Ok(())).is_err());
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    std::fs::write(&file, "old").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    write_atomically(&link, |file| file.write_all(b"new")).unwrap();
    assert!(link.is_symlink());
    assert_eq!(std::fs::read(&file).unwrap(), b"new");
    assert!(write_atomically(std::path::Path::new("/dev/null"), |_| Ok(())).is_err());
}

#[test]
fn tone_curve_is_smooth_monotone_and_keeps_mid_tones() {
    assert_eq!(tone_curve(0.5), 0.5);
    assert_eq!(tone_curve(-3.0), 0.0);
    let slope = (tone_curve(0.8 + 1e-6) - tone_curve(0.8 - 1e-6)) / 2e-6;
    assert!((slope - 1.0).abs() < 1e-5);
    let mut last = -1.0;
    for i in 0..4000 {
        let y = tone_curve(f64::from(i) * 0.001);
        assert!(y > last && y < 1.0);
        last = y;
    }
    assert!((srgb_encode(0.214_041_14) - 0.5).abs() < 1e-7);
    let bytes = tone_map(
        &[[1.0, 0.5, f64::NAN], [1e30, f64::INFINITY, -1.0]],
        Exposure::default(),
    );
    assert_eq!(bytes, [247, 188, 0, 255, 255, 0]);
    // The log-average of a grey image goes to 0.18, which is 118 of 255.
    assert_eq!(tone_map(&[[7.0; 3]; 4], Exposure::Automatic)[..3], [118; 3]);
    assert_eq!(tone_map(&[[0.0; 3]; 4], Exposure::Automatic)[..3], [0; 3]);
}

#[test]
fn png_round_trips() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.png");
    let pixels = [
        [0.0; 3],
        [0.5, 0.25, 0.125],
        [20.0; 3],
        [0.8; 3],
        [0.1; 3],
        [0.0, 1.0, 0.0],
    ];
    write_png(&path, 3, 2, &pixels, Exposure::Stops(-1.0)).unwrap();
    let read = image::open(&path).unwrap().into_rgb8();
    assert_eq!(read.dimensions(), (3, 2));
    assert_eq!(read.as_raw(), &tone_map(&pixels, Exposure::Stops(-1.0)));
}

#[test]
fn sample_ranges_parse_join_and_overlap() {
    let range = |text: &str| text.parse::<SampleRange>().unwrap();
    assert_eq!(
        range("18446744073709551615:4..8").to_string(),
        "18446744073709551615:4..8"
    );
    for bad in ["", "1", "1:2", "1:5..2", "x:1..2", "1:1..-2"] {
        assert!(bad.parse::<SampleRange>().is_err(), "{bad}");
    }
    assert!(range("1:0..8").overlaps(&range("1:7..9")));
    assert!(!range("1:0..8").overlaps(&range("1:8..9")));
    assert!(!range("1:0..8").overlaps(&range("2:0..8")));
    let joined = join_ranges(&[
        range("2:0..4"),
        range("1:4..8"),
        range("1:0..4"),
        range("1:9..10"),
    ]);
    assert_eq!(joined, [range("1:0..8"), range("1:9..10"), range("2:0..4")]);
}

#[test]
fn output_variables_have_names() {
    for aov in Aov::ALL {
        assert_eq!(aov.name().parse(), Ok(aov));
    }
    assert!("Normal".parse::<Aov>().is_err());
    let set: AovSet = [Aov::Uv, Aov::Albedo].into_iter().collect();
    assert_eq!(set.to_string(), "albedo,uv");
    assert_eq!(
        (
            set.accumulators(),
            set.offset(Aov::Uv),
            all().accumulators()
        ),
        (5, 3, 12)
    );
    assert!(!AovSet::NONE.with(Aov::Variance).needs_surface());
}
