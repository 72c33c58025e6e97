//! The walk over eight-wide compressed nodes (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs").
//!
//! The whole walk is compiled twice on x86-64, for every processor and for those with AVX2, which is looked up once when
//! the traverser is made. Many rays at once take the walk in lockstep (`super::stream`) where there is AVX-512.

use super::build::MAX_WIDE_DEPTH;
use super::single::lanes::Lanes;
#[cfg(not(target_arch = "x86_64"))]
use super::single::lanes::Portable;
#[cfg(target_arch = "x86_64")]
use super::single::lanes::{Avx2, Sse2};
use super::{Accel, Group};
use crate::processor::simd_level;
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::scene::intersect::{intersect_quadric, is_traceable};
use halflight_kernel::scene::traverse::{REACH, are_occluded_in_turn, closest_hits_in_turn};
use halflight_kernel::scene::{Hit, HitBatch, RayBatch, Tables, Traverse};
use halflight_kernel::simd::SimdLevel;
use std::mem::MaybeUninit;

/// Nodes that wait: of each node on the way down at most seven children, and all eight of the last.
const STACK_SIZE: usize = 7 * MAX_WIDE_DEPTH + 1;

/// The ray tracer over an [`Accel`].
#[derive(Clone, Copy)]
pub struct CpuTraverse<'a> {
    pub(super) accel: &'a Accel,
    pub(super) tables: Tables<'a>,
    #[cfg(target_arch = "x86_64")]
    has_avx2: bool,
    simd: SimdLevel,
}

/// The nearest hit so far.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub hit: Hit,
    /// Where the search ends: a little beyond the hit.
    pub t_max: f32,
}

impl Nearest {
    /// Keeps a hit if it comes first; whether it does.
    #[inline(always)]
    pub fn keep(&mut self, hit: Hit) -> bool {
        let is_first = self.hit.is_behind(hit.t, hit.primitive, hit.instance);
        if is_first {
            self.t_max = hit.t * REACH;
            self.hit = hit;
        }
        is_first
    }
}

impl<'a> CpuTraverse<'a> {
    pub(super) fn new(accel: &'a Accel, tables: Tables<'a>) -> CpuTraverse<'a> {
        CpuTraverse {
            accel,
            tables,
            #[cfg(target_arch = "x86_64")]
            has_avx2: is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            simd: simd_level(),
        }
    }

    /// The nearest hit, or with `ANY` whichever comes first.
    #[inline(always)]
    fn trace<T: Lanes, const ANY: bool>(&self, ray: &Ray) -> Hit {
        let mut nearest = Nearest {
            hit: Hit::MISS,
            t_max: ray.t_max,
        };
        if !is_traceable(ray) {
            return nearest.hit;
        }
        let world = T::ray(ray.origin, ray.direction, ray.t_min);
        let group = &self.accel.groups[0];
        if group.is_mixed {
            walk::<T, ANY, true>(group, &world, 0, &mut nearest, |slot, nearest| {
                self.other::<T, ANY, true>(group, slot, ray, ray, 0, nearest)
            });
        } else {
            walk::<T, ANY, false>(group, &world, 0, &mut nearest, |_, _| false);
        }
        nearest.hit
    }

    /// One entry of a leaf that is not a triangle, with the ray in the group's space; true stops the walk.
    #[inline(always)]
    fn other<T: Lanes, const ANY: bool, const WORLD: bool>(
        &self,
        group: &Group,
        slot: usize,
        local: &Ray,
        ray: &Ray,
        instance: u32,
        nearest: &mut Nearest,
    ) -> bool {
        let primitive = group.places[slot].primitive();
        let triangles = self.tables.triangles.len();
        if (primitive as usize) < triangles {
            return false;
        }
        let index = primitive as usize - triangles;
        if index < self.tables.quadrics.len() {
            let quadric = &self.tables.quadrics[index];
            let t = intersect_quadric(
                quadric.kind,
                transform_point(&quadric.to_object, local.origin),
                transform_vector(&quadric.to_object, local.direction),
                local.t_min,
                nearest.t_max,
            );
            let is_first = nearest.keep(Hit {
                t,
                b1: 0.0,
                b2: 0.0,
                primitive,
                instance,
            });
            return ANY && is_first;
        }
        if WORLD {
            let instance = index - self.tables.quadrics.len();
            return self.enter::<T, ANY>(instance, ray, nearest);
        }
        false
    }

    /// An instance: the walk of its group.
    #[inline(always)]
    fn enter<T: Lanes, const ANY: bool>(
        &self,
        instance: usize,
        ray: &Ray,
        nearest: &mut Nearest,
    ) -> bool {
        let record = &self.tables.instances[instance];
        let group = &self.accel.groups[record.group as usize];
        let origin = transform_point(&record.to_object, ray.origin);
        let direction = transform_vector(&record.to_object, ray.direction);
        let mut local = *ray;
        (local.origin, local.direction) = (origin, direction);
        if !is_traceable(&local) {
            return false;
        }
        let prepared = T::ray(origin, direction, ray.t_min);
        let instance = instance as u32;
        walk::<T, ANY, true>(group, &prepared, instance, nearest, |slot, nearest| {
            self.other::<T, ANY, false>(group, slot, &local, ray, instance, nearest)
        })
    }
}

