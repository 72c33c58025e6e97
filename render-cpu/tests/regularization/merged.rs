//! Layers of regularisation of merged images.

use glam::Vec3;
use halflight::film::Film;
use halflight::film::aov::Aov;
use halflight::image::exr_output::{ChannelValues, LayeredImage, write_exr};
use halflight::image::merge::Merger;
use halflight::image::metadata::{ImageMetadata, SampleRange};
use halflight::image::read_exr;

#[test]
fn shares_of_regularised_light_are_those_of_all_samples() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, samples: std::ops::Range<u32>| {
        let mut film = Film::new(
            3,
            1,
            [0, 0],
            [Aov::Regularization, Aov::Samples].into_iter().collect(),
        )
        .unwrap();
        for x in 0..3 {
            for i in samples.clone() {
                // The first pixel has regularised light in its last samples only, the last has none.
                let light =
                    [0.0, 0.5, 0.0][x as usize] + if x == 0 { 0.02 * i as f32 } else { 0.1 };
                let share = if x == 2 || (x == 0 && i < 5) {
                    0.0
                } else {
                    0.3
                };
                let mut pixel = film.pixel_mut(x, 0);
                pixel.add_sample(Vec3::splat(light));
                let tau = 10.0 + i as f32;
                pixel.add_regularized(
                    Vec3::splat(light),
                    [share * light, share * light * tau.ln()],
                );
            }
        }
        let metadata = ImageMetadata {
            sample_ranges: vec![SampleRange {
                seed: 1,
                from: samples.start,
                to: samples.end,
            }],
            ..ImageMetadata::default()
        };
        let path = folder.path().join(name);
        write_exr(
            &path,
            &LayeredImage::from_film(&film, [3, 1], metadata),
            false,
        )
        .unwrap();
        read_exr(&path).unwrap()
    };
    let whole = of("whole.exr", 0..12);
    let mut merger = Merger::new("a", &of("a.exr", 0..5), false).unwrap();
    merger.add("b", &of("b.exr", 5..12)).unwrap();
    let merged = merger.finish();
    for layer in ["regularization.share", "regularization.scale"] {
        let expected = whole.channel(layer).unwrap();
        let (_, found) = merged
            .channels
            .iter()
            .find(|(name, _)| name == layer)
            .unwrap();
        let ChannelValues::Float(found) = found else {
            panic!("{layer} is no layer of floats");
        };
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() <= 2e-5 * (1.0 + expected),
                "{layer}: {found}, {expected}"
            );
        }
    }
}
