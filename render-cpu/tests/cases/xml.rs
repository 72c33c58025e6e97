//! XML that is not well-formed but that Mitsuba reads, and encodings.

use crate::{Files, text};

const WALL: &str = r#"<shape type="rectangle"><bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.5"/></bsdf></shape>"#;

#[track_caller]
fn same(bytes: &[u8]) {
    let files = Files::new(&[]);
    let reference = files.clean("3.0.0", WALL);
    let scene = files.load(bytes, true).unwrap_or_else(|error| {
        panic!("{}: {error}", String::from_utf8_lossy(bytes));
    });
    assert_eq!(scene.tables.fingerprint(), reference);
}

#[test]
fn declarations_comments_and_ampersands() {
    let plain = text("3.0.0", WALL);
    let declared = |declaration: &str| format!("{declaration}{plain}");
    for scene in [
        declared("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"),
        declared("\n  <?xml version='1.0'?>"),
        declared("\u{feff}<?xml version=\"1.0\"?>"),
        declared("\u{feff}"),
        declared("<!DOCTYPE scene>"),
        declared("<!DOCTYPE scene SYSTEM \"scene.dtd\" [ <!ELEMENT scene ANY> ]>"),
        declared("<?xml version=\"1.0\" standalone=\"yes\"?><!-- a -- b --- c -->"),
        plain.replace("<bsdf ", "<!-- R&D -- <bsdf> --><bsdf "),
        plain.replace("id=\"grey\"", "id=\"R&D\""),
        plain.replace("id=\"grey\"", "id=\"a&nbsp;b&c;\""),
        plain.replace("id=\"grey\"", "id=\"a<b>c\""),
        plain.replace("type=\"diffuse\" id", "type=\"diffuse\"id"),
        plain.replace("</shape>", "</shape> & more "),
        plain.replace('\n', "\r\n"),
    ] {
        same(scene.as_bytes());
    }
}

#[test]
fn declared_encodings() {
    let named = |label: &str| {
        let body = text("3.0.0", WALL).replace("grey", "größe");
        format!("<?xml version=\"1.0\" encoding=\"{label}\"?>\n{body}")
    };
    let latin = |text: &str| -> Vec<u8> { text.chars().map(|c| c as u8).collect() };
    for label in ["ISO-8859-1", "iso-8859-15", "latin1", "windows-1252"] {
        same(&latin(&named(label)));
    }
    same(named("UTF-8").as_bytes());
    for little in [true, false] {
        let mut bytes = Vec::new();
        for unit in std::iter::once(0xfeff).chain(named("UTF-16").encode_utf16()) {
            let unit: u16 = unit;
            bytes.extend(if little {
                unit.to_le_bytes()
            } else {
                unit.to_be_bytes()
            });
        }
        same(&bytes);
    }
}

#[test]
fn encodings_that_are_wrong_are_named() {
    let files = Files::new(&[]);
    let bytes = text("3.0.0", WALL).replace("grey", "gr\u{fc}n");
    let latin: Vec<u8> = bytes.chars().map(|c| c as u8).collect();
    assert!(files.load(&latin, false).unwrap_err().contains("UTF-8"));
    let unknown = format!("<?xml version=\"1.0\" encoding=\"klingon\"?>{bytes}");
    let error = files.load(unknown.as_bytes(), false).unwrap_err();
    assert!(error.contains("\"klingon\""), "{error}");
}

#[test]
fn places_stay_those_of_the_file() {
    let files = Files::new(&[]);
    let scene = "\n<?xml version=\"1.0\"?>\n<!-- a -- b\n-->\n<scene version=\"3.0.0\">\n  <blub/>\n</scene>";
    let error = files.load(scene.as_bytes(), true).unwrap_err();
    assert!(error.contains("scene.xml:6:3: <blub>"), "{error}");
}
