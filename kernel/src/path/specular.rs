//! Discrete events of a material, found again for a pair of directions: what it does there, and with which probability.
//!
//! Full paths keep the kind of an event (reflection or transmission), not the lobe; the value is the sum over the lobes that
//! have an event of that kind in the same direction. Hosts only, as full paths are.

use super::discrete_event::discrete_of_lobe;
use crate::bsdf::{Bsdf, lobe};
use crate::math::Rgb;
use crate::scene::Tables;
use glam::Vec3;

/// A direction of a discrete event is found again to this cosine.
const SAME_DIRECTION: f32 = 1.0 - 2e-4;

/// What a material does in a discrete direction.
pub(super) struct DiscreteScattering {
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
) -> DiscreteScattering {
    let mut sum = DiscreteScattering {
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
