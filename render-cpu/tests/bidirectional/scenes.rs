//! Scenes from text, and what their tests need.

use halflight::accel::{Accel, CpuTraverse};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::scene::SceneView;

/// The view that tests see.
pub type View<'a> = SceneView<'a, CpuTraverse<'a>>;

/// A scene of the given XML, without the outermost element.
pub fn scene(content: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("<scene version=\"3.0.0\">{content}</scene>")).unwrap();
    let parsed = parse_scene(&path, &[], true).unwrap();
    build_scene(&parsed, &BuildOptions::default()).unwrap()
}

/// Calls `test` with the scene's tables and its ray tracer.
pub fn with_view(scene: &Scene, test: impl FnOnce(&View<'_>)) {
    let tables = scene.tables.view();
    let accel = Accel::build(tables, &scene.tables.groups);
    let traverse = accel.traverse(tables);
    test(&SceneView {
        tables,
        traverse: &traverse,
    });
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
