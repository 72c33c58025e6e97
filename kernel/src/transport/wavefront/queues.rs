//! Shading queues: paths sorted by the code that shades them.
//!
//! One queue holds the paths that escaped, one those that are shaded path by path (the fallback), and two each BSDF variant,
//! without and with textures. Each queue occupies a segment of the slots that begins at a vector.

use super::bsdf_variant;
use super::paths::{PathLanes, QueuedPaths};
use super::segment::Segment;
use crate::math::field;
use crate::scene::{HitBatch, NONE, Tables, material_flag, quadric_kind};
use crate::simd::lanes::{VECTOR_WIDTH, round_up_to_vector};
use crate::simd::{SimdLevel, multiversioned};
use crate::transport::settings::IntegratorSettings;
use bytemuck::Zeroable;

/// Paths whose ray meets nothing.
pub(super) const ESCAPED: usize = 0;
/// Paths that are shaded one by one.
pub(super) const FALLBACK: usize = 1;
/// The first queue of paths that meet a triangle or a sphere of the world whose material is a BSDF variant; see [`queue_of`].
const VARIANTS: u32 = 2;
/// Number of queues.
pub(super) const COUNT: usize = (VARIANTS + 2 * bsdf_variant::COUNT) as usize;
/// Instead of a queue: paths that end here and gain nothing.
const NO_QUEUE: u32 = COUNT as u32;
/// Added to the queue of paths that meet a sphere: their slots follow those of the triangles.
const AT_SPHERE: u32 = 32;

const _: () = assert!(NO_QUEUE < AT_SPHERE);

/// The queue of a BSDF variant.
pub(super) const fn queue_of(variant: u32, is_textured: bool) -> usize {
    (VARIANTS + 2 * variant) as usize + is_textured as usize
}

/// What the rays of the first `count` paths have met.
#[derive(Clone, Copy)]
pub(super) struct TracedPaths<'a, const N: usize> {
    pub paths: &'a PathLanes<N>,
    pub hits: &'a HitBatch<N>,
    pub count: usize,
    /// Whether shiny variants are shaded one by one, too.
    pub has_no_shiny_loops: bool,
}

/// The queues of paths, before their slots are assigned.
#[repr(C, align(64))]
#[derive(Zeroable)]
struct Classification<const N: usize> {
    /// The queue of each path.
    queue: [u32; N],
    /// 1 where the surface emits.
    emits: [u32; N],
    /// Which queues have paths at triangles, and which at spheres, as bits.
    present: [u32; 2],
}

/// The slots of all queues.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct ShadingQueues<const N: usize> {
    classification: Classification<N>,
    /// The path in each slot.
    pub entries: [u32; N],
    pub segments: [Segment; COUNT],
    /// The part of each segment whose paths are at spheres.
    pub spheres: [Segment; COUNT],
}

impl<const N: usize> ShadingQueues<N> {
    /// The most paths that are sure to find slots, however they are distributed over the queues.
    pub const fn capacity() -> usize {
        let shared = N.saturating_sub((VECTOR_WIDTH - 1) * COUNT);
        if shared > N / VECTOR_WIDTH {
            shared
        } else {
            N / VECTOR_WIDTH
        }
    }

    /// The paths of a queue.
    #[inline]
    pub fn queued<'a>(&'a self, queue: usize, paths: &'a PathLanes<N>) -> QueuedPaths<'a, N> {
        QueuedPaths {
            paths,
            entries: &self.entries,
            segment: self.segments[queue],
        }
    }

    /// Whether path `i` meets light that is weighted against emitter samples, or passes on what it is weighted by.
    pub fn meets_light(&self, i: usize, has_environment: bool) -> bool {
        match self.classification.queue[i] as usize {
            ESCAPED => has_environment,
            FALLBACK => true,
            _ => self.classification.emits[i] != 0,
        }
    }

