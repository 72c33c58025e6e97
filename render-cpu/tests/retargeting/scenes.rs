//! A room in which every flow can be turned, and edits of it.

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::error::SceneError;
use halflight::scene::xml::parse_scene;

/// A floor, a red and a glossy wall, a ball, a mirror out of sight that throws the lamp's light onto the floor, and the lamp.
/// `$floor` is the floor's material.
pub const ROOM: &str = r#"
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective"><float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 1.6, 4" target="0, 0.7, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle" id="floor"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>FLOOR</shape>
    <shape type="rectangle" id="red"><transform name="to_world"><scale value="1.5"/><rotate y="1" angle="90"/><translate x="-2" y="1.5"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.15, 0.1"/></bsdf></bsdf></shape>
    <shape type="rectangle" id="back"><transform name="to_world"><scale x="3" y="1.5"/><translate y="1.5" z="-2"/></transform>
        <bsdf type="roughconductor"><float name="alpha" value="0.35"/></bsdf></shape>
    <shape type="sphere" id="ball"><point name="center" value="0.8, 0.5, -0.3"/><float name="radius" value="0.5"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.3, 0.5, 0.6"/></bsdf></shape>
    <shape type="rectangle" id="mirror"><transform name="to_world"><scale value="0.9"/><lookat origin="2.3, 1.3, 1.4" target="0, 0.9, 0.4" up="0, 1, 0"/></transform>
        <bsdf type="twosided"><bsdf type="conductor"/></bsdf></shape>
    <shape type="rectangle" id="lamp"><transform name="to_world"><scale value="0.5"/><lookat origin="0, 2.8, 0.6" target="0.8, 0.5, 0.8" up="0, 0, 1"/></transform>
        <emitter type="area"><rgb name="radiance" value="9, 8, 7"/></emitter></shape>"#;

/// Diffuse.
pub const PLAIN: &str = r#"<bsdf type="diffuse"/>"#;

/// Diffuse and glossy at once.
pub const PLASTIC: &str = r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.4, 0.35, 0.3"/><float name="alpha" value="0.3"/></bsdf>"#;

/// The room with a floor and edits, read strictly: what is odd is an error.
pub fn try_room(floor: &str, edits: &str) -> Result<Scene, SceneError> {
    read_room(floor, edits, true)
}

/// The same, read strictly or not.
pub fn read_room(floor: &str, edits: &str, is_strict: bool) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    let content = ROOM.replace("FLOOR", floor);
    let text = format!("<scene version=\"3.0.0\">{content}\n{edits}</scene>");
    std::fs::write(&path, text).unwrap();
    let parsed = parse_scene(&path, &[], is_strict)?;
    build_scene(&parsed, &BuildOptions::default())
}

/// The same, known to be sound.
pub fn room(floor: &str, edits: &str) -> Scene {
    try_room(floor, edits).unwrap()
}
