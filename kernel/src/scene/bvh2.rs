//! The binary BVH walk that shaders use.
//!
//! One node array holds the world's tree and a subtree per group; a leaf of the world's tree may name instances. The walk
//! has one stack for both levels: entering an instance pushes `LEAVE`, transforms the ray (t keeps its world meaning)
//! and goes on in the group's subtree; popping `LEAVE` restores the world's ray. Children are visited nearest first and
//! popped nodes are tested again against the interval, which has shrunk meanwhile. Boxes are tested with a slab test
//! whose far distance is widened by two roundings (Ize 2013, "Robust BVH Ray Traversal"), so that no ray slips between
//! boxes that touch, and rays along a face meet the boxes on both sides. The interval ends a little beyond the nearest
//! hit ([`super::traverse::REACH`]), for what lies at the same distance. Checked: the same hits as a search of all
//! primitives and as the CPU's tree.

use super::hit::Hit;
use super::intersect::{ShearedRay, intersect_quadric, intersect_triangle, is_traceable};
use super::records::NONE;
use super::traverse::{REACH, Traverse};
use super::view::Tables;
use crate::math::affine::{transform_point, transform_vector};
use crate::math::float::abs;
use crate::math::{Ray, vec3};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A node: a box, and two children or a run of primitives.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BvhNode {
    /// Least corner of the box.
    pub min: [f32; 3],
    /// The left child, the right one follows it; in a leaf the first entry of the primitive indices.
    pub first: u32,
    /// Greatest corner of the box.
    pub max: [f32; 3],
    /// Number of primitives of a leaf, zero for inner nodes.
    pub count: u32,
}

/// Entries of the stack: one per level of the world's tree and of a group's, and at the bottom of the first the
/// [`MAX_LEAF`] instances of a leaf, the last of which becomes `LEAVE`.
pub const STACK_SIZE: usize = 2 * MAX_DEPTH + MAX_LEAF;

/// The deepest tree, in nodes from its root to a leaf, that host code may lend for the world or for a group. What exceeds
/// the stack in a deeper one is not visited.
pub const MAX_DEPTH: usize = 30;

/// The most primitives that a leaf of the world's tree may hold.
pub const MAX_LEAF: usize = 4;

/// Stack entry: the walk leaves the instance.
const LEAVE: u32 = u32::MAX;

/// Bit of a stack entry that names an instance rather than a node.
const INSTANCE: u32 = 1 << 31;

/// The walk over nodes that the host has built.
///
/// `primitive_indices` hold what [`Hit::primitive`] holds: a triangle, or the number of triangles plus a quadric. In the
/// world's tree they may also hold the number of triangles and quadrics plus an instance, whose subtree starts at
/// [`super::Instance::root`]. Node 0 is the world's root; without nodes everything is missed.
#[derive(Clone, Copy)]
pub struct Bvh2Traverse<'a> {
    /// The scene's tables.
    pub tables: Tables<'a>,
    /// The world's tree, then the groups'.
    pub nodes: &'a [BvhNode],
    /// What the leaves hold.
    pub primitive_indices: &'a [u32],
}

/// A ray in the space that is being walked, with what boxes and triangles need of it.
#[derive(Clone, Copy)]
struct LocalRay {
    sheared: ShearedRay,
    inverse: Vec3,
}

impl LocalRay {
    #[inline]
    fn new(origin: Vec3, direction: Vec3) -> LocalRay {
        LocalRay {
            sheared: ShearedRay::new(origin, direction),
            inverse: Vec3::new(
                inverse(direction.x),
                inverse(direction.y),
                inverse(direction.z),
            ),
        }
    }
}

/// 1 / x, but finite, so that no slab test multiplies zero by infinity.
#[inline]
fn inverse(x: f32) -> f32 {
    if abs(x) > 1e-18 {
        1.0 / x
    } else if x < 0.0 {
        -1e18
    } else {
        1e18
    }
}

