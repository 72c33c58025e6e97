//! Scene files: every element, both generations of names, files that include each other, and everything that can be
//! wrong with them.

mod elements;
mod errors;
mod files;
mod hostile;
mod references;

use std::path::Path;
use std::sync::Arc;

use glam::DMat4;
use halflight::scene::error::SceneError;
use halflight::scene::xml::{Object, ParsedScene, Value, parse_scene_from_str};

fn parse(text: &str) -> Result<ParsedScene, SceneError> {
    parse_scene_from_str(text, Path::new("scene.xml"), &[], true)
}

fn parse_leniently(text: &str) -> ParsedScene {
    parse_scene_from_str(text, Path::new("scene.xml"), &[], false).expect("parses")
}

fn with(text: &str, defines: &[(&str, &str)]) -> Result<ParsedScene, SceneError> {
    let defines: Vec<_> = defines
        .iter()
        .map(|(name, value)| (name.to_string(), value.to_string()))
        .collect();
    parse_scene_from_str(text, Path::new("scene.xml"), &defines, true)
}

/// The first object of a scene that holds the elements in one bsdf.
fn bsdf(elements: &str) -> Arc<Object> {
    first(&format!(
        "<scene version=\"3.0.0\"><bsdf type=\"t\">{elements}</bsdf></scene>"
    ))
}

fn first(text: &str) -> Arc<Object> {
    let scene = parse(text).unwrap_or_else(|error| panic!("{error}"));
    let child = scene.root.children().next().expect("an object");
    child.object.clone()
}

fn error_of(text: &str) -> String {
    parse(text).expect_err(text).to_string()
}

fn value(elements: &str) -> Value {
    bsdf(elements).get("p").expect("is there").value.clone()
}

fn transform(elements: &str) -> DMat4 {
    bsdf(&format!("<transform name=\"p\">{elements}</transform>"))
        .get_transform("p")
        .expect("a transform")
}

fn assert_same(a: DMat4, b: DMat4) {
    assert!(a.abs_diff_eq(b, 1e-12), "{a} is not {b}");
}
