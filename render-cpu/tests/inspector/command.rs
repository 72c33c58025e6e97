//! The command that writes the page: what it refuses, and that it depends on nothing but what it is told.

use crate::{BALL, write_page};
use std::path::Path;
use std::process::Command;

/// What the command says when it refuses.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
    let output = command
        .arg("inspect")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(!output.status.success(), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn what_does_not_fit_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, scene: &str| {
        std::fs::write(
            folder.path().join(name),
            format!("<scene version=\"3.0.0\">{scene}</scene>"),
        )
        .unwrap()
    };
    write("s.xml", BALL);
    write("other.xml", &BALL.replace("id=\"ball\"", "id=\"globe\""));
    let mut render = Command::new(env!("CARGO_BIN_EXE_halflight"));
    render.args([
        "render", "s.xml", "--spp", "1", "--record", "p.bin", "-o", "s.exr",
    ]);
    assert!(
        render
            .current_dir(folder.path())
            .output()
            .unwrap()
            .status
            .success()
    );
    for (arguments, reason) in [
        (&["s.xml", "-o", "x.png"][..], "say with --tool"),
        (&["s.xml", "-o", "x.txt"], "ends in .html"),
        (
            &[
                "other.xml",
                "-o",
                "x.html",
                "--spp",
                "1",
                "--paths",
                "p.bin",
            ],
            "these are paths of another scene",
        ),
        (
            &[
                "s.xml", "-o", "x.html", "--spp", "1", "--width", "48", "--image", "s.exr",
            ],
            "96 x 64 pixels, where the scene's image has 48 x 32",
        ),
        (
            &["s.xml", "-o", "x.html", "--spp", "1", "--only", "L Q E"],
            "'Q' is none of",
        ),
        (
            &["s.xml", "-o", "x.html", "--spp", "1", "--pixel", "5000,0"],
            "--pixel: 5000,0 is not in the image of 96 x 64 pixels",
        ),
    ] {
        let said = refused(folder.path(), arguments);
        assert!(said.contains(reason), "{arguments:?}: {said}");
        assert!(!folder.path().join("x.html").exists());
    }
}

#[test]
fn the_page_does_not_depend_on_threads_and_holds_no_markup_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = BALL.replace("id=\"floor\"", "id=\"floor &lt;/script>&lt;b>\"");
    let page = |threads: &str, more: &[&str]| {
        let arguments = ["--spp", "2", "--record-count", "100", "--threads", threads];
        write_page(folder.path(), &scene, &[&arguments, more].concat());
        std::fs::read_to_string(folder.path().join("page.html")).unwrap()
    };
    let (one, three) = (page("1", &[]), page("3", &[]));
    assert!(one == three);
    assert!(one.contains("floor \\u003c/script>\\u003cb>") && !one.contains("floor </script>"));
    // A sphere of 48 by 24 quadrangles, and two rectangles.
    assert!(one.contains("\"triangles\":2308") && one.contains("\"of\":2308"));
    let thin = page("2", &["--triangles", "400"]);
    assert!(thin.contains("\"of\":2308") && thin.len() < one.len());
}
