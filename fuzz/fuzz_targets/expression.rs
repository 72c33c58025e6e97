//! Path expressions. Run with `cargo fuzz run expression`, see `Cargo.toml`.
#![no_main]

use halflight::expression::compile;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use std::path::Path;
use std::sync::OnceLock;

/// A few names, and a region.
const SCENE: &str = r#"<scene version="3.0.0"><sensor type="perspective"/>
<shape type="sphere" id="a"><bsdf type="diffuse" id="b"/></shape>
<shape type="sphere" id="c"><emitter type="area" id="d"><rgb name="radiance" value="1"/></emitter></shape></scene>"#;

fn scene() -> &'static Scene {
    static BUILT: OnceLock<Scene> = OnceLock::new();
    BUILT.get_or_init(|| {
        let path = Path::new("no such folder/fuzz.xml");
        let parsed = parse_scene_from_str(SCENE, path, &[], false).expect("a scene");
        build_scene(&parsed, &BuildOptions::default()).expect("a scene")
    })
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let texts: Vec<&str> = text.split('\n').collect();
    let scene = scene();
    if let Err(error) = compile(&texts, false, &scene.tables.view(), &scene.names) {
        assert!(error.position <= error.text.chars().count());
    }
});
