//! Scenes of several files.

use halflight::scene::xml::parse_scene;

use super::*;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Folder {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a parent")).expect("makes a folder");
            std::fs::write(path, text).expect("writes");
        }
        Folder(folder)
    }
    fn parse(&self, name: &str) -> Result<ParsedScene, SceneError> {
        parse_scene(&self.0.path().join(name), &[], true)
    }
    /// The message of the error, with the folder taken out of file names.
    fn error(&self, name: &str) -> String {
        let message = self.parse(name).expect_err("an error").to_string();
        message.replace(&format!("{}/", self.0.path().display()), "")
    }
}

#[test]
fn included_files_are_read_where_they_stand() {
    let folder = Folder::new(&[
        (
            "main.xml",
            "<scene version=\"3.0.0\"><path value=\"common\"/><default name=\"n\" value=\"1\"/>\
             <include filename=\"parts/part.xml\"/><include name=\"m\" filename=\"material.xml\"/>\
             <shape type=\"obj\"><ref id=\"tex\"/><string name=\"filename\" value=\"mesh.obj\"/></shape></scene>",
        ),
        (
            "common/parts/part.xml",
            "<scene version=\"0.6.0\"><default name=\"n\" value=\"2\"/><texture type=\"t\" id=\"tex\">\
             <integer name=\"sampleCount\" value=\"$n\"/><string name=\"filename\" value=\"a.png\"/></texture>\
             <include filename=\"deep.xml\"/></scene>",
        ),
        (
            "common/parts/deep.xml",
            "<scene version=\"3.0.0\"><emitter type=\"point\"/></scene>",
        ),
        ("common/parts/a.png", ""),
        ("common/mesh.obj", ""),
        (
            "material.xml",
            "<bsdf version=\"3.0.0\" type=\"diffuse\" id=\"mat\"/>",
        ),
    ]);
    let scene = folder.parse("main.xml").expect("parses");
    let children: Vec<_> = scene
        .root
        .children()
        .map(|child| (child.name(), child.object.plugin.as_str()))
        .collect();
    assert_eq!(
        children,
        [("", "t"), ("", "point"), ("m", "diffuse"), ("", "obj")]
    );
    assert_eq!(scene.files.len(), 4);
    let objects: Vec<_> = scene.root.children().map(|child| child.object).collect();
    assert_eq!(
        objects[0].get_int("sample_count", 0),
        Ok(1),
        "the first default wins"
    );
    assert!(
        objects[0]
            .require_file("filename")
            .expect("found")
            .ends_with("common/parts/a.png")
    );
    assert!(
        objects[3]
            .require_file("filename")
            .expect("found")
            .ends_with("common/mesh.obj")
    );
}

#[test]
fn files_that_are_not_there_are_named() {
    let folder = Folder::new(&[
        (
            "a.xml",
            "<scene version=\"3.0.0\">\n <include filename=\"none.xml\"/></scene>",
        ),
        (
            "b.xml",
            "<scene version=\"3.0.0\">\n\n<path value=\"nowhere\"/></scene>",
        ),
        (
            "c.xml",
            "<scene version=\"3.0.0\"><shape type=\"obj\">\n<string name=\"filename\" value=\"m.obj\"/></shape></scene>",
        ),
        (
            "d.xml",
            "<scene version=\"3.0.0\"><include filename=\"sub\"/></scene>",
        ),
        (
            "e.xml",
            "<scene version=\"3.0.0\"><bsdf type=\"t\"><path value=\"sub\"/></bsdf></scene>",
        ),
        ("sub/f.xml", ""),
        (
            "g.xml",
            "<scene version=\"3.0.0\">\n<include filename=\"sub/f.xml\"/></scene>",
        ),
    ]);
    let here = folder.0.path().display();
    let searched = format!("searched \"{here}\"");
    assert_eq!(
        folder.error("a.xml"),
        format!("a.xml:2:2: <include filename=\"none.xml\">: no file \"none.xml\"; {searched}")
    );
    assert_eq!(
        folder.error("b.xml"),
        format!("b.xml:3:1: <path>: no folder \"nowhere\"; {searched}")
    );
    let scene = folder.parse("c.xml").expect("parses");
    let child = scene.root.children().next().expect("a shape");
    let message = child
        .object
        .require_file("filename")
        .expect_err("missing")
        .to_string();
    assert_eq!(
        message,
        format!("{here}/c.xml:2:1: <string name=\"filename\">: no file \"m.obj\"; {searched}")
    );
    assert_eq!(folder.error("d.xml"), "sub: is not a regular file");
    assert!(
        folder
            .error("e.xml")
            .ends_with("<path>: belongs directly inside of the outermost element")
    );
    assert!(
        folder
            .error("g.xml")
            .starts_with("sub/f.xml:1:1: malformed XML: ")
    );
    assert!(
        folder
            .error("none.xml")
            .starts_with("none.xml: cannot be read: ")
    );
}

#[test]
fn inclusion_ends() {
    let folder = Folder::new(&[
        (
            "self.xml",
            "<scene version=\"3.0.0\"><include filename=\"self.xml\"/></scene>",
        ),
        (
            "a.xml",
            "<scene version=\"3.0.0\"><include filename=\"b.xml\"/></scene>",
        ),
        (
            "b.xml",
            "<scene version=\"3.0.0\"><include filename=\"./a.xml\"/></scene>",
        ),
    ]);
    for name in ["self.xml", "a.xml"] {
        let message = folder.error(name);
        assert!(
            message.ends_with("the file includes itself, directly or through others"),
            "{message}"
        );
    }
    // A billion laughs: each of ten files includes the next one ten times.
    let names: Vec<String> = (0..11).map(|i| format!("{i}.xml")).collect();
    let texts: Vec<String> = (0..11)
        .map(|i| {
            let include = format!("<include filename=\"{}.xml\"/>", i + 1);
            format!(
                "<scene version=\"3.0.0\">{}</scene>",
                if i < 10 {
                    include.repeat(10)
                } else {
                    String::new()
                }
            )
        })
        .collect();
    let files: Vec<_> = names
        .iter()
        .map(String::as_str)
        .zip(texts.iter().map(String::as_str))
        .collect();
    let message = Folder::new(&files).error("0.xml");
    assert!(
        message.ends_with("more than 4096 files are included"),
        "{message}"
    );
    let texts: Vec<String> = (0..20)
        .map(|i| {
            format!(
                "<scene version=\"3.0.0\"><include filename=\"{}.xml\"/></scene>",
                i + 1
            )
        })
        .collect();
    let names: Vec<String> = (0..20).map(|i| format!("{i}.xml")).collect();
    let files: Vec<_> = names
        .iter()
        .map(String::as_str)
        .zip(texts.iter().map(String::as_str))
        .collect();
    let message = Folder::new(&files).error("0.xml");
    assert!(
        message.ends_with("files are included more than 15 deep"),
        "{message}"
    );
}

#[test]
fn files_without_a_named_encoding_are_said() {
    let folder = Folder::new(&[]);
    std::fs::write(
        folder.0.path().join("latin.xml"),
        b"<scene version=\"3.0.0\">\n<!-- \xe9 --></scene>",
    )
    .expect("writes");
    assert_eq!(
        folder.error("latin.xml"),
        "latin.xml:2: XML: no UTF-8, and no other encoding is named; the file is read as Windows-1252"
    );
    std::fs::write(
        folder.0.path().join("bom.xml"),
        b"\xef\xbb\xbf<scene version=\"3.0.0\"/>",
    )
    .expect("writes");
    assert!(folder.parse("bom.xml").is_ok());
}
