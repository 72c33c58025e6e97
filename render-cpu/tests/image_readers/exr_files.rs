//! OpenEXR with all its layers.

use crate::read;
use exr::prelude::*;
use halflight::image::ExrImage;
use std::io::Cursor;

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

pub(crate) fn write(
    width: usize,
    height: usize,
    encoding: Encoding,
    position: (i32, i32),
) -> Vec<u8> {
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

pub(crate) fn encodings() -> Vec<Encoding> {
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
