//! `halflight merge`: combines images of the same scene that hold different samples.

use super::output_file;
use crate::atomic_file::WriteError;
use crate::image::exr_output::{ChannelValues, LayeredImage, write_exr};
use crate::image::merge::Merger;
use crate::image::merge_error::MergeError;
use crate::image::png_output::{Exposure, write_png};
use crate::image::{ImageError, read_exr};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Merge images of one scene, rendered with different seeds or sample ranges, or crops of one image.
#[derive(Args, Clone, Debug)]
pub struct MergeArgs {
    /// The images: OpenEXR files with a samples layer.
    #[arg(required = true, value_name = "IMAGE.exr")]
    pub images: Vec<PathBuf>,
    /// The merged image.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Write a tone-mapped PNG beside it.
    #[arg(long)]
    pub png: bool,
    /// Merge images that share samples, or are of other scenes or settings, all the same.
    #[arg(long)]
    pub force: bool,
}

/// Why images were not merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeCommandError {
    /// An image could not be read.
    #[error(transparent)]
    Read(#[from] ImageError),
    /// The images do not belong together.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// The result could not be written there.
    #[error("{0}")]
    Output(String),
    /// The result could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Runs the command.
///
/// # Errors
/// If an image cannot be read, the images do not belong together, or the result cannot be written.
pub fn run(args: &MergeArgs) -> Result<ExitCode, MergeCommandError> {
    let inputs = || args.images.iter().map(PathBuf::as_path);
    output_file::check(&args.output, &["exr"], inputs()).map_err(MergeCommandError::Output)?;
    if args.png {
        let png = args.output.with_extension("png");
        output_file::check(&png, &[], inputs()).map_err(MergeCommandError::Output)?;
    }
    let mut merger: Option<Merger> = None;
    for path in &args.images {
        let name = path.display().to_string();
        let image = read_exr(path)?;
        match &mut merger {
            None => merger = Some(Merger::new(&name, &image, args.force)?),
            Some(merger) => merger.add(&name, &image)?,
        }
    }
    // The command line demands at least one image.
    let Some(merger) = merger else {
        return Ok(ExitCode::FAILURE);
    };
    for warning in merger.warnings() {
        tracing::warn!("{warning}");
    }
    let image = merger.finish();
    write_exr(&args.output, &image, false)?;
    if args.png {
        let pixels = rgb(&image);
        write_png(
            &args.output.with_extension("png"),
            image.width,
            image.height,
            &pixels,
            Exposure::default(),
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Radiance of an image, by rows.
fn rgb(image: &LayeredImage) -> Vec<[f64; 3]> {
    let mut pixels = vec![[0.0; 3]; image.width as usize * image.height as usize];
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        for (channel, values) in &image.channels {
            if let (true, ChannelValues::Float(values) | ChannelValues::Colour(values)) =
                (channel == name, values)
            {
                pixels
                    .iter_mut()
                    .zip(values)
                    .for_each(|(p, &v)| p[c] = f64::from(v));
            }
        }
    }
    pixels
}
