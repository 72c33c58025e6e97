//! The walk of a single ray over eight-wide compressed nodes (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs").
//!
//! The whole walk is compiled for each [`InstructionSet`].

#[cfg(target_arch = "x86_64")]
use super::avx2::Avx2;
use super::instruction_set::InstructionSet;
use crate::accel::build::MAX_WIDE_DEPTH;
use crate::accel::trees::Group;
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::scene::intersect::{intersect_quadric, is_traceable};
use halflight_kernel::scene::traverse::REACH;
use halflight_kernel::scene::{Hit, Tables};
use std::mem::MaybeUninit;

/// Nodes on the stack: at most seven children of each node down to the current one, and all eight of that.
const STACK_SIZE: usize = 7 * MAX_WIDE_DEPTH + 1;

/// What rays go through: trees, the world's first, and the tables that they were built over.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// The trees of the groups.
    pub groups: &'a [Group],
    /// The primitives.
    pub tables: Tables<'a>,
}

/// The nearest hit so far.
#[derive(Clone, Copy)]
pub struct Nearest {
    /// The hit.
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

/// A ray in world space and in the space of the group that is walked.
struct GroupRay<'a> {
    world: &'a Ray,
    local: &'a Ray,
    /// The instance of the group; 0 for the world's own.
    instance: u32,
}

impl<'a> GroupRay<'a> {
    /// In the world's own group.
    #[inline(always)]
    fn of_world(ray: &'a Ray) -> GroupRay<'a> {
        GroupRay {
            world: ray,
            local: ray,
            instance: 0,
        }
    }
}

impl World<'_> {
    /// The nearest hit, or with `ANY` whichever comes first.
    #[inline(always)]
    pub fn trace<T: InstructionSet, const ANY: bool>(&self, ray: &Ray) -> Hit {
        let mut nearest = Nearest {
            hit: Hit::MISS,
            t_max: ray.t_max,
        };
        if !is_traceable(ray) {
            return nearest.hit;
        }
        let world = T::ray(ray.origin, ray.direction, ray.t_min);
        let group = &self.groups[0];
        if group.is_mixed {
            let rays = GroupRay::of_world(ray);
            walk::<T, ANY, true>(group, &world, 0, &mut nearest, |slot, nearest| {
                self.other::<T, ANY, true>(group, slot, &rays, nearest)
            });
        } else {
            walk::<T, ANY, false>(group, &world, 0, &mut nearest, |_, _| false);
        }
        nearest.hit
    }

    /// Tests one entry of a leaf that is not a triangle; true stops the walk.
    #[inline(always)]
    fn other<T: InstructionSet, const ANY: bool, const WORLD: bool>(
        &self,
        group: &Group,
        slot: usize,
        ray: &GroupRay<'_>,
        nearest: &mut Nearest,
    ) -> bool {
        let local = ray.local;
        let primitive = group.entries[slot].primitive();
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
                instance: ray.instance,
            });
            return ANY && is_first;
        }
        if WORLD {
            let instance = index - self.tables.quadrics.len();
            return self.enter::<T, ANY>(instance, ray.world, nearest);
        }
        false
    }

    /// An instance: the walk of its group.
    #[inline(always)]
    fn enter<T: InstructionSet, const ANY: bool>(
        &self,
        instance: usize,
        ray: &Ray,
        nearest: &mut Nearest,
    ) -> bool {
        let record = &self.tables.instances[instance];
        let group = &self.groups[record.group as usize];
        let origin = transform_point(&record.to_object, ray.origin);
        let direction = transform_vector(&record.to_object, ray.direction);
        let mut local = *ray;
        (local.origin, local.direction) = (origin, direction);
        if !is_traceable(&local) {
            return false;
        }
        let prepared = T::ray(origin, direction, ray.t_min);
        let instance = instance as u32;
        let rays = GroupRay {
            world: ray,
            local: &local,
            instance,
        };
        walk::<T, ANY, true>(group, &prepared, instance, nearest, |slot, nearest| {
            self.other::<T, ANY, false>(group, slot, &rays, nearest)
        })
    }

    /// One entry of a leaf of the world that is not a triangle, on processors with AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    pub fn test_other_avx2<const ANY: bool>(
        &self,
        group: &Group,
        entry: usize,
        ray: &Ray,
        nearest: &mut Nearest,
    ) {
        self.other::<Avx2, ANY, true>(group, entry, &GroupRay::of_world(ray), nearest);
    }
}

/// Visits the leaves that the ray meets before `nearest`, near nodes first unless with `ANY`. Triangles are tested here,
/// what else a `MIXED` group holds by `other`, which returns true to stop. Whether the walk was stopped.
#[inline(always)]
fn walk<T: InstructionSet, const ANY: bool, const MIXED: bool>(
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
        let entries = children.entries();
        if entries != 0 {
            let first = node.primitive_base_idx as usize;
            let found = T::nearest(&group.entries[first..], entries, ray, nearest.t_max);
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
            let mut others = if MIXED { entries } else { 0 };
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
