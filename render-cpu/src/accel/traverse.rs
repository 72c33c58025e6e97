//! The walk over eight-wide compressed nodes.
//!
//! A node stores its children's boxes in bytes on a grid of power-of-two steps (Ylitie, Karras, Laine 2017, "Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs"); the ray is moved to the grid instead of the boxes to
//! the world. The distance to a grid plane, (p - o) / d + q e / d, rounds relative to its two terms, so that both sides of
//! a box are moved apart by that error: no ray slips between boxes that touch.

use super::packed::PackedTriangle;
use super::{Accel, Group};
use glam::{Vec3, Vec3A, Vec4, Vec4Swizzles};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::scene::intersect::{
    ShearedRay, intersect_quadric, is_traceable, plane_distance,
};
use halflight_kernel::scene::{Hit, Tables, Traverse};
use obvhs::cwbvh::node::CwBvhNode;

/// Node groups that wait: a wide tree of depth d needs at most d.
const STACK_SIZE: usize = 64;

/// The ray tracer over an [`Accel`].
#[derive(Clone, Copy)]
pub struct CpuTraverse<'a> {
    accel: &'a Accel,
    tables: Tables<'a>,
}

/// A ray in a group's space with what nodes and triangles need of it.
struct GroupRay {
    sheared: ShearedRay,
    /// Rows of a packed triangle that are x, y and z of the sheared space.
    rows: [usize; 3],
    origin: Vec3A,
    inverse: Vec3A,
    is_negative: [bool; 3],
    octant: u32,
    t_min: f32,
}

impl GroupRay {
    #[inline(always)]
    fn new(origin: Vec3, direction: Vec3, t_min: f32) -> GroupRay {
        let sheared = ShearedRay::new(origin, direction);
        let axis = sheared.axis as usize;
        let is_negative = [direction.x < 0.0, direction.y < 0.0, direction.z < 0.0];
        GroupRay {
            sheared,
            rows: [(axis + 1) % 3, (axis + 2) % 3, axis],
            origin: origin.into(),
            // Finite, so that no plane distance is zero times infinity.
            inverse: Vec3A::from(direction.map(|x| {
                if x.abs() > 1e-18 {
                    1.0 / x
                } else {
                    1e18f32.copysign(x)
                }
            })),
            is_negative,
            octant: (!is_negative[0] as u32) << 2
                | (!is_negative[1] as u32) << 1
                | !is_negative[2] as u32,
            t_min,
        }
    }
}

impl<'a> CpuTraverse<'a> {
    pub(super) fn new(accel: &'a Accel, tables: Tables<'a>) -> CpuTraverse<'a> {
        CpuTraverse { accel, tables }
    }

    /// The nearest hit, or with `ANY` whichever comes first.
    #[inline(always)]
    fn trace<const ANY: bool>(&self, ray: &Ray) -> Hit {
        let mut hit = Hit::MISS;
        if !is_traceable(ray) {
            return hit;
        }
        let mut t_max = ray.t_max;
        let world = GroupRay::new(ray.origin, ray.direction, ray.t_min);
        let group = &self.accel.groups[0];
        if group.is_mixed {
            walk(&group.nodes, &world, &mut t_max, |slot, t_max| {
                self.primitive::<ANY, true>(group, slot, &world, ray, 0, t_max, &mut hit)
            });
        } else {
            walk(&group.nodes, &world, &mut t_max, |slot, t_max| {
                let found = triangle::<ANY>(group, slot, &world, 0, t_max, &mut hit);
                ANY && found
            });
        }
        hit
    }

    /// One entry of a leaf of any kind; true stops the walk.
    #[inline(always)]
    fn primitive<const ANY: bool, const WORLD: bool>(
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
            return self.enter::<ANY>(instance, ray, t_max, hit);
        }
        false
    }

    /// An instance: the walk of its group.
    #[inline(never)]
    fn enter<const ANY: bool>(
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
        walk(&group.nodes, &local, t_max, |slot, t_max| {
            self.primitive::<ANY, false>(group, slot, &local, ray, instance, t_max, hit)
        })
    }
}

