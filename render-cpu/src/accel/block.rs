//! A ray against eight triangles: [`halflight_kernel::scene::intersect::intersect_triangle`] with the same operations in the
//! same order, so that the hits are the same to the bit.
//!
//! Nearly all triangles go away by the signs of their edge functions, which here are left to the compiler's vectors; what
//! a block keeps goes to the kernel, one by one. Processors with AVX2 do all of it side by side ([`super::avx2`]).

use super::packed::{BLOCK, TriangleBlock};
use glam::Vec3;
use halflight_kernel::scene::intersect::{ShearedRay, intersect_triangle};

/// What a block needs of a ray.
#[derive(Clone, Copy, Debug)]
pub struct BlockRay {
    /// The kernel's preparation.
    pub sheared: ShearedRay,
    /// Components that are x, y and z of the sheared space.
    pub(super) rows: [usize; 3],
    /// The origin in that order.
    pub(super) origin: [f32; 3],
    /// Where hits begin.
    pub t_min: f32,
}

impl BlockRay {
    /// Prepares a ray; its direction is not zero.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32) -> BlockRay {
        let sheared = ShearedRay::new(origin, direction);
        let axis = sheared.axis as usize;
        let rows = [(axis + 1) % 3, (axis + 2) % 3, axis];
        BlockRay {
            sheared,
            rows,
            origin: rows.map(|row| origin.to_array()[row]),
            t_min,
        }
    }
}

/// A hit in a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockHit {
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub b1: f32,
    /// Barycentric weight of the third vertex.
    pub b2: f32,
    /// Place in the block; [`BLOCK`] for a miss.
    pub place: usize,
}

impl BlockHit {
    /// No intersection.
    pub const MISS: BlockHit = BlockHit {
        t: f32::MAX,
        b1: 0.0,
        b2: 0.0,
        place: BLOCK,
    };
}

/// The nearest hit in (t_min, t_max) among the places whose bits are set in `places`, of several at the very same distance
/// the one with the lowest `name`.
#[inline(always)]
pub fn portable(
    block: &TriangleBlock,
    name: impl Fn(usize) -> u32,
    ray: &BlockRay,
    places: u32,
    t_max: f32,
) -> BlockHit {
    let mut hit = BlockHit::MISS;
    let mut candidates = places & candidates(block, ray);
    while candidates != 0 {
        let place = candidates.trailing_zeros() as usize;
        candidates &= candidates - 1;
        let [p0, p1, p2] = block.vertices(place);
        let found = intersect_triangle(&ray.sheared, p0, p1, p2, ray.t_min, t_max);
        let is_first = found.t == hit.t && hit.place < BLOCK && name(place) < name(hit.place);
        if found.t < hit.t || is_first {
            hit = BlockHit {
                t: found.t,
                b1: found.b1,
                b2: found.b2,
                place,
            };
        }
    }
    hit
}

/// The places, a bit each, where no two edge functions have opposite signs. Edges that are zero are left to the kernel.
#[inline(always)]
fn candidates(block: &TriangleBlock, ray: &BlockRay) -> u32 {
    let [rx, ry, rz] = ray.rows.map(|row| &block.axes[row]);
    let shear = ray.sheared.shear;
    let mut candidates = 0;
    for k in 0..BLOCK {
        let mut x = [0.0; 3];
        let mut y = [0.0; 3];
        for vertex in 0..3 {
            let z = rz[vertex][k] - ray.origin[2];
            x[vertex] = (rx[vertex][k] - ray.origin[0]) - shear.x * z;
            y[vertex] = (ry[vertex][k] - ray.origin[1]) - shear.y * z;
        }
        let u = x[2] * y[1] - y[2] * x[1];
        let v = x[0] * y[2] - y[0] * x[2];
        let w = x[1] * y[0] - y[1] * x[0];
        let below = (u < 0.0) | (v < 0.0) | (w < 0.0);
        let above = (u > 0.0) | (v > 0.0) | (w > 0.0);
        candidates |= (!(below & above) as u32) << k;
    }
    candidates
}
