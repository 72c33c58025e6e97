//! Walks of a segment of a path to given half vectors, with the test that the reverse walk exists.
//!
//! One end of the segment may have moved before. The walk there starts from the old vertices between the new ends and leads to the
//! target; the walk back starts from what was found, between the old ends, and must lead to the old vertices.

use super::super::algorithm::WalkCounts;
use super::path_chain::PathChain;
use crate::manifold::chain::ChainJacobian;
use crate::manifold::exploration::explore;
use crate::manifold::vertex::{ChainVertex, vertex_kind};
use crate::manifold::walk::{Walk, WalkOptions, is_same_path, walk};
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
        let segment = Segment::of(vertices, len, form);
        segment.jacobian.is_regular().then_some(segment)
    }

    fn of(vertices: [ChainVertex; N], len: usize, form: u32) -> Segment<N> {
        Segment {
            vertices,
            jacobian: ChainJacobian::new(&vertices, len, form),
        }
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

/// The vertices with the half vectors `target` between the given ends, if the walk finds them and finds its way back to those of
/// `old` with the half vectors `back`.
pub fn reconnect<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    old: &Segment<N>,
    moved: Option<MovedEnd>,
    [target, back]: [&[Vec2; N]; 2],
    method: Method,
    options: &WalkOptions,
    counts: &mut WalkCounts,
) -> Option<[ChainVertex; N]> {
    let len = old.count();
    counts.walks += 1;
    let start = match moved {
        None => *old,
        Some(end) => with_end(old, old.vertices, Some(end), options.form),
    };
    let there = solve(view, &start, target, method, options);
    counts.iterations += u64::from(there.iterations);
    // A walk of no iterations has not looked at the edges of a new end.
    if !there.is_converged() || moved.is_some() && there.iterations == 0 {
        return None;
    }
    counts.found += 1;
    counts.iterations_of_found += u64::from(there.iterations);
    let old_end = moved.map(|end| match end {
        MovedEnd::Low(_) => MovedEnd::Low(old.vertices[0]),
        MovedEnd::High(_) => MovedEnd::High(old.vertices[len - 1]),
    });
    let from = with_end(old, there.vertices, old_end, options.form);
    let again = solve(view, &from, back, method, options);
    let returns =
        again.is_converged() && is_same_path(&again.vertices, &old.vertices, len, options);
    counts.irreversible += u64::from(!returns);
    returns.then_some(there.vertices)
}

/// A segment of as many vertices as `old`, with an end replaced.
fn with_end<const N: usize>(
    old: &Segment<N>,
    mut vertices: [ChainVertex; N],
    end: Option<MovedEnd>,
    form: u32,
) -> Segment<N> {
    let len = old.count();
    match end {
        Some(MovedEnd::Low(x)) => vertices[0] = x,
        Some(MovedEnd::High(x)) => vertices[len - 1] = x,
        None => {}
    }
    Segment::of(vertices, len, form)
}

fn solve<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &Segment<N>,
    target: &[Vec2; N],
    method: Method,
    options: &WalkOptions,
) -> Walk<N> {
    let len = start.count();
    let is_pinned = |x: &ChainVertex| x.kind == vertex_kind::PINNED_POSITION;
    let has_positions = is_pinned(&start.vertices[0]) && is_pinned(&start.vertices[len - 1]);
    if method == Method::Exploration && has_positions {
        explore(view, &start.vertices, len, target, options)
    } else {
        walk(view, &start.vertices, &start.jacobian, target, options)
    }
}

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
        ..WalkOptions::new(if length < least {
            least
        } else if length > radius {
            radius
        } else {
            length
        })
    }
}
