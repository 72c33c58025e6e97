//! The part of a path between an end that has moved and one that stays: connected, or found by a walk at given half vectors.

use super::super::algorithm::WalkCounts;
use super::super::veach::candidate::join;
use super::super::veach::{ChainPath, MAX_VERTICES};
use super::path_chain::{PathChain, curved, set_vertex};
use super::reconnection::{Method, MovedEnd, Segment, options_of, reconnect};
use crate::manifold::mutation::{density_factor, mutate, mutation_kind};
use crate::manifold::walk::WalkOptions;
use crate::manifold::{ChainJacobian, ChainVertex};
use crate::math::scaled::Scaled;
use crate::path::full_path::vertex::Edge;
use crate::path::tracer::Tracer;
use crate::scene::Traverse;
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

/// Capacities of segments, chosen by their length: what is copied in a walk grows with them.
macro_rules! with_capacity {
    ($len:expr, $n:ident => $body:expr) => {{
        let len: usize = $len;
        if len <= 4 {
            const $n: usize = 4;
            $body
        } else if len <= 8 {
            const $n: usize = 8;
            $body
        } else {
            const $n: usize = crate::transport::markov::veach::MAX_VERTICES;
            $body
        }
    }};
}
pub(super) use with_capacity;

/// Half vectors of the vertices of a path.
pub type HalfVectors = ArrayVec<Vec2, MAX_VERTICES>;

/// Half vectors at which a walk shall find all vertices of `chain`: those that it has, zero at discrete events. None where one has
/// no half vector.
pub fn held(path: &ChainPath, chain: &PathChain, form: u32) -> Option<HalfVectors> {
    let mut out = HalfVectors::new();
    out.push(Vec2::ZERO);
    for i in 1..path.edges() {
        let h = chain.half_vector(i, form);
        out.push(match h {
            // A path whose chain cannot be rebuilt is left to other mutations.
            Some(h) if !path.vertices[i].is_smooth() => {
                if !(h.length_squared() < LARGEST_DRIFT * LARGEST_DRIFT) {
                    return None;
                }
                Vec2::ZERO
            }
            Some(h) => h,
            None => return None,
        });
    }
    out.push(Vec2::ZERO);
    Some(out)
}

/// Half vectors of discrete events are this far off the normal at most: farther off, the event has another normal than the surface.
const LARGEST_DRIFT: f32 = 5e-3;

/// Which part of a path is closed, and how.
#[derive(Clone, Copy)]
pub struct Closing<'a> {
    /// Index of its first vertex, towards the light.
    pub low: usize,
    /// Index of its last vertex.
    pub high: usize,
    /// Half vectors of all vertices of the new path.
    pub target: &'a [Vec2],
    /// Those of the old path.
    pub back: &'a [Vec2],
    /// Which walk.
    pub method: Method,
    /// Where its projections start: one of [`walk_start`](crate::manifold::walk::walk_start).
    pub start: u32,
}

