//! The material ball: the example scene of the same name with another BSDF on it, rendered by the path tracer.

use super::source::{Source, escaped};
use crate::accel::Accel;
use crate::film::Film;
use crate::film::aov::AovSet;
use crate::image::png_output::{Exposure, tone_map};
use crate::measured::synthetic::{brushed, nickel};
use crate::render::{Goal, Observer, RenderOptions, RunState, render};
use crate::scene::build::{BuildOptions, FilmOverride, Scene, build_scene};
use crate::scene::xml::parse_scene_from_str;
use std::error::Error;
use std::fs;
use std::sync::atomic::AtomicBool;

/// Any error of making a picture.
pub type AnyError = Box<dyn Error + Send + Sync>;

const SCENE: &str = include_str!("../../scenes/material-ball.xml");
const BALL: &str = include_str!("../../scenes/meshes/ball.obj");
const FOOT: &str = include_str!("../../scenes/meshes/foot.obj");

/// The start of the BSDF in the example scene.
const START: &str = "<bsdf type=\"roughconductor\" id=\"material\">";
const END: &str = "</bsdf>";
/// Where the ball refers to it.
const REFERENCE: &str = "<ref id=\"material\"/>";

/// The field of view of the example scene, and the narrower one of the pictures.
const FIELD: [&str; 2] = [
    "<float name=\"fov\" value=\"27\"/>",
    "<float name=\"fov\" value=\"21\"/>",
];

/// Name of the parameter that holds the folder with the files of the preview.
const FOLDER: &str = "halflight_folder";
/// The synthetic measurements, as BSDFs name them.
const NICKEL: &str = "$halflight_folder/nickel.binary";
const BRUSHED: &str = "$halflight_folder/brushed.bsdf";

/// Index of the ball among the shapes: the floor comes first.
const BALL_SHAPE: usize = 1;

/// The ball in a material.
pub struct Preview {
    /// The scene.
    pub scene: Scene,
    /// Index of the material.
    pub material: u32,
}

/// The scene text with `source` on the ball.
fn scene_text(source: &Source, directory: &str) -> String {
    // The scene's own names must not meet those of the definitions.
    let mut text = SCENE
        .replace(" id=\"floor\"", " id=\"halflight-floor\"")
        .replace(" id=\"foot\"", " id=\"halflight-foot\"")
        .replace(FIELD[0], FIELD[1])
        .replace("\"meshes/", &format!("\"{}/", escaped(directory)))
        .replace(
            "version=\"3.0.0\"",
            &format!("version=\"{}\"", escaped(&source.version)),
        );
    for (name, value) in [("spp", "64"), ("max_depth", "16")] {
        text = text.replace(&format!("<default name=\"{name}\" value=\"{value}\"/>"), "");
        text = text.replace(&format!("${name}"), value);
    }
    // Before the definitions come in, which may hold such a reference of their own; after them in the text.
    text = text.replacen(REFERENCE, &source.bsdf, 1);
    let Some(start) = text.find(START) else {
        return text;
    };
    let end = text[start..]
        .find(END)
        .map_or(start, |at| start + at + END.len());
    let folder = format!(
        "<default name=\"{FOLDER}\" value=\"{}\"/>\n{}",
        escaped(directory),
        source.definitions
    );
    text.replace_range(start..end, &folder);
    text
}

impl Preview {
    /// Builds the scene, `size` pixels on each side.
    ///
    /// # Errors
    /// What is wrong with the BSDF; or the meshes of the scene cannot be put into a temporary folder.
    pub fn new(source: &Source, size: u32) -> Result<Preview, AnyError> {
        let directory = tempfile::tempdir()?;
        fs::write(directory.path().join("ball.obj"), BALL)?;
        fs::write(directory.path().join("foot.obj"), FOOT)?;
        if source.bsdf.contains(NICKEL) {
            fs::write(directory.path().join("nickel.binary"), nickel())?;
        }
        if source.bsdf.contains(BRUSHED) {
            fs::write(directory.path().join("brushed.bsdf"), brushed()?)?;
        }
        let text = scene_text(source, &directory.path().to_string_lossy());
        let parsed = parse_scene_from_str(&text, &source.file, &[], false)?;
        let options = BuildOptions {
            film: FilmOverride {
                size: Some([size; 2]),
                ..FilmOverride::default()
            },
            ..BuildOptions::default()
        };
        let scene = build_scene(&parsed, &options)?;
        let material = scene.tables.shapes[BALL_SHAPE].material;
        Ok(Preview { scene, material })
    }

    /// Renders `spp` samples per pixel to 8-bit sRGB.
    ///
    /// # Errors
    /// If the film cannot be allocated.
    pub fn render(&self, spp: u32) -> Result<Vec<u8>, AnyError> {
        let [width, height] = self.scene.tables.camera.crop_size;
        let mut film = Film::new(width, height, [0; 2], AovSet::NONE)?;
        let accel = Accel::build(self.scene.tables.view(), &self.scene.tables.groups);
        let options = RenderOptions {
            goal: Goal::Samples(spp),
            seed: 0,
            first_sample: 0,
            adaptive: false,
        };
        render(
            &self.scene,
            &accel,
            &options,
            &mut film,
            &mut RunState::default(),
            &AtomicBool::new(false),
            &mut Silent,
        )?;
        Ok(tone_map(&film.mean(), Exposure::default()))
    }
}

struct Silent;

impl Observer for Silent {
    fn after_pass(&mut self, _: &RunState, _: &Film) -> Result<(), AnyError> {
        Ok(())
    }
}
