//! Discrete events of a material, found again for a pair of directions: what it does there, and with which probability.
//!
//! Whole paths keep the kind of an event (reflection or transmission), not the lobe; the value is the sum over the lobes that
//! have an event of that kind in the same direction. Hosts only, as whole paths are.

use crate::bsdf::{Bsdf, event, lobe};
use crate::math::Rgb;
use crate::scene::{Tables, lobe_kind};
use glam::{Vec2, Vec3};

/// A direction of a discrete event is found again to this cosine.
const SAME_DIRECTION: f32 = 1.0 - 2e-4;

/// What a material does in a discrete direction.
pub(super) struct Discrete {
    pub value: Rgb,
    pub pdf: f32,
    pub eta: f32,
    /// Ratio of the cosines of wi and wo.
    pub exchange: f32,
    /// Whether there is no other direction of the same kind.
    pub is_unique: bool,
}

/// Sum over the lobes of a material, looked up for wi, that have a discrete event of the given kind in the direction wo.
pub(super) fn discrete(
    bsdf: &Bsdf,
    tables: &Tables<'_>,
    wi: Vec3,
    wo: Vec3,
    wanted: u32,
) -> Discrete {
    let mut sum = Discrete {
        value: Vec3::ZERO,
        pdf: 0.0,
        eta: 1.0,
        exchange: 1.0,
        is_unique: true,
    };
    for i in 0..bsdf.lobe_count() {
        let found = discrete_of_lobe(bsdf, tables, wi, i, wanted);
        if !(found.pdf > 0.0) {
            continue;
        }
        if found.wo.normalize().dot(wo) > SAME_DIRECTION {
            sum.value += found.value;
            sum.pdf += found.pdf;
            sum.eta = found.eta;
            sum.exchange = lobe::exchange_ratio(&bsdf.lobe(i), tables.data, wi, wo);
        } else {
            sum.is_unique = false;
        }
    }
    sum
}

/// The direction of the first lobe that has a discrete event of the given kind.
pub fn discrete_direction(bsdf: &Bsdf, tables: &Tables<'_>, wi: Vec3, wanted: u32) -> Option<Vec3> {
    (0..bsdf.lobe_count())
        .map(|i| discrete_of_lobe(bsdf, tables, wi, i, wanted))
        .find(|found| found.pdf > 0.0)
        .map(|found| found.wo.normalize())
}

/// A discrete event of one lobe.
#[derive(Clone, Copy, Debug)]
struct DiscreteEvent {
    wo: Vec3,
    /// f |cos| as a weight times the probability.
    value: Rgb,
    /// Zero for no event.
    pdf: f32,
    /// Relative index from the side of wi to that of wo.
    eta: f32,
}

/// The event of kind `wanted` of lobe `index` of a material looked up for wi.
fn discrete_of_lobe(
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
