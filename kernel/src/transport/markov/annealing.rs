//! Chains whose target is mollified less and less (Kaplanyan 2017, section 6.3.2).
//!
//! Step n of a chain has the radius r_n = r_0 gamma^n, here changed every [`STAGE`] steps. A state x of the target I_m does not
//! belong to the next one, I_(m+1); with the weight
//!
//! ```text
//! W = prod_m I_(m+1)(x_m) / I_m(x_m)
//! ```
//!
//! over the states in which the changes have found the chain it counts as one that does (annealed importance sampling: Neal 2001),
//! so that an image of chains is unbiased for the mean of its mollified targets, however slowly they mix. The thesis leaves W
//! out and relies on a rate slow enough for that. A chain whose state has left the kernel has no weight any more.
//!
//! r_0 is that of the group, which shrinks from group to group as it does from sample to sample elsewhere, r_0 = r n^-lambda: each
//! group estimates its normalisation by regularised bidirectional path tracing with that radius, from its candidates, so the mean
//! of a run is refined with every group.

use crate::regularize::bandwidth::geometric;
use crate::regularize::settings::{Regularization, RegularizationSettings};

/// Steps between two changes of the radius.
pub const STAGE: u32 = 64;

/// The mollification of a group's chains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Annealing {
    /// Of the first step.
    start: Regularization,
    /// 1 - gamma.
    one_minus_gamma: f32,
}

impl Annealing {
    /// Nothing is regularised.
    pub const NONE: Annealing = Annealing {
        start: Regularization::NONE,
        one_minus_gamma: 0.0,
    };

    /// Of a group, in a scene of the given radius.
    pub fn of_group(settings: &RegularizationSettings, scene_radius: f32, group: u32) -> Annealing {
        Annealing {
            start: Regularization {
                // Paths of chains keep what is rough.
                half_tangent: 0.0,
                ..Regularization::of_sample(settings, scene_radius, group)
            },
            one_minus_gamma: settings.one_minus_gamma,
        }
    }

    /// The regularisation after so many steps.
    #[inline]
    pub fn at(&self, step: u32) -> Regularization {
        let mut regularization = self.start;
        if self.shrinks() {
            regularization.radius = geometric(
                regularization.radius,
                self.one_minus_gamma,
                step / STAGE * STAGE,
            );
        }
        regularization
    }

    /// Whether the radius after so many steps is not that of the step before.
    #[inline]
    pub fn changes_at(&self, step: u32) -> bool {
        self.shrinks() && step > 0 && step.is_multiple_of(STAGE)
    }

    /// Whether vertices are blurred.
    #[inline]
    pub fn mollifies(&self) -> bool {
        self.start.radius > 0.0
    }

    #[inline]
    fn shrinks(&self) -> bool {
        self.mollifies() && self.one_minus_gamma > 0.0
    }
}
