//! Files and values that are not what an option takes: said in words that lead on.

use super::Place;

/// What a command that fails says.
#[track_caller]
pub fn refused(place: &Place, arguments: &[&str]) -> String {
    let output = place.run(arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{arguments:?} succeeded");
    text
}

#[test]
fn an_image_is_no_scene() {
    let place = Place::with_scene();
    place.succeed(&["scene.xml", "-o", "a.exr"]);
    let image = std::fs::read(place.path("a.exr")).expect("an image");
    place.write("b.xml", &image);
    for (arguments, format) in [
        (&["a.exr"][..], "OpenEXR"),
        (&["a.png"], "PNG"),
        (&["render", "b.xml"], "OpenEXR"),
        (&["info", "a.png"], "PNG"),
        (&["material", "a.exr", "-o", "m.png"], "OpenEXR"),
        (
            &["inspect", "a.png", "--tool", "false-color", "-o", "f.png"],
            "PNG",
        ),
    ] {
        let text = refused(&place, arguments);
        let part = format!("is no scene file, but an image of the format {format}");
        assert!(text.contains(&part), "{arguments:?}: {text}");
    }
    assert_eq!(std::fs::read(place.path("a.exr")).expect("an image"), image);
}

#[test]
fn a_material_may_be_in_a_lenient_file() {
    let place = Place::with_scene();
    let scene = b"<scene version='3.0.0'><!-- gr\xfcn --><bsdf id='g' type='diffuse' type='diffuse'/></scene>";
    place.write("latin.xml", scene);
    place.succeed(&["material", "latin.xml", "--spp", "1", "-o", "m.png", "-q"]);
}

#[test]
fn negative_numbers_are_values() {
    let place = Place::with_scene();
    let look = &[
        "inspect",
        "scene.xml",
        "--tool",
        "false-color",
        "-o",
        "f.png",
    ][..];
    for (arguments, part) in [
        (
            [look, &["--min", "-1"]].concat(),
            "expected a number that is not negative",
        ),
        (
            vec!["scene.xml", "--spp", "-1"],
            "invalid value '-1' for '--spp",
        ),
        (
            vec!["scene.xml", "--threads", "-2"],
            "invalid value '-2' for '--threads",
        ),
        (
            vec!["scene.xml", "--clamp", "-0.5"],
            "expected a number above zero",
        ),
        (
            vec!["scene.xml", "--time", "-5s"],
            "expected a time such as",
        ),
        (
            vec!["scene.xml", "--crop", "-1,0,2,2"],
            "for '--crop <X,Y,W,H>'",
        ),
        (
            vec!["material", "diffuse", "--spp", "-3"],
            "invalid value '-3' for '--spp",
        ),
    ] {
        let text = refused(&place, &arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
        assert!(!text.contains("tip:"), "{arguments:?}: {text}");
    }
}

#[test]
fn values_beyond_sixteen_bits_are_said() {
    let place = Place::with_scene();
    place.write(
        "bright.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm"><integer name="width" value="2"/><integer name="height" value="1"/></film></sensor>
        <emitter type="constant"><rgb name="radiance" value="1e38, 1e30, 1"/></emitter></scene>"#,
    );
    let says = |arguments: &[&str]| {
        let output = place.run(&[&["bright.xml", "--spp", "1"], arguments].concat());
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let text = says(&["-o", "half.exr", "--half"]);
    assert!(
        text.contains("half.exr: 4 values are too large for 16 bits and are stored as 65504"),
        "{text}"
    );
    assert!(!says(&["-o", "full.exr"]).contains("too large"));
    // Whatever the values are, they stand apart.
    let table = place.succeed(&["image", "statistics", "full.exr"]);
    for line in table.lines().skip(2) {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words.len(), 7, "{table}");
        assert!(
            words[1..].iter().all(|w| w.parse::<f64>().is_ok()),
            "{table}"
        );
    }
    assert!(
        table.contains("1.000e38") && table.contains("1.00000"),
        "{table}"
    );
}

#[test]
fn layers_have_the_names_that_the_command_gives_them() {
    let place = Place::with_scene();
    let render = [
        "scene.xml",
        "--aov",
        "alpha,depth,samples",
        "-o",
        "a.exr",
        "-q",
    ];
    place.succeed(&render);
    for (layer, channel) in [("alpha", "A"), ("depth", "depth.Z"), ("samples", "samples")] {
        place.succeed(&["image", "convert", "a.exr", "--layer", layer, "-o", "b.exr"]);
        let channels = place.channels("a.exr");
        let (_, expected) = channels
            .iter()
            .find(|(name, _)| name == channel)
            .expect("a channel");
        let found = place.channels("b.exr");
        assert_eq!(&found[0].1, expected, "{layer}");
    }
}

#[test]
fn two_runs_do_not_share_a_checkpoint() {
    let place = Place::with_scene();
    let arguments = ["scene.xml", "--checkpoint", "c", "-o", "a.exr"];
    let lock = std::fs::File::create(place.path(".c.lock")).expect("a file");
    lock.try_lock().expect("a lock");
    let text = refused(&place, &arguments);
    assert!(text.contains("c is in use by another run"), "{text}");
    assert!(!place.path("a.exr").exists());
    // What a killed run leaves is nobody's.
    drop(lock);
    place.succeed(&arguments);
    let text = refused(&place, &["scene.xml", "--resume", "nothing", "-o", "a.exr"]);
    assert!(!text.contains("in use"), "{text}");
    assert_eq!(place.files(), ["a.exr", "a.png", "c", "scene.xml"]);
}

#[test]
fn what_an_option_cannot_choose_is_said() {
    let place = Place::with_scene();
    for (arguments, part) in [
        (
            &["scene.xml", "--record", "r", "--record-pixels", "24,0,9,9"][..],
            "the pixels 24,0,9,9 are not in the image, 0,0,24,16",
        ),
        (
            &[
                "inspect",
                "scene.xml",
                "--tool",
                "paths",
                "--pixels",
                "0,0,0,4",
                "-o",
                "p.png",
            ],
            "the pixels 0,0,0,4 are not in the image",
        ),
        (
            &["scene.xml", "--record", "r", "--record-pixels", "20,0,9,9"],
            "the pixels 20,0,9,9 reach beyond the image of 24 x 16 pixels",
        ),
        (
            &["scene.xml", "--edit-time", "nan"],
            "expected a finite number",
        ),
        (
            &["scene.xml", "--edit-time", "1"],
            "--edit-time: there is no edit with an <animation>",
        ),
        (
            &["material", "diffuse", "--id", "x", "-o", "m.png"],
            "diffuse: no bsdf with the id \"x\"",
        ),
        (&["scene.xml", "--exposure", "100"], "from -64 to 64"),
    ] {
        let text = refused(&place, arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
    assert_eq!(place.files(), ["scene.xml"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_what_has_nothing_to_write() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let place = Place::with_scene();
    // Standard input that does not end is a scene that loads forever.
    let mut process = place
        .command(&["-", "-o", "a.exr"])
        .stdin(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    std::thread::sleep(Duration::from_millis(300));
    // SAFETY: it is our own child, which has not been waited for.
    unsafe { libc::kill(process.id() as libc::pid_t, libc::SIGINT) };
    let start = Instant::now();
    while process.try_wait().expect("a child").is_none() {
        assert!(start.elapsed() < Duration::from_secs(20), "it goes on");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(place.files(), ["scene.xml"]);
}
