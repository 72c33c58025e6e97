//! What is refused of path expressions, records of paths, edits and the tools that look at paths.

use super::Place;
use super::wrong_values::refused;

#[test]
fn options_of_another_tool_are_refused() {
    let place = Place::with_scene();
    place.write("e.xml", b"<scene version='3.0.0'><edit type='retarget'><float name='intensity' value='2'/></edit></scene>");
    place.write("r", b"");
    let inspect = ["inspect", "scene.xml", "-o"];
    let picture = |tool: &'static str| [&inspect[..], &["p.png", "--tool", tool]].concat();
    let page = [&inspect[..], &["p.html"]].concat();
    let (color, plot) = (picture("false-color"), picture("spherical-plot"));
    let (paths, volume) = (picture("paths"), picture("volume"));
    for (before, own, part) in [
        (
            &color,
            &["--at", "0,0,0"][..],
            "--at is of --tool spherical-plot, pages, not of --tool false-color",
        ),
        (
            &color,
            &["--voxels", "8"],
            "--voxels is of --tool volume, pages",
        ),
        (
            &color,
            &["--bundles", "8"],
            "--bundles is of --tool paths, not",
        ),
        (
            &color,
            &["--triangles", "800"],
            "--triangles is of pages, not of --tool false-color",
        ),
        (
            &plot,
            &["--quantity", "radiance"],
            "--quantity is of --tool false-color, not",
        ),
        (
            &plot,
            &["--paths", "r"],
            "--paths is of --tool paths, pages, not",
        ),
        (
            &paths,
            &["--log"],
            "--log is of --tool false-color, --tool spherical-plot, not of --tool paths",
        ),
        (
            &paths,
            &["--box", "0,0,0,1,1,1"],
            "--box is of --tool volume, pages, not",
        ),
        (
            &volume,
            &["--cluster", "object"],
            "--cluster is of --tool paths, not",
        ),
        (
            &volume,
            &["--min", "0"],
            "--min is of --tool false-color, --tool spherical-plot, not",
        ),
        (
            &page,
            &["--view", "0,0,1"],
            "--view is of --tool spherical-plot, not of pages",
        ),
        (&page, &["--json"], "not of pages"),
        (
            &page,
            &["--walks", "9"],
            "--walks goes with --box in a page",
        ),
        (
            &page,
            &["--rows", "9"],
            "--rows goes with --at or --pixel in a page",
        ),
        (
            &page,
            &["--edit", "e.xml"],
            "--edit: a page shows light as it is",
        ),
        (
            &volume,
            &["--edit", "e.xml"],
            "--edit: this tool looks at light as it is",
        ),
        (
            &plot,
            &["--pixel", "24,3"],
            "--pixel: 24,3 is not in the image of 24 x 16 pixels",
        ),
    ] {
        let arguments = [&before[..], own].concat();
        let text = refused(&place, &arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
    assert_eq!(place.files(), ["e.xml", "r", "scene.xml"]);
    let edited = [&color[..], &["--spp", "1", "-q", "--edit", "e.xml"]].concat();
    place.succeed(&edited);
}

#[test]
fn what_is_no_record_of_paths_is_said() {
    let place = Place::with_scene();
    place.succeed(&[
        "scene.xml",
        "--spp",
        "2",
        "--record",
        "r",
        "-o",
        "a.exr",
        "-q",
    ]);
    place.succeed(&[
        "scene.xml",
        "--spp",
        "2",
        "--record",
        "r.jsonl",
        "-o",
        "a.exr",
        "-q",
    ]);
    let record = std::fs::read(place.path("r")).expect("a record");
    place.write("short", &record[..record.len() - 5]);
    place.write("cut", &record[..40]);
    place.write("junk", b"no");
    for (file, part) in [
        ("junk", "junk: this is no record of paths"),
        ("scene.xml", "scene.xml: this is no record of paths"),
        ("short", "short: the record ends too early"),
        ("cut", "cut: the record ends too early"),
        ("r.jsonl", "r.jsonl: these are lines of JSON"),
    ] {
        let text = refused(
            &place,
            &[
                "inspect",
                "scene.xml",
                "--tool",
                "paths",
                "--spp",
                "1",
                "--paths",
                file,
                "-o",
                "p.png",
            ],
        );
        assert!(text.contains(part), "{file}: {text}");
    }
}

#[test]
fn images_and_checkpoints_of_other_edits_are_refused_in_words() {
    let place = Place::with_scene();
    let write = |name: &str, selection: &str, intensity: &str| {
        let edit = format!(
            "<scene version='3.0.0'><edit type='retarget'><string name='selection' value='{selection}'/><float name='intensity' value='{intensity}'/></edit></scene>"
        );
        place.write(name, edit.as_bytes());
    };
    write("two.xml", "L X X", "2");
    write("three.xml", "L X X", "3");
    write("other.xml", "L X+ X", "2");
    let render = |edits: &'static str, more: &[&'static str]| {
        let common = ["scene.xml", "-q", "--edit", edits];
        [&common[..], more].concat()
    };
    place.succeed(&render(
        "two.xml",
        &["--spp", "1", "--checkpoint", "c", "-o", "a.exr"],
    ));
    let again = ["--spp", "2", "--checkpoint", "c", "-o", "b.exr"];
    let text = refused(&place, &render("three.xml", &again));
    assert!(
        text.contains("another render: they differ in the content of edit 1; it is not"),
        "{text}"
    );
    let text = refused(&place, &render("other.xml", &again));
    assert!(
        text.contains("another render: edit 1 is L X X there and L X+ X here; it is not"),
        "{text}"
    );
    let text = refused(&place, &[&["scene.xml", "-q"][..], &again].concat());
    assert!(
        text.contains("another render: edit 1 is L X X there and not set here; it is not"),
        "{text}"
    );
    place.succeed(&render("three.xml", &["--samples", "1..2", "-o", "b.exr"]));
    let text = refused(&place, &["merge", "a.exr", "b.exr", "-o", "m.exr"]);
    assert!(
        text.contains(
            "b.exr and a.exr are not shares of one image: they differ in the content of edit 1"
        ),
        "{text}"
    );
    place.succeed(&render("other.xml", &["--samples", "1..2", "-o", "b.exr"]));
    let text = refused(&place, &["merge", "a.exr", "b.exr", "-o", "m.exr"]);
    assert!(
        text.contains("b.exr: its edit 1 is L X+ X, that of a.exr is L X X"),
        "{text}"
    );
}
