//! The part of a path between an end that has moved and one that stays: connected, or found by a walk at given half vectors.

use super::super::algorithm::WalkCounts;
use super::super::veach::candidate::join;
use super::super::veach::{ChainPath, MAX_VERTICES};
use super::path_chain::{PathChain, curved, set_vertex};
use super::reconnection::{Method, MovedEnd, Segment, leads_back, options_of, reconnect};
use crate::manifold::ChainVertex;
use crate::manifold::mutation::{Mutation, density_factor, jump, mutation_kind, test_way_back};
use crate::manifold::walk::WalkOptions;
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

/// Half vectors at which a walk shall find the vertices of `chain` behind vertex `low`: those that they have, zero at discrete events
/// and before. None where one has no half vector.
pub fn held(path: &ChainPath, chain: &PathChain, low: usize, form: u32) -> Option<HalfVectors> {
    let mut out = HalfVectors::new();
    for _ in 0..=low {
        out.push(Vec2::ZERO);
    }
    for i in low + 1..path.edges() {
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
    /// The same between ends that stay: a walk, or a jump to another sub-manifold where the walk fails.
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
    ) -> Option<Moved<N>> {
        let pair = (&mut *y, &mut *of_y);
        let walked = self.close(tracer, x, chain, Some(segment), pair, None, form, counts);
        if let Some(way_back) = walked {
            return Some(Moved {
                way_back,
                jump: None,
            });
        }
        // A jump leaves the half vectors of discrete events behind.
        let inner = self.low + 1..self.high;
        if !x.vertices[inner.clone()].iter().all(|v| v.is_smooth()) {
            return None;
        }
        let options = self.options(tracer, x, chain, form);
        let (target, from) = (self.cut(self.target), &segment.jacobian);
        let found = jump(tracer.view, &segment.vertices, from, &target, &options);
        if found.kind != mutation_kind::JUMP {
            return None;
        }
        counts.jumps += 1;
        self.set_vertices(tracer, x, (y, of_y), &found.vertices);
        let mut back = HalfVectors::new();
        back.extend(self.back.iter().copied());
        back[inner].copy_from_slice(&found.reverse_target[1..self.high - self.low]);
        // Densities per area of vertices over those per half vectors, the reverse step over the forward step; what the paths carry is per
        // half vectors too.
        let carried = density_factor(&found.jacobian).over(density_factor(from));
        let factor = carried.product(found.reverse_factor.over(found.forward_factor));
        Some(Moved {
            way_back: WayBack::Jump { found, options },
            jump: Some(Jump { back, factor }),
        })
    }

    /// Finds the vertices of `y` between the ends, of which one is not that of `x`, if there are such. What moves stands in the
    /// chain of `y` then, too.
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
    ) -> Option<WayBack<N>> {
        let (low, high) = (self.low, self.high);
        let moved_end = moved.map(|end| match end {
            ClosingEnd::Low => low,
            ClosingEnd::High => high,
        });
        if let Some(i) = moved_end {
            of_y.vertices[i] = end_of(tracer, y, i, chain.vertices[i].reference);
        }
        if high == low + 1 {
            return join(tracer, y, low).then_some(WayBack::Edge);
        }
        let options = self.options(tracer, x, chain, form);
        let moved = moved.map(|end| match end {
            ClosingEnd::Low => MovedEnd::Low(of_y.vertices[low]),
            ClosingEnd::High => MovedEnd::High(of_y.vertices[high]),
        });
        let found = reconnect(
            tracer.view,
            segment?,
            moved,
            &self.cut(self.target),
            self.method,
            &options,
            counts,
        )?;
        self.set_vertices(tracer, x, (y, of_y), &found);
        Some(WayBack::Walk {
            found,
            moved,
            options,
        })
    }

    /// Whether the reverse mutation leads from `y` back to `x`, of which the segments are given.
    pub fn leads_back<T: Traverse, const N: usize>(
        &self,
        tracer: &Tracer<'_, T>,
        [segment, of_y]: [&Segment<N>; 2],
        way_back: &mut WayBack<N>,
        counts: &mut WalkCounts,
    ) -> bool {
        match way_back {
            WayBack::Edge => true,
            WayBack::Walk {
                found,
                moved,
                options,
            } => leads_back(
                tracer.view,
                segment,
                *moved,
                found,
                Some(&of_y.jacobian),
                &self.cut(self.back),
                self.method,
                options,
                counts,
            ),
            WayBack::Jump { found, options } => {
                test_way_back(tracer.view, &segment.vertices, options, found);
                found.kind == mutation_kind::JUMP
            }
        }
    }

    /// Half vectors of the inner vertices.
    fn cut<const N: usize>(&self, all: &[Vec2]) -> [Vec2; N] {
        let mut out = [Vec2::ZERO; N];
        out[1..self.high - self.low].copy_from_slice(&all[self.low + 1..self.high]);
        out
    }

    /// Puts what was found into the path and its chain.
    fn set_vertices<T: Traverse, const N: usize>(
        &self,
        tracer: &Tracer<'_, T>,
        x: &ChainPath,
        (y, of_y): (&mut ChainPath, &mut PathChain),
        found: &[ChainVertex; N],
    ) {
        for i in self.low + 1..self.high {
            y.vertices[i].event = x.vertices[i].event;
            set_vertex(
                &tracer.view.tables,
                &mut y.vertices[i],
                &found[i - self.low],
            );
            of_y.vertices[i] = found[i - self.low];
        }
        clear_edges(y, self.low, self.high);
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

/// How a new path leads back to the old one. That it does is to be shown at last.
#[allow(clippy::large_enum_variant)] // On the stack, for as long as a proposal is looked at; there is no heap here.
pub enum WayBack<const N: usize> {
    /// By an edge that was connected.
    Edge,
    /// By a walk.
    Walk {
        /// The vertices from which it starts.
        found: [ChainVertex; N],
        /// The end that has moved.
        moved: Option<MovedEnd>,
        /// Limits.
        options: WalkOptions,
    },
    /// By a jump, where a walk fails.
    Jump {
        /// The jump that has led here.
        found: Mutation<N>,
        /// Limits of the walk.
        options: WalkOptions,
    },
}

/// A new path between ends that stay.
pub struct Moved<const N: usize> {
    /// How it leads back.
    pub way_back: WayBack<N>,
    /// Set if a jump has led there.
    pub jump: Option<Jump>,
}

/// What a jump does to the ratio of the acceptance.
pub struct Jump {
    /// Half vectors that lead back, of all vertices of the path.
    pub back: HalfVectors,
    /// What the ratio gets in addition to that of a walk with those half vectors.
    pub factor: Scaled,
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
