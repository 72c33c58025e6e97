//! `halflight image`: formats, parts and numbers.

use super::{Place, SCENE, read};

/// Red, green and blue of all pixels.
fn colours(place: &Place, name: &str) -> Vec<f32> {
    let image = read(&place.path(name));
    ["R", "G", "B"]
        .iter()
        .flat_map(|c| image.channel(c).expect("a channel").to_vec())
        .collect()
}

fn rendered() -> Place {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "a.exr",
        "--aov",
        "albedo,depth",
    ]);
    place
}

#[test]
fn formats_keep_what_they_can() {
    let place = rendered();
    let original = colours(&place, "a.exr");
    for (format, tolerance) in [("pfm", 0.0), ("hdr", 0.01)] {
        let file = format!("b.{format}");
        place.succeed(&["image", "convert", "a.exr", "-o", &file]);
        place.succeed(&["image", "convert", &file, "-o", "back.exr"]);
        let largest = |i: usize| {
            let n = original.len() / 3;
            (0..3).map(|c| original[c * n + i % n]).fold(0.0, f32::max)
        };
        for (i, (a, b)) in original.iter().zip(colours(&place, "back.exr")).enumerate() {
            assert!(
                (a - b).abs() <= tolerance * largest(i),
                "{format}: {a} became {b}"
            );
        }
    }
    // A PNG is the one that a render makes.
    place.succeed(&["image", "convert", "a.exr", "-o", "b.png"]);
    let picture = |name: &str| {
        image::open(place.path(name))
            .expect("a picture")
            .into_rgb8()
    };
    assert_eq!(picture("b.png"), picture("a.png"));
    place.succeed(&[
        "image",
        "convert",
        "a.exr",
        "-o",
        "darker.png",
        "--exposure",
        "-1",
    ]);
    place.succeed(&[
        "image", "convert", "a.exr", "-o", "soft.jpg", "--tone", "reinhard",
    ]);
    let mean = |name: &str| {
        let bytes = picture(name).into_raw();
        bytes.iter().map(|&b| f64::from(b)).sum::<f64>() / bytes.len() as f64
    };
    assert!(mean("darker.png") < mean("b.png") && mean("soft.jpg") < mean("b.png"));
    // Layers, and one that is not there.
    place.succeed(&[
        "image",
        "convert",
        "a.exr",
        "--layer",
        "depth",
        "-o",
        "depth.exr",
    ]);
    let depth = read(&place.path("a.exr"))
        .channel("depth.Z")
        .expect("depth")
        .to_vec();
    assert_eq!(
        read(&place.path("depth.exr")).channel("G"),
        Some(&depth[..])
    );
    let output = place.run(&["image", "convert", "a.exr", "--layer", "uv", "-o", "uv.exr"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        text.contains("no layer \"uv\"") && text.contains("albedo, depth"),
        "{text}"
    );
}

#[test]
fn parts_are_cut_out_and_put_together() {
    let place = rendered();
    let all = colours(&place, "a.exr");
    let crops = [
        ("left.exr", "0,0,9,16"),
        ("top.exr", "9,0,15,6"),
        ("rest.exr", "9,6,15,10"),
    ];
    for (file, crop) in crops {
        place.succeed(&["image", "convert", "a.exr", "--crop", crop, "-o", file]);
    }
    let part = read(&place.path("rest.exr"));
    assert_eq!((part.origin, part.width, part.height), ([9, 6], 15, 10));
    assert_eq!(part.display_size, [24, 16]);
    place.succeed(&[
        "image", "assemble", "rest.exr", "left.exr", "top.exr", "-o", "all.exr",
    ]);
    assert_eq!(colours(&place, "all.exr"), all);
    let output = place.run(&[
        "image", "convert", "a.exr", "--crop", "20,0,5,5", "-o", "no.exr",
    ]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!place.path("no.exr").exists());
    // Rendered in parts: a box filter has no part in its neighbours.
    place.write(
        "box.xml",
        SCENE.replace(
            "name=\"height\" value=\"16\"/>",
            "name=\"height\" value=\"16\"/><rfilter type=\"box\"/>",
        ),
    );
    place.succeed(&["render", "box.xml", "-o", "whole.exr"]);
    for (file, crop) in [("l.exr", "0,0,9,16"), ("r.exr", "9,0,15,16")] {
        place.succeed(&["render", "box.xml", "-o", file, "--crop", crop]);
    }
    place.succeed(&["merge", "l.exr", "r.exr", "-o", "merged.exr"]);
    assert_eq!(place.channels("merged.exr"), place.channels("whole.exr"));
}

#[test]
fn differences_means_and_numbers() {
    let place = rendered();
    place.succeed(&["render", "scene.xml", "-o", "b.exr", "--seed", "1"]);
    place.succeed(&["image", "difference", "a.exr", "b.exr", "-o", "d.exr"]);
    place.succeed(&["image", "average", "a.exr", "b.exr", "-o", "m.exr"]);
    let [a, b, d, m] = ["a.exr", "b.exr", "d.exr", "m.exr"].map(|f| colours(&place, f));
    for i in 0..a.len() {
        assert_eq!(d[i], a[i] - b[i]);
        assert!((m[i] - 0.5 * (a[i] + b[i])).abs() <= 1e-6 * (1.0 + a[i].abs()));
    }
    let text = place.succeed(&["image", "statistics", "a.exr", "--json"]);
    let statistics: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let green = read(&place.path("a.exr"))
        .channel("G")
        .expect("green")
        .to_vec();
    let mean = green.iter().map(|&v| f64::from(v)).sum::<f64>() / green.len() as f64;
    let found = statistics["values"]["green"]["mean"]
        .as_f64()
        .expect("a number");
    assert!((found / mean - 1.0).abs() < 1e-12);
    let most = green.iter().copied().fold(0.0, f32::max);
    let found = statistics["values"]["green"]["most"]
        .as_f64()
        .expect("a number");
    assert!((found / f64::from(most) - 1.0).abs() < 1e-12);
    assert!(
        place
            .succeed(&["image", "statistics", "a.exr"])
            .contains("luminance")
    );
    place.succeed(&["image", "false-color", "a.exr", "-o", "f.png"]);
    let picture = image::open(place.path("f.png")).expect("a picture");
    assert!(picture.height() > 16, "it has a legend");
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "small.exr",
        "--size",
        "8x8",
        "--no-png",
    ]);
    let output = place.run(&["image", "difference", "a.exr", "small.exr", "-o", "no.exr"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("24 x 16 and 8 x 8"), "{text}");
}
