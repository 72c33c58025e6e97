//! The walk over eight-wide compressed nodes (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs").
//!
//! The whole walk is compiled twice on x86-64, for every processor and for those with AVX2, which is looked up once when
//! the traverser is made.

use super::build::MAX_WIDE_DEPTH;
#[cfg(not(target_arch = "x86_64"))]
use super::node::Portable;
#[cfg(target_arch = "x86_64")]
use super::node::{Avx2, Sse2};
use super::node::{Children, NodeRay, NodeTest};
use super::packed::PackedTriangle;
use super::{Accel, Group};
use glam::{Vec3, Vec4, Vec4Swizzles};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::scene::intersect::{
    ShearedRay, intersect_quadric, is_traceable, plane_distance,
};
use halflight_kernel::scene::{Hit, Tables, Traverse};
use obvhs::cwbvh::node::CwBvhNode;
use std::mem::MaybeUninit;

/// Nodes that wait: of each node on the way down at most seven children, and all eight of the last.
const STACK_SIZE: usize = 7 * MAX_WIDE_DEPTH + 1;

/// The ray tracer over an [`Accel`].
#[derive(Clone, Copy)]
pub struct CpuTraverse<'a> {
    accel: &'a Accel,
    tables: Tables<'a>,
    #[cfg(target_arch = "x86_64")]
    has_avx2: bool,
}

/// A ray in a group's space with what nodes and triangles need of it.
struct GroupRay {
    node: NodeRay,
    sheared: ShearedRay,
    /// Rows of a packed triangle that are x, y and z of the sheared space.
    rows: [usize; 3],
    /// The origin's components in those rows.
    row_origin: [f32; 3],
    t_min: f32,
}

impl GroupRay {
    #[inline(always)]
    fn new(origin: Vec3, direction: Vec3, t_min: f32) -> GroupRay {
        let sheared = ShearedRay::new(origin, direction);
        let axis = sheared.axis as usize;
        let rows = [(axis + 1) % 3, (axis + 2) % 3, axis];
        GroupRay {
            node: NodeRay::new(origin, direction, t_min),
            sheared,
            rows,
            row_origin: rows.map(|k| origin[k]),
            t_min,
        }
    }
}

impl<'a> CpuTraverse<'a> {
    pub(super) fn new(accel: &'a Accel, tables: Tables<'a>) -> CpuTraverse<'a> {
        CpuTraverse {
            accel,
            tables,
            #[cfg(target_arch = "x86_64")]
            has_avx2: is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
        }
    }

    /// The nearest hit, or with `ANY` whichever comes first.
    #[inline(always)]
    fn trace<T: NodeTest, const ANY: bool>(&self, ray: &Ray) -> Hit {
        let mut hit = Hit::MISS;
        if !is_traceable(ray) {
            return hit;
        }
        let mut t_max = ray.t_max;
        let world = GroupRay::new(ray.origin, ray.direction, ray.t_min);
        let group = &self.accel.groups[0];
        if group.is_mixed {
            walk::<T, ANY>(&group.nodes, &world, &mut t_max, |slot, t_max| {
                self.primitive::<T, ANY, true>(group, slot, &world, ray, 0, t_max, &mut hit)
            });
        } else {
            walk::<T, ANY>(&group.nodes, &world, &mut t_max, |slot, t_max| {
                let found = triangle::<ANY>(group, slot, &world, 0, t_max, &mut hit);
                ANY && found
            });
        }
        hit
    }

    /// One entry of a leaf of any kind; true stops the walk.
    #[inline(always)]
    fn primitive<T: NodeTest, const ANY: bool, const WORLD: bool>(
        &self,
        group: &Group,
        slot: usize,
        local: &GroupRay,
        ray: &Ray,
        instance: u32,
        t_max: &mut f32,
        hit: &mut Hit,
    ) -> bool {
        let primitive = group.primitives[slot];
        let triangle_count = self.tables.triangles.len() as u32;
        if primitive < triangle_count {
            return triangle::<ANY>(group, slot, local, instance, t_max, hit) && ANY;
        }
        let index = (primitive - triangle_count) as usize;
        if index < self.tables.quadrics.len() {
            let quadric = &self.tables.quadrics[index];
            let t = intersect_quadric(
                quadric.kind,
                transform_point(&quadric.to_object, local.sheared.origin),
                transform_vector(&quadric.to_object, local.sheared.direction),
                local.t_min,
                *t_max,
            );
            if t < *t_max {
                *t_max = t;
                *hit = Hit {
                    t,
                    b1: 0.0,
                    b2: 0.0,
                    primitive,
                    instance,
                };
                return ANY;
            }
            return false;
        }
        if WORLD {
            let instance = index - self.tables.quadrics.len();
            return self.enter::<T, ANY>(instance, ray, t_max, hit);
        }
        false
    }

    /// An instance: the walk of its group.
    #[inline(always)]
    fn enter<T: NodeTest, const ANY: bool>(
        &self,
        instance: usize,
        ray: &Ray,
        t_max: &mut f32,
        hit: &mut Hit,
    ) -> bool {
        let record = &self.tables.instances[instance];
        let group = &self.accel.groups[record.group as usize];
        let origin = transform_point(&record.to_object, ray.origin);
        let direction = transform_vector(&record.to_object, ray.direction);
        let mut local_ray = *ray;
        (local_ray.origin, local_ray.direction) = (origin, direction);
        if !is_traceable(&local_ray) {
            return false;
        }
        let local = GroupRay::new(origin, direction, ray.t_min);
        let instance = instance as u32;
        walk::<T, ANY>(&group.nodes, &local, t_max, |slot, t_max| {
            self.primitive::<T, ANY, false>(group, slot, &local, ray, instance, t_max, hit)
        })
    }
}

