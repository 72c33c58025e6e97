//! What other programs see of an image: tev while it is rendered, attributes and channels afterwards.

use super::{Place, SCENE, read};
use exr::meta::MetaData;
use glam::Vec3;
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::scene::camera::film_position;
use std::io::Read;
use std::net::TcpListener;

/// A message of tev's protocol, read byte by byte.
struct Message<'a>(&'a [u8]);

impl Message<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (bytes, rest) = self.0.split_first_chunk().expect("more bytes");
        self.0 = rest;
        *bytes
    }

    fn number(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn long(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn text(&mut self) -> String {
        let mut bytes = Vec::new();
        loop {
            match self.take::<1>() {
                [0] => return String::from_utf8(bytes).expect("UTF-8"),
                [byte] => bytes.push(byte),
            }
        }
    }
}

#[test]
fn tev_gets_the_image_byte_by_byte() {
    let place = Place::with_scene();
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let viewer = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let (mut socket, _) = listener.accept().expect("a client");
        socket.read_to_end(&mut bytes).expect("bytes");
        bytes
    });
    place.succeed(&["render", "scene.xml", "-o", "out.exr", "--tev", &address]);
    let bytes = viewer.join().expect("a viewer");

    let mut rest = &bytes[..];
    let mut shown = vec![[f32::NAN; 3]; 24 * 16];
    let mut messages = 0;
    while !rest.is_empty() {
        let length = u32::from_le_bytes(*rest.first_chunk().expect("a length")) as usize;
        let (message, after) = rest.split_at(length);
        rest = after;
        let mut message = Message(&message[4..]);
        let [kind, grabs_focus] = message.take();
        assert_eq!(message.text(), "out.exr");
        if messages == 0 {
            assert_eq!((kind, grabs_focus), (4, 1), "an image is made first");
            assert_eq!([message.number(), message.number()], [24, 16]);
            assert_eq!(message.number(), 3);
            assert_eq!(
                [message.text(), message.text(), message.text()],
                ["R", "G", "B"]
            );
        } else {
            assert_eq!((kind, grabs_focus), (6, 0), "then it is filled");
            assert_eq!(message.number(), 3);
            assert_eq!(
                [message.text(), message.text(), message.text()],
                ["R", "G", "B"]
            );
            let [x, y, w, h] = [(); 4].map(|()| message.number());
            assert_eq!((x, w, y + h <= 16), (0, 24, true));
            assert_eq!([(); 3].map(|()| message.long()), [0, 1, 2]);
            assert_eq!([(); 3].map(|()| message.long()), [3, 3, 3]);
            for pixel in &mut shown[(y * w) as usize..((y + h) * w) as usize] {
                *pixel = [(); 3].map(|()| f32::from_le_bytes(message.take()));
            }
        }
        assert!(message.0.is_empty(), "bytes beyond the message");
        messages += 1;
    }
    assert!(messages >= 2);
    let image = read(&place.path("out.exr"));
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let values: Vec<f32> = shown.iter().map(|p| p[c]).collect();
        assert_eq!(
            image.channel(name),
            Some(&values[..]),
            "the last image in tev is the one written"
        );
    }

    // Nobody there: an error before anything is rendered. Somebody who leaves: a warning.
    let output = place.run(&["render", "scene.xml", "-o", "no.exr", "--tev", &address]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        text.contains("tev at") && !place.path("no.exr").exists(),
        "{text}"
    );
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let leaver = std::thread::spawn(move || drop(listener.accept()));
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "gone.exr",
        "--tev",
        &address,
        "--time",
        "2.5s",
    ]);
    leaver.join().expect("a viewer");
    assert!(place.path("gone.exr").exists());
}

#[test]
fn a_live_picture_is_there_before_the_image() {
    let place = Place::with_scene();
    let render = [
        "render",
        "scene.xml",
        "-o",
        "out.exr",
        "--spp",
        "1000000",
        "--live",
    ];
    let mut child = place
        .command(&render)
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the command runs");
    let start = std::time::Instant::now();
    while !place.path("out.png").exists() {
        assert!(start.elapsed().as_secs() < 120, "no picture");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(image::open(place.path("out.png")).is_ok());
    assert!(!place.path("out.exr").exists());
    child.kill().expect("a process");
    child.wait().expect("a status");
}

#[test]
fn the_name_decides_the_format() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "a.exr"]);
    place.succeed(&["render", "scene.xml", "-o", "b.png"]);
    let picture = |name: &str| {
        image::open(place.path(name))
            .expect("a picture")
            .into_rgb8()
    };
    assert_eq!(picture("a.png"), picture("b.png"));
    place.succeed(&["render", "scene.xml", "-o", "c.pfm", "--no-png"]);
    place.succeed(&["image", "convert", "c.pfm", "-o", "d.exr"]);
    assert_eq!(
        read(&place.path("a.exr")).channel("G"),
        read(&place.path("d.exr")).channel("G")
    );
    assert_eq!(
        place.files(),
        ["a.exr", "a.png", "b.png", "c.pfm", "d.exr", "scene.xml"]
    );
}

