//! Whether an image file can hold what is asked for, found out before it is rendered.

use super::render_args::RenderArgs;
use crate::film::aov::Aov;
use crate::image::picture_output::ImageFormat;
use crate::image::png_output::Exposure;
use crate::scene::build::Scene;
use std::path::Path;

impl RenderArgs {
    /// Makes sure that no option is without an effect on the files that are written.
    ///
    /// # Errors
    /// The first one that is, in one sentence.
    pub(super) fn check_format(&self, output: &Path) -> Result<(), String> {
        let format = ImageFormat::of_file(output).unwrap_or(ImageFormat::Exr);
        let name = output.display();
        if format != ImageFormat::Exr {
            for (option, is_given) in [
                ("--aov", !self.aov.is_empty()),
                ("--lpe", !self.estimator.expressions.lpe.is_empty()),
                ("--half", self.look.half),
                ("--owner", !self.look.owner.is_empty()),
            ] {
                if is_given {
                    return Err(format!(
                        "{name} cannot hold what {option} asks for; an OpenEXR file can (-o NAME.exr)"
                    ));
                }
            }
        }
        if self.look.no_png && format == ImageFormat::Png {
            return Err(format!("{name} is the PNG that --no-png does not want"));
        }
        if self.live && format == ImageFormat::Jpeg {
            return Err(format!("--live rewrites a PNG, and {name} is none"));
        }
        let is_for_screens = !format.is_linear() || self.writes_png(output);
        if self.look.exposure != Exposure::Stops(0.0) && !is_for_screens {
            return Err("--exposure is that of the PNG, and --no-png wants none".to_owned());
        }
        Ok(())
    }

    /// Says which layers of the scene the image does not hold. A film's wish for an alpha channel is none.
    pub(super) fn warn_of_lost_layers(&self, output: &Path, scene: &Scene) {
        let lost: Vec<String> = scene
            .layers
            .iter()
            .filter(|layer| *layer != Aov::Alpha)
            .map(|layer| layer.to_string())
            .collect();
        let holds_layers = ImageFormat::of_file(output).is_none_or(|f| f == ImageFormat::Exr);
        if !holds_layers && !lost.is_empty() {
            tracing::warn!(
                "{} cannot hold the layers that the scene asks for ({}); an OpenEXR file can",
                output.display(),
                lost.join(", ")
            );
        }
    }
}
