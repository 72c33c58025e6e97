//! Textures of every format.

use crate::bitmap;
use exr::prelude::*;
use halflight::image::Texels;
use image::ImageFormat;
use std::io::{Cursor, Write};

pub(crate) fn encoded(image: &image::DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A 5 x 3 image with all four channels different.
pub(crate) fn test_rgba() -> image::RgbaImage {
    image::RgbaImage::from_fn(5, 3, |x, y| {
        image::Rgba([x as u8 * 50, y as u8 * 100, (x * y) as u8, 255 - x as u8])
    })
}

#[test]
fn eight_bit_formats_keep_their_bytes() {
    let rgba = image::DynamicImage::from(test_rgba());
    let rgb = image::DynamicImage::from(rgba.to_rgb8());
    let grey = image::DynamicImage::from(rgba.to_luma8());
    let grey_alpha = image::DynamicImage::from(rgba.to_luma_alpha8());
    for format in [ImageFormat::Png, ImageFormat::Bmp, ImageFormat::Tga] {
        for image in [&rgba, &rgb, &grey, &grey_alpha] {
            if format == ImageFormat::Bmp && image.color() == image::ColorType::La8 {
                continue; // BMP has no such kind.
            }
            let bytes = encoded(image, format);
            for raw in [false, true] {
                let bitmap = bitmap(&bytes, raw, "image.TGA").unwrap();
                assert_eq!((bitmap.width, bitmap.height), (5, 3));
                let expected = Texels::Rgba8 {
                    data: image.to_rgba8().into_raw(),
                    srgb: !raw,
                };
                assert_eq!(bitmap.texels, expected, "{format:?} {:?}", image.color());
            }
        }
    }
}

#[test]
fn jpeg_is_read() {
    let flat = image::DynamicImage::from(image::RgbImage::from_pixel(
        16,
        8,
        image::Rgb([200, 100, 50]),
    ));
    let bitmap = bitmap(&encoded(&flat, ImageFormat::Jpeg), false, "image.jpg").unwrap();
    let Texels::Rgba8 { data, srgb: true } = bitmap.texels else {
        panic!("{:?}", bitmap.texels);
    };
    assert_eq!(data.len(), 16 * 8 * 4);
    for pixel in data.chunks_exact(4) {
        for (value, expected) in pixel.iter().zip([200, 100, 50, 255_u8]) {
            assert!(value.abs_diff(expected) <= 3, "{pixel:?}");
        }
    }
}

#[test]
fn sixteen_bit_png_becomes_floats() {
    let image: image::ImageBuffer<image::Rgb<u16>, Vec<u16>> =
        image::ImageBuffer::from_fn(4, 2, |x, y| image::Rgb([x as u16 * 20000, y as u16, 65535]));
    let bytes = encoded(&image.clone().into(), ImageFormat::Png);
    let Texels::Rgb32F(raw) = bitmap(&bytes, true, "").unwrap().texels else {
        panic!("not floats");
    };
    let Texels::Rgb32F(linear) = bitmap(&bytes, false, "").unwrap().texels else {
        panic!("not floats");
    };
    for (i, value) in image.into_raw().into_iter().enumerate() {
        let encoded = f64::from(value) / 65535.0;
        assert!((f64::from(raw[i]) - encoded).abs() < 1e-7);
        let expected = if encoded <= 0.04045 {
            encoded / 12.92
        } else {
            ((encoded + 0.055) / 1.055).powf(2.4)
        };
        assert!((f64::from(linear[i]) - expected).abs() < 1e-6);
    }
}

/// A PNG from its header fields, palette and rows (each after its filter byte).
pub(crate) fn png_by_hand(
    size: [u32; 2],
    depth: u8,
    color: u8,
    palette: &[u8],
    rows: &[u8],
) -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        file.extend((data.len() as u32).to_be_bytes());
        let mut crc = flate2::Crc::new();
        crc.update(name);
        crc.update(data);
        file.extend(name);
        file.extend(data);
        file.extend(crc.sum().to_be_bytes());
    };
    let mut header = Vec::new();
    header.extend(size[0].to_be_bytes());
    header.extend(size[1].to_be_bytes());
    header.extend([depth, color, 0, 0, 0]);
    chunk(b"IHDR", &header);
    if !palette.is_empty() {
        chunk(b"PLTE", palette);
    }
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(rows).unwrap();
    chunk(b"IDAT", &encoder.finish().unwrap());
    chunk(b"IEND", &[]);
    file
}

