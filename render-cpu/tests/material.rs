//! Pictures of materials: what a name or file stands for, the curves of the diagrams, the sheet.

use glam::Vec3;
use halflight::material::curves::Probe;
use halflight::material::examples::{EXAMPLES, Example};
use halflight::material::gallery::{PICTURE, contact_sheet};
use halflight::material::preview::Preview;
use halflight::material::sheet;
use halflight::material::source::{self, Source};
use halflight::plot::canvas::Canvas;
use halflight_kernel::scene::lobe_kind;
use std::fs;
use std::path::Path;

fn preview(bsdf: &str) -> Preview {
    let source = Source {
        name: "test".into(),
        bsdf: bsdf.into(),
        definitions: String::new(),
        version: "3.0.0".into(),
        file: "test.xml".into(),
    };
    Preview::new(&source, 16).expect("builds")
}

fn kind_of(preview: &Preview) -> u32 {
    let tables = &preview.scene.tables;
    let material = tables.materials[preview.material as usize];
    tables.lobes[material.first_lobe as usize].kind
}

#[test]
fn names_stand_for_examples_and_conductors() {
    for example in EXAMPLES {
        let found = source::find(example.name, None).unwrap();
        assert_eq!(found.bsdf, example.bsdf);
        let preview = Preview::new(&found, 16).expect(example.name);
        assert!(
            preview.scene.warnings.is_empty(),
            "{:?}",
            preview.scene.warnings
        );
        // The lights and the floor of the scene around it are there.
        assert_eq!(preview.scene.tables.emitters.len(), 3);
        assert!(preview.scene.tables.materials.len() >= 3);
    }
    let gold = Preview::new(&source::find("Au", None).unwrap(), 16).unwrap();
    assert_eq!(kind_of(&gold), lobe_kind::ROUGH_CONDUCTOR);
    let message = source::find("roughplastik", None).unwrap_err().to_string();
    assert!(
        message.contains("did you mean \"roughplastic\"?"),
        "{message}"
    );
}

/// A file in a fresh folder.
fn with_file(name: &str, contents: &[u8], test: impl FnOnce(&Path)) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    fs::write(&path, contents).unwrap();
    test(&path);
}

#[test]
fn scene_files_give_their_bsdfs_with_what_they_refer_to() {
    // An id that the scene of the preview has as well, a nested BSDF without an id, a version of its own.
    let text = "<scene version=\"0.6.0\"><default name=\"shade\" value=\"0.3\"/>
        <texture type=\"checkerboard\" id=\"floor\"/>
        <bsdf type=\"plastic\" id=\"material\"><rgb name=\"diffuseReflectance\" value=\"$shade\"/></bsdf>
        <bsdf type=\"twosided\" id=\"both\"><ref id=\"material\"/></bsdf>
        <bsdf type=\"diffuse\" id=\"checks\"><ref name=\"reflectance\" id=\"floor\"/></bsdf>
        <shape type=\"sphere\"><bsdf type=\"conductor\" id=\"inside\"/></shape></scene>";
    with_file("scene.xml", text.as_bytes(), |path| {
        let find = |id| source::find(path.to_str().unwrap(), id);
        let kind = |id| kind_of(&Preview::new(&find(id).unwrap(), 16).expect("builds"));
        assert_eq!(kind(None), lobe_kind::PLASTIC);
        assert_eq!(kind(Some("both")), lobe_kind::PLASTIC);
        assert_eq!(kind(Some("checks")), lobe_kind::DIFFUSE);
        assert_eq!(kind(Some("inside")), lobe_kind::CONDUCTOR);
        assert_eq!(find(Some("both")).unwrap().name, "both of scene.xml");
        assert!(find(Some("none")).unwrap_err().to_string().contains("none"));
    });
    with_file("scene.xml", b"<scene version=\"3.0.0\"/>", |path| {
        assert!(source::find(path.to_str().unwrap(), None).is_err());
    });
    with_file("scene.xml", b"<scene", |path| {
        assert!(source::find(path.to_str().unwrap(), None).is_err());
    });
}

#[test]
fn measured_files_are_materials() {
    let mut bytes: Vec<u8> = [2_i32, 2, 2].iter().flat_map(|n| n.to_le_bytes()).collect();
    bytes.extend((0..24).flat_map(|_| 150.0_f64.to_le_bytes()));
    with_file("a & b.binary", &bytes, |path| {
        let found = source::find(path.to_str().unwrap(), None).unwrap();
        let preview = Preview::new(&found, 16).unwrap();
        assert_eq!(kind_of(&preview), lobe_kind::MERL);
    });
}

