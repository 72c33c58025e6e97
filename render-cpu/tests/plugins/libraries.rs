//! Material libraries of OBJ files, as Mitsuba 0.6 reads them.

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::scene::lobe_kind;

const OBJ: &str = "mtllib my materials.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
    usemtl red\nf 1/1 2/2 3/3\nusemtl shiny\nf 1/1 3/2 4/3\nusemtl mirror\nf 2 3 4\n";

const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nillum 1\nnewmtl shiny\nKd 0.2 0.2 0.2\nKs 0.5 0.5 0.5\nNs 30\nillum 2\n\
    map_Kd -s 1 1 1 picture.exr\nd 0.5\nnewmtl mirror\nillum 5\n";

fn build(shape: &str, obj: &str, version: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a writable folder");
    };
    write("shape.obj", obj);
    write("my materials.mtl", MTL);
    exr::prelude::write_rgb_file(folder.path().join("picture.exr"), 2, 2, |_, _| {
        (0.3, 0.4, 0.5)
    })
    .expect("a picture");
    write(
        "scene.xml",
        &format!(
            r#"<scene version="{version}"><sensor type="perspective"/><emitter type="constant"/><shape type="obj">
            <string name="filename" value="shape.obj"/>{shape}</shape></scene>"#
        ),
    );
    let parsed =
        parse_scene(&folder.path().join("scene.xml"), &[], true).map_err(|e| e.to_string())?;
    build_scene(&parsed, &BuildOptions::default()).map_err(|e| e.to_string())
}

/// The kinds of lobes of each shape.
fn kinds(scene: &Scene) -> Vec<Vec<u32>> {
    let tables = &scene.tables;
    let of_shape = |material: u32| {
        let material = tables.materials[material as usize];
        let lobes = material.first_lobe..material.first_lobe + material.lobe_count;
        lobes.map(|i| tables.lobes[i as usize].kind).collect()
    };
    tables.shapes.iter().map(|s| of_shape(s.material)).collect()
}

#[test]
fn faces_without_a_bsdf_take_that_of_the_library() {
    let scene = build("", OBJ, "0.6.0").expect("a scene");
    assert_eq!(
        kinds(&scene),
        [
            vec![lobe_kind::DIFFUSE],
            vec![lobe_kind::PHONG, lobe_kind::DIFFUSE, lobe_kind::NULL],
            vec![lobe_kind::CONDUCTOR],
        ]
    );
    let red = &scene.tables.lobes[0].reflectance.value;
    assert_eq!(*red, [0.8, 0.1, 0.1]);
    assert_eq!(scene.tables.textures.len(), 1);
    // A BSDF of the scene comes first, and is for all faces where it names no material.
    let named = r#"<bsdf type="plastic" name="red"/>"#;
    let scene = build(named, OBJ, "0.6.0").expect("a scene");
    assert_eq!(kinds(&scene)[0], [lobe_kind::PLASTIC]);
    assert_eq!(kinds(&scene)[2], [lobe_kind::CONDUCTOR]);
    let scene = build(r#"<bsdf type="plastic"/>"#, OBJ, "0.6.0").expect("a scene");
    let all = kinds(&scene);
    assert!(all.iter().all(|k| *k == [lobe_kind::PLASTIC]), "{all:?}");
    // Mitsuba 3 reads no libraries; and 0.6 can be told not to.
    let scene = build("", OBJ, "3.0.0").expect("a scene");
    assert_eq!(kinds(&scene), [[lobe_kind::DIFFUSE]]);
    let without = r#"<boolean name="loadMaterials" value="false"/>"#;
    let scene = build(without, OBJ, "0.6.0").expect("a scene");
    assert_eq!(kinds(&scene).len(), 1);
}

#[test]
fn what_a_library_lacks_is_said() {
    let missing = OBJ.replace("my materials.mtl", "gone.mtl");
    let error = build("", &missing, "0.6.0").expect_err("a missing library");
    assert!(error.contains("gone.mtl (mtllib) is not there"), "{error}");
    let unknown = OBJ.replace("usemtl mirror", "usemtl other");
    let error = build("", &unknown, "0.6.0").expect_err("an unknown material");
    assert!(error.contains("\"other\" (usemtl)"), "{error}");
}
