//! Light subpaths that many camera subpaths share: each camera vertex is connected to a few of all their vertices, chosen where
//! much light is likely to come from.
//!
//! Connecting to all vertices of one light walk costs a look-up, two evaluations and a ray for each, most of which bring
//! little. Where M light walks are known that have N vertices together, the sum over the connections of a whole walk is also
//!
//! ```text
//! E sum_v C(v) = (1 / M) sum_(i = 1)^N C(v_i)
//! ```
//!
//! of which a random v_i with density q_i takes an unbiased sample C(v_i) / (M q_i) (light vertex cache: Davidovic et al. 2014,
//! "Progressive light transport simulation on the GPU", section 5.2). The density is made by resampling (Talbot, Cline and
//! Egbert 2005): m candidates at equal distances in the store from a random one on, of which one is taken in proportion to an
//! estimate of what it gives that needs neither its surface nor a ray,
//!
//! ```text
//! c_i = L(T_i) G / (1 + h(G / pi) [d_vcm_i + d_vcm]),   G = (cos_i + e) (cos + e) / d^2,
//! 1 / q_i = (N / m) sum_j c_j / c_i
//! ```
//!
//! with L(T) the luminance of the walk's throughput, G the geometry term kept above zero by e = 0.1 (one instead of a cosine that is
//! not known), and the weight against the two strategies nearest by, as if both surfaces were diffuse.
//!
//! Weights do not change: a partition of one over strategies stays one, whatever the number of samples of each.
//! Invariants (tests): the mean is that of connections with one's own light walk.

use super::vertex_store::VertexStore;
use crate::math::{float, luminance, vec3};
use crate::path::{Connector, Heuristic, Interaction, PathVertex, Walk};
use crate::scene::NONE;
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// Candidates of one connection: m above.
pub const CANDIDATES: u32 = 4;

/// Least cosine that an estimate assumes: e above.
const LEAST_COSINE: f32 = 0.1;

/// Light walks whose vertices all lie in one store, from its first index on.
#[derive(Clone, Copy, Debug)]
pub struct SharedWalks {
    /// Their vertices: N above.
    pub vertices: u32,
    /// How many walks there are, those without vertices too: M above.
    pub walks: u32,
}

impl SharedWalks {
    /// None.
    pub const NONE: SharedWalks = SharedWalks {
        vertices: 0,
        walks: 0,
    };

    /// One of all vertices for a connection with the vertex `at` of a camera walk, chosen by two numbers of [0, 1), with the factor
    /// 1 / (M q) of what it gives; [`NONE`] where no candidate can give anything.
    pub fn choose<V: VertexStore>(
        &self,
        store: &V,
        connector: &Connector<'_>,
        walk: &Walk,
        at: &Interaction<'_>,
        u: Vec2,
    ) -> (u32, f32) {
        let count = self.vertices;
        if count == 0 {
            return (NONE, 0.0);
        }
        let candidates = count.min(CANDIDATES);
        let stride = count / candidates;
        let mut index = ((u.x * count as f32) as u32).min(count - 1);
        let (facing, h) = (at.facing(), connector.strategies.heuristic);
        let mut u = u.y;
        let (mut sum, mut chosen, mut of_chosen) = (0.0, NONE, 0.0);
        let mut k = 0;
        while k < candidates {
            let vertex = store.get(index);
            let edges = vertex.depth.saturating_add(walk.subpath.depth);
            let c = if connector.allows_edges(edges.saturating_add(2)) {
                estimate(&vertex, at.point.position, facing, walk.arrived.d_vcm, h)
            } else {
                0.0
            };
            if c > 0.0 {
                sum += c;
                // One number makes all the choices: what is left of it after each is uniform again.
                let share = c / sum;
                if u < share {
                    chosen = index;
                    of_chosen = c;
                    u /= share;
                } else {
                    u = (u - share) / (1.0 - share);
                }
            }
            index += stride;
            if index >= count {
                index -= count;
            }
            k += 1;
        }
        let factor = count as f32 / (candidates as f32 * self.walks as f32);
        (chosen, factor * (sum / of_chosen))
    }
}

/// About what a connection gives: c above. Zero only where it gives nothing.
#[inline]
fn estimate(vertex: &PathVertex, position: Vec3, facing: Vec3, d_vcm: f32, h: Heuristic) -> f32 {
    let between = vec3(vertex.position) - position;
    let distance2 = between.length_squared();
    let scale = 1.0 / float::sqrt(distance2);
    let cosine = known_cosine(facing, between, scale);
    let cosine_light = known_cosine(vec3(vertex.facing), -between, scale);
    if !(distance2 > 0.0) || cosine < 0.0 || cosine_light < 0.0 {
        return 0.0;
    }
    let geometry = (cosine + LEAST_COSINE) * (cosine_light + LEAST_COSINE) / distance2;
    let others = h.of(geometry * FRAC_1_PI) * (vertex.d_vcm + d_vcm);
    let light = luminance(vec3(vertex.throughput));
    let c = light * (geometry / (1.0 + others));
    // Points that coincide, and weights beyond all numbers, give nothing that a float can hold.
    if c < f32::MAX { c } else { 0.0 }
}

/// The cosine at a surface that shows one side only, one at others.
#[inline]
fn known_cosine(facing: Vec3, direction: Vec3, scale: f32) -> f32 {
    if facing == Vec3::ZERO {
        1.0
    } else {
        facing.dot(direction) * scale
    }
}