#[test]
fn png_palette_and_single_bits_are_expanded() {
    // Four pixels of two bits: palette entries 2, 0, 1, 2.
    let file = png_by_hand(
        [4, 1],
        2,
        3,
        &[1, 2, 3, 4, 5, 6, 7, 8, 9],
        &[0, 0b10_00_01_10],
    );
    let Texels::Rgba8 { data, .. } = bitmap(&file, true, "").unwrap().texels else {
        panic!("not bytes");
    };
    assert_eq!(
        data,
        [7, 8, 9, 255, 1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255]
    );
    // Three grey pixels of one bit.
    let file = png_by_hand([3, 1], 1, 0, &[], &[0, 0b101_00000]);
    let Texels::Rgba8 { data, .. } = bitmap(&file, true, "").unwrap().texels else {
        panic!("not bytes");
    };
    assert_eq!(data, [255, 255, 255, 255, 0, 0, 0, 255, 255, 255, 255, 255]);
}

#[test]
fn giant_png_is_refused() {
    for (size, why) in [
        ([30_000, 30_000], "too large"),
        ([10_000, 10_000], "too short to hold"),
        ([100_000, 1], ""),
        ([0, 1], ""),
        ([u32::MAX, u32::MAX], ""),
    ] {
        let message = bitmap(&png_by_hand(size, 8, 6, &[], &[0; 64]), true, "").unwrap_err();
        assert!(message.contains(why), "{size:?}: {message}");
    }
}

#[test]
fn radiance_hdr_is_linear() {
    // Shared exponents are exact for powers of two.
    let image = image::Rgb32FImage::from_fn(9, 4, |x, y| {
        image::Rgb([(1_u32 << x) as f32, (1_u32 << y) as f32 * 0.5, 0.0])
    });
    let bytes = encoded(&image.clone().into(), ImageFormat::Hdr);
    let bitmap = bitmap(&bytes, false, "").unwrap();
    let Texels::Rgb32F(data) = bitmap.texels else {
        panic!("not floats");
    };
    for (value, expected) in data.iter().zip(image.into_raw()) {
        assert!((value - expected).abs() <= expected.max(256.0) / 256.0);
    }
}

fn exr_bitmap(channels: &[(&str, f32)]) -> std::result::Result<Vec<f32>, String> {
    let channel =
        |(name, value): &(&str, f32)| AnyChannel::new(*name, FlatSamples::F32(vec![*value; 6]));
    let channels: Vec<AnyChannel<FlatSamples>> = channels.iter().map(channel).collect();
    let layer = Layer::new(
        (3, 2),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.into()),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .unwrap();
    match bitmap(bytes.get_ref(), false, "test.exr")?.texels {
        Texels::Rgb32F(data) => Ok(data[..3].to_vec()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn exr_textures_find_their_color() {
    type Channels = &'static [(&'static str, f32)];
    let cases: [(Channels, [f32; 3]); 6] = [
        (
            &[("A", 9.0), ("B", 3.0), ("G", 2.0), ("R", 1.0)],
            [1.0, 2.0, 3.0],
        ),
        (&[("Y", 4.0), ("A", 9.0)], [4.0; 3]),
        (
            &[("beauty.B", 3.0), ("beauty.G", 2.0), ("beauty.R", 1.0)],
            [1.0, 2.0, 3.0],
        ),
        (&[("depth.Z", 7.0), ("l.Y", 5.0)], [5.0; 3]),
        (&[("height", 6.0)], [6.0; 3]),
        (
            &[
                ("R", f32::NAN),
                ("G", f32::INFINITY),
                ("B", f32::NEG_INFINITY),
            ],
            [0.0, 65504.0, -65504.0],
        ),
    ];
    for (channels, expected) in cases {
        assert_eq!(exr_bitmap(channels).unwrap(), expected, "{channels:?}");
    }
    for channels in [
        &[("X", 1.0), ("Y", 1.0), ("Z", 1.0)][..],
        &[("foo", 1.0), ("bar", 1.0)],
    ] {
        assert!(exr_bitmap(channels).unwrap_err().contains("not supported"));
    }
}
