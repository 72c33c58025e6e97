//! Material libraries of OBJ files, as Mitsuba 0.6 reads them.

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::scene::lobe_kind;

const OBJ: &str = "mtllib my materials.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
    usemtl red\nf 1/1 2/2 3/3\nusemtl shiny\nf 1/1 3/2 4/3\nusemtl mirror\nf 2 3 4\n";

const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nillum 1\nnewmtl shiny\nKd 0.2 0.2 0.2\nKs 0.5 0.5 0.5\nNs 30\nillum 2\n\
    map_Kd -s 1 1 1 picture.exr\nd 0.5\nnewmtl mirror\nillum 5\n";

fn build(shape: &str, obj: &str, version: &str) -> Result<Scene, String> {
    build_with(shape, obj, version, MTL, true)
}

/// The shape with a library.
fn build_with(
    shape: &str,
    obj: &str,
    version: &str,
    mtl: &str,
    strict: bool,
) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a writable folder");
    };
    write("shape.obj", obj);
    write("my materials.mtl", mtl);
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
        parse_scene(&folder.path().join("scene.xml"), &[], strict).map_err(|e| e.to_string())?;
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

/// What is said about the shape with a library of red, shiny and mirror, each with lines of its own.
#[track_caller]
fn said_of(mtl: &str) -> (Scene, Vec<String>) {
    let scene = build_with("", OBJ, "0.6.0", mtl, false).expect("a scene");
    let said = scene.warnings.iter().map(ToString::to_string).collect();
    (scene, said)
}

#[test]
fn a_library_without_a_material_of_the_faces_is_said() {
    let (scene, said) = said_of("newmtl other\nKd 1 0 0\n");
    assert_eq!(said.len(), 3, "{said:?}");
    for (message, name) in said.iter().zip(["red", "shiny", "mirror"]) {
        assert!(
            message.contains(&format!("\"{name}\" (usemtl)")),
            "{said:?}"
        );
    }
    assert!(kinds(&scene).iter().all(|k| *k == [lobe_kind::DIFFUSE]));
}

#[test]
fn what_a_library_has_beyond_mitsuba_is_said_with_its_line() {
    let (_, said) = said_of(&MTL.replace("illum 1\n", "illum 1\nKe 1 1 1\n"));
    assert_eq!(said.len(), 1, "{said:?}");
    let words = "my materials.mtl:4: the material \"red\": its light (Ke)";
    assert!(said[0].contains(words), "{said:?}");
    // Of materials that no face has, nothing is.
    let (_, said) = said_of(&format!("{MTL}newmtl spare\nKe 1 1 1\nblub\n"));
    assert!(said.is_empty(), "{said:?}");
}

#[test]
fn a_missing_map_leaves_the_colour() {
    let missing = MTL.replace("picture.exr", "gone/picture2.exr");
    let (scene, said) = said_of(&missing);
    assert_eq!(said.len(), 1, "{said:?}");
    let words = "my materials.mtl:9: the material \"shiny\": there is no map \"gone/picture2.exr\"";
    assert!(said[0].contains(words), "{said:?}");
    assert_eq!(scene.tables.textures.len(), 0);
    build_with("", OBJ, "0.6.0", &missing, true).expect_err("strictly an error");
    // Paths of another machine.
    for path in ["C:\\Users\\me\\picture.exr", "/home/me/picture.exr"] {
        let (scene, said) = said_of(&MTL.replace("picture.exr", path));
        assert!(said.is_empty(), "{said:?}");
        assert_eq!(scene.tables.textures.len(), 1);
    }
    // One that cannot be read is named at its material.
    let error = build_with(
        "",
        OBJ,
        "0.6.0",
        &MTL.replace("picture.exr", "shape.obj"),
        false,
    );
    let error = error.expect_err("no image");
    assert!(error.contains("my materials.mtl:4"), "{error}");
}

#[test]
fn maps_are_scaled_and_moved() {
    let options = MTL.replace("-s 1 1 1 picture", "-s 2 4 1 -o 0.5 0.25 -clamp on picture");
    let (scene, said) = said_of(&options);
    assert!(said.is_empty(), "{said:?}");
    // v is turned over with the image: 1 - (4 (1 - v) + 0.25).
    assert_eq!(
        scene.tables.textures[0].to_uv,
        [2.0, 0.0, 0.5, 0.0, 4.0, -3.25]
    );
}
