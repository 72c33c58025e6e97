//! Readers of image files: every variant reads back what was written, and no bytes make them panic or allocate wildly.

use exr::prelude::*;
use halflight::image_io::{Bitmap, ExrImage, Texels, read_bitmap, read_exr_bytes};
use image::ImageFormat;
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::LazyLock;

fn read(bytes: &[u8]) -> std::result::Result<ExrImage, String> {
    read_exr_bytes(bytes, Path::new("test.exr")).map_err(|error| error.to_string())
}

fn plane(width: usize, height: usize, seed: f32) -> Vec<f32> {
    (0..width * height)
        .map(|i| (i as f32 * 0.25 + seed).fract() * 8.0)
        .collect()
}

/// Planes of three sample types whose values all types can hold exactly.
fn test_channels(width: usize, height: usize) -> Vec<AnyChannel<FlatSamples>> {
    let half = plane(width, height, 0.5);
    let float = plane(width, height, 0.25);
    let uint: Vec<u32> = (0..(width * height) as u32).collect();
    vec![
        AnyChannel::new(
            "albedo.R",
            FlatSamples::F16(half.iter().map(|&v| f16::from_f32(v)).collect()),
        ),
        AnyChannel::new("depth", FlatSamples::F32(float)),
        AnyChannel::new("id", FlatSamples::U32(uint)),
    ]
}

fn write(width: usize, height: usize, encoding: Encoding, position: (i32, i32)) -> Vec<u8> {
    let mut attributes = LayerAttributes::default().with_position(Vec2(position.0, position.1));
    attributes
        .other
        .insert(Text::from("spp"), AttributeValue::I32(64));
    attributes.other.insert(
        Text::from("scene"),
        AttributeValue::Text(Text::from("box.xml")),
    );
    let layer = Layer::new(
        (width, height),
        attributes,
        encoding,
        AnyChannels::sort(test_channels(width, height).into()),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .unwrap();
    bytes.into_inner()
}

fn assert_test_image(image: &ExrImage, width: usize, height: usize) {
    assert_eq!((image.width, image.height), (width as u32, height as u32));
    let names: Vec<&str> = image.channels.iter().map(|(n, _)| n.as_str()).collect();
    assert_eq!(names, ["albedo.R", "depth", "id"]);
    assert_eq!(
        image.channel("albedo.R").unwrap(),
        plane(width, height, 0.5)
    );
    assert_eq!(image.channel("depth").unwrap(), plane(width, height, 0.25));
    let uint: Vec<f32> = (0..width * height).map(|i| i as f32).collect();
    assert_eq!(image.channel("id").unwrap(), uint);
    assert_eq!(image.attribute("spp"), Some("64"));
    assert_eq!(image.attribute("scene"), Some("box.xml"));
}

fn encodings() -> Vec<Encoding> {
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
    ];
    let mut encodings = Vec::new();
    for compression in compressions {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(5, 4))] {
            encodings.push(Encoding {
                compression,
                blocks,
                line_order: LineOrder::Increasing,
            });
        }
    }
    encodings
}

#[test]
fn exr_reads_back_every_encoding_and_sample_type() {
    for encoding in encodings() {
        let bytes = write(17, 21, encoding, (-3, 40));
        let image = read(&bytes).unwrap();
        assert_test_image(&image, 17, 21);
        assert_eq!(image.origin, [-3, 40]);
    }
}

#[test]
fn exr_parts_prefix_their_channels() {
    let layer = |name: &str, value: f32, size: usize| {
        let samples = FlatSamples::F32(vec![value; size * size]);
        Layer::new(
            (size, size),
            LayerAttributes::named(name),
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(vec![AnyChannel::new("Y", samples)].into()),
        )
    };
    let layers = vec![
        layer("first", 1.0, 4),
        layer("small", 2.0, 2),
        layer("second", 3.0, 4),
    ];
    let image = Image::from_layers(ImageAttributes::with_size((4, 4)), layers);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let image = read(bytes.get_ref()).unwrap();
    // The part of another size is left out.
    assert_eq!(image.channels.len(), 2);
    assert_eq!(image.channel("first.Y").unwrap(), [1.0; 16]);
    assert_eq!(image.channel("second.Y").unwrap(), [3.0; 16]);
}

fn small_exr(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let encoding = Encoding {
        compression,
        blocks,
        line_order: LineOrder::Increasing,
    };
    write(5, 6, encoding, (0, 0))
}

#[test]
fn exr_truncated_anywhere_is_an_error() {
    let encodings = [
        small_exr(Compression::Uncompressed, Blocks::ScanLines),
        small_exr(Compression::ZIP1, Blocks::Tiles(Vec2(4, 4))),
    ];
    for bytes in encodings {
        read(&bytes).unwrap();
        for length in 0..bytes.len() {
            let message = read(&bytes[..length]).unwrap_err();
            assert!(message.starts_with("test.exr: "), "{message}");
        }
    }
}

