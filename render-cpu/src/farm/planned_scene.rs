//! The scene of a farm: its file, and what the command line changes about it, in a form that every task reads again.
//!
//! What options change of the algorithm's parameters is kept as the words of its settings, so that no option is forgotten.

use super::error::FarmError;
use crate::expression::PartsRequest;
use crate::image::png_output::Exposure;
use crate::scene::build::{BuildOptions, Crop, FilmOverride, Scene, build_scene};
use crate::scene::xml::parse_scene;
use halflight_kernel::transport::IntegratorSettings;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A scene file and what is changed about it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedScene {
    /// The file.
    pub file: PathBuf,
    /// Values of `$name`.
    pub defines: Vec<(String, String)>,
    /// Size of the image.
    pub size: Option<[u32; 2]>,
    /// Width of the image.
    pub width: Option<u32>,
    /// Part of the image: left, top, width, height.
    pub crop: Option<[u32; 4]>,
    /// Algorithm instead of the scene's.
    pub integrator: Option<String>,
    /// Random numbers instead of the scene's.
    pub sampler: Option<String>,
    /// Which of several sensors.
    pub sensor: usize,
    /// Whether warnings are errors.
    pub strict: bool,
    /// The words of the algorithm's settings, where options change them.
    #[serde(default)]
    pub settings: Option<Vec<u32>>,
    /// Layers by path expressions.
    #[serde(default)]
    pub parts: PartsRequest,
    /// A file with edits of light transport.
    #[serde(default)]
    pub edit: Option<PathBuf>,
    /// The moment of their keyframes.
    #[serde(default)]
    pub edit_time: Option<f64>,
    /// How the image is made of the samples.
    #[serde(default)]
    pub look: PlannedLook,
}

/// What is done to samples and films before they become the image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedLook {
    /// What the largest component of every sample is brought down to.
    pub clamp: Option<f32>,
    /// Whether colours are 16-bit floats.
    pub half: bool,
    /// Whether there is no PNG.
    pub no_png: bool,
    /// Exposure of the PNG.
    pub exposure: Exposure,
    /// Name of the image's owner.
    pub owner: String,
}

impl PlannedScene {
    /// Reads the scene and builds its tables.
    ///
    /// # Errors
    /// What is wrong with the scene.
    pub fn load(&self) -> Result<Scene, FarmError> {
        let parsed = parse_scene(&self.file, &self.defines, self.strict)?;
        let options = BuildOptions {
            film: FilmOverride {
                size: self.size,
                width: self.width,
                crop: self.crop.map(|[x, y, width, height]| Crop {
                    offset: [x, y],
                    size: [width, height],
                }),
            },
            integrator: self.integrator.clone(),
            sampler: self.sampler.clone(),
            sensor: self.sensor,
            edit: self.edit.clone(),
            edit_time: self.edit_time,
        };
        let mut scene = build_scene(&parsed, &options)?;
        if let Some(words) = &self.settings {
            scene.settings = settings_of_words(words)?;
        }
        let divided = scene.divide(&self.parts);
        divided.map_err(|e| FarmError::Request(e.to_string()))?;
        Ok(scene)
    }
}

/// Settings as words, for a plan.
pub fn settings_words(settings: &IntegratorSettings) -> Vec<u32> {
    bytemuck::cast_slice(std::slice::from_ref(settings)).to_vec()
}

/// The inverse of [`settings_words`].
fn settings_of_words(words: &[u32]) -> Result<IntegratorSettings, FarmError> {
    bytemuck::try_cast_slice(words)
        .ok()
        .and_then(|settings: &[IntegratorSettings]| match settings {
            [settings] => Some(*settings),
            _ => None,
        })
        .ok_or_else(|| {
            FarmError::Request("the plan was made by another version of halflight".to_owned())
        })
}
