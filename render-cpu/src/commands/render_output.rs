//! The output files of `halflight render`: their names, and their contents.

use super::output_file;
use super::preview::{LivePng, Previews};
use super::preview_tev::TevPreview;
use super::render_args::RenderArgs;
use crate::atomic_file::WriteError;
use crate::film::Film;
use crate::film::aov::Aov;
use crate::film::chain_counts::describe;
use crate::image::camera_attributes::CameraAttributes;
use crate::image::exr_output::{LayeredImage, write_exr};
use crate::image::picture::Picture;
use crate::image::picture_output::{EXTENSIONS, ImageFormat, write_picture};
use crate::image::png_output::{Look, write_png};
use crate::image::window::Window;
use crate::render::record::{CLAMP, image_metadata};
use crate::render::{MutationsPerPixel, RenderOptions, RunState};
use crate::say::note;
use crate::scene::build::Scene;
use crate::scene::xml::refuse_image;
use serde_json::{Value, json};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Pixels of images that take some time to write.
const LARGE: usize = 1 << 22;

impl RenderArgs {
    /// The name of the image file; determined before rendering, so that a bad name is reported at once.
    pub(super) fn output_path(&self) -> Result<PathBuf, String> {
        // Before a name is made of it that may be its own.
        refuse_image(&self.scene.scene).map_err(|error| error.to_string())?;
        let output = match &self.output {
            Some(path) => path.clone(),
            None if self.scene.scene.as_os_str() == "-" => PathBuf::from("image.exr"),
            None => {
                let stem = self
                    .scene
                    .scene
                    .file_stem()
                    .ok_or_else(|| format!("{} names no file", self.scene.scene.display()))?;
                PathBuf::from(stem).with_extension("exr")
            }
        };
        let inputs = [Some(&self.scene.scene), self.resume.as_ref()];
        let inputs = || inputs.into_iter().flatten().map(PathBuf::as_path);
        output_file::check(&output, &EXTENSIONS, inputs())?;
        let png = output.with_extension("png");
        let mut outputs = vec![(output.as_path(), "the image")];
        if self.writes_png(&output) {
            output_file::check(&png, &[], inputs())?;
            outputs.push((&png, "the PNG beside the image"));
        }
        if let Some(checkpoint) = &self.checkpoint {
            output_file::check(checkpoint, &[], [self.scene.scene.as_path()])?;
            outputs.push((checkpoint, "the checkpoint"));
        }
        if let Some(record) = &self.record.record {
            output_file::check(record, &[], inputs())?;
            outputs.push((record, "the record of paths"));
        }
        output_file::check_distinct(&outputs)?;
        self.check_format(&output)?;
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
        // Both are compressed by one thread each.
        let (image, png) = rayon::join(
            || self.write_image(output, scene, film, options, state),
            || self.write_png_beside(output, film),
        );
        image?;
        png?;
        Ok(())
    }

    /// Writes the image elsewhere after `error` has kept it from where it belongs, so that it is not lost: where temporary files
    /// go. Returns the error, which says where it is now.
    pub(super) fn write_elsewhere(
        &self,
        error: Box<dyn Error + Send + Sync>,
        output: &Path,
        scene: &Scene,
        film: &Film,
        options: &RenderOptions,
        state: &RunState,
    ) -> Box<dyn Error + Send + Sync> {
        let folder = tempfile::Builder::new().prefix("halflight-").tempdir();
        let (Ok(folder), Some(name)) = (folder, output.file_name()) else {
            return error;
        };
        let elsewhere = folder.path().join(name);
        match self.write_image(&elsewhere, scene, film, options, state) {
            Ok(()) => {
                // The folder stays.
                let _ = folder.keep();
                format!("{error}; the image is {} instead", elsewhere.display()).into()
            }
            Err(_) => error,
        }
    }

