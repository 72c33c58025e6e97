//! Rays against spheres, one of each per lane: [`halflight_kernel::scene::intersect::intersect_quadric`] with the same
//! operations in the same order, so that the hits are the same to the bit.

use super::triangles::Hits;
use super::{SimdFloat, SimdMask, dot};

/// The hits in (t_min, t_max), the two numbers of `range`, among the lanes of `mask`, by the rows of the maps from world to
/// object, where the sphere is the unit sphere.
#[inline(always)]
pub fn hit_spheres<F: SimdFloat>(
    origin: [F; 3],
    direction: [F; 3],
    to_object: [[F; 4]; 3],
    range: [F; 2],
    mask: F::Mask,
) -> Hits<F> {
    let all = F::Mask::all();
    let (zero, one) = (F::splat(0.0), F::splat(1.0));
    let [x, y, z] = to_object;
    let o = [
        linear(x, origin) + x[3],
        linear(y, origin) + y[3],
        linear(z, origin) + z[3],
    ];
    let d = [
        linear(x, direction),
        linear(y, direction),
        linear(z, direction),
    ];
    let a = dot(d, d);
    let b = -dot(o, d);
    // The discriminant from the distance of the ray's closest point, which loses no digits far from the sphere.
    let along = b / a;
    let closest = [
        o[0] + d[0] * along,
        o[1] + d[1] * along,
        o[2] + d[2] * along,
    ];
    let c = dot(o, o) - one;
    let discriminant = one - dot(closest, closest);
    let mut hit = discriminant.ge(zero, mask);
    hit = a.gt(zero, hit);
    let square = a * discriminant;
    let s = F::select(square.gt(zero, all), square, zero).sqrt();
    let q = F::select(b.lt(zero, all), b - s, b + s);
    let t0 = F::select(q.ne(zero, all), c / q, zero);
    let t1 = q / a;
    // The other where one is not a number.
    let t1 = F::select(t1.ne(t1, all), t0, t1);
    let (near, far) = (t0.min(t1), t0.max(t1));
    let is_near = near.lt(range[1], near.gt(range[0], hit));
    let is_far = far.lt(range[1], far.gt(range[0], hit));
    Hits {
        mask: is_near | is_far,
        t: F::select(is_near, near, far),
        b1: zero,
        b2: zero,
    }
}

/// The linear part of a row of a map.
#[inline(always)]
fn linear<F: SimdFloat>([x, y, z, _]: [F; 4], v: [F; 3]) -> F {
    dot([x, y, z], v)
}
