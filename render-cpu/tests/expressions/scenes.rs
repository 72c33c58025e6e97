//! Scenes from text.

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;

/// A scene of the given XML, without the outermost element.
pub fn scene(content: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("<scene version=\"3.0.0\">{content}</scene>")).unwrap();
    let parsed = parse_scene(&path, &[], true).unwrap();
    build_scene(&parsed, &BuildOptions::default()).unwrap()
}

/// Four shapes of three materials, one of them a region; three emitters of three kinds.
pub const NAMED: &str = r#"
    <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>
    <bsdf type="twosided" id="wood"><bsdf type="diffuse"/></bsdf>
    <bsdf type="dielectric" id="glass"/>
    <bsdf type="roughconductor" id="gold"/>
    <shape type="rectangle" id="floor"><ref id="wood"/></shape>
    <shape type="sphere" id="ring"><ref id="gold"/></shape>
    <shape type="sphere" id="ball"><ref id="glass"/></shape>
    <shape type="cube" id="door"><transform name="to_world"><scale value="2"/><translate x="5"/></transform><ref id="wood"/></shape>
    <shape type="rectangle" id="lamp"><emitter type="area" id="key"><rgb name="radiance" value="1"/></emitter></shape>
    <emitter type="point" id="rim"><rgb name="intensity" value="1"/></emitter>
    <emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#;
