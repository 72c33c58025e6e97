//! The inspector's page: as new as its sources, and in a browser.
//!
//! Tests in a browser are skipped where there is no Chromium, with the reason, unless `HALFLIGHT_REQUIRE_CHROMIUM` is set.

mod browser;
mod command;
#[path = "../expressions/matcher.rs"]
#[allow(dead_code)]
mod matcher;
mod measure;
mod numbers;
#[path = "../expressions/scenes.rs"]
mod scenes;
#[path = "../common/skip.rs"]
mod skip;
mod stamp;
mod use_of_page;

use browser::Browser;
use std::path::Path;
use std::process::Command;

/// A browser, or none where the test is skipped.
fn browser() -> Option<Browser> {
    skip::available(Browser::start([1280, 800]), "HALFLIGHT_REQUIRE_CHROMIUM")
}

/// Writes the page of a scene, given without its outermost element, with `arguments` beside, as `folder/page.html`.
fn write_page(folder: &Path, scene: &str, arguments: &[&str]) {
    let text = format!("<scene version=\"3.0.0\">{scene}</scene>");
    std::fs::write(folder.join("scene.xml"), text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
    command.args(["inspect", "scene.xml", "-o", "page.html"]);
    let output = command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Looks down on a floor with a glass ball under a lamp and a grey sky; 96 by 64 pixels.
const BALL: &str = r#"<integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, -4, 4" target="0, 0, 0.3" up="0, 0, 1"/></transform>
    <film type="hdrfilm"><integer name="width" value="96"/><integer name="height" value="64"/><rfilter type="box"/></film></sensor>
    <shape type="rectangle" id="floor"><transform name="to_world"><scale value="4"/></transform>
        <bsdf type="diffuse" id="paint"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf></shape>
    <shape type="sphere" id="ball"><point name="center" value="0.2, 0, 0.7"/><float name="radius" value="0.6"/>
        <bsdf type="dielectric" id="glass"/></shape>
    <shape type="rectangle" id="panel"><transform name="to_world"><scale value="0.7"/><rotate x="1" angle="180"/><translate x="-0.6" z="3"/></transform>
        <emitter type="area" id="lamp"><rgb name="radiance" value="9, 8, 7"/></emitter></shape>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.3, 0.32, 0.36"/></emitter>"#;