/// Overwrites the data window, whose value follows its name, type and size in the header, and hides the count of chunks,
/// by which the crate would notice.
fn with_data_window(mut bytes: Vec<u8>, window: [i32; 4]) -> Vec<u8> {
    let count = bytes.windows(6).position(|w| w == b"chunkC").unwrap();
    bytes[count] = b'x';
    let tag = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = bytes.windows(tag.len()).position(|w| w == tag).unwrap() + tag.len();
    for (k, value) in window.iter().enumerate() {
        bytes[at + 4 * k..at + 4 * k + 4].copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

#[test]
fn exr_giant_sizes_are_refused_by_the_header() {
    let bytes = small_exr(Compression::ZIP16, Blocks::ScanLines);
    for (window, why) in [
        ([0, 0, 99_999, 0], "a side is too long"),
        ([0, 0, 0, 1_000_000_000], "a side is too long"),
        ([0, 0, 50_000, 50_000], "too many samples"),
        ([0, 0, 9_999, 9_999], "too short to hold"),
        (
            [-536_870_911, -536_870_911, 536_870_910, 536_870_910],
            "a side is too long",
        ),
        ([i32::MIN, i32::MIN, i32::MAX, i32::MAX], "damaged"),
    ] {
        let message = read(&with_data_window(bytes.clone(), window)).unwrap_err();
        assert!(message.contains(why), "{window:?}: {message}");
    }
}

/// Found by fuzzing: the crate reserves what the block's counters say, and aborts.
#[test]
fn exr_dwa_counters_are_refused() {
    let encoding = Encoding {
        compression: Compression::DWAA(None),
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let bytes = write(64, 30, encoding, (0, 0));
    read(&bytes).unwrap();
    // The only block begins where the only entry of the table before it points.
    let block = (8..bytes.len())
        .find(|&at| bytes[at - 8..at] == (at as u64).to_le_bytes())
        .unwrap();
    let counters = block + 8;
    for k in [1, 6, 7, 8, 9] {
        for count in [1 << 40, i64::MAX as u64, u64::MAX] {
            let mut damaged = bytes.clone();
            damaged[counters + 8 * k..counters + 8 * k + 8].copy_from_slice(&count.to_le_bytes());
            let message = read(&damaged).unwrap_err();
            assert!(message.contains("DWA block announces more"), "{message}");
        }
    }
}

#[test]
fn exr_giant_tiles_are_refused_by_the_header() {
    let bytes = small_exr(Compression::ZIP1, Blocks::Tiles(Vec2(4, 4)));
    let tag = b"tiles\0tiledesc\0\x09\0\0\0";
    let at = bytes.windows(tag.len()).position(|w| w == tag).unwrap() + tag.len();
    for size in [[1 << 16, 1 << 16], [1 << 20, 1 << 10]] {
        let mut damaged = bytes.clone();
        damaged[at..at + 4].copy_from_slice(&u32::to_le_bytes(size[0]));
        damaged[at + 4..at + 8].copy_from_slice(&u32::to_le_bytes(size[1]));
        let count = damaged.windows(6).position(|w| w == b"chunkC").unwrap();
        damaged[count] = b'x';
        let message = read(&damaged).unwrap_err();
        assert!(message.contains("one of its tiles"), "{size:?}: {message}");
    }
}

#[test]
fn exr_block_that_occurs_twice_is_an_error() {
    let bytes = small_exr(Compression::Uncompressed, Blocks::ScanLines);
    let rows = 6;
    let row_bytes = 8 + 5 * (2 + 4 + 4);
    let table = bytes.len() - rows * row_bytes - rows * 8;
    let mut repeated = bytes.clone();
    repeated.copy_within(table..table + 8, table + 8);
    assert!(read(&repeated).unwrap_err().contains("occurs twice"));
    // The same with two tables entries swapped is harmless.
    let mut swapped = bytes.clone();
    swapped.copy_within(table..table + 8, table + 8);
    swapped[table..table + 8].copy_from_slice(&bytes[table + 8..table + 16]);
    assert_test_image(&read(&swapped).unwrap(), 5, 6);
}

fn bitmap(bytes: &[u8], raw: bool, name: &str) -> std::result::Result<Bitmap, String> {
    read_bitmap(bytes, raw, Path::new(name)).map_err(|error| error.to_string())
}

fn encoded(image: &image::DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A 5 x 3 image with all four channels different.
fn test_rgba() -> image::RgbaImage {
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
fn png_by_hand(size: [u32; 2], depth: u8, color: u8, palette: &[u8], rows: &[u8]) -> Vec<u8> {
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
    let cases: [(&[(&str, f32)], [f32; 3]); 6] = [
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
