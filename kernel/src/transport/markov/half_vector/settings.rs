//! Settings of mutations in half-vector space.

use crate::manifold::half_vector_form;
use crate::manifold::walk::walk_start;
use crate::transport::settings::{ChainSettings, half_vector_flag};

/// Which roughness scales the steps of half vectors.
pub mod roughness_kind {
    /// The local one, of the Beckmann lobe that resembles the BSDF at the pair of directions
    /// ([`crate::bsdf::local_roughness`]).
    pub const LOCAL: u32 = 0;
    /// The largest of the lobes, at all pairs.
    pub const GLOBAL: u32 = 1;
    /// One, whatever the material.
    pub const UNIT: u32 = 2;
}

/// Settings of the half-vector mutation and of manifold exploration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfVectorSettings {
    /// One of [`roughness_kind`].
    pub roughness: u32,
    /// One of [`half_vector_form`].
    pub form: u32,
    /// Whether the full path moves in half-vector space, instead of breaking up.
    pub is_original: bool,
    /// How narrow the directions are into which manifold exploration turns paths.
    pub lambda: f32,
    /// Step over the optimal one of a lobe alone.
    pub gamma: f32,
    /// Where projections of walks start: one of [`walk_start`].
    pub start: u32,
    /// Whether steps lead a few percent of the image far at most.
    pub is_stratified: bool,
}

impl HalfVectorSettings {
    /// Those of chains.
    pub fn new(chains: &ChainSettings) -> HalfVectorSettings {
        let has = |flag: u32| chains.half_vector_flags & flag != 0;
        HalfVectorSettings {
            roughness: if has(half_vector_flag::EQUAL_STEPS) {
                roughness_kind::UNIT
            } else if has(half_vector_flag::GLOBAL_ROUGHNESS) {
                roughness_kind::GLOBAL
            } else {
                roughness_kind::LOCAL
            },
            form: if has(half_vector_flag::PROJECTED) {
                half_vector_form::PROJECTED
            } else {
                half_vector_form::SLOPE
            },
            is_original: has(half_vector_flag::ORIGINAL),
            lambda: chains.lambda,
            gamma: chains.half_vector_step,
            start: if has(half_vector_flag::FROM_LIGHT) {
                walk_start::LIGHT
            } else if has(half_vector_flag::FROM_SENSOR) {
                walk_start::SENSOR
            } else {
                walk_start::CHOSEN
            },
            is_stratified: !has(half_vector_flag::UNSTRATIFIED),
        }
    }
}
