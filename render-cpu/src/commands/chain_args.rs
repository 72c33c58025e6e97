//! Arguments of algorithms that run Markov chains.

use crate::render::{Shape, shape};
use crate::scene::build::Scene;
use clap::Args;

/// What the command line changes about chains.
#[derive(Args, Clone, Debug)]
pub struct ChainArgs {
    /// Samples per pixel for direct illumination in each group of chains, which then leave it out; 0 leaves it to the chains
    /// (pssmlt, mmlt, mlt, erpt).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1 << 20))]
    pub direct_samples: Option<u32>,
    /// Chains in a group (pssmlt, mmlt, mlt).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 16))]
    pub chains: Option<u32>,
}

impl ChainArgs {
    /// Changes the scene's settings.
    ///
    /// # Errors
    /// If no chains will run.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), String> {
        let is_used = self.direct_samples.is_some() || self.chains.is_some();
        if is_used && shape(scene.settings.kind) != Shape::Chains {
            return Err(
                "--direct-samples and --chains are for Markov chains (--integrator mlt)"
                    .to_string(),
            );
        }
        let own = &mut scene.settings.chains;
        if let Some(samples) = self.direct_samples {
            own.direct_samples = samples;
        }
        if let Some(chains) = self.chains {
            own.chains = chains;
        }
        Ok(())
    }
}