impl Bvh2Traverse<'_> {
    /// The entry distance of the box, [`f32::MAX`] when the ray misses it within (t_min, t_max).
    #[inline]
    fn enter(&self, node: u32, ray: &LocalRay, t_min: f32, t_max: f32) -> f32 {
        let node = &self.nodes[node as usize];
        let a = (vec3(node.min) - ray.sheared.origin) * ray.inverse;
        let b = (vec3(node.max) - ray.sheared.origin) * ray.inverse;
        let near = a.min(b);
        let far = a.max(b);
        let t0 = near.x.max(near.y).max(near.z).max(t_min);
        // Relative error of both ends: two roundings for the difference and the product, one for the inverse. Of a ray
        // in the plane of a face the far distance is zero: there, the box's own width replaces it.
        let far = far + (far.abs() + near.abs()) * 4.0e-7;
        let t1 = far.x.min(far.y).min(far.z);
        if t0 <= t1.min(t_max) { t0 } else { f32::MAX }
    }

    /// The nearest hit, or with `any` whichever comes first.
    #[inline]
    fn walk(&self, ray: &Ray, any: bool) -> Hit {
        let mut hit = Hit::MISS;
        if self.nodes.is_empty() || !is_traceable(ray) {
            return hit;
        }
        let world = LocalRay::new(ray.origin, ray.direction);
        let mut local = world;
        let triangle_count = self.tables.triangles.len() as u32;
        let quadric_end = triangle_count + self.tables.quadrics.len() as u32;
        let mut t_max = ray.t_max;
        let mut instance = 0;
        let mut stack = [0u32; STACK_SIZE];
        let mut size = 1;
        // The node that is visited next; its box is known to be met. NONE takes the next from the stack.
        let mut current = NONE;
        while size > 0 || current != NONE {
            if current == NONE {
                size -= 1;
                let mut entry = stack[size];
                if entry == LEAVE {
                    local = world;
                    instance = 0;
                    continue;
                }
                if entry & INSTANCE != 0 {
                    instance = entry & !INSTANCE;
                    let record = &self.tables.instances[instance as usize];
                    local = LocalRay::new(
                        transform_point(&record.to_object, ray.origin),
                        transform_vector(&record.to_object, ray.direction),
                    );
                    stack[size] = LEAVE;
                    size += 1;
                    entry = record.root;
                }
                // The interval may have shrunk since the entry was made.
                if self.enter(entry, &local, ray.t_min, t_max) < f32::MAX {
                    current = entry;
                }
                continue;
            }
            let (first, count) = {
                let node = &self.nodes[current as usize];
                (node.first, node.count)
            };
            current = NONE;
            if count == 0 {
                let left = self.enter(first, &local, ray.t_min, t_max);
                let right = self.enter(first + 1, &local, ray.t_min, t_max);
                let right_first = (right < left) as u32;
                if left.min(right) < f32::MAX {
                    current = first + right_first;
                }
                if left.max(right) < f32::MAX && size < STACK_SIZE {
                    stack[size] = first + 1 - right_first;
                    size += 1;
                }
                continue;
            }
            for i in first..first + count {
                let primitive = self.primitive_indices[i as usize];
                if primitive < triangle_count {
                    let v = self.tables.triangles[primitive as usize].vertices;
                    let found = intersect_triangle(
                        &local.sheared,
                        vec3(self.tables.positions[v[0] as usize]),
                        vec3(self.tables.positions[v[1] as usize]),
                        vec3(self.tables.positions[v[2] as usize]),
                        ray.t_min,
                        t_max,
                    );
                    if hit.is_behind(found.t, primitive, instance) {
                        t_max = found.t * REACH;
                        hit = Hit {
                            t: found.t,
                            b1: found.b1,
                            b2: found.b2,
                            primitive,
                            instance,
                        };
                    }
                } else if primitive < quadric_end {
                    let quadric = &self.tables.quadrics[(primitive - triangle_count) as usize];
                    let t = intersect_quadric(
                        quadric.kind,
                        transform_point(&quadric.to_object, local.sheared.origin),
                        transform_vector(&quadric.to_object, local.sheared.direction),
                        ray.t_min,
                        t_max,
                    );
                    if hit.is_behind(t, primitive, instance) {
                        t_max = t * REACH;
                        hit = Hit {
                            t,
                            b1: 0.0,
                            b2: 0.0,
                            primitive,
                            instance,
                        };
                    }
                } else if size < STACK_SIZE {
                    stack[size] = INSTANCE | (primitive - quadric_end);
                    size += 1;
                }
            }
            if any && hit.is_hit() {
                return hit;
            }
        }
        hit
    }
}

impl Traverse for Bvh2Traverse<'_> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        self.walk(ray, false)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.walk(ray, true).is_hit()
    }
}
