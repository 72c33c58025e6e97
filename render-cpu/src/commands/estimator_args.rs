//! Arguments that change how an algorithm estimates, whatever the scene says.

use super::chain_args::ChainArgs;
use super::expression_args::ExpressionArgs;
use super::photon_args::PhotonArgs;
use super::regularization_args::RegularizationArgs;
use crate::render::{Shape, shape};
use crate::scene::build::Scene;
use clap::{Args, ValueEnum};

/// How strategies are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HeuristicName {
    /// By squares of densities.
    Power,
    /// By densities.
    Balance,
}

/// What the command line changes about bidirectional algorithms.
#[derive(Args, Clone, Debug)]
pub struct EstimatorArgs {
    /// Weights of the strategies of bdpt.
    #[arg(help_heading = "Algorithm", long, value_name = "NAME")]
    pub heuristic: Option<HeuristicName>,
    /// Only what bdpt finds with S vertices from the light and T from the sensor (bdpt); "*" stands for any number.
    #[arg(help_heading = "Algorithm", long, value_name = "S,T", value_parser = parse_strategy, group = "shown_strategies")]
    pub strategies: Option<[Option<u32>; 2]>,
    /// Without weights, each strategy as if it were alone; with --strategies or a sheet of all of them.
    #[arg(help_heading = "Algorithm", long, requires = "shown_strategies")]
    pub unweighted: bool,
    /// Connect each vertex of a camera walk to N vertices of the light walks of many samples, instead of to all of its own (bdpt, vcm;
    /// layers and edited images keep to their own).
    #[arg(help_heading = "Algorithm", long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1 << 10))]
    pub connections: Option<u32>,
    /// Of photon mapping.
    #[command(flatten)]
    pub photons: PhotonArgs,
    /// Of Markov chains.
    #[command(flatten)]
    pub chains: ChainArgs,
    /// Of regularisation.
    #[command(flatten)]
    pub regularization: RegularizationArgs,
    /// Of path expressions.
    #[command(flatten)]
    pub expressions: ExpressionArgs,
}

impl EstimatorArgs {
    /// Changes the scene's settings.
    ///
    /// # Errors
    /// If they are not of the algorithm that will run.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), String> {
        self.photons.apply(scene)?;
        self.chains.apply(scene)?;
        self.regularization.apply(scene)?;
        self.expressions.apply(scene).map_err(|e| e.to_string())?;
        let is_used =
            self.heuristic.is_some() || self.strategies.is_some() || self.connections.is_some();
        if is_used && shape(scene.settings.kind) != Shape::Splats {
            return Err(
                "--heuristic, --strategies and --connections are for bidirectional algorithms (--integrator bdpt)"
                    .to_string(),
            );
        }
        let bidirectional = &mut scene.settings.bidirectional;
        if let Some(name) = self.heuristic {
            bidirectional.power_heuristic = (name == HeuristicName::Power).into();
        }
        if let Some([s, t]) = self.strategies {
            let all = halflight_kernel::scene::NONE;
            bidirectional.only_s = s.unwrap_or(all);
            bidirectional.only_t = t.unwrap_or(all);
        }
        bidirectional.unweighted = self.unweighted.into();
        if let Some(connections) = self.connections {
            bidirectional.connections = connections;
        }
        Ok(())
    }
}

/// Two numbers of vertices.
fn parse_strategy(text: &str) -> Result<[Option<u32>; 2], String> {
    let form = || "expected S,T, each a number of vertices or *".to_string();
    let number = |text: &str| match text.trim() {
        "*" => Ok(None),
        text => text.parse().map(Some).map_err(|_| form()),
    };
    let (s, t) = text.split_once(',').ok_or_else(form)?;
    let strategy: [Option<u32>; 2] = [number(s)?, number(t)?];
    match strategy {
        [Some(s), Some(t)] if s.saturating_add(t) < 2 => {
            Err("a path has at least two vertices".to_string())
        }
        _ => Ok(strategy),
    }
}