#[cfg(target_arch = "x86_64")]
impl CpuTraverse<'_> {
    #[target_feature(enable = "avx2,fma")]
    fn closest_avx2(&self, ray: &Ray) -> Hit {
        self.trace::<Avx2, false>(ray)
    }

    /// One entry of a leaf of the world that is not a triangle.
    #[target_feature(enable = "avx2,fma")]
    pub(super) fn test_other<const ANY: bool>(
        &self,
        group: &Group,
        place: usize,
        ray: &Ray,
        nearest: &mut Nearest,
    ) {
        self.other::<Avx2, ANY, true>(group, place, ray, ray, 0, nearest);
    }

    #[target_feature(enable = "avx2,fma")]
    fn any_avx2(&self, ray: &Ray) -> Hit {
        self.trace::<Avx2, true>(ray)
    }
}

#[cfg(target_arch = "x86_64")]
impl Traverse for CpuTraverse<'_> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        if self.has_avx2 {
            // SAFETY: the processor has the features.
            unsafe { self.closest_avx2(ray) }
        } else {
            self.trace::<Sse2, false>(ray)
        }
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        if self.has_avx2 {
            // SAFETY: the processor has the features.
            unsafe { self.any_avx2(ray) }.is_hit()
        } else {
            self.trace::<Sse2, true>(ray).is_hit()
        }
    }

    fn closest_hits<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        if self.simd.has_avx512() {
            // SAFETY: the processor has the features (`processor_vectors`).
            return unsafe { self.lockstep::<false, N>(rays, count, hits) };
        }
        closest_hits_in_turn(self, rays, count, hits);
    }

    fn are_occluded<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        if self.simd.has_avx512() {
            // SAFETY: the processor has the features (`processor_vectors`).
            return unsafe { self.lockstep::<true, N>(rays, count, hits) };
        }
        are_occluded_in_turn(self, rays, count, hits);
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Traverse for CpuTraverse<'_> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        self.trace::<Portable, false>(ray)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.trace::<Portable, true>(ray).is_hit()
    }
}

/// Visits the leaves that the ray meets before `nearest`, near nodes first unless with `ANY`. Triangles are tested here,
/// what else a `MIXED` group holds by `other`, which returns true to stop. Whether the walk was stopped.
#[inline(always)]
fn walk<T: Lanes, const ANY: bool, const MIXED: bool>(
    group: &Group,
    ray: &T::Ray,
    instance: u32,
    nearest: &mut Nearest,
    mut other: impl FnMut(usize, &mut Nearest) -> bool,
) -> bool {
    let nodes = &group.nodes[..];
    if nodes.is_empty() {
        return false;
    }
    // Only entries below `size` are ever read; they need not be cleared for every ray.
    let mut stack = [const { MaybeUninit::<(u32, f32)>::uninit() }; STACK_SIZE];
    let mut size = 0;
    let mut node = &nodes[0];
    loop {
        let children = T::children(node, ray, nearest.t_max);
        let leaves = children.places();
        if leaves != 0 {
            let first = node.primitive_base_idx as usize;
            let found = T::nearest(&group.places[first..], leaves, ray, nearest.t_max);
            if found.t < f32::MAX {
                let is_first = nearest.keep(Hit {
                    t: found.t,
                    b1: found.b1,
                    b2: found.b2,
                    primitive: found.primitive,
                    instance,
                });
                if ANY && is_first {
                    return true;
                }
            }
            let mut others = if MIXED { leaves } else { 0 };
            while others != 0 {
                let slot = first + others.trailing_zeros() as usize;
                others &= others - 1;
                if other(slot, nearest) {
                    return true;
                }
            }
        }
        let mut inner = children.inner();
        let bottom = size;
        while inner != 0 {
            let child = inner.trailing_zeros();
            inner &= inner - 1;
            let before = u32::from(node.imask) & ((1 << child) - 1);
            let index = node.child_base_idx + before.count_ones();
            let entry = (index, children.near[child as usize & 7]);
            // Sorted in with the nearest on top; for occlusion any order does.
            let mut at = size;
            while !ANY && at > bottom {
                // SAFETY: entries below `size` have been written.
                let below = unsafe { stack[at - 1].assume_init() };
                if below.1 >= entry.1 {
                    break;
                }
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at].write(entry);
            size += 1;
        }
        loop {
            if size == 0 {
                return false;
            }
            size -= 1;
            // SAFETY: entries below the previous `size` have been written.
            let (index, t) = unsafe { stack[size].assume_init() };
            if t <= nearest.t_max {
                node = &nodes[index as usize];
                break;
            }
        }
    }
}
