//! A ray against the triangles of some leaf entries: [`halflight_kernel::scene::intersect::intersect_triangle`] with the same operations
//! in the same order, so that the hits are the same to the bit.
//!
//! Here one after the other; processors with AVX2 do eight side by side ([`super::avx2`]).

use crate::accel::build::leaf_entry::LeafEntry;
use glam::Vec3;
use halflight_kernel::scene::NONE;
use halflight_kernel::scene::intersect::{ShearedRay, intersect_triangle};

/// What triangles need of a ray.
#[derive(Clone, Copy, Debug)]
pub struct TriangleRay {
    /// The kernel's preparation.
    pub sheared: ShearedRay,
    /// Components that are x, y and z of the sheared space.
    pub(super) rows: [usize; 3],
    /// The origin in that order.
    pub(super) origin: [f32; 3],
    /// Where hits begin.
    pub t_min: f32,
}

impl TriangleRay {
    /// Prepares a ray; its direction is not zero.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32) -> TriangleRay {
        let sheared = ShearedRay::new(origin, direction);
        let axis = sheared.axis as usize;
        let rows = [(axis + 1) % 3, (axis + 2) % 3, axis];
        TriangleRay {
            sheared,
            rows,
            origin: rows.map(|row| origin.to_array()[row]),
            t_min,
        }
    }
}

/// A hit among some triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter; [`f32::MAX`] for a miss.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub b1: f32,
    /// Barycentric weight of the third vertex.
    pub b2: f32,
    /// The primitive.
    pub primitive: u32,
}

impl TriangleHit {
    /// No intersection.
    pub const MISS: TriangleHit = TriangleHit {
        t: f32::MAX,
        b1: 0.0,
        b2: 0.0,
        primitive: u32::MAX,
    };

    /// Whether a hit at `t` comes first.
    #[inline(always)]
    pub(super) fn is_behind(&self, t: f32, primitive: u32) -> bool {
        t < self.t || (t == self.t && t < f32::MAX && primitive < self.primitive)
    }
}

/// The nearest hit in (t_min, t_max) among those of the `entries` whose bits are set in `mask`, of several at the very same
/// distance the one with the lowest primitive.
#[inline(always)]
pub fn portable(entries: &[LeafEntry], mask: u32, ray: &TriangleRay, t_max: f32) -> TriangleHit {
    let mut hit = TriangleHit::MISS;
    let mut left = mask;
    while left != 0 {
        let entry = &entries[left.trailing_zeros() as usize];
        left &= left - 1;
        for (triangle, primitive) in [entry.primitive(), entry.partner()].into_iter().enumerate() {
            if primitive == NONE {
                continue;
            }
            let [p0, p1, p2] = entry.vertices(triangle);
            let found = intersect_triangle(&ray.sheared, p0, p1, p2, ray.t_min, t_max);
            if hit.is_behind(found.t, primitive) {
                hit = TriangleHit {
                    t: found.t,
                    b1: found.b1,
                    b2: found.b2,
                    primitive,
                };
            }
        }
    }
    hit
}
