//! Truncated and damaged files of every format.

use crate::bitmap_files::{encoded, png_by_hand, test_rgba};
use crate::exr_files::{encodings, write};
use crate::{bitmap, read};
use halflight::image::Texels;
use image::ImageFormat;
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use std::sync::LazyLock;

/// A small valid file of each format.
static SAMPLES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let rgba = image::DynamicImage::from(test_rgba());
    let rgb = image::DynamicImage::from(rgba.to_rgb8());
    let mut samples = vec![
        encoded(&rgba, ImageFormat::Png),
        encoded(&rgba.to_rgb16().into(), ImageFormat::Png),
        png_by_hand(
            [4, 1],
            2,
            3,
            &[1, 2, 3, 4, 5, 6, 7, 8, 9],
            &[0, 0b10_00_01_10],
        ),
        encoded(&rgb, ImageFormat::Jpeg),
        encoded(&rgba, ImageFormat::Bmp),
        encoded(&rgba, ImageFormat::Tga),
        encoded(&rgba.to_rgb32f().into(), ImageFormat::Hdr),
    ];
    for encoding in encodings() {
        samples.push(write(5, 6, encoding, (0, 0)));
    }
    samples
});

/// What is returned must be whole; errors are as good.
fn assert_consistent(bytes: &[u8]) {
    if let Ok(bitmap) = bitmap(bytes, false, "test.tga") {
        let pixels = bitmap.width as usize * bitmap.height as usize;
        match bitmap.texels {
            Texels::Rgba8 { data, .. } => assert_eq!(data.len(), 4 * pixels),
            Texels::Rgb32F(data) => {
                assert_eq!(data.len(), 3 * pixels);
                assert!(data.iter().all(|v| v.is_finite()));
            }
        }
    }
    if let Ok(image) = read(bytes) {
        let pixels = image.width as usize * image.height as usize;
        assert!(!image.channels.is_empty());
        assert!(
            image
                .channels
                .iter()
                .all(|(_, plane)| plane.len() == pixels)
        );
    }
}

#[test]
fn truncated_images_are_errors_or_whole() {
    for bytes in SAMPLES.iter() {
        assert!(bitmap(bytes, false, "test.tga").is_ok() || read(bytes).is_ok());
        for length in 0..bytes.len() {
            assert_consistent(&bytes[..length]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damaged_images_are_errors_or_whole(
        which in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = SAMPLES[which.index(SAMPLES.len())].clone();
        for (at, byte) in flips {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        assert_consistent(&bytes);
    }
}