#[cfg(target_arch = "x86_64")]
impl CpuTraverse<'_> {
    #[target_feature(enable = "avx2,fma")]
    fn closest_avx2(&self, ray: &Ray) -> Hit {
        self.trace::<Avx2, false>(ray)
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

/// A triangle of a leaf: [`halflight_kernel::scene::intersect::intersect_triangle`] on all three vertices at once, with
/// the same operations on each component. Whether it was hit.
#[inline(always)]
fn triangle<const ANY: bool>(
    group: &Group,
    slot: usize,
    ray: &GroupRay,
    instance: u32,
    t_max: &mut f32,
    hit: &mut Hit,
) -> bool {
    let triangle = &group.triangles[slot];
    let row = |k: usize| triangle.axes[ray.rows[k]] - Vec4::splat(ray.row_origin[k]);
    let shear = ray.sheared.shear;
    let z = row(2);
    let x = row(0) - Vec4::splat(shear.x) * z;
    let y = row(1) - Vec4::splat(shear.y) * z;
    // u = c x b, v = a x c, w = b x a in the sheared plane.
    let (cx, cy, bx, by) = (x.zxyw(), y.zxyw(), x.yzxw(), y.yzxw());
    let mut edges = cx * by - cy * bx;
    let is_zero = edges.cmpeq(Vec4::ZERO);
    if is_zero.bitmask() & 7 != 0 {
        let by_differences = ((cx + bx) * (by - cy) - (cy + by) * (bx - cx)) * 0.5;
        edges = Vec4::select(is_zero, by_differences, edges);
    }
    let below = edges.cmplt(Vec4::ZERO).bitmask() & 7;
    let above = edges.cmpgt(Vec4::ZERO).bitmask() & 7;
    if below != 0 && above != 0 {
        return false;
    }
    let determinant = edges.x + edges.y + edges.z;
    let is_solid = determinant.abs() > 0.0 && determinant.abs() < f32::MAX;
    if !is_solid {
        return false;
    }
    let [p0, p1, p2] = vertices(triangle);
    let z = (z * shear.z).truncate();
    let t = plane_distance(ray.sheared.origin, ray.sheared.direction, p0, p1, p2, z);
    if t > ray.t_min && t < *t_max {
        let scale = 1.0 / determinant;
        *t_max = t;
        *hit = Hit {
            t,
            b1: edges.y * scale,
            b2: edges.z * scale,
            primitive: group.primitives[slot],
            instance,
        };
        return true;
    }
    false
}

/// The three points of a packed triangle.
#[inline(always)]
fn vertices(triangle: &PackedTriangle) -> [Vec3; 3] {
    let [x, y, z] = triangle.axes;
    [
        Vec3::new(x.x, y.x, z.x),
        Vec3::new(x.y, y.y, z.y),
        Vec3::new(x.z, y.z, z.z),
    ]
}

/// Visits the primitives in leaves that the ray meets before `t_max` until `visit` returns true, near nodes first unless
/// with `ANY`.
#[inline(always)]
fn walk<T: NodeTest, const ANY: bool>(
    nodes: &[CwBvhNode],
    ray: &GroupRay,
    t_max: &mut f32,
    mut visit: impl FnMut(usize, &mut f32) -> bool,
) -> bool {
    if nodes.is_empty() {
        return false;
    }
    // Only entries below `size` are ever read; they need not be cleared for every ray.
    let mut stack = [const { MaybeUninit::<(u32, f32)>::uninit() }; STACK_SIZE];
    let mut size = 0;
    let mut node = &nodes[0];
    loop {
        let Children { near, mut hit } = T::children(node, &ray.node, *t_max);
        let inner = node.imask as u32;
        let bottom = size;
        let mut leaves = hit & !inner;
        hit &= inner;
        while leaves != 0 {
            let child = leaves.trailing_zeros();
            leaves &= leaves - 1;
            let meta = node.child_meta[child as usize] as u32;
            let first = node.primitive_base_idx + (meta & 31);
            // The count is unary in the top bits.
            for slot in first..first + (meta >> 5).count_ones() {
                if visit(slot as usize, t_max) {
                    return true;
                }
            }
        }
        while hit != 0 {
            let child = hit.trailing_zeros();
            hit &= hit - 1;
            let index = node.child_base_idx + (inner & ((1 << child) - 1)).count_ones();
            let entry = (index, near[child as usize]);
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
            if t <= *t_max {
                node = &nodes[index as usize];
                break;
            }
        }
    }
}
