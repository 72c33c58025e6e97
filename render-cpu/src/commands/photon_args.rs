//! Arguments of photon mapping, instead of what the scene says.

use crate::scene::build::Scene;
use clap::Args;
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::photon::nearest::MOST_NEAREST;

/// What the command line changes about photon mapping.
#[derive(Args, Clone, Debug)]
pub struct PhotonArgs {
    /// Light paths per pass of photon mapping.
    #[arg(help_heading = "Algorithm", long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 28))]
    pub photons: Option<u32>,
    /// Radius within which photons are gathered in the first pass, in units of the scene.
    #[arg(help_heading = "Algorithm", long, value_name = "R", value_parser = parse_radius)]
    pub radius: Option<f32>,
    /// Photons that the first radius of each pixel holds (sppm), 0 for one radius for all pixels.
    #[arg(help_heading = "Algorithm", long, value_name = "K", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_NEAREST)))]
    pub nearest: Option<u32>,
}

impl PhotonArgs {
    /// Changes the scene's settings.
    ///
    /// # Errors
    /// If another algorithm will run.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), String> {
        let is_used = self.photons.is_some() || self.radius.is_some();
        let kind = scene.settings.kind;
        let is_adaptive = kind == integrator_kind::ADAPTIVE_PHOTONS;
        if is_adaptive && self.radius.is_some() {
            return Err("--radius is not for appm, whose pixels find their own radii".to_string());
        }
        let has_photons = is_adaptive
            || kind == integrator_kind::PROGRESSIVE_PHOTONS
            || kind == integrator_kind::METROPOLIS_PHOTONS
            || kind == integrator_kind::VERTEX_MERGING;
        if is_used && !has_photons {
            return Err(
                "--photons and --radius are for photon mapping (--integrator sppm, appm, mcppm, vcm, vm or bpm)"
                    .to_string(),
            );
        }
        if self.nearest.is_some() && kind != integrator_kind::PROGRESSIVE_PHOTONS {
            return Err(
                "--nearest is for stochastic progressive photon mapping (--integrator sppm)"
                    .to_string(),
            );
        }
        if self.nearest.is_some() && self.radius.is_some() {
            return Err("--nearest and --radius both say what the first radius is".to_string());
        }
        let photon = &mut scene.settings.photon;
        photon.photon_count = self.photons.unwrap_or(photon.photon_count);
        photon.initial_radius = self.radius.unwrap_or(photon.initial_radius);
        if let Some(nearest) = self.nearest {
            photon.nearest = nearest;
            photon.initial_radius = 0.0;
        }
        Ok(())
    }
}

fn parse_radius(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|r: &f32| *r > 0.0 && r.is_finite())
        .ok_or_else(|| "expected a length above zero".to_string())
}
