//! `halflight material`: pictures and diagrams of a material.

use super::output_file;
use crate::image::png_output::write_png_bytes;
use crate::material::examples::EXAMPLES;
use crate::material::gallery::contact_sheet;
use crate::material::preview::Preview;
use crate::material::{sheet, source};
use crate::say::print_line;
use clap::Args;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draw a material: a lit ball, its lobes, its albedo and its local roughness.
#[derive(Args, Clone, Debug)]
pub struct MaterialArgs {
    /// A plugin (diffuse, roughconductor, coating, ...), a conductor (Au, Cu, ...), a scene file with a BSDF, or a
    /// MERL file (.binary).
    #[arg(value_name = "NAME|FILE", required_unless_present_any = ["all", "list"])]
    pub material: Option<String>,
    /// Which BSDF of a scene file [default: the first].
    #[arg(long, value_name = "ID")]
    pub id: Option<String>,
    /// The picture.
    #[arg(short, long, value_name = "OUT.png", default_value = "material.png")]
    pub output: PathBuf,
    /// Draw the ball in an example of every material.
    #[arg(long, conflicts_with_all = ["material", "id"])]
    pub all: bool,
    /// Print the names of the examples.
    #[arg(long, conflicts_with_all = ["material", "id", "all"])]
    pub list: bool,
    /// Samples per pixel of the ball.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
}

/// Runs the command.
///
/// # Errors
/// When there is no such material, something is wrong with it, or the picture cannot be written.
pub fn run(args: &MaterialArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    if args.list {
        for example in EXAMPLES {
            print_line(example.name)?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let input = args.material.as_deref().map(Path::new);
    output_file::check(&args.output, &["png"], input)?;
    let canvas = if let Some(name) = &args.material {
        let source = source::find(name, args.id.as_deref())?;
        let preview = Preview::new(&source, sheet::PICTURE)?;
        for warning in &preview.scene.warnings {
            tracing::warn!("{warning}");
        }
        sheet::draw(&source.name, &preview, args.spp)?
    } else {
        contact_sheet(EXAMPLES, args.spp, |name| tracing::info!("rendered {name}"))?
    };
    let [width, height] = canvas.size();
    write_png_bytes(&args.output, width, height, canvas.rgb())?;
    if !quiet {
        print_line(args.output.display())?;
    }
    Ok(ExitCode::SUCCESS)
}
