//! Experiments: what the papers prove about regularisation and half-vector space, reproduced on integrals with known
//! answers, with the kernel's own functions.
//!
//! Each experiment returns a [`Report`]: the text that the command prints and the diagrams that it writes. They are
//! deterministic: fixed seeds, and sums over runs in a fixed order whatever the number of threads.

pub mod appm;
pub mod bounds;
pub mod chains;
pub mod convergence;
mod fit;
pub mod half_vector_flatness;
pub mod mollified_estimator;
pub mod regularization;
mod report;
pub mod search;
pub mod steps;

pub use report::Report;

/// An experiment that the command can run.
pub struct Experiment {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// Runs it; `true` for fewer samples.
    pub run: fn(bool) -> Report,
}

/// All experiments.
pub const ALL: [Experiment; 5] = [
    Experiment {
        name: "mollified-estimator",
        about: "bias, variance and error of a mollified delta against the exponent of its bandwidth",
        run: mollified_estimator::run,
    },
    Experiment {
        name: "appm",
        about: "progressive photon mapping: the optimal alpha and radii from statistics",
        run: appm::run,
    },
    Experiment {
        name: "bounds",
        about: "largest values of BSDFs against their bounds, and of regularised BSDFs against tau",
        run: bounds::run,
    },
    Experiment {
        name: "half-vector-flatness",
        about: "how flat and how decorrelated a path's contribution is in half-vector space",
        run: half_vector_flatness::run,
    },
    Experiment {
        name: "steps",
        about: "how far half vectors step: from the roughness of materials, or the same everywhere",
        run: steps::run,
    },
];
