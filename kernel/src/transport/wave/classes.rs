//! Which paths of a wave take the same way through the code.

use super::super::IntegratorSettings;
use super::form;
use super::paths::PathLanes;
use super::segment::Segment;
use crate::math::lanes::{VECTOR, whole};
use crate::math::vectors::{Vectors, over_lanes};
use crate::math::{element, field};
use crate::scene::{HitBatch, NONE, Tables, material_flag};
use bytemuck::Zeroable;

/// Paths whose ray meets nothing.
pub(super) const ESCAPING: u32 = 0;
/// Paths of which each takes the way of a single one.
pub(super) const GENERAL: u32 = 1;
/// The first class of paths that scatter at a triangle of the world with a plain material; see [`plain`].
const PLAIN: u32 = 2;
/// Number of classes.
pub(super) const CLASSES: usize = (PLAIN + 2 * form::COUNT) as usize;
/// Paths that end without anything to gather.
const ENDING: u32 = CLASSES as u32;

/// The class of plain materials of a form.
pub(super) const fn plain(form: u32, is_textured: bool) -> u32 {
    PLAIN + 2 * form + is_textured as u32
}

/// Slots in the order of classes.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct Classes<const N: usize> {
    class: [u32; N],
    /// The path in each slot.
    pub list: [u32; N],
    pub segments: [Segment; CLASSES],
}

impl<const N: usize> Classes<N> {
    /// The most paths that surely find slots.
    pub const fn capacity() -> usize {
        let shared = N.saturating_sub((VECTOR - 1) * CLASSES);
        if shared > N / VECTOR {
            shared
        } else {
            N / VECTOR
        }
    }

    /// Sorts the first `count` paths by class.
    pub fn sort(
        &mut self,
        vectors: Vectors,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        paths: &PathLanes<N>,
        hits: &HitBatch<N>,
        count: usize,
    ) {
        classify(
            vectors,
            tables,
            settings,
            paths,
            hits,
            count,
            &mut self.class,
        );
        let mut counts = [0u32; CLASSES + 1];
        for i in 0..count.min(N) {
            counts[(self.class[i] as usize).min(CLASSES)] += 1;
        }
        let mut next = [0u32; CLASSES + 1];
        let mut first = 0;
        for class in 0..CLASSES {
            next[class] = first as u32;
            let count = counts[class] as usize;
            self.segments[class] = Segment { first, count };
            first += count.next_multiple_of(VECTOR);
        }
        for i in 0..count.min(N) {
            let class = (self.class[i] as usize).min(CLASSES);
            let slot = next[class] as usize;
            if class < CLASSES && slot < N {
                self.list[slot] = i as u32;
                next[class] += 1;
            }
        }
    }
}

over_lanes! {
    /// The class of each path.
    fn classify<; const N: usize>(
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        paths: &PathLanes<N>,
        hits: &HitBatch<N>,
        count: usize,
        classes: &mut [u32; N],
    ) {
        let triangle_count = tables.triangles.len() as u32;
        let is_strict = settings.strict_normals != 0;
        let hides = settings.hide_emitters != 0;
        for i in 0..whole::<N>(count) {
            let triangle = element(tables.triangles, hits.primitive[i]);
            let shape = element(tables.shapes, triangle.shape);
            let material = element(tables.materials, shape.material);
            let lobe = material.first_lobe;
            let kind = field(tables.lobes, lobe, |l| l.kind);
            let form = form::of(kind, field(tables.lobes, lobe, |l| l.distribution));
            let is_textured = (material.flags & material_flag::TEXTURED != 0) as u32;
            let goes_on = paths.depth[i].wrapping_add(1) < settings.max_depth;
            let is_lit = shape.emitter != NONE;
            let is_here = (hits.primitive[i] < triangle_count) & (hits.instance[i] == 0);
            let is_plain = is_here
                & (material.flags & material_flag::PLAIN != 0)
                & (form < form::COUNT)
                & !is_strict
                & !(is_lit & (hides | !goes_on));
            let class = if is_plain {
                PLAIN + 2 * form + is_textured
            } else {
                GENERAL
            };
            let ends = is_here & !goes_on & !is_lit;
            let class = if ends { ENDING } else { class };
            classes[i] = if hits.t[i] < f32::MAX { class } else { ESCAPING };
        }
    }
}
