//! Arguments about what is done to samples and films before they become image files.

use super::render_values::{parse_exposure, parse_positive};
use crate::image::png_output::Exposure;
use clap::Args;

/// How an image is written.
#[derive(Args, Clone, Debug)]
pub struct LookArgs {
    /// Write no PNG.
    #[arg(help_heading = "Image", long)]
    pub no_png: bool,
    /// Exposure of the PNG in stops, or "auto".
    #[arg(help_heading = "Image", long, value_name = "EV", default_value = "0", value_parser = parse_exposure, allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// Name of the image's owner, for its metadata.
    #[arg(
        help_heading = "Image",
        long,
        value_name = "NAME",
        default_value = "",
        hide_default_value = true
    )]
    pub owner: String,
    /// Write colours as 16-bit floats, which end at 65504.
    #[arg(help_heading = "Image", long)]
    pub half: bool,
    /// Bring the largest component of every sample down to VALUE: fewer fireflies, and a bias towards darkness.
    #[arg(help_heading = "Samples", long, value_name = "VALUE", value_parser = parse_positive)]
    pub clamp: Option<f32>,
}
