//! What the film of an algorithm must hold.

use crate::film::aov::{Aov, AovSet};
use halflight_kernel::transport::integrator_kind;

/// Layers that a film must have for a kind of integrator, because they hold its state.
pub fn own_layers(kind: u32) -> AovSet {
    if kind == integrator_kind::ADAPTIVE_PHOTONS {
        AovSet::NONE.with(Aov::Bandwidth)
    } else {
        AovSet::NONE
    }
}
