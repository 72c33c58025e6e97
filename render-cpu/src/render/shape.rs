//! The shapes of algorithms: which driver takes the samples of each kind of integrator.

use halflight_kernel::transport::integrator_kind;

/// How an algorithm's samples are driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A sample is its pixel's alone.
    Pixels,
    /// A sample adds light to other pixels too.
    Splats,
    /// Samples of all pixels are taken in passes over what light walks left.
    Passes,
    /// A sample of all pixels is what a group of Markov chains finds.
    Chains,
}

/// The driver of each kind of integrator.
pub fn shape(kind: u32) -> Shape {
    match kind {
        integrator_kind::BIDIRECTIONAL
        | integrator_kind::LIGHT_TRACING
        | integrator_kind::VERTEX_MERGING => Shape::Splats,
        integrator_kind::PROGRESSIVE_PHOTONS => Shape::Passes,
        integrator_kind::PRIMARY_SAMPLE_MLT | integrator_kind::VEACH_MLT => Shape::Chains,
        _ => Shape::Pixels,
    }
}
