//! Plugins that public scenes use: a scene of each loads strictly and shows something, and their values are those of Mitsuba or
//! of the published formulas.

mod daylight;
mod every_plugin;
mod libraries;
mod lists;
mod measured;
mod principled;
mod sensors;
mod shapes;
mod textures;

use glam::{Vec2, Vec3};
use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::error::SceneError;
use halflight::scene::xml::{parse_scene, parse_scene_from_str};
use halflight_kernel::bsdf::{Bsdf, mode};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::{SurfacePoint, Tables};
use std::path::{Path, PathBuf};

/// A camera before the square [-1, 1]^2 in z = 0, and a sky of radiance one.
const SURROUNDINGS: &str = r#"<integrator type="direct"><integer name="emitter_samples" value="0"/></integrator>
    <sensor type="perspective"><float name="fov" value="28.072486935852958"/>
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film>
    </sensor><emitter type="constant"/>"#;

/// Builds content strictly, in front of a camera.
#[track_caller]
fn build(version: &str, content: &str) -> Scene {
    build_as_it_is(version, &format!("{SURROUNDINGS}{content}"))
}

/// Builds content strictly.
#[track_caller]
fn build_as_it_is(version: &str, content: &str) -> Scene {
    try_build(version, content, true).unwrap_or_else(|error| panic!("{error}"))
}

/// Builds content strictly that refers to files of a folder.
fn try_build_in(folder: &Path, version: &str, content: &str) -> Result<Scene, SceneError> {
    let text = format!("<scene version=\"{version}\">{content}</scene>");
    let parsed = parse_scene_from_str(&text, &folder.join("scene.xml"), &[], true)?;
    build_scene(&parsed, &BuildOptions::default())
}

/// The material of the first shape at a point of a plane.
fn bsdf(tables: &Tables<'_>, wi: Vec3) -> Bsdf {
    let point = SurfacePoint {
        frame: Frame::LOCAL,
        geometric_normal: Vec3::Z,
        uv: Vec2::splat(0.5),
        material: tables.shapes[0].material,
        ..SurfacePoint::ZERO
    };
    Bsdf::at(tables, &point, wi, mode::RADIANCE)
}

fn try_build(version: &str, content: &str, strict: bool) -> Result<Scene, SceneError> {
    let text = format!("<scene version=\"{version}\">{content}</scene>");
    let parsed = parse_scene_from_str(&text, Path::new("scene.xml"), &[], strict)?;
    build_scene(&parsed, &BuildOptions::default())
}

/// What is said about content that is built leniently.
#[track_caller]
fn warnings(version: &str, content: &str) -> Vec<String> {
    let scene = try_build(version, content, false).unwrap_or_else(|error| panic!("{error}"));
    scene.warnings.iter().map(ToString::to_string).collect()
}

/// Why content cannot be built.
#[track_caller]
fn error(version: &str, content: &str) -> String {
    match try_build(version, content, false) {
        Ok(_) => panic!("{content} is built"),
        Err(error) => error.to_string(),
    }
}

/// The pixels of the image.
fn pixels(scene: &Scene, spp: u32) -> Vec<[f64; 3]> {
    let options = RenderOptions {
        goal: Goal::Samples(spp),
        seed: 1,
        first_sample: 0,
        adaptive: false,
    };
    render_film(scene, &options, AovSet::NONE)
        .expect("a film")
        .mean()
}

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plugins/scenes");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder of scenes")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "xml"))
        .collect();
    scenes.sort();
    scenes
}

#[test]
fn a_scene_of_every_plugin_loads_strictly_and_shows_something() {
    let scenes = scenes();
    assert!(scenes.len() >= 8, "{scenes:?}");
    for path in scenes {
        let parsed = parse_scene(&path, &[], true)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let scene = build_scene(&parsed, &BuildOptions::default())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let pixels = pixels(&scene, 4);
        assert!(pixels.as_flattened().iter().all(|v| v.is_finite()));
        let sum: f64 = pixels.as_flattened().iter().sum();
        assert!(sum > 0.0, "{} is black", path.display());
    }
}
