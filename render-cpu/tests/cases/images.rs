//! Images: powers and channels of bitmaps, and formats.

use crate::{Files, assert_mean};
use image::{DynamicImage, ImageFormat};
use std::io::Cursor;

fn encoded(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("an image");
    bytes.into_inner()
}

fn grey8(value: u8) -> DynamicImage {
    image::GrayImage::from_pixel(2, 2, image::Luma([value])).into()
}

pub fn exr(rgba: [f32; 4]) -> Vec<u8> {
    use exr::prelude::{Image, SpecificChannels, WritableImage};
    let channels = SpecificChannels::rgba(move |_| (rgba[0], rgba[1], rgba[2], rgba[3]));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_channels((2, 2), channels)
        .write()
        .to_buffered(&mut bytes)
        .expect("an image");
    bytes.into_inner()
}

fn floats(value: f32) -> DynamicImage {
    image::Rgb32FImage::from_pixel(2, 2, image::Rgb([value; 3])).into()
}

/// A wall with a texture, which the sky shows as it is.
fn wall(file: &str, properties: &str) -> String {
    format!(
        r#"<integrator type="direct"><integer name="emitter_samples" value="0"/></integrator>
        <shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="{file}"/>{properties}</texture></bsdf></shape>"#
    )
}

#[track_caller]
fn assert_value(files: &Files, file: &str, properties: &str, expected: f64) {
    let scene = files
        .load(
            crate::text("0.6.0", &wall(file, properties)).as_bytes(),
            true,
        )
        .unwrap();
    // White light from everywhere, found by the BSDF's own samples: each is the albedo.
    assert_mean(&scene, 4, expected, 2e-3);
}

