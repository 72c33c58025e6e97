//! Image files of a film, and what a failed write leaves behind.

use crate::{all, fill};
use glam::Vec3;
use halflight::atomic_file::write_atomically;
use halflight::film::Film;
use halflight::film::aov::Aov;
use halflight::image::exr_output::{LayeredImage, write_exr};
use halflight::image::metadata::{ImageMetadata, SampleRange, join_ranges};
use halflight::image::png_output::{Exposure, srgb_encode, tone_curve, tone_map, write_png};
use std::io::Write;

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
        owner: "Zoë".into(),
        ..ImageMetadata::default()
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
        "R G B A albedo.R albedo.G albedo.B normal.X normal.Y normal.Z depth.Z position.X \
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
                "A" => film.aov_mean(Aov::Alpha, 0, i),
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
        Some(exr::prelude::AttributeValue::F64(number)) => Some(number.to_string()),
        _ => {
            let own = &exr.layer_data.attributes;
            let text = match name {
                "software" => own.software_name.clone(),
                "owner" => own.owner.clone(),
                _ => None,
            };
            text.map(|text| String::from_utf8(text.as_slice().to_vec()).unwrap())
        }
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
