//! Arguments of regularisation, instead of what the scene says.

use crate::scene::build::Scene;
use crate::scene::build::regularization::{EDITED, parse_mollify, parse_regularize, refusal};
use clap::Args;
use halflight_kernel::transport::settings::RegularizationSettings;

/// What the command line changes about regularisation.
#[derive(Args, Clone, Debug)]
pub struct RegularizationArgs {
    /// Blur shiny materials where paths are connected, less with every sample, so that light behind them is found: tau=T is the
    /// largest value of a BSDF in the first sample (10 to 100, higher is sharper and noisier); lambda says how fast it grows, constant
    /// keeps it; quality,
    /// fade=F and diffusion leave alone what needs no blur; virtual and lights=all are for path; weights=plain is for comparison; tau=inf switches it off.
    #[arg(help_heading = "Algorithm", long, value_name = "tau=T,..", value_parser = parse_regularize, conflicts_with = "mollify")]
    pub regularize: Option<RegularizationSettings>,
    /// Blur specular surfaces where nothing else finds the light, less with every sample: r0=R is the radius in the first sample,
    /// 1% of the scene's or a length; lambda, kernel, constant and lights=all as well, and gamma, by which Markov chains shrink it
    /// with each mutation; metals and glass count as specular of whose lobe the share quantile=Q lies within the radius; r0=0
    /// switches it off.
    #[arg(help_heading = "Algorithm", long, value_name = "r0=R,..", value_parser = parse_mollify)]
    pub mollify: Option<RegularizationSettings>,
}

impl RegularizationArgs {
    /// Changes the scene's settings.
    ///
    /// # Errors
    /// If an algorithm without connections of its own will run.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), String> {
        if let Some(asked) = self.regularize.or(self.mollify) {
            if asked.is_some() && !scene.edits.is_empty() {
                return Err(EDITED.to_string());
            }
            scene.settings.regularization = asked;
        }
        // What the scene asks for, too, if other options do not go with it.
        match refusal(&scene.settings) {
            Some(reason) => Err(reason),
            None => Ok(()),
        }
    }
}
