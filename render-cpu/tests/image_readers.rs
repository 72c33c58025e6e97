//! Readers of image files: every variant reads back what was written, and no bytes make them panic or allocate wildly.

use exr::prelude::*;
use halflight::image_io::{ExrImage, read_exr_bytes};
use std::io::Cursor;
use std::path::Path;

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
