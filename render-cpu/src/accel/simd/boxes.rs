//! Rays against the boxes of a node's children.
//!
//! The corners of the boxes lie on the node's grid ([`CwBvhNode`]): plane q of an axis with the grid's corner p and step e
//! lies at p + q e, and a ray o + t d meets it at
//!
//! t = (p - o) / d + q e / d.
//!
//! Both terms round relative to their own size, so the near planes are moved back and the far ones forth by that much: a box
//! is never missed, and no ray slips between boxes that touch. The ray is in the box from the last of the near planes to
//! the first of the far ones (Kay and Kajiya 1986, "Ray Tracing Complex Scenes", slabs).

use super::SimdFloat;
use obvhs::cwbvh::node::CwBvhNode;

/// Plane distances of nodes by axes: t = q step + low for near planes, q step + high for far ones.
#[derive(Clone, Copy)]
pub struct PlaneDistances<F> {
    /// Ray parameter from plane to plane.
    pub step: [F; 3],
    /// Ray parameter of the grid's corner, rounded down.
    pub low: [F; 3],
    /// Ray parameter of the grid's corner, rounded up.
    pub high: [F; 3],
}

impl<F: SimdFloat> PlaneDistances<F> {
    /// For grids with planes `unit` apart, whose corners are `offset` from the rays' origins; `inverse` is 1 / direction.
    /// `PLANES` is how many planes away rounding takes place.
    #[inline(always)]
    pub fn new<const PLANES: u32>(unit: [F; 3], offset: [F; 3], inverse: [F; 3]) -> Self {
        let [x, y, z] = [
            axis::<F, PLANES>(unit[0], offset[0], inverse[0]),
            axis::<F, PLANES>(unit[1], offset[1], inverse[1]),
            axis::<F, PLANES>(unit[2], offset[2], inverse[2]),
        ];
        PlaneDistances {
            step: [x[0], y[0], z[0]],
            low: [x[1], y[1], z[1]],
            high: [x[2], y[2], z[2]],
        }
    }

    /// For the same node in all lanes.
    #[inline(always)]
    pub fn of_node(node: &CwBvhNode, origin: [F; 3], inverse: [F; 3]) -> Self {
        let corner = [
            F::splat(node.p.x) - origin[0],
            F::splat(node.p.y) - origin[1],
            F::splat(node.p.z) - origin[2],
        ];
        let unit = [unit(node.e[0]), unit(node.e[1]), unit(node.e[2])];
        Self::new::<255>(unit, corner, inverse)
    }

    /// From where to where rays are in boxes with these near and far planes, and in the range besides. They miss a box where
    /// the first exceeds the second.
    #[inline(always)]
    pub fn interval(&self, near: [F; 3], far: [F; 3], range: [F; 2]) -> [F; 2] {
        let first = near[0]
            .mul_add(self.step[0], self.low[0])
            .max(near[1].mul_add(self.step[1], self.low[1]))
            .max(near[2].mul_add(self.step[2], self.low[2]).max(range[0]));
        let last = far[0]
            .mul_add(self.step[0], self.high[0])
            .min(far[1].mul_add(self.step[1], self.high[1]))
            .min(far[2].mul_add(self.step[2], self.high[2]).min(range[1]));
        [first, last]
    }
}

/// The step of a grid, of which nodes keep the exponent.
#[inline(always)]
fn unit<F: SimdFloat>(exponent: u8) -> F {
    F::splat(f32::from_bits(u32::from(exponent) << 23))
}

/// Step, low and high of an axis.
#[inline(always)]
fn axis<F: SimdFloat, const PLANES: u32>(unit: F, offset: F, inverse: F) -> [F; 3] {
    let step = unit * inverse;
    let base = offset * inverse;
    let size = step.abs().mul_add(F::splat(PLANES as f32), base.abs());
    // Four roundings of each term, doubled.
    let error = size * F::splat(5e-7);
    [step, base - error, base + error]
}