#[test]
fn gamma_overrides_the_transfer_of_every_format() {
    let deep =
        image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::from_pixel(2, 2, image::Luma([32768]));
    let files = Files::new(&[
        ("grey.png", &encoded(grey8(128), ImageFormat::Png)),
        ("deep.png", &encoded(deep.into(), ImageFormat::Png)),
        ("half.exr", &exr([0.5; 4])),
        ("half.hdr", &encoded(floats(0.5), ImageFormat::Hdr)),
    ]);
    let srgb = |x: f64| ((x + 0.055) / 1.055_f64).powf(2.4);
    let byte = 128.0 / 255.0_f64;
    let deep = 32768.0 / 65535.0_f64;
    let gamma = |value: f64| format!(r#"<float name="gamma" value="{value}"/>"#);
    for power in [1.0, 1.8, 2.2, 3.2] {
        assert_value(&files, "grey.png", &gamma(power), byte.powf(power));
        assert_value(&files, "deep.png", &gamma(power), deep.powf(power));
        assert_value(&files, "half.exr", &gamma(power), 0.5_f64.powf(power));
        assert_value(&files, "half.hdr", &gamma(power), 0.5_f64.powf(power));
    }
    for (file, value) in [("grey.png", byte), ("deep.png", deep), ("half.exr", 0.5)] {
        assert_value(&files, file, &gamma(-1.0), srgb(value));
    }
    for (file, value) in [
        ("grey.png", srgb(byte)),
        ("deep.png", srgb(deep)),
        ("half.exr", 0.5),
    ] {
        assert_value(&files, file, &gamma(0.0), value);
        assert_value(&files, file, "", value);
    }
    let error = files.error("0.6.0", &wall("grey.png", &gamma(-2.0)));
    assert!(error.contains("-2 is neither"), "{error}");
}

#[test]
fn one_channel_of_a_bitmap() {
    let pixel = image::Rgba([51_u8, 102, 153, 204]);
    let rgba = image::RgbaImage::from_pixel(2, 2, pixel);
    let deep = DynamicImage::from(rgba.clone()).into_rgba16();
    let files = Files::new(&[
        ("c.png", &encoded(rgba.into(), ImageFormat::Png)),
        ("d.png", &encoded(deep.into(), ImageFormat::Png)),
        ("e.exr", &exr([0.2, 0.4, 0.6, 0.8])),
        ("grey.png", &encoded(grey8(128), ImageFormat::Png)),
    ]);
    let srgb = |x: f64| ((x + 0.055) / 1.055_f64).powf(2.4);
    let channel = |name: &str| format!(r#"<string name="channel" value="{name}"/>"#);
    for (names, value) in [(["r", "x"], 0.2), (["g", "y"], 0.4), (["b", "Z"], 0.6)] {
        for name in names {
            assert_value(&files, "c.png", &channel(name), srgb(value));
            assert_value(&files, "d.png", &channel(name), srgb(value));
            assert_value(&files, "e.exr", &channel(name), value);
        }
    }
    // Opacity is never encoded, and one where there is none.
    for (file, value) in [
        ("c.png", 0.8),
        ("d.png", 0.8),
        ("e.exr", 0.8),
        ("grey.png", 1.0),
    ] {
        assert_value(&files, file, &channel("a"), value);
    }
    let raw = channel("g") + r#"<boolean name="raw" value="true"/>"#;
    assert_value(&files, "d.png", &raw, 0.4);
    let error = files.error("0.6.0", &wall("c.png", &channel("q")));
    assert!(error.contains("\"q\" is none of"), "{error}");
}

#[test]
fn the_axes_of_a_bitmap_may_have_modes_of_their_own() {
    let files = Files::new(&[("grey.png", &encoded(grey8(128), ImageFormat::Png))]);
    let mode = |name: &str, value: &str| format!(r#"<string name="{name}" value="{value}"/>"#);
    let both = mode("wrapModeU", "clamp") + &mode("wrapModeV", "clamp");
    let mip_maps = r#"<string name="filterType" value="ewa"/><float name="maxAnisotropy" value="8"/><boolean name="cache" value="false"/>"#;
    let clamped = files.clean("0.6.0", &wall("grey.png", &mode("wrapMode", "clamp")));
    assert_eq!(
        files.clean("0.6.0", &wall("grey.png", &(both + mip_maps))),
        clamped
    );
    let mixed = mode("wrapModeU", "clamp") + &mode("wrapModeV", "mirror");
    assert_eq!(
        files.warned("0.6.0", &wall("grey.png", &mixed), "one mode for both axes"),
        clamped
    );
    let wrong = files.error("0.6.0", &wall("grey.png", &mode("wrapMode", "around")));
    assert!(wrong.contains("\"around\" is none of"), "{wrong}");
}

/// Two rows of three pixels, grey, from the top left.
const PIXELS: [f32; 6] = [0.0, 0.25, 0.5, 0.75, 1.0, 0.125];

/// The mean of the two left pixels of a texture of [`PIXELS`], which is the same for no other order.
const LEFT: f64 = (0.0 + 0.75) / 2.0;

#[track_caller]
fn assert_left(files: &Files, file: &str) {
    let near = r#"<string name="filter_type" value="nearest"/><transform name="to_uv"><scale x="0.33"/></transform>"#;
    assert_value(files, file, near, LEFT);
    // And the upper row alone, a third of each.
    let upper = r#"<string name="filter_type" value="nearest"/><string name="wrap_mode" value="clamp"/><transform name="to_uv"><scale y="0.01"/></transform>"#;
    let lower = r#"<string name="filter_type" value="nearest"/><string name="wrap_mode" value="clamp"/><transform name="to_uv"><scale y="0.01"/><translate y="0.9"/></transform>"#;
    let mean = |properties: &str| {
        let scene = files.scene("3.0.0", &wall(file, properties)).unwrap();
        crate::mean(&scene, 64)[0]
    };
    let rows = [mean(upper), mean(lower)];
    assert!(
        (rows[0] - 0.25).abs() < 0.05 && (rows[1] - 0.625).abs() < 0.05,
        "{file}: {rows:?}"
    );
}

#[test]
fn float_maps_are_read() {
    let map = |header: &str, channels: usize, little: bool, scale: f32| {
        let mut bytes = header.as_bytes().to_vec();
        for row in [3..6, 0..3] {
            for value in &PIXELS[row] {
                for _ in 0..channels {
                    let value = value / scale;
                    bytes.extend(if little {
                        value.to_le_bytes()
                    } else {
                        value.to_be_bytes()
                    });
                }
            }
        }
        bytes
    };
    let files = Files::new(&[
        ("a.pfm", &map("PF\n3 2\n-1.0\n", 3, true, 1.0)),
        ("b.pfm", &map("PF\n3 2\n1.0\n", 3, false, 1.0)),
        ("c.pfm", &map("Pf\n3 2\n-1\n", 1, true, 1.0)),
        ("d.pfm", &map("PF 3 2 -2.0 ", 3, true, 2.0)),
        ("e.pfm", &map("PF\r\n3 2\r\n-1.0\r\n", 3, true, 1.0)),
        ("short.pfm", b"PF\n3 2\n-1.0\n0000"),
        ("huge.pfm", b"PF\n60000 60000\n-1.0\n0000"),
        ("odd.pfm", &[b"PF\n3 2\n0\n".as_slice(), &[0; 72]].concat()),
    ]);
    for file in ["a.pfm", "b.pfm", "c.pfm", "d.pfm", "e.pfm"] {
        assert_left(&files, file);
    }
    for (file, words) in [
        ("short.pfm", "too short"),
        ("huge.pfm", "too"),
        ("odd.pfm", "the scale"),
    ] {
        let error = files.error("3.0.0", &wall(file, ""));
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn radiance_pictures_of_every_order_are_read() {
    // Mantissa and exponent of numbers below two; 128 in the mantissa is one half of 2^(e - 128).
    let rgbe = |value: f32| -> [u8; 4] {
        if value == 0.0 {
            [0; 4]
        } else {
            let m = (value / 2.0 * 256.0) as u8;
            [m, m, m, 129]
        }
    };
    let picture = |signature: &str, header: &str, sizes: &str, order: [usize; 6]| {
        let mut bytes = format!("#?{signature}\n{header}\n{sizes}\n").into_bytes();
        for i in order {
            bytes.extend(rgbe(PIXELS[i]));
        }
        bytes
    };
    const FORMAT: &str = "FORMAT=32-bit_rle_rgbe\n";
    let files = Files::new(&[
        (
            "a.hdr",
            &picture("RADIANCE", FORMAT, "-Y 2 +X 3", [0, 1, 2, 3, 4, 5]),
        ),
        (
            "b.hdr",
            &picture("RGBE", FORMAT, "-Y 2 +X 3", [0, 1, 2, 3, 4, 5]),
        ),
        (
            "c.hdr",
            &picture("RADIANCE", FORMAT, "+Y 2 +X 3", [3, 4, 5, 0, 1, 2]),
        ),
        (
            "d.hdr",
            &picture("RADIANCE", FORMAT, "-Y 2 -X 3", [2, 1, 0, 5, 4, 3]),
        ),
        (
            "e.hdr",
            &picture("RADIANCE", FORMAT, "+Y 2 -X 3", [5, 4, 3, 2, 1, 0]),
        ),
        (
            "f.hdr",
            &picture("RADIANCE", FORMAT, "+X 3 -Y 2", [0, 3, 1, 4, 2, 5]),
        ),
        (
            "g.hdr",
            &picture("RADIANCE", FORMAT, "-X 3 +Y 2", [5, 2, 4, 1, 3, 0]),
        ),
        (
            "h.hdr",
            &picture(
                "RADIANCE",
                "# made by hand\n",
                "-Y 2 +X 3",
                [0, 1, 2, 3, 4, 5],
            ),
        ),
        (
            "exposed.hdr",
            &picture("RADIANCE", "EXPOSURE=2.0\n", "-Y 2 +X 3", [0; 6]),
        ),
        (
            "neutral.hdr",
            &picture("RADIANCE", "EXPOSURE= 1\n", "-Y 2 +X 3", [0, 1, 2, 3, 4, 5]),
        ),
        (
            "xyz.hdr",
            &picture("RADIANCE", "FORMAT=32-bit_rle_xyze\n", "-Y 2 +X 3", [0; 6]),
        ),
        ("odd.hdr", &picture("RADIANCE", FORMAT, "-Y 2 +Y 3", [0; 6])),
    ]);
    for file in [
        "a.hdr",
        "b.hdr",
        "c.hdr",
        "d.hdr",
        "e.hdr",
        "f.hdr",
        "g.hdr",
        "h.hdr",
        "neutral.hdr",
    ] {
        assert_left(&files, file);
    }
    files.warned("3.0.0", &wall("exposed.hdr", ""), "EXPOSURE=2.0");
    let error = files.error("3.0.0", &wall("xyz.hdr", ""));
    assert!(
        error.contains("CIE XYZ") && error.matches("not supported").count() == 1,
        "{error}"
    );
    assert!(
        files
            .error("3.0.0", &wall("odd.hdr", ""))
            .contains("the order of the pixels")
    );
}

#[test]
fn other_formats_are_read_or_named_once() {
    let grey = PIXELS.map(|v| (v * 255.0) as u8);
    let image = || DynamicImage::from(image::GrayImage::from_raw(3, 2, grey.to_vec()).unwrap());
    let text = format!(
        "P2\n# by hand\n3 2 255\n{}\n",
        grey.map(|v| v.to_string()).join(" ")
    );
    let files = Files::new(&[
        ("a.tif", &encoded(image(), ImageFormat::Tiff)),
        ("b.pgm", &encoded(image(), ImageFormat::Pnm)),
        ("c.pgm", text.as_bytes()),
        ("d.bmp", &encoded(image(), ImageFormat::Bmp)),
        ("e.tga", &encoded(image(), ImageFormat::Tga)),
        ("f.webp", b"RIFF\x24\x00\x00\x00WEBPVP8 \x18\x00\x00\x00"),
        ("g.gif", b"GIF89a\x01\x00\x01\x00\x00\x00\x00"),
        ("h.dat", b"whatever this is"),
    ]);
    let raw = r#"<boolean name="raw" value="true"/><string name="filter_type" value="nearest"/><transform name="to_uv"><scale x="0.33"/></transform>"#;
    for file in ["a.tif", "b.pgm", "c.pgm", "d.bmp", "e.tga"] {
        assert_value(&files, file, raw, LEFT);
    }
    for file in ["f.webp", "g.gif", "h.dat"] {
        let error = files.error("3.0.0", &wall(file, ""));
        assert_eq!(error.matches("not supported").count(), 1, "{error}");
        assert!(
            error.contains(file) && error.contains("scene.xml:"),
            "{error}"
        );
    }
}
