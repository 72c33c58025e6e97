//! Scenes from text, and what their tests need.

#[path = "../common/view.rs"]
mod view;

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use std::path::Path;
pub use view::{View, with_view};

/// A file's name and what writes it.
pub type NamedFile<'a> = (&'a str, &'a dyn Fn(&Path));

/// A scene of the given XML, without the outermost element, beside the files that the functions write.
pub fn scene(content: &str, files: &[NamedFile<'_>]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    for (name, write) in files {
        write(&folder.path().join(name));
    }
    std::fs::write(&path, format!("<scene version=\"3.0.0\">{content}</scene>")).unwrap();
    let parsed = parse_scene(&path, &[], true).unwrap();
    build_scene(&parsed, &BuildOptions::default()).unwrap()
}

/// A pinhole of 8 by 6 pixels that looks into the room of [`room`].
pub const PINHOLE: &str = r#"<sensor type="perspective"><float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="0.1, 1, 3.5" target="0, 0.9, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="6"/>
    <rfilter type="box"/></film></sensor>"#;

/// A room with a floor and two walls of the given material, open to the front.
pub fn room(material: &str) -> String {
    format!(
        r#"<bsdf type="twosided" id="wall">{material}</bsdf>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate x="1" angle="-90"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><translate z="-1.5"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate y="1" angle="90"/>
            <translate x="-1.5"/></transform><ref id="wall"/></shape>"#
    )
}

/// A small square lamp that shines down.
pub const LAMP: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.4"/>
    <rotate x="1" angle="90"/><translate y="1.8"/></transform>
    <emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>"#;

/// Writes a sky of smooth colours and a bright cloud.
pub fn sky(path: &Path) {
    exr::prelude::write_rgb_file(path, 8, 4, |x, y| {
        let cloud = if x == 5 && y == 1 { 6.0 } else { 0.0 };
        let (x, y) = (x as f32, y as f32);
        (
            0.3 + 0.1 * x + cloud,
            0.5 + 0.05 * (x - 4.0).abs() + cloud,
            1.0 - 0.2 * y + cloud,
        )
    })
    .unwrap();
}

/// Writes a picture of smooth ripples, as normals or as heights or as opacity.
pub fn ripples(path: &Path) {
    exr::prelude::write_rgb_file(path, 16, 16, |x, y| {
        let x = (x as f32 * 0.9).sin();
        let y = (y as f32 * 1.3).cos();
        (0.5 + 0.2 * x, 0.5 + 0.25 * y, 0.9)
    })
    .unwrap();
}

/// Writes an octahedron whose normals are those of the sphere around it.
pub fn faceted_sphere(path: &Path) {
    let corners = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1"];
    let mut text = String::new();
    for corner in corners {
        text += &format!("v {corner}\nvn {corner}\n");
    }
    for (x, y, z) in [(1, 3, 5), (2, 4, 5), (1, 4, 6), (2, 3, 6)] {
        text += &format!("f {x}//{x} {y}//{y} {z}//{z}\n");
    }
    for (x, y, z) in [(2, 3, 5), (1, 4, 5), (1, 3, 6), (2, 4, 6)] {
        text += &format!("f {y}//{y} {x}//{x} {z}//{z}\n");
    }
    std::fs::write(path, text).unwrap();
}
