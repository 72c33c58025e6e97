//! Mistakes in edits: one clear error each, with the line.

use crate::scenes::{PLAIN, ROOM, room, try_room};
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene;

/// Line of the edit in the scene.
fn line() -> usize {
    ROOM.lines().count() + 1
}

#[test]
fn are_told_with_their_place() {
    let source = r#"<transform name="source"><scale value="0.5"/></transform>"#;
    let map = r#"<transform name="map"><translate x="1"/></transform>"#;
    let cases = [
        (r#"<edit type="paint"/>"#.to_owned(), "there is no edit \"paint\"; known is retarget"),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L S^ X"/>{map}</edit>"#),
            "path expression \"L S^ X\", character",
        ),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L X* E"/>{map}</edit>"#),
            "a selection leads from L",
        ),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L X"/>{map}</edit>"#),
            "a selection leads from L",
        ),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L D X[floor]"/>{map}</edit>"#),
            "where it shall be is said by the source",
        ),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L D[roof] X"/>{map}</edit>"#),
            "nothing named \"roof\"",
        ),
        (
            r#"<edit type="retarget"><transform name="target"><scale value="2"/></transform></edit>"#.to_owned(),
            "a target needs a source",
        ),
        (
            format!(r#"<edit type="retarget">{source}{map}<transform name="target"/></edit>"#),
            "either \"target\" or \"map\"",
        ),
        (
            r#"<edit type="retarget"><transform name="source"><scale x="0" y="1" z="1"/></transform></edit>"#.to_owned(),
            "<transform name=\"source\">",
        ),
        (
            r#"<edit type="retarget"><string name="source" value="roof"/></edit>"#.to_owned(),
            "no shape \"roof\" for a source",
        ),
        (
            format!(r#"<edit type="retarget">{map}<string name="keep" value="light"/></edit>"#),
            "expected radiance or energy",
        ),
        (
            format!(r#"<edit type="retarget"><string name="flow" value="importance"/>{map}<string name="keep" value="energy"/></edit>"#),
            "energy is kept of light alone",
        ),
        (
            format!(r#"<edit type="retarget">{map}<float name="intensity" value="-1"/></edit>"#),
            "intensity",
        ),
        (
            r#"<edit type="retarget"><animation name="map"><transform time="1"/><transform time="1"/></animation></edit>"#.to_owned(),
            "the times of an animation grow",
        ),
        (format!(r#"<edit type="retarget">{map}<float name="strength" value="1"/></edit>"#), "strength"),
        (r#"<edit type="retarget"/>"#.to_owned(), "this edit changes nothing"),
        (format!(r#"<edit type="retarget"><string name="selection" value="L D X"/>{source}</edit>"#), "this edit changes nothing"),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L D X"/><string name="flow" value="light"/>{map}</edit>"#),
            "the selection says which flow",
        ),
        (
            format!(r#"<edit type="retarget">{map}<float name="saturation" value="0.5"/></edit>"#),
            "a hue, which is not given",
        ),
        (
            r#"<edit type="retarget"><float name="intensity" value="2"/><string name="keep" value="energy"/></edit>"#.to_owned(),
            "and there is neither",
        ),
        (
            format!(r#"<edit type="retarget"><string name="shape" value="sphere"/>{map}</edit>"#),
            "a source which a transform places",
        ),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L D[nosuch*] X"/>{map}</edit>"#),
            "character 5: no path of this scene can match: it has nothing whose name fits",
        ),
        (
            format!(r#"<edit type="retarget"><string name="selection" value="L S^T X"/>{map}</edit>"#),
            "no surface of the scene scatters as \"L S^T X\" says",
        ),
    ];
    for (edit, expected) in cases {
        let message = try_room(PLAIN, &edit).unwrap_err().to_string();
        assert!(message.contains(expected), "{edit}: {message}");
        let place = format!("scene.xml:{}:", line());
        assert!(message.contains(&place), "{edit}: {message} {place}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn of_algorithms_and_files() {
    let map = r#"<edit type="retarget"><transform name="map"><translate x="1"/><rotate y="1" angle="3"/></transform></edit>"#;
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("<scene version=\"3.0.0\">{content}</scene>")).unwrap();
        path
    };
    let scene = parse_scene(
        &write("scene.xml", &ROOM.replace("FLOOR", PLAIN)),
        &[],
        true,
    )
    .unwrap();
    let build = |file: &str, content: &str, integrator: &str| {
        let options = BuildOptions {
            edit: Some(write(file, content)),
            integrator: Some(integrator.to_owned()),
            ..BuildOptions::default()
        };
        build_scene(&scene, &options).map(|scene| scene.edits)
    };
    assert!(!build("edits.xml", map, "path").unwrap().is_empty());
    for (content, integrator, expected) in [
        (map, "direct", "edits of light transport are not for direct"),
        ("", "path", "there is no <edit>"),
        (
            r#"<bsdf type="diffuse"/>"#,
            "path",
            "holds nothing but <edit>s",
        ),
        (
            r#"<edit type="retarget"><float name="intensity" value="3"/><float name="hu" value="3"/></edit>"#,
            "path",
            "does not use this",
        ),
    ] {
        let message = build("edits.xml", content, integrator)
            .unwrap_err()
            .to_string();
        assert!(message.contains(expected), "{content}: {message}");
        assert!(message.contains("edits.xml:1:"), "{content}: {message}");
    }
    // A time chooses between keyframes, which must be there.
    for edit in [None, Some(write("still.xml", map))] {
        let options = BuildOptions {
            edit,
            edit_time: Some(0.0),
            ..BuildOptions::default()
        };
        let message = build_scene(&scene, &options).unwrap_err().to_string();
        assert!(message.contains("no edit with an <animation>"), "{message}");
    }
    // Shapes are named, and the time chooses between keyframes.
    let keys = r#"<edit type="retarget"><string name="source" value="ball"/><animation name="map">
        <transform time="0"/><transform time="2"><translate x="1"/></transform></animation></edit>"#;
    assert!(
        room(PLAIN, keys).edits.is_empty(),
        "nothing has moved at first"
    );
    let options = BuildOptions {
        edit: Some(write("keys.xml", keys)),
        edit_time: Some(1.0),
        ..BuildOptions::default()
    };
    let edits = build_scene(&scene, &options).unwrap().edits;
    assert!((edits.view().unwrap().list[0].map[3] - 0.5).abs() < 1e-6);
}
