//! The vertices between which manifold exploration perturbs a path ([`super::manifold_perturbation`]), and which vertices count as
//! specular.

use crate::transport::markov::veach::MAX_VERTICES;
use arrayvec::ArrayVec;
use core::f32::consts::PI;

/// Half the opening of the lobe below which a vertex is specular, in radians: 7 degrees.
pub const SPECULAR_ANGLE: f32 = 7.0 / 180.0 * PI;

/// That above which it is not: 13 degrees.
pub const ROUGH_ANGLE: f32 = 13.0 / 180.0 * PI;

/// Probability that the perturbation starts at the sensor, if it can start elsewhere.
const FROM_SENSOR: f32 = 0.25;

/// A choice of the vertices between which a path is perturbed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The vertex where the direction turns.
    pub a: usize,
    /// The vertex that moves with it.
    pub b: usize,
    /// The one that stays; none if b is on the light.
    pub c: Option<usize>,
}

impl Plan {
    /// Whether it leads from the sensor's side to the light's.
    pub fn is_from_sensor(&self) -> bool {
        self.a > self.b
    }
}

/// Probability that a vertex of a roughness is taken as rough.
pub fn p_rough(alpha: f32) -> f32 {
    // sqrt(ln 10)
    let angle = crate::math::float::atan(1.517_427_1 * alpha);
    ((angle - SPECULAR_ANGLE) / (ROUGH_ANGLE - SPECULAR_ANGLE))
        .max(0.0)
        .min(1.0)
}

/// At most one plan from each vertex in both directions.
pub(super) type Plans = ArrayVec<Plan, { 2 * MAX_VERTICES }>;

/// All plans for a path of `k` edges whose vertices are rough or not; the first is from the sensor, if there is such.
/// `may_hit`: whether walks can hit its light; `is_far`: whether that is at infinity.
pub fn plans(k: usize, rough: &[bool], may_hit: bool, is_far: bool) -> Plans {
    let mut out = Plans::new();
    let is_end = |i: usize| i == 0 || i == k || rough[i];
    let down = |from: usize| (0..from).rev().find(|&i| is_end(i));
    let up = |from: usize| (from + 1..=k).find(|&i| is_end(i));
    for a in (1..=k).rev().filter(|&i| is_end(i)) {
        let Some(b) = down(a) else { continue };
        let c = down(b);
        if b > 0 || may_hit {
            out.push(Plan { a, b, c });
        }
    }
    for a in (0..k).filter(|&i| is_end(i) && !(i == 0 && is_far)) {
        if let Some(b) = up(a)
            && b < k
        {
            out.push(Plan { a, b, c: up(b) });
        }
    }
    out
}

pub(super) fn choose(plans: &Plans, k: usize, u: f32) -> Plan {
    let starts_at_sensor = plans[0].a == k;
    let others = &plans[usize::from(starts_at_sensor)..];
    if others.is_empty() || starts_at_sensor && u < FROM_SENSOR {
        return plans[0];
    }
    let u = if starts_at_sensor {
        (u - FROM_SENSOR) / (1.0 - FROM_SENSOR)
    } else {
        u
    };
    let at = (u * others.len() as f32) as usize;
    others[at.min(others.len() - 1)]
}
