//! What path tracing leaves to chains of paths.
//!
//! Path tracing and chains that mutate paths are good at different paths, and often of the same pixel. With the balance heuristic
//! between n samples of path tracing with the density p and m states of chains with the density I / b, path tracing keeps the
//! share n p / (n p + m I / b) of a path that carries I: a contribution of luminance L = I / p counts as
//!
//! ```text
//! L v(L),   v(L) = 1 / (1 + s L),   s = m / (n b),
//! ```
//!
//! and chains find the rest. So a contribution is never more than 1 / s: what would be a bright dot is left to chains, whose
//! states in turn are spared all that path tracing finds well. A path that path tracing finds in two ways, by hitting the light and
//! by sampling it, with the weights w_0 and w_1, keeps w_0 v(w_0 I / p_0) + w_1 v(w_1 I / p_1). Any s is unbiased.
//!
//! Direct illumination, paths of two edges, stays with path tracing altogether, paths of more than [`MOST_EDGES`] edges with
//! chains: up to there no Russian roulette is played, whose probabilities depend on more than the path.
//!
//! Invariant (tests): images of both parts together have no less and no more light than either method alone.

use crate::math::{Rgb, luminance};

/// Most edges of a path that path tracing finds for chains.
pub const MOST_EDGES: u32 = 10;

/// Fewest edges of a path that chains find.
pub const LEAST_EDGES: u32 = 3;

/// How much path tracing keeps of what it finds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remainder {
    /// s of the header; 0 where path tracing keeps all.
    pub scale: f32,
}

impl Remainder {
    /// v(L) of a path of so many edges.
    #[inline]
    pub fn kept(&self, luminance: f32, edges: u32) -> f32 {
        if edges < LEAST_EDGES || !(self.scale > 0.0) {
            return 1.0;
        }
        1.0 / (1.0 + self.scale * luminance)
    }

    /// What is kept of a contribution.
    #[inline]
    pub fn of(&self, value: Rgb, edges: u32) -> Rgb {
        value * self.kept(luminance(value), edges)
    }

    /// The share of a path of luminance I that is left to chains, for the densities p_0 and p_1 with which path tracing finds it by
    /// hitting the light and by sampling it; zero for what it cannot find.
    #[inline]
    pub fn chain_share(&self, luminance: f32, pdf: [f32; 2], edges: u32) -> f32 {
        if edges > MOST_EDGES || !(pdf[0] + pdf[1] > 0.0) {
            return 1.0;
        }
        let mut left = 0.0;
        for i in 0..2 {
            if pdf[i] > 0.0 {
                let ratio = pdf[1 - i] / pdf[i];
                // The power heuristic, as in path tracing.
                let weight = 1.0 / (1.0 + ratio * ratio);
                // 1 - v(L) without the difference.
                let x = self.scale * luminance * (weight / pdf[i]);
                left += weight * if x < f32::MAX { x / (1.0 + x) } else { 1.0 };
            }
        }
        left
    }
}
