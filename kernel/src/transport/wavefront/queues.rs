//! Which paths of a wave take the same way through the code.

use super::super::IntegratorSettings;
use super::bsdf_variant;
use super::paths::PathLanes;
use super::segment::Segment;
use crate::math::field;
use crate::scene::{HitBatch, NONE, Tables, material_flag, quadric_kind};
use crate::simd::lanes::{VECTOR_WIDTH, round_up_to_vector};
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;

/// Paths whose ray meets nothing.
pub(super) const ESCAPING: u32 = 0;
/// Paths of which each takes the way of a single one.
pub(super) const GENERAL: u32 = 1;
/// The first class of paths that scatter at a triangle or a sphere of the world with a plain material; see [`plain`].
const PLAIN: u32 = 2;
/// Number of classes.
pub(super) const CLASSES: usize = (PLAIN + 2 * bsdf_variant::COUNT) as usize;
/// Paths that end without anything to gather.
const ENDING: u32 = CLASSES as u32;

/// Added to the class of paths at spheres, which come behind the others.
const AT_SPHERE: u32 = 32;

const _: () = assert!(ENDING < AT_SPHERE);

/// The class of plain materials of a form.
pub(super) const fn plain(variant: u32, is_textured: bool) -> u32 {
    PLAIN + 2 * variant + is_textured as u32
}

/// Slots in the order of classes.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct Classes<const N: usize> {
    class: [u32; N],
    /// The path in each slot.
    pub list: [u32; N],
    pub segments: [Segment; CLASSES],
    /// The part of each segment whose paths are at spheres.
    pub spheres: [Segment; CLASSES],
}

impl<const N: usize> Classes<N> {
    /// The most paths that surely find slots.
    pub const fn capacity() -> usize {
        let shared = N.saturating_sub((VECTOR_WIDTH - 1) * CLASSES);
        if shared > N / VECTOR_WIDTH {
            shared
        } else {
            N / VECTOR_WIDTH
        }
    }

    /// Sorts the first `count` paths by class.
    pub fn sort(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        paths: &PathLanes<N>,
        hits: &HitBatch<N>,
        count: usize,
    ) {
        let classify = match tables.quadrics {
            [] => classify::<false, N>,
            _ => classify::<true, N>,
        };
        let mut present = [0; 2];
        classify(
            simd,
            tables,
            settings,
            paths,
            hits,
            count,
            &mut self.class,
            &mut present,
        );
        let of = &self.class[..count.min(N)];
        self.segments = [Segment::NONE; CLASSES];
        self.spheres = [Segment::NONE; CLASSES];
        let mut first = 0;
        for class in 0..CLASSES as u32 {
            let mut next = first;
            let is_present = present.map(|classes| classes & (1 << class) != 0);
            if is_present[0] {
                next = collect(of, class, &mut self.list, next);
            }
            if is_present[1] {
                let behind = collect(of, class + AT_SPHERE, &mut self.list, next);
                self.spheres[class as usize] = Segment::between(next, behind);
                next = behind;
            }
            self.segments[class as usize] = Segment::between(first, next);
            first = next.next_multiple_of(VECTOR_WIDTH);
        }
    }
}

/// Lists the indices of what is of a class, from place `next` of the list on; returns the place behind them.
fn collect<const N: usize>(
    classes: &[u32],
    class: u32,
    list: &mut [u32; N],
    mut next: usize,
) -> usize {
    // Without a branch on what comes when: the place behind the last is written again and again.
    for (i, &of) in classes.iter().enumerate() {
        if next < N {
            list[next] = i as u32;
        }
        next += usize::from(of == class);
    }
    next.min(N)
}

multiversioned! {
    /// The class of each path, and which there are, as bits, first without [`AT_SPHERE`]; with `QUADRICS` if the scene has any.
    fn classify<; const QUADRICS: bool, const N: usize>(
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        paths: &PathLanes<N>,
        hits: &HitBatch<N>,
        count: usize,
        classes: &mut [u32; N],
        present: &mut [u32; 2],
    ) {
        let (mut found, mut found_spheres) = (0, 0);
        let triangle_count = tables.triangles.len() as u32;
        let is_strict = settings.strict_normals != 0;
        let hides = settings.hide_emitters != 0;
        for i in 0..round_up_to_vector::<N>(count) {
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
            let continues = paths.depth[i].wrapping_add(1) < settings.max_depth;
            let is_lit = field(tables.shapes, shape, |s| s.emitter) != NONE;
            let is_here =
                ((primitive < triangle_count) | is_sphere) & (hits.instance[i] == 0);
            let is_plain = is_here
                & (variant < bsdf_variant::COUNT)
                & !is_strict
                & !(is_lit & (hides | !continues));
            let class = if is_plain {
                PLAIN + 2 * variant + is_textured
            } else {
                GENERAL
            };
            let ends = is_here & !continues & !is_lit;
            let class = if ends { ENDING } else { class };
            let class = if hits.t[i] < f32::MAX { class } else { ESCAPING };
            let is_apart = is_sphere & (class >= PLAIN);
            classes[i] = if is_apart { class + AT_SPHERE } else { class };
            found |= if is_apart { 0 } else { 1 << class };
            found_spheres |= if is_apart { 1 << class } else { 0 };
        }
        *present = [found, found_spheres];
    }
}
