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

/// Loads with one warning of the given words, and the tables of the plain scene.
#[track_caller]
fn said(bytes: &[u8], words: &str) {
    let files = Files::new(&[]);
    let reference = files.clean("3.0.0", WALL);
    let scene = files.load(bytes, false).unwrap_or_else(|error| {
        panic!("{}: {error}", String::from_utf8_lossy(bytes));
    });
    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains(words), "{warnings:?}");
    assert_eq!(scene.tables.fingerprint(), reference);
    assert!(files.load(bytes, true).unwrap_err().contains(words));
}

#[test]
fn encodings_that_are_wrong_are_named() {
    let german = text("3.0.0", WALL).replace("grey", "gr\u{fc}n");
    let latin: Vec<u8> = german.chars().map(|c| c as u8).collect();
    said(&latin, "scene.xml:7: XML: no UTF-8");
    let comment = text("3.0.0", WALL).replace("<shape", "<!-- gr\u{fc}n --><shape");
    let latin: Vec<u8> = comment.chars().map(|c| c as u8).collect();
    said(&latin, "Windows-1252");
    let unknown = format!("<?xml version=\"1.0\" encoding=\"klingon\"?>{german}");
    said(unknown.as_bytes(), "\"klingon\"");
    let unmarked: Vec<u8> = german.encode_utf16().flat_map(u16::to_le_bytes).collect();
    same(&unmarked);
    let unmarked: Vec<u8> = german.encode_utf16().flat_map(u16::to_be_bytes).collect();
    same(&unmarked);
    for (bytes, part) in [
        (
            &b"\x76\x2f\x31\x01\x02\0\0\0\xff"[..],
            "an image of the format OpenEXR",
        ),
        (b"\x01\x02\0\0\0\xff", "is no text"),
    ] {
        let error = Files::new(&[]).load(bytes, false).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn characters_that_xml_forbids_are_blanks() {
    let plain = text("3.0.0", WALL);
    for scene in [
        format!("{plain}\0"),
        format!("{plain}\n\0\0"),
        plain.replace("<shape", "\u{c}<shape"),
        plain.replace("grey", "gr\u{1}ey"),
        plain.replace("grey", "gr&#1;ey"),
        plain.replace("grey", "gr&#x1F;ey"),
    ] {
        same(scene.as_bytes());
    }
}

#[test]
fn what_stands_around_the_scene_is_left_out() {
    let plain = text("3.0.0", WALL);
    let outside = "text outside";
    said(format!("{plain}\nthe end").as_bytes(), outside);
    said(format!("made by hand {plain}").as_bytes(), outside);
    let second = format!("{plain}<scene version=\"3.0.0\"><shape type=\"sphere\"/></scene>");
    said(second.as_bytes(), "behind the outermost element");
    let twice = plain.replace("id=\"grey\"", "id=\"grey\" id=\"green\"");
    said(twice.as_bytes(), "an attribute is there twice");
}

#[test]
fn versions_that_are_none_are_said() {
    for version in ["abc", "", "3.x", "1.2.3.4"] {
        Files::new(&[]).warned(version, WALL, "\"version\" is none");
    }
    for version in ["4.2.0", "17"] {
        Files::new(&[]).warned(version, WALL, "newer");
    }
    for version in ["3", "3.5.2", " 2.1.0 ", "3.0"] {
        Files::new(&[]).clean(version, WALL);
    }
}

#[test]
fn places_stay_those_of_the_file() {
    let files = Files::new(&[]);
    let scene = "\n<?xml version=\"1.0\"?>\n<!-- a -- b\n-->\n<scene version=\"3.0.0\">\n  <blub/>\n</scene>";
    let error = files.load(scene.as_bytes(), true).unwrap_err();
    assert!(error.contains("scene.xml:6:3: <blub>"), "{error}");
}

#[test]
fn text_between_elements_is_said() {
    let files = Files::new(&[]);
    let without = files.clean("3.0.0", r#"<shape type="sphere"/>"#);
    for content in [
        r#"<shape type="sphere">radius 2</shape>"#,
        r#"radius 2<shape type="sphere"/>"#,
        "<shape type=\"sphere\">\n<![CDATA[ radius 2 ]]></shape>",
    ] {
        let words = "left out: \"radius 2\"";
        assert_eq!(files.warned("3.0.0", content, words), without);
    }
    let content = r#"<shape type="sphere"/> & more "#;
    assert_eq!(
        files.warned("3.0.0", content, "left out: \"& more\""),
        without
    );
    let error = files
        .load(text("3.0.0", "\n\n  lost").as_bytes(), true)
        .expect_err("strictly an error");
    assert!(error.contains("scene.xml:9:3: text"), "{error}");
}