impl Closing<'_> {
    /// The same between ends that stay: a walk, or a jump to another sub-manifold where walks fail in both directions.
    #[allow(clippy::too_many_arguments)]
    pub fn move_or_jump<T: Traverse, const N: usize>(
        &self,
        tracer: &Tracer<'_, T>,
        x: &ChainPath,
        chain: &PathChain,
        segment: &Segment<N>,
        (y, of_y): (&mut ChainPath, &mut PathChain),
        form: u32,
        counts: &mut WalkCounts,
    ) -> Moved {
        let tables = &tracer.view.tables;
        let (low, high) = (self.low, self.high);
        // A jump leaves the half vectors of discrete events behind.
        let inner = low + 1..high;
        if !x.vertices[inner.clone()].iter().all(|v| v.is_smooth()) {
            let is_found = self.close(
                tracer,
                x,
                chain,
                Some(segment),
                (y, of_y),
                None,
                form,
                counts,
            );
            return if is_found {
                Moved::Walk
            } else {
                Moved::Nowhere
            };
        }
        let options = self.options(tracer, x, chain, form);
        let mut target = [Vec2::ZERO; N];
        target[1..high - low].copy_from_slice(&self.target[inner.clone()]);
        let from = &segment.jacobian;
        let found = mutate(tracer.view, &segment.vertices, from, &target, &options);
        counts.walks += 1;
        counts.iterations += u64::from(found.iterations);
        if found.kind == mutation_kind::WALK || found.kind == mutation_kind::NOT_REVERSIBLE {
            counts.found += 1;
            counts.iterations_of_found += u64::from(found.iterations);
        }
        counts.irreversible += u64::from(found.kind == mutation_kind::NOT_REVERSIBLE);
        if found.kind != mutation_kind::WALK && found.kind != mutation_kind::JUMP {
            return Moved::Nowhere;
        }
        for i in inner.clone() {
            y.vertices[i].event = x.vertices[i].event;
            set_vertex(tables, &mut y.vertices[i], &found.vertices[i - low]);
            of_y.vertices[i] = found.vertices[i - low];
        }
        clear_edges(y, low, high);
        if found.kind == mutation_kind::WALK {
            return Moved::Walk;
        }
        counts.jumps += 1;
        let mut back = HalfVectors::new();
        back.extend(self.back.iter().copied());
        back[inner].copy_from_slice(&found.reverse_target[1..high - low]);
        // Densities per area of vertices over those per half vectors, the reverse step over the forward step; what the paths carry is per
        // half vectors too.
        let per_area = |j: &ChainJacobian<N>| density_factor(j);
        let carried = per_area(&found.jacobian).over(per_area(from));
        let factor = found.reverse_factor.over(found.forward_factor);
        Moved::Jump {
            back,
            factor: carried.product(factor),
        }
    }

    /// Finds the vertices of `y` between the ends, of which one is not that of `x`; returns whether there are such. What moves
    /// stands in the chain of `y` then, too.
    #[allow(clippy::too_many_arguments)]
    pub fn close<T: Traverse, const N: usize>(
        &self,
        tracer: &Tracer<'_, T>,
        x: &ChainPath,
        chain: &PathChain,
        segment: Option<&Segment<N>>,
        (y, of_y): (&mut ChainPath, &mut PathChain),
        moved: Option<ClosingEnd>,
        form: u32,
        counts: &mut WalkCounts,
    ) -> bool {
        let tables = &tracer.view.tables;
        let (low, high) = (self.low, self.high);
        let moved_end = moved.map(|end| match end {
            ClosingEnd::Low => low,
            ClosingEnd::High => high,
        });
        if let Some(i) = moved_end {
            of_y.vertices[i] = end_of(tracer, y, i, chain.vertices[i].reference);
        }
        if high == low + 1 {
            return join(tracer, y, low);
        }
        let Some(segment) = segment else {
            return false;
        };
        let options = self.options(tracer, x, chain, form);
        let end = moved.map(|end| match end {
            ClosingEnd::Low => MovedEnd::Low(of_y.vertices[low]),
            ClosingEnd::High => MovedEnd::High(of_y.vertices[high]),
        });
        let cut = |all: &[Vec2]| {
            let mut out = [Vec2::ZERO; N];
            out[1..high - low].copy_from_slice(&all[low + 1..high]);
            out
        };
        let found = reconnect(
            tracer.view,
            segment,
            end,
            [&cut(self.target), &cut(self.back)],
            self.method,
            &options,
            counts,
        );
        let Some(found) = found else {
            return false;
        };
        for i in low + 1..high {
            y.vertices[i].event = x.vertices[i].event;
            set_vertex(tables, &mut y.vertices[i], &found[i - low]);
            of_y.vertices[i] = found[i - low];
        }
        clear_edges(y, low, high);
        true
    }

    /// Limits of its walks.
    pub fn options<T: Traverse>(
        &self,
        tracer: &Tracer<'_, T>,
        x: &ChainPath,
        chain: &PathChain,
        form: u32,
    ) -> WalkOptions {
        let tables = &tracer.view.tables;
        WalkOptions {
            start: self.start,
            ..options_of(chain, x.is_infinite(tables), tables.info.radius, form)
        }
    }
}

/// What has become of a part of a path between ends that stay.
#[allow(clippy::large_enum_variant)] // On the stack, for as long as a proposal is looked at; there is no heap here.
pub enum Moved {
    /// There is no new path.
    Nowhere,
    /// A reversible walk has led to the new path.
    Walk,
    /// A jump.
    Jump {
        /// Half vectors that lead back, of all vertices of the path.
        back: HalfVectors,
        /// What the ratio of the acceptance gets in addition to that of a walk with those half vectors.
        factor: Scaled,
    },
}

/// Which end has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosingEnd {
    /// The one towards the light.
    Low,
    /// The one towards the sensor.
    High,
}

/// A vertex of a path as the end of a segment.
fn end_of<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &ChainPath,
    i: usize,
    reference: Vec3,
) -> ChainVertex {
    let point = curved(&tracer.view.tables, &path.vertices[i].point);
    ChainVertex::from_surface_with(&point, reference)
}

/// Segments that walks have found pass through no masks.
pub fn clear_edges(path: &mut ChainPath, low: usize, high: usize) {
    for vertex in &mut path.vertices[low..high] {
        vertex.edge = Edge::CLEAR;
    }
}