#[test]
fn images_without_layers_are_plain_rgb() {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "a.exr",
        "--owner",
        "Ada",
        "--spp",
        "3",
    ]);
    let image = read(&place.path("a.exr"));
    let names: Vec<&str> = image
        .channels
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    assert_eq!(names, ["B", "G", "R"]);
    assert_eq!(image.sample_counts().expect("counts")[..], [3.0; 24 * 16]);
    for (name, value) in [("owner", "Ada"), ("spp", "3"), ("samplesPerPixel", "3")] {
        assert_eq!(image.attribute(name), Some(value));
    }
    // They merge all the same.
    place.succeed(&["render", "scene.xml", "-o", "b.exr", "--samples", "3..5"]);
    place.succeed(&["merge", "a.exr", "b.exr", "-o", "c.exr"]);
    let merged = read(&place.path("c.exr"));
    assert_eq!(merged.attribute("samplesPerPixel"), Some("5"));
    for matrix in ["worldToCamera", "worldToNDC"] {
        let of_one = image.attribute(matrix).expect("a matrix");
        assert_eq!(of_one.split(' ').count(), 16);
        assert_eq!(merged.attribute(matrix), Some(of_one));
    }
    assert_eq!(merged.channels.len(), 3);
    // Everything at once.
    place.succeed(&["render", "scene.xml", "-o", "d.exr", "--aov", "all"]);
    let image = read(&place.path("d.exr"));
    for name in [
        "A",
        "samples",
        "albedo.R",
        "normal.X",
        "depth.Z",
        "position.Y",
        "uv.V",
        "variance.B",
    ] {
        assert!(image.channel(name).is_some(), "{name}");
    }
    // Open above the back of the floor.
    let (alpha, depth) = (
        image.channel("A").expect("A"),
        image.channel("depth.Z").expect("Z"),
    );
    assert!(
        alpha
            .iter()
            .zip(depth)
            .all(|(a, z)| (*a > 0.0) == (*z > 0.0) && *a <= 1.0)
    );
    assert!(alpha.contains(&1.0) && alpha.contains(&0.0));
}

#[test]
fn cameras_are_told_as_openexr_has_them() {
    let place = Place::with_scene();
    place.write(
        "shifted.xml",
        SCENE.replace(
            "<float name=\"fov\" value=\"45\"/>",
            "<float name=\"fov\" value=\"45\"/><float name=\"principal_point_offset_x\" value=\"0.1\"/>",
        ),
    );
    place.write(
        "parallel.xml",
        SCENE.replace("type=\"perspective\"", "type=\"orthographic\""),
    );
    for file in ["scene.xml", "shifted.xml", "parallel.xml"] {
        place.succeed(&["render", file, "-o", "a.exr", "--no-png", "--spp", "1"]);
        let metadata = MetaData::read_from_file(place.path("a.exr"), false).expect("a header");
        let own = &metadata.headers[0].own_attributes;
        let apply = |m: [f32; 16], p: Vec3| -> [f32; 4] {
            let p = [p.x, p.y, p.z, 1.0];
            std::array::from_fn(|column| (0..4).map(|row| p[row] * m[4 * row + column]).sum())
        };
        let parsed = parse_scene(&place.path(file), &[], false).expect("a scene");
        let scene = build_scene(&parsed, &BuildOptions::default()).expect("a scene");
        let tables = scene.tables.view();
        for point in [Vec3::new(0.3, 0.7, 0.2), Vec3::new(-0.5, 1.1, 1.0)] {
            let seen =
                film_position(&tables, point, glam::Vec2::ZERO).film / glam::Vec2::new(24.0, 16.0);
            let [x, y, _, w] = apply(own.world_to_normalized_device.expect("worldToNDC"), point);
            assert!(
                (x / w - seen.x).abs() < 1e-4 && (y / w - seen.y).abs() < 1e-4,
                "{file}"
            );
            // From (0, 1.5, 5) towards (0, 0.8, 0): right is +x of the world.
            let [x, y, z, w] = apply(own.world_to_camera.expect("worldToCamera"), point);
            let forward = Vec3::new(0.0, -0.7, -5.0).normalize();
            let from = point - Vec3::new(0.0, 1.5, 5.0);
            let up = Vec3::X.cross(forward);
            let expected = Vec3::new(from.x, from.dot(up), from.dot(forward));
            assert!(
                (Vec3::new(x, y, z) - expected).length() < 1e-4 && w == 1.0,
                "{file}"
            );
        }
    }
}