impl Traverse for CpuTraverse<'_> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        self.trace::<false>(ray)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.trace::<true>(ray).is_hit()
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
    let row = |k: usize| triangle.axes[ray.rows[k]] - Vec4::splat(ray.origin[ray.rows[k]]);
    let shear = ray.sheared.shear;
    let z = row(2);
    let x = row(0) - Vec4::splat(shear.x) * z;
    let y = row(1) - Vec4::splat(shear.y) * z;
    // u = c x b, v = a x c, w = b x a in the sheared plane.
    let edges = x.zxyw() * y.yzxw() - y.zxyw() * x.yzxw();
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

/// Visits the leaves that the ray meets before `t_max`, roughly front to back, until `visit` returns true.
#[inline(always)]
fn walk(
    nodes: &[CwBvhNode],
    ray: &GroupRay,
    t_max: &mut f32,
    mut visit: impl FnMut(usize, &mut f32) -> bool,
) -> bool {
    if nodes.is_empty() {
        return false;
    }
    let mut stack = [(0u32, 0u32); STACK_SIZE];
    let mut size = 0;
    // A group of sibling nodes: the first child, the hit ones by priority in the high byte, the inner ones in the low.
    let mut group = (0u32, 0x8000_0000u32);
    loop {
        if group.1 & 0xff00_0000 == 0 {
            if size == 0 {
                return false;
            }
            size -= 1;
            group = stack[size];
        }
        let priority = 31 - group.1.leading_zeros();
        group.1 &= !(1 << priority);
        let slot = (priority - 24) ^ ray.octant;
        let before = (group.1 & ((1 << slot) - 1) & 0xff).count_ones();
        let node = &nodes[(group.0 + before) as usize];
        if group.1 & 0xff00_0000 != 0 && size < STACK_SIZE {
            stack[size] = group;
            size += 1;
        }
        let hits = intersect_node(node, ray, *t_max);
        let mut leaves = hits & 0x00ff_ffff;
        while leaves != 0 {
            let offset = leaves.trailing_zeros();
            leaves &= leaves - 1;
            if visit((node.primitive_base_idx + offset) as usize, t_max) {
                return true;
            }
        }
        group = (
            node.child_base_idx,
            (hits & 0xff00_0000) | node.imask as u32,
        );
    }
}

/// The children that the ray meets: hit inner ones by priority in the high byte, primitives of hit leaves below.
#[inline(always)]
fn intersect_node(node: &CwBvhNode, ray: &GroupRay, t_max: f32) -> u32 {
    let step = node.compute_extent() * ray.inverse;
    let base = (Vec3A::from(node.p) - ray.origin) * ray.inverse;
    let error = (base.abs() + step.abs() * 255.0) * 5e-7;
    let (low, high) = (base - error, base + error);
    let pick = |k: usize, min: &[u8; 8], max: &[u8; 8]| {
        if ray.is_negative[k] {
            (*max, *min)
        } else {
            (*min, *max)
        }
    };
    let (near_x, far_x) = pick(0, &node.child_min_x, &node.child_max_x);
    let (near_y, far_y) = pick(1, &node.child_min_y, &node.child_max_y);
    let (near_z, far_z) = pick(2, &node.child_min_z, &node.child_max_z);
    let mut is_hit = [false; 8];
    for i in 0..8 {
        let x0 = near_x[i] as f32 * step.x + low.x;
        let y0 = near_y[i] as f32 * step.y + low.y;
        let z0 = near_z[i] as f32 * step.z + low.z;
        let x1 = far_x[i] as f32 * step.x + high.x;
        let y1 = far_y[i] as f32 * step.y + high.y;
        let z1 = far_z[i] as f32 * step.z + high.z;
        let t0 = x0.max(y0).max(z0.max(ray.t_min));
        let t1 = x1.min(y1).min(z1.min(t_max));
        is_hit[i] = t0 <= t1;
    }
    let (bits, shifts) = node.get_child_and_index_bits(ray.octant * 0x0101_0101);
    let mut hits = 0;
    for i in 0..8 {
        let bits = (bits >> (8 * i)) as u8 as u32;
        let shift = (shifts >> (8 * i)) as u8 as u32;
        hits |= if is_hit[i] { bits << shift } else { 0 };
    }
    hits
}
