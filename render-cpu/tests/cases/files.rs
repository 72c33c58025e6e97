//! Files that hold something else than their name says.

use crate::Files;

const POINTER: &[u8] = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\nsize 12345\n";
const PAGE: &[u8] = b"\n<!DOCTYPE HTML>\n<html><body>404</body></html>";
const OTHER_PAGE: &[u8] = b"\xef\xbb\xbf<HTML lang=\"en\"><title>Sign in</title></HTML>";

/// Content that reads a file, for every reader of the program.
fn readers(file: &str) -> Vec<String> {
    let mesh = |plugin: &str| {
        format!(r#"<shape type="{plugin}"><string name="filename" value="{file}"/></shape>"#)
    };
    let bsdf = |bsdf: &str| format!(r#"<shape type="sphere">{bsdf}</shape>"#);
    vec![
        mesh("obj"),
        mesh("ply"),
        mesh("serialized"),
        bsdf(&format!(
            r#"<bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="{file}"/></texture></bsdf>"#
        )),
        bsdf(&format!(
            r#"<bsdf type="merl"><string name="filename" value="{file}"/></bsdf>"#
        )),
        bsdf(&format!(
            r#"<bsdf type="diffuse"><spectrum name="reflectance" filename="{file}"/></bsdf>"#
        )),
        format!(r#"<include filename="{file}"/>"#),
    ]
}

#[test]
fn pointers_of_git_lfs_are_named_as_such() {
    let files = Files::new(&[("file.png", POINTER)]);
    for content in readers("file.png") {
        let error = files.error("3.0.0", &content);
        assert!(
            error.contains("Git LFS") && error.contains("git lfs pull"),
            "{error}"
        );
    }
}

#[test]
fn web_pages_are_named_as_such() {
    let files = Files::new(&[("file.obj", PAGE), ("file.png", OTHER_PAGE)]);
    for content in readers("file.obj") {
        let error = files.error("3.0.0", &content);
        assert!(error.contains("a web page, not an OBJ file"), "{error}");
    }
    for content in readers("file.png") {
        let error = files.error("3.0.0", &content);
        assert!(error.contains("a web page, not a PNG file"), "{error}");
    }
}

#[test]
fn other_text_is_no_mesh() {
    let files = Files::new(&[
        ("empty.obj", b""),
        ("prose.obj", b"Not found.\nTry again later.\n"),
        ("comment.obj", b"# nothing\no object\n"),
    ]);
    for file in ["empty.obj", "prose.obj", "comment.obj"] {
        let content =
            format!(r#"<shape type="obj"><string name="filename" value="{file}"/></shape>"#);
        let error = files.error("3.0.0", &content);
        assert!(
            error.contains("no vertex and no face") && error.contains(file),
            "{error}"
        );
    }
}
