//! What a path carries per half vectors: the measures in which mutations propose.
//!
//! Let f be what a path carries in the measure of camera walks ([`crate::path::full_path`]). Over the positions of the vertices between
//! x_l, nearer to the light, and x_h, which both stay, it is
//!
//! ```text
//! f prod_(i=l)^(h-1) |o_i.n_i| / |x_(i+1) - x_i|^2
//!     = f prod_(i=l)^(h-1) G(x_i, x_(i+1)) / prod_(i=l+1)^h |i_i.n_i|,
//! ```
//!
//! o_i the direction to the sensor, i_i that to the light; from the lens on the last factor is the importance times the cosine. With
//! the identity of [`crate::manifold::chain`] it becomes, over the half vectors instead of the positions,
//!
//! ```text
//! f M(l..h),   M(l..h) = G(x_l <-> x_h) / |i_h.n_h| prod_(i=l+1)^(h-1) m_i,
//! m_i = |do_i / dh_i| |o_i.n_i| q_i / |i_i.n_i|.
//! ```
//!
//! At a discrete event f counts a weight instead of a density over directions to the light, which brings |dh_i / di_i|: what
//! is left of m_i is the inverse of [`Path::light_ratio`](crate::path::full_path::Path::light_ratio). Checked: chains of every kind
//! of vertex and end keep the image (`chains` of the front end).

use super::super::veach::ChainPath;
use super::path_chain::PathChain;
use crate::manifold::chain::{ChainJacobian, generalized_geometry_term, scattering_measure};
use crate::manifold::constraint::half_vector_form;
use crate::manifold::half_vector::half_vector;
use crate::manifold::vertex::{ChainVertex, vertex_kind};
use crate::math::float::abs;
use crate::math::scaled::Scaled;
use crate::scene::Tables;

/// m_i.
pub fn vertex_factor(path: &ChainPath, chain: &PathChain, i: usize, form: u32) -> f32 {
    if !path.vertices[i].is_smooth() {
        return 1.0 / path.light_ratio(i);
    }
    let [previous, x, next] = [i - 1, i, i + 1].map(|j| &chain.vertices[j]);
    scattering_measure(previous, x, next, form) / x.cosine(path.previous_direction(i))
}

/// |di_i / dh_i| q_i of an inner vertex from which a walk goes on to the light with a given half vector; one for a discrete event.
pub fn towards_light(path: &ChainPath, chain: &PathChain, i: usize, form: u32) -> f32 {
    if !path.vertices[i].is_smooth() {
        return 1.0;
    }
    let x = &chain.vertices[i];
    let (wi, wo) = (path.previous_direction(i), path.next_direction(i));
    if x.kind == vertex_kind::INDEX_MATCHED {
        return 1.0 / abs(x.normal.dot(wi));
    }
    let h = half_vector(wi, wo, x.eta, x.normal);
    let cos_h = abs(h.h.dot(x.normal));
    let q = if form == half_vector_form::SLOPE {
        cos_h * cos_h * cos_h
    } else {
        1.0 / cos_h
    };
    h.length * h.length / abs(h.h.dot(wi)) * q
}

/// M(l..h) for a segment of the chain with its constraints.
pub fn segment_factor<const N: usize>(
    tables: &Tables<'_>,
    path: &ChainPath,
    chain: &PathChain,
    segment: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    low: usize,
    form: u32,
) -> Scaled {
    let high = low + jacobian.len - 1;
    if jacobian.len == 2 {
        return Scaled::ONE.times(1.0 / path.solid_angle_per_area(tables, low));
    }
    let mut product = generalized_geometry_term(segment, jacobian);
    for i in low + 1..high {
        product = product.times(vertex_factor(path, chain, i, form));
    }
    let end = &segment[jacobian.len - 1];
    if high < path.edges() {
        return product.times(1.0 / end.cosine(path.previous_direction(high)));
    }
    product = product.times(path.importance);
    if end.kind == vertex_kind::PINNED_DIRECTION {
        return product;
    }
    let before = segment[jacobian.len - 2].position;
    product.times((end.position - before).length_squared())
}
