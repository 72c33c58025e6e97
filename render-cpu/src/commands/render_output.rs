//! The output files of `halflight render`: their names, and their contents.

use super::render::RenderArgs;
use crate::film::Film;
use crate::image::exr_output::{LayeredImage, write_exr};
use crate::image::png_output::write_png;
use crate::render::record::image_metadata;
use crate::render::{RenderOptions, RunState};
use crate::scene::build::Scene;
use std::error::Error;
use std::path::{Path, PathBuf};

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
        if output
            .extension()
            .is_none_or(|e| !e.eq_ignore_ascii_case("exr"))
        {
            return Err(format!(
                "{}: the image is an OpenEXR file; its name ends in .exr",
                output.display()
            ));
        }
        let folder = match output.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(format!(
                "{}: there is no folder {}",
                output.display(),
                folder.display()
            ));
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
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
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
    pub(super) fn report(&self, output: &Path, state: &RunState) {
        eprintln!(
            "{}{}: {} samples per pixel in {:.1} s",
            output.display(),
            if self.no_png { "" } else { " and .png" },
            state.samples,
            state.seconds
        );
    }
}
