//! The output files of `halflight render`: their names, and their contents.

use super::output_file;
use super::render_args::RenderArgs;
use crate::film::Film;
use crate::image::exr_output::{LayeredImage, write_exr};
use crate::image::png_output::write_png;
use crate::render::record::image_metadata;
use crate::render::{MutationsPerPixel, RenderOptions, RunState};
use crate::say::note;
use crate::scene::build::Scene;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Pixels of images that take some time to write.
const LARGE: usize = 1 << 22;

impl RenderArgs {
    /// The name of the image file; determined before rendering, so that a bad name is reported at once.
    pub(super) fn output_path(&self) -> Result<PathBuf, String> {
        let output = match &self.output {
            Some(path) => path.clone(),
            None => {
                let stem = self
                    .scene
                    .scene
                    .file_stem()
                    .ok_or_else(|| format!("{} names no file", self.scene.scene.display()))?;
                PathBuf::from(stem).with_extension("exr")
            }
        };
        let inputs = [
            Some(&self.scene.scene),
            self.resume.as_ref(),
            self.checkpoint.as_ref(),
        ];
        let inputs = || inputs.into_iter().flatten().map(PathBuf::as_path);
        output_file::check(&output, &["exr"], inputs())?;
        if !self.no_png {
            output_file::check(&output.with_extension("png"), &[], inputs())?;
        }
        if let Some(checkpoint) = &self.checkpoint {
            output_file::check(checkpoint, &[], [self.scene.scene.as_path()])?;
        }
        Ok(output)
    }

    /// Writes the EXR and the PNG.
    pub(super) fn write(
        &self,
        output: &Path,
        scene: &Scene,
        film: &Film,
        options: &RenderOptions,
        state: &RunState,
        quiet: bool,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        let pixels = film.statistics().len();
        if !quiet && pixels >= LARGE {
            note(format_args!(
                "writing {}, {} x {}",
                output.display(),
                film.width(),
                film.height()
            ));
        }
        let metadata = image_metadata(&self.scene.scene, scene, film, options, state);
        let image = LayeredImage::from_film(film, scene.tables.camera.film_size, metadata);
        write_exr(output, &image, self.half)?;
        tracing::info!("wrote {}", output.display());
        if !self.no_png {
            let png = output.with_extension("png");
            write_png(
                &png,
                film.width(),
                film.height(),
                &film.mean(),
                self.exposure,
            )?;
            tracing::info!("wrote {}", png.display());
        }
        Ok(())
    }

    /// The last line of a run: where the image is and what it took.
    pub(super) fn report(
        &self,
        output: &Path,
        film: &Film,
        state: &RunState,
        unit: MutationsPerPixel,
    ) {
        let samples = film.mean_samples() * f64::from(unit.0);
        let digits = if samples.fract() == 0.0 { 0 } else { 2 };
        note(format_args!(
            "{}{}: {samples:.digits$} {} per pixel in {:.1} s",
            output.display(),
            if self.no_png { "" } else { " and .png" },
            if unit.0 > 1 { "mutations" } else { "samples" },
            state.seconds
        ));
    }
}
