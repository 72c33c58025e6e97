//! The shapes of algorithms: which driver takes the samples of each kind of integrator.

use crate::film::aov::{Aov, AovSet};
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
        integrator_kind::PROGRESSIVE_PHOTONS | integrator_kind::ADAPTIVE_PHOTONS => Shape::Passes,
        integrator_kind::PRIMARY_SAMPLE_MLT | integrator_kind::VEACH_MLT => Shape::Chains,
        _ => Shape::Pixels,
    }
}

/// Layers that a film must have for a kind of integrator, because they hold its state.
pub fn own_layers(kind: u32) -> AovSet {
    if kind == integrator_kind::ADAPTIVE_PHOTONS {
        AovSet::NONE.with(Aov::Bandwidth)
    } else {
        AovSet::NONE
    }
}
