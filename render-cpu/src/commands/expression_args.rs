//! Arguments of path expressions.

use crate::expression::{PartsError, PartsRequest};
use crate::scene::build::Scene;
use clap::Args;

/// What is asked for of paths.
#[derive(Args, Clone, Debug, Default)]
pub struct ExpressionArgs {
    /// A layer NAME with the light of the paths that an expression matches, from the light as in caustics='L S+ D E' or from the
    /// camera as in key="C<RD>.*<L.'key'>"; may be given several times.
    #[arg(help_heading = "Paths", long, value_name = "NAME=EXPRESSION", value_parser = PartsRequest::parse_layer)]
    pub lpe: Vec<(String, String)>,
    /// Nothing but the paths that an expression matches.
    #[arg(help_heading = "Paths", long, value_name = "EXPRESSION")]
    pub only: Option<String>,
}

impl ExpressionArgs {
    /// What is asked for.
    pub fn request(&self) -> PartsRequest {
        PartsRequest {
            layers: self.lpe.clone(),
            only: self.only.clone(),
        }
    }

    /// Compiles the expressions for the scene and its algorithm.
    ///
    /// # Errors
    /// A mistake in an expression, or an algorithm that knows no paths.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), PartsError> {
        scene.divide(&self.request())
    }
}