#[test]
fn clamped_samples_are_dimmer_and_the_image_says_so() {
    let place = Place::with_scene();
    let render = ["render", "scene.xml", "--spp", "16", "--no-png", "-o"];
    place.succeed(&[&render[..], &["free.exr"]].concat());
    place.succeed(&[&render[..], &["clamped.exr", "--clamp", "0.5"]].concat());
    let [free, clamped] = ["free.exr", "clamped.exr"].map(|f| read(&place.path(f)));
    let red = |image: &halflight::image::ExrImage| image.channel("R").expect("red").to_vec();
    let mut is_dimmer = false;
    for (a, b) in red(&free).iter().zip(red(&clamped)) {
        assert!(b <= a + 1e-6 && b <= 0.5 + 1e-6);
        is_dimmer |= b < 0.9 * a;
    }
    assert!(is_dimmer);
    assert!(
        clamped
            .attribute("settings")
            .is_some_and(|s| s.contains("\"clamp\":\"0.5\""))
    );
    // They are images of different things.
    place.succeed(&[&render[..], &["other.exr", "--clamp", "0.5", "--seed", "1"]].concat());
    place.succeed(&["merge", "clamped.exr", "other.exr", "-o", "m.exr"]);
    let output = place.run(&["merge", "other.exr", "free.exr", "-o", "m.exr"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("its clamp is"), "{text}");
}

#[test]
fn statistics_of_a_run_are_json() {
    let place = Place::with_scene();
    let text = place.succeed(&["render", "scene.xml", "-o", "a.exr", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        (&json["image"], &json["finished"]),
        (&"a.exr".into(), &true.into())
    );
    assert_eq!(
        (&json["samples_per_pixel"], &json["samples"]),
        (&4.0.into(), &(4 * 24 * 16).into())
    );
    assert!(json["seconds"].as_f64().is_some_and(|s| s > 0.0));
}

#[test]
fn layers_for_denoisers_keep_their_ranges_and_are_hardly_noisy() {
    let place = Place::with_scene();
    let image = |name: &str, seed: &str| {
        let render = [
            "render",
            "scene.xml",
            "--spp",
            "16",
            "--no-png",
            "--aov",
            "albedo,normal",
        ];
        place.succeed(&[&render[..], &["-o", name, "--seed", seed]].concat());
        read(&place.path(name))
    };
    let (a, b) = (image("a.exr", "1"), image("b.exr", "2"));
    let layer = |image: &halflight::image::ExrImage, names: [&str; 3]| -> Vec<Vec3> {
        let [x, y, z] = names.map(|n| image.channel(n).expect("a channel").to_vec());
        (0..x.len()).map(|i| Vec3::new(x[i], y[i], z[i])).collect()
    };
    let names = [
        ["R", "G", "B"],
        ["albedo.R", "albedo.G", "albedo.B"],
        ["normal.X", "normal.Y", "normal.Z"],
    ];
    let albedo = layer(&a, names[1]);
    assert!(
        albedo
            .iter()
            .all(|v| v.min_element() >= 0.0 && v.max_element() <= 1.0)
    );
    assert!(albedo.iter().any(|v| v.max_element() > 0.2));
    assert!(layer(&a, names[2]).iter().all(|v| v.length() <= 1.0 + 1e-5));
    // Relative squared difference of two runs.
    let noise = names.map(|names| {
        let (a, b) = (layer(&a, names), layer(&b, names));
        let difference: f32 = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (*a - *b).length_squared())
            .sum();
        let power: f32 = a.iter().map(|a| a.length_squared()).sum();
        difference / power
    });
    assert!(
        noise[1] < 0.2 * noise[0] && noise[2] < 0.2 * noise[0],
        "{noise:?}"
    );
}