    /// Sorts the paths into queues.
    pub fn sort(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        traced: &TracedPaths<'_, N>,
    ) {
        let classify = match tables.quadrics {
            [] => classify::<false, N>,
            _ => classify::<true, N>,
        };
        classify(simd, tables, settings, traced, &mut self.classification);
        let queues = &self.classification.queue[..traced.count.min(N)];
        let present = self.classification.present;
        self.segments = [Segment::NONE; COUNT];
        self.spheres = [Segment::NONE; COUNT];
        let mut first = 0;
        for queue in 0..COUNT as u32 {
            let mut next = first;
            let is_present = present.map(|queues| queues & (1 << queue) != 0);
            if is_present[0] {
                next = collect(queues, queue, &mut self.entries, next);
            }
            if is_present[1] {
                let end = collect(queues, queue + AT_SPHERE, &mut self.entries, next);
                self.spheres[queue as usize] = Segment::between(next, end);
                next = end;
            }
            self.segments[queue as usize] = Segment::between(first, next);
            first = next.next_multiple_of(VECTOR_WIDTH);
        }
    }
}

/// Writes the paths of a queue to `entries` from slot `next` on; returns the slot behind them.
fn collect<const N: usize>(
    queues: &[u32],
    queue: u32,
    entries: &mut [u32; N],
    mut next: usize,
) -> usize {
    // Without a branch on the queue: the slot behind the last entry is overwritten again and again.
    for (i, &of) in queues.iter().enumerate() {
        if next < N {
            entries[next] = i as u32;
        }
        next += usize::from(of == queue);
    }
    next.min(N)
}

multiversioned! {
    /// The queue of each path, plus [`AT_SPHERE`] at spheres; with `QUADRICS` if the scene has any.
    fn classify<; const QUADRICS: bool, const N: usize>(
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        traced: &TracedPaths<'_, N>,
        classification: &mut Classification<N>,
    ) {
        let (mut present, mut present_at_spheres) = (0, 0);
        let (paths, hits) = (traced.paths, traced.hits);
        let triangle_count = tables.triangles.len() as u32;
        let is_strict = settings.rules.strict_normals != 0;
        // From there on they are shiny.
        let end = if traced.has_no_shiny_loops { bsdf_variant::CONDUCTOR } else { bsdf_variant::COUNT };
        let hides = settings.rules.hide_emitters != 0;
        for i in 0..round_up_to_vector::<N>(traced.count) {
            let primitive = hits.primitive[i];
            let mut shape = field(tables.triangles, primitive, |t| t.shape);
            let mut is_sphere = false;
            if QUADRICS {
                let quadric = primitive.wrapping_sub(triangle_count);
                is_sphere = (primitive >= triangle_count)
                    & (quadric < tables.quadrics.len() as u32)
                    & (field(tables.quadrics, quadric, |q| q.kind) == quadric_kind::SPHERE);
                let of_sphere = field(tables.quadrics, quadric, |q| q.shape);
                shape = if is_sphere { of_sphere } else { shape };
            }
            let material = field(tables.shapes, shape, |s| s.material);
            let flags = field(tables.materials, material, |m| m.flags);
            let variant = bsdf_variant::of_material(flags);
            let is_textured = (flags & material_flag::TEXTURED != 0) as u32;
            let may_scatter = paths.depth[i].wrapping_add(1) < settings.rules.max_depth;
            let emits = field(tables.shapes, shape, |s| s.emitter) != NONE;
            let is_in_world =
                ((primitive < triangle_count) | is_sphere) & (hits.instance[i] == 0);
            let has_loop = is_in_world
                & (variant < end)
                & !is_strict
                & !(emits & (hides | !may_scatter));
            let queue = if has_loop {
                VARIANTS + 2 * variant + is_textured
            } else {
                FALLBACK as u32
            };
            let is_mask = flags & material_flag::HAS_NULL != 0;
            let ends = is_in_world & !may_scatter & !emits & !is_mask;
            let queue = if ends { NO_QUEUE } else { queue };
            let queue = if hits.t[i] < f32::MAX { queue } else { ESCAPED as u32 };
            let at_sphere = is_sphere & (queue >= VARIANTS);
            classification.emits[i] = u32::from(emits);
            classification.queue[i] = if at_sphere { queue + AT_SPHERE } else { queue };
            present |= if at_sphere { 0 } else { 1 << queue };
            present_at_spheres |= if at_sphere { 1 << queue } else { 0 };
        }
        classification.present = [present, present_at_spheres];
    }
}
