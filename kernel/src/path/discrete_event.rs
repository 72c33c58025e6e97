//! The discrete events of a lobe: the one direction into which it reflects, and the one into which it transmits.

use crate::bsdf::{Bsdf, event, lobe};
use crate::math::Rgb;
use crate::scene::{Tables, lobe_kind};
use glam::{Vec2, Vec3};

/// A discrete event of one lobe.
#[derive(Clone, Copy, Debug)]
pub struct DiscreteEvent {
    /// Its direction.
    pub wo: Vec3,
    /// f |cos| as a weight times the probability.
    pub value: Rgb,
    /// Probability, zero for no event.
    pub pdf: f32,
    /// Relative index from the side of wi to that of wo.
    pub eta: f32,
}

/// The event of kind `wanted` of lobe `index` of a material looked up for wi.
pub fn discrete_of_lobe(
    bsdf: &Bsdf,
    tables: &Tables<'_>,
    wi: Vec3,
    index: u32,
    wanted: u32,
) -> DiscreteEvent {
    let result = DiscreteEvent {
        wo: Vec3::Z,
        value: Vec3::ZERO,
        pdf: 0.0,
        eta: 1.0,
    };
    if index >= bsdf.lobe_count() {
        return result;
    }
    let model = bsdf.lobe(index);
    if !lobe::has_delta(&model) || model.kind == lobe_kind::NULL {
        return result;
    }
    // A lobe has one or two events, at the ends of the number that chooses.
    for u in [0.0, 1.0 - f32::EPSILON] {
        let sample = lobe::sample(&model, tables.data, wi, u, Vec2::splat(0.5));
        let is_wanted = sample.event & event::DELTA != 0
            && sample.event & event::NULL == 0
            && direction_bits(sample.event) == direction_bits(wanted);
        if sample.pdf > 0.0 && is_wanted {
            return DiscreteEvent {
                wo: sample.wo,
                value: sample.weight * model.weight * sample.pdf,
                pdf: sample.pdf * bsdf.selection(index),
                eta: sample.eta,
            };
        }
    }
    result
}

/// Reflection or transmission.
#[inline]
fn direction_bits(event: u32) -> u32 {
    event & (event::REFLECTION | event::TRANSMISSION)
}
