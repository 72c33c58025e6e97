//! Walks of a segment of a path to given half vectors, with the test that the reverse walk exists.
//!
//! One end of the segment may have moved before. The walk there starts from the old vertices between the new ends and leads to the
//! target; the walk back starts from what was found, between the old ends, and must lead to the old vertices. It comes last, when the
//! path that was found would otherwise be accepted.

use super::super::algorithm::WalkCounts;
use super::path_chain::PathChain;
use crate::manifold::chain::ChainJacobian;
use crate::manifold::exploration::explore;
use crate::manifold::vertex::{ChainVertex, vertex_kind};
use crate::manifold::walk::{WalkOptions, is_same_path, walk};
use crate::scene::{SceneView, Traverse};
use glam::Vec2;

/// A part of a path between two vertices that a walk does not move.
#[derive(Clone, Copy)]
pub struct Segment<const N: usize> {
    /// The vertices.
    pub vertices: [ChainVertex; N],
    /// Their constraints.
    pub jacobian: ChainJacobian<N>,
}

impl<const N: usize> Segment<N> {
    /// The vertices `low` to `high` of a path; nothing without constraints that can be inverted.
    pub fn new(chain: &PathChain, low: usize, high: usize, form: u32) -> Option<Segment<N>> {
        let mut vertices = [ChainVertex::NONE; N];
        let len = high - low + 1;
        if len > N {
            return None;
        }
        vertices[..len].copy_from_slice(&chain.vertices[low..=high]);
        for end in [0, len - 1] {
            if vertices[end].is_inner() {
                vertices[end].kind = vertex_kind::PINNED_POSITION;
            }
        }
        let jacobian = ChainJacobian::new(&vertices, len, form);
        jacobian
            .is_regular()
            .then_some(Segment { vertices, jacobian })
    }

    /// Number of vertices.
    pub fn count(&self) -> usize {
        self.jacobian.len
    }
}

/// An end of a segment that has moved.
#[derive(Clone, Copy)]
pub enum MovedEnd {
    /// The one towards the light.
    Low(ChainVertex),
    /// The one towards the sensor.
    High(ChainVertex),
}

/// Which walk finds the vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// All vertices are predicted at once ([`walk`]).
    HalfVectors,
    /// One end follows the transfer matrix ([`explore`]); at ends without a position it is the other.
    Exploration,
}

/// The vertices with the half vectors `target` between the given ends, if the walk finds them.
pub fn reconnect<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    old: &Segment<N>,
    moved: Option<MovedEnd>,
    target: &[Vec2; N],
    method: Method,
    options: &WalkOptions,
    counts: &mut WalkCounts,
) -> Option<[ChainVertex; N]> {
    let len = old.count();
    counts.walks += 1;
    let start = with_end(&old.vertices, len, moved);
    let there = if explores(&start, len, method) {
        explore(view, &start, len, target, options)
    } else if moved.is_none() {
        walk(view, &start, &old.jacobian, target, options)
    } else {
        let jacobian = ChainJacobian::new(&start, len, options.form);
        walk(view, &start, &jacobian, target, options)
    };
    counts.iterations += u64::from(there.iterations);
    // A walk of no iterations has not looked at the edges of a new end.
    if !there.is_converged() || moved.is_some() && there.iterations == 0 {
        return None;
    }
    counts.found += 1;
    counts.iterations_of_found += u64::from(there.iterations);
    Some(there.vertices)
}

/// Whether the walk from `found` to the half vectors `back` leads back to the vertices of `old`. `jacobian`: the constraints of
/// `found`, which serve where no end has moved.
pub fn leads_back<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    old: &Segment<N>,
    moved: Option<MovedEnd>,
    found: &[ChainVertex; N],
    jacobian: Option<&ChainJacobian<N>>,
    back: &[Vec2; N],
    method: Method,
    options: &WalkOptions,
    counts: &mut WalkCounts,
) -> bool {
    let len = old.count();
    counts.tested += 1;
    let old_end = moved.map(|end| match end {
        MovedEnd::Low(_) => MovedEnd::Low(old.vertices[0]),
        MovedEnd::High(_) => MovedEnd::High(old.vertices[len - 1]),
    });
    let from = with_end(found, len, old_end);
    let again = if explores(&from, len, method) {
        explore(view, &from, len, back, options)
    } else {
        match jacobian {
            Some(jacobian) if moved.is_none() => walk(view, &from, jacobian, back, options),
            _ => {
                let jacobian = ChainJacobian::new(&from, len, options.form);
                walk(view, &from, &jacobian, back, options)
            }
        }
    };
    let returns =
        again.is_converged() && is_same_path(&again.vertices, &old.vertices, len, options);
    counts.irreversible += u64::from(!returns);
    returns
}

/// The vertices of a segment with an end replaced.
fn with_end<const N: usize>(
    vertices: &[ChainVertex; N],
    len: usize,
    end: Option<MovedEnd>,
) -> [ChainVertex; N] {
    let mut vertices = *vertices;
    match end {
        Some(MovedEnd::Low(x)) => vertices[0] = x,
        Some(MovedEnd::High(x)) => vertices[len - 1] = x,
        None => {}
    }
    vertices
}

/// Whether manifold exploration finds the vertices, which takes ends with positions.
fn explores<const N: usize>(start: &[ChainVertex; N], len: usize, method: Method) -> bool {
    let is_pinned = |x: &ChainVertex| x.kind == vertex_kind::PINNED_POSITION;
    method == Method::Exploration && is_pinned(&start[0]) && is_pinned(&start[len - 1])
}

/// Most projections of a walk, and the smallest part of a Newton step that it tries. Steps are small against lobes, and walks that find
/// a path do so in two or three iterations; with limits of 20 and 1 / 1024 the others took more than half of all iterations, and
/// found one path more of a hundred.
const MOST_ITERATIONS: u32 = 8;
const SMALLEST_STEP: f32 = 1.0 / 8.0;

/// The limits of walks of a path: those of its own size, which is not that of all its surroundings.
pub fn options_of(
    chain: &PathChain,
    is_from_infinity: bool,
    radius: f32,
    form: u32,
) -> WalkOptions {
    let length = chain.length(is_from_infinity);
    // Positions are rounded to the size of the scene.
    let least = 0.02 * radius;
    WalkOptions {
        form,
        max_iterations: MOST_ITERATIONS,
        smallest_step: SMALLEST_STEP,
        ..WalkOptions::new(if length < least {
            least
        } else if length > radius {
            radius
        } else {
            length
        })
    }
}
