//! Acceptance of a mutation whose proposals exist only if a walk leads back.
//!
//! The probability is a R, a the ratio of contributions and densities cut at one, and R = 1 if the reverse mutation finds the old path,
//! else 0. R takes as much time as the proposal itself and is nearly always 1. So the number u that decides is drawn first, and R is
//! looked at where u < a alone: acceptance in two stages (Christen and Fox 2005, "Markov chain Monte Carlo Using an
//! Approximation"), with the expensive factor in the second. The chain is the same. Its image counts the state after the step
//! once, where other mutations count both states by their probabilities: the means are the same.

use super::super::veach::ChainPath;

/// What becomes of a proposal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Whether it carries light.
    pub is_lit: bool,
    /// Whether it becomes the state.
    pub is_accepted: bool,
}

impl Verdict {
    /// There is no path.
    pub const DARK: Verdict = Verdict {
        is_lit: false,
        is_accepted: false,
    };

    /// Of the path `y` with the ratio of its contribution and densities; `accepts` says whether it is accepted if it `leads_back`.
    pub fn of(
        ratio: f32,
        y: &ChainPath,
        accepts: impl Fn(&ChainPath, f32) -> bool,
        leads_back: impl FnOnce() -> bool,
    ) -> Verdict {
        let is_lit = ratio > 0.0 && ratio <= f32::MAX;
        Verdict {
            is_lit,
            is_accepted: is_lit && accepts(y, ratio) && leads_back(),
        }
    }
}
