//! Tools that look at the light of a scene, against light that is known.

mod clusters;
mod paths;
mod probes;
mod records;
#[path = "../common/view.rs"]
mod view;
mod volume;

use halflight::expression::{PartsRequest, PathParts};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use view::with_view;

fn scene(content: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("<scene version=\"3.0.0\">{content}</scene>")).unwrap();
    let parsed = parse_scene(&path, &[], true).unwrap();
    build_scene(&parsed, &BuildOptions::default()).unwrap()
}

/// The paths of an expression, or all.
fn parts(scene: &Scene, only: Option<&str>) -> PathParts {
    let request = PartsRequest {
        layers: Vec::new(),
        only: only.map(str::to_owned),
    };
    PathParts::new(&request, &scene.tables.view(), &scene.names).unwrap()
}

/// Looks down on a large floor at z = 0 from above; 6 by 4 pixels.
const ABOVE: &str = r#"<integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="6"/><integer name="height" value="4"/><rfilter type="box"/></film></sensor>
    <shape type="rectangle" id="floor"><transform name="to_world"><scale value="9"/></transform>
        <bsdf type="roughconductor" id="metal"><float name="alpha" value="0.1"/></bsdf></shape>"#;

const SKY: &str =
    r#"<emitter type="constant" id="sky"><rgb name="radiance" value="0.5, 0.5, 0.5"/></emitter>"#;