#[test]
fn curves_are_those_of_the_models() {
    let diffuse = preview(
        "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.2, 0.5, 0.8\"/></bsdf>",
    );
    let probe = Probe::new(diffuse.scene.tables.view(), diffuse.material);
    assert!((probe.albedo(40.0) - Vec3::new(0.2, 0.5, 0.8)).length() < 1e-4);
    let slice = probe.slice(60.0);
    assert!(slice.discrete.is_empty());
    let [angle, value] = slice.values.iter().copied().find(|v| v[0] == 0.0).unwrap();
    let luminance = 0.2 * 0.212671 + 0.5 * 0.71516 + 0.8 * 0.072169;
    assert!(angle == 0.0 && (value - luminance / std::f32::consts::PI).abs() < 1e-4);

    let glass = preview(
        "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf>",
    );
    let probe = Probe::new(glass.scene.tables.view(), glass.material);
    assert!((probe.albedo(0.0) - Vec3::ONE).length() < 1e-3);
    let discrete = probe.slice(30.0).discrete;
    let share = |at: f32| {
        let near = |d: &&[f32; 2]| (d[0] - at).abs() < 0.1;
        discrete.iter().find(near).map_or(0.0, |d| d[1])
    };
    // Mirrored at 30 degrees, refracted at asin(sin(30) / 1.5) behind the surface.
    let below = 180.0 - (0.5_f32 / 1.5).asin().to_degrees();
    assert!((share(30.0) - 0.0415).abs() < 2e-3, "{discrete:?}");
    assert!((share(below) - 0.9585).abs() < 2e-3, "{discrete:?}");

    let rough = preview(
        "<bsdf type=\"roughconductor\"><string name=\"distribution\" value=\"beckmann\"/><float name=\"alpha\" value=\"0.3\"/></bsdf>",
    );
    let probe = Probe::new(rough.scene.tables.view(), rough.material);
    let roughness = probe.slice(30.0).roughness;
    assert!(roughness.len() > 600);
    for [angle, found] in roughness {
        assert!((found - 0.3).abs() < 5e-3, "{angle}: {found}");
    }
}

#[test]
fn sheet_shows_ball_and_curves() {
    let preview = preview("<bsdf type=\"thindielectric\"/>");
    let canvas = sheet::draw("thindielectric", &preview, 1).unwrap();
    let [width, height] = canvas.size();
    let pixel = |x: u32, y: u32| {
        let at = 3 * (y * width + x) as usize;
        [canvas.rgb()[at], canvas.rgb()[at + 1], canvas.rgb()[at + 2]]
    };
    let dark = |x: std::ops::Range<u32>, y: std::ops::Range<u32>| {
        x.flat_map(|x| y.clone().map(move |y| (x, y)))
            .filter(|&(x, y)| pixel(x, y) != [255; 3])
            .count()
    };
    // Title, picture (16 pixels here), diagrams.
    assert!(dark(0..300, 0..45) > 100);
    assert!(dark(20..36, 50..66) > 200);
    assert!(dark(460..width, 60..440) > 500);
    assert!(dark(0..width / 2, 480..height) > 500);
    assert!(dark(width / 2..width, 480..height) > 500);
}

#[test]
fn contact_sheet_holds_every_picture() {
    let examples: &[Example] = &EXAMPLES[..2];
    let mut names = Vec::new();
    let canvas = contact_sheet(examples, 1, |name| names.push(name.to_owned())).unwrap();
    assert_eq!(names, ["diffuse", "roughdiffuse"]);
    let [width, height] = canvas.size();
    assert!(width > 2 * PICTURE && width < 3 * PICTURE && height < 2 * PICTURE);
}

#[test]
fn pictures_are_cut_off_at_the_border() {
    let mut canvas = Canvas::new(3, 2);
    canvas.paste(&[7; 12], [2, 2], 2, 1);
    assert_eq!(canvas.rgb()[15..], [7; 3]);
    assert_eq!(canvas.rgb()[..15], [255; 15]);
    canvas.paste(&[7; 12], [2, 2], 9, 9);
}
