//! Arguments for one picture with the images of all strategies.

use clap::Args;
use std::path::PathBuf;

/// A sheet instead of an image.
#[derive(Args, Clone, Debug)]
pub struct SheetArgs {
    /// Instead of the image, one picture with the images of all strategies of bdpt, by path length and light vertices.
    #[arg(help_heading = "Algorithm", long, value_name = "OUT.png", group = "shown_strategies",
        conflicts_with_all = ["output", "samples", "adaptive", "aov", "checkpoint", "resume", "half", "no_png", "record", "lpe", "tev", "live"])]
    pub strategy_sheet: Option<PathBuf>,
    /// Most edges of the paths on the strategy sheet; no more than max_depth.
    #[arg(
        help_heading = "Algorithm",
        long,
        value_name = "N",
        default_value_t = 6,
        requires = "strategy_sheet"
    )]
    pub sheet_length: u32,
}