    /// Writes the image in the format of its name.
    fn write_image(
        &self,
        output: &Path,
        scene: &Scene,
        film: &Film,
        options: &RenderOptions,
        state: &RunState,
    ) -> Result<(), WriteError> {
        let format = ImageFormat::of_file(output).unwrap_or(ImageFormat::Exr);
        let camera = &scene.tables.camera;
        if format == ImageFormat::Exr {
            let mut metadata = image_metadata(&self.scene.scene, scene, film, options, state);
            metadata.owner.clone_from(&self.look.owner);
            metadata.camera = CameraAttributes::of(camera);
            if let Some(clamp) = self.look.clamp {
                let value = clamp.to_string();
                metadata.settings.insert(CLAMP.to_owned(), value);
            }
            if !self.asked_layers(scene).contains(Aov::Samples) {
                metadata.samples_per_pixel = film.even_samples();
            }
            let image = LayeredImage::from_film(film, camera.film_size, metadata);
            write_exr(output, &image, self.look.half)?;
        } else {
            let picture = Picture {
                window: Window {
                    origin: film.crop_offset().map(|v| v as i32),
                    width: film.width(),
                    height: film.height(),
                },
                full_size: camera.film_size,
                pixels: film.mean().iter().map(|p| p.map(|v| v as f32)).collect(),
            };
            let look = Look {
                exposure: self.look.exposure,
                ..Look::default()
            };
            write_picture(output, format, &picture, look)?;
        }
        tracing::info!("wrote {}", output.display());
        Ok(())
    }

    /// Writes the PNG beside the image, if there shall be one.
    fn write_png_beside(&self, output: &Path, film: &Film) -> Result<(), WriteError> {
        if self.writes_png(output) {
            let png = output.with_extension("png");
            write_png(
                &png,
                film.width(),
                film.height(),
                &film.mean(),
                self.look.exposure,
            )?;
            tracing::info!("wrote {}", png.display());
        }
        Ok(())
    }

    /// What shows the image while it is rendered.
    ///
    /// # Errors
    /// If tev cannot be reached.
    pub(super) fn previews(&self, output: &Path, film: &Film) -> Result<Previews, String> {
        let name = || output.display().to_string();
        let connect = |address: &String| TevPreview::connect(address, name(), film);
        let png = output.with_extension("png");
        Ok(Previews {
            tev: self.tev.as_ref().map(connect).transpose()?,
            png: self.live.then(|| LivePng::new(png, self.look.exposure)),
        })
    }

    /// Whether a PNG goes beside an image: where that is none to look at.
    pub(super) fn writes_png(&self, output: &Path) -> bool {
        !self.look.no_png && ImageFormat::of_file(output).is_none_or(ImageFormat::is_linear)
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
            if self.writes_png(output) {
                " and .png"
            } else {
                ""
            },
            if unit.0 > 1 { "mutations" } else { "samples" },
            state.seconds
        ));
        for (name, counts) in film.chain_counts().iter() {
            tracing::info!("{}", describe(name, counts));
        }
        if let Some(rays) = film.chain_counts().rays_per_mutation() {
            tracing::info!("{rays:.2} rays per mutation");
        }
    }

    /// What a run took, as JSON.
    pub(super) fn statistics(
        &self,
        output: &Path,
        scene: &Scene,
        film: &Film,
        state: &RunState,
        is_finished: bool,
    ) -> Value {
        let png = self
            .writes_png(output)
            .then(|| output.with_extension("png"));
        json!({
            "scene": self.scene.scene.display().to_string(),
            "image": output.display().to_string(),
            "png": png.map(|path| path.display().to_string()),
            "width": film.width(),
            "height": film.height(),
            "integrator": scene.integrator,
            "threads": rayon::current_num_threads(),
            "finished": is_finished,
            "samples_per_pixel": film.mean_samples(),
            "samples": film.total_samples(),
            "rejected_samples": film.total_rejected(),
            "seconds": state.seconds,
            "passes": state.passes,
            "relative_noise": film.relative_noise(),
            "mutations": film.chain_counts().json(),
            "rays_per_mutation": film.chain_counts().rays_per_mutation(),
            "warnings": scene.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
    }
}
