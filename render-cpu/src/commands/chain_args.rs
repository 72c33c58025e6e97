//! Arguments of algorithms that run Markov chains.

use crate::render::{Shape, shape};
use crate::scene::build::Scene;
use clap::{Args, ValueEnum};
use halflight_kernel::transport::settings::half_vector_flag;

/// What the command line changes about chains.
#[derive(Args, Clone, Debug)]
pub struct ChainArgs {
    /// Samples per pixel for direct illumination in each group of chains, which then leave it out; 0 leaves it to the chains
    /// (pssmlt, mmlt, mlt, memlt, hslt, erpt, meerpt). By default mlt, memlt, hslt, erpt and meerpt leave all that path tracing
    /// finds well to it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1 << 20))]
    pub direct_samples: Option<u32>,
    /// Chains in a group (pssmlt, mmlt, mlt, memlt, hslt).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 16))]
    pub chains: Option<u32>,
    /// A first stage decides how often chains come to each part of the image, so that dark parts are not left to a few visits
    /// (pssmlt, mmlt, mlt, memlt, hslt, erpt, meerpt).
    #[arg(long)]
    pub two_stage: bool,
    /// The half-vector mutation that breaks paths up, or the original one of full paths (hslt).
    #[arg(long, value_name = "NAME")]
    pub hslt: Option<HalfVectorName>,
    /// Steps of half vectors from the roughness at a pair of directions, or from the largest of a material (hslt).
    #[arg(long, value_name = "NAME")]
    pub roughness: Option<RoughnessName>,
    /// Half vectors as slopes with Gaussian steps, or projected onto the surface with Phong lobes (hslt).
    #[arg(long, value_name = "NAME")]
    pub half_vectors: Option<HalfVectorForm>,
}

/// Half-vector mutations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HalfVectorName {
    /// That of the thesis.
    Original,
    /// The one that breaks paths up.
    Improved,
}

/// Roughness from which steps of half vectors come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RoughnessName {
    /// At a pair of directions.
    Local,
    /// The largest of a material.
    Global,
}

/// Coordinates of half vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HalfVectorForm {
    /// On the plane.
    Slopes,
    /// On the disk.
    Projected,
}

impl ChainArgs {
    /// Changes the scene's settings.
    ///
    /// # Errors
    /// If no chains will run.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), String> {
        let is_used = self.direct_samples.is_some() || self.chains.is_some() || self.two_stage;
        if is_used && shape(scene.settings.kind) != Shape::Chains {
            return Err(
                "--direct-samples, --chains and --two-stage are for Markov chains (--integrator mlt)"
                    .to_string(),
            );
        }
        let settings = &mut scene.settings.chains;
        if let Some(samples) = self.direct_samples {
            settings.direct_samples = samples;
        }
        if self.two_stage {
            settings.two_stage = 1;
        }
        if let Some(chains) = self.chains {
            settings.chains = chains;
        }
        let choices = [
            (
                self.hslt.map(|n| n == HalfVectorName::Original),
                half_vector_flag::ORIGINAL,
            ),
            (
                self.roughness.map(|n| n == RoughnessName::Global),
                half_vector_flag::GLOBAL_ROUGHNESS,
            ),
            (
                self.half_vectors.map(|n| n == HalfVectorForm::Projected),
                half_vector_flag::PROJECTED,
            ),
        ];
        for (choice, flag) in choices {
            let Some(is_set) = choice else { continue };
            if !(settings.half_vector_weight > 0.0) {
                return Err(
                    "--hslt, --roughness and --half-vectors are for the half-vector mutation (--integrator hslt)"
                        .to_string(),
                );
            }
            settings.half_vector_flags &= !flag;
            if is_set {
                settings.half_vector_flags |= flag;
            }
        }
        Ok(())
    }
}
