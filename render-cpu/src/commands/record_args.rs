//! Arguments of the record of paths.

use super::scene_args::{check_window, parse_numbers};
use crate::accel::Accel;
use crate::expression::{PartsRequest, PathParts};
use crate::inspect::record::{Choice, record};
use crate::render::RenderOptions;
use crate::say::note;
use crate::scene::build::Scene;
use clap::Args;
use halflight_kernel::scene::SceneView;
use std::error::Error;
use std::path::PathBuf;

/// What is recorded beside an image.
#[derive(Args, Clone, Debug, Default)]
pub struct RecordArgs {
    /// Write some of the image's paths with their vertices, chosen by the light that they add: PATHS.jsonl as lines of JSON, any
    /// other name as bytes. They are found by path tracing, with the seed and the number of samples of the image.
    #[arg(help_heading = "Paths", long, value_name = "PATHS")]
    pub record: Option<PathBuf>,
    /// Record nothing but the paths that an expression matches; with --only those that match both.
    #[arg(
        help_heading = "Paths",
        long,
        value_name = "EXPRESSION",
        requires = "record"
    )]
    pub record_where: Option<String>,
    /// Record the paths of some pixels of the whole image alone.
    #[arg(help_heading = "Paths", long, value_name = "X,Y,W,H", value_parser = parse_window, requires = "record")]
    pub record_pixels: Option<[u32; 4]>,
    /// Number of paths that are recorded.
    #[arg(help_heading = "Paths", long, value_name = "N", default_value_t = 10_000, requires = "record",
        value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub record_count: u32,
}

impl RecordArgs {
    /// Compiles what is asked for, so that mistakes show before the image is rendered.
    ///
    /// # Errors
    /// A mistake in the expression.
    pub(super) fn parts(&self, scene: &Scene) -> Result<PathParts, Box<dyn Error + Send + Sync>> {
        if self.record.is_none() {
            return Ok(PathParts::default());
        }
        if !scene.edits.is_empty() {
            return Err("--record writes paths as they are, without edits".into());
        }
        if let Some(window) = self.record_pixels {
            check_window(window, scene)?;
        }
        let only = scene.parts.request().only.clone();
        let request = match (only, self.record_where.clone()) {
            (Some(only), Some(text)) => PartsRequest {
                layers: vec![("recorded".to_owned(), text)],
                only: Some(only),
            },
            (only, text) => PartsRequest {
                layers: Vec::new(),
                only: only.or(text),
            },
        };
        Ok(PathParts::new(
            &request,
            &scene.tables.view(),
            &scene.names,
        )?)
    }

    /// Writes the record of an image of `samples` samples per pixel, if one is wanted.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write(
        &self,
        parts: &PathParts,
        scene: &Scene,
        accel: &Accel,
        options: &RenderOptions,
        samples: u32,
        quiet: bool,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        let Some(path) = &self.record else {
            return Ok(());
        };
        let tables = scene.tables.view();
        let traverse = accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        let choice = Choice {
            most: self.record_count as usize,
            samples,
            seed: options.seed,
            first_sample: options.first_sample,
            pixels: self.record_pixels,
        };
        let found = record(&view, scene, parts, &choice);
        found.save(path)?;
        if !quiet {
            note(format_args!(
                "{}: {} of {} paths",
                path.display(),
                found.header.count,
                found.header.found
            ));
        }
        Ok(())
    }
}

fn parse_window(text: &str) -> Result<[u32; 4], String> {
    parse_numbers(text, &[','], "X,Y,WIDTH,HEIGHT")
}
