//! Rays against triangles, a ray and a triangle or two per lane:
//! [`halflight_kernel::scene::intersect::intersect_triangle`] with the same operations in the same order, so that the hits
//! are the same to the bit (the watertight test of Woop, Benthin and Wald 2013).
//!
//! In sheared space the ray starts at the origin and runs along z; it passes through a triangle if the three edge functions
//! p x q of its projected vertices have no opposite signs. Leaf entries hold two triangles abc and acd that share an edge
//! ([`crate::accel::build::leaf_entry`]). Their edge functions are found from the four vertices, those of the common edge from the same
//! products ([`hit_pairs`]). All that follows is for one of them, the one that the ray passes through. Where it passes
//! through both, which lie at an angle then or meet at the ray, the other follows by itself.

use super::{SimdFloat, SimdMask, SimdWord, cross, dot, minus, select3};
use halflight_kernel::scene::NONE;

/// What triangles need of rays.
#[derive(Clone, Copy)]
pub struct ShearedRays<F: SimdFloat> {
    /// Starts.
    pub origin: [F; 3],
    /// Directions.
    pub direction: [F; 3],
    /// Shear of x and y, scale of z.
    pub shear: [F; 3],
    /// Lanes whose direction is longest along x.
    pub is_x: F::Mask,
    /// Lanes whose direction is longest along y.
    pub is_y: F::Mask,
    /// Where hits begin.
    pub t_min: F,
    /// Where they end.
    pub t_max: F,
}

/// Hits of some lanes.
#[derive(Clone, Copy)]
pub struct Hits<F: SimdFloat> {
    /// The lanes.
    pub mask: F::Mask,
    /// Ray parameters.
    pub t: F,
    /// Barycentric weights of the second vertices.
    pub b1: F,
    /// Barycentric weights of the third vertices.
    pub b2: F,
}

/// A vertex in sheared space, relative to the origin and with its signs turned, which changes no edge function.
#[derive(Clone, Copy)]
pub struct Sheared<F> {
    /// Across the ray.
    pub x: F,
    /// Across the ray.
    pub y: F,
    /// Back along the longest axis.
    pub z: F,
}

/// What the rays pass through among the triangles of leaf entries.
#[derive(Clone, Copy)]
struct CrossedTriangles<F: SimdFloat> {
    /// Lanes that pass through the first triangle.
    first: F::Mask,
    /// Lanes that pass through the second one.
    second: F::Mask,
    /// Their edge functions.
    edges: [[F; 3]; 2],
    /// The vertices' distances back along the longest axis.
    depths: [F; 4],
}

/// The lanes in which a direction is longest along x, and those in which it is along y.
#[inline(always)]
pub fn longest_axes<F: SimdFloat>(direction: [F; 3]) -> (F::Mask, F::Mask) {
    let all = F::Mask::all();
    let a = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
    let is_x = a[0].ge(a[1], all) & a[0].ge(a[2], all);
    let is_y = a[1].ge(a[2], all) & !is_x;
    (is_x, is_y)
}

/// Components in the cyclic order that puts each lane's axis last: x where `is_x`, y where `is_y`, z elsewhere.
#[inline(always)]
fn permute<F: SimdFloat>(v: [F; 3], is_x: F::Mask, is_y: F::Mask) -> [F; 3] {
    [
        F::select(is_x, v[1], F::select(is_y, v[2], v[0])),
        F::select(is_x, v[2], F::select(is_y, v[0], v[1])),
        F::select(is_x, v[0], F::select(is_y, v[1], v[2])),
    ]
}

/// Shear of x and y per unit of z and the scale 1 / d_z of z, in the order of each lane's longest axis.
#[inline(always)]
pub fn shears<F: SimdFloat>(direction: [F; 3], is_x: F::Mask, is_y: F::Mask) -> [F; 3] {
    let [x, y, z] = permute(direction, is_x, is_y);
    [x / z, y / z, F::splat(1.0) / z]
}

/// The hits in (t_min, t_max) of the lanes of `mask` with the nearer of the triangles with these vertices, of two at the
/// same distance the one with the lower primitive; and the primitives. `partners` are those of the second triangles or
/// [`NONE`], `rotations` those of leaf entries.
#[inline(always)]
pub fn hit_pairs<F: SimdFloat>(
    rays: &ShearedRays<F>,
    vertices: &[[F; 3]; 4],
    primitives: F::Word,
    partners: F::Word,
    rotations: F::Word,
    mask: F::Mask,
) -> (Hits<F>, F::Word) {
    let all = F::Mask::all();
    let pairs = partners.ne(F::Word::splat(NONE), mask);
    let passing = pass(rays, vertices, mask, pairs);
    let either = passing.first | passing.second;
    let both = passing.first & passing.second;
    if !either.any() {
        let zero = F::splat(0.0);
        let none = Hits {
            mask: either,
            t: zero,
            b1: zero,
            b2: zero,
        };
        return (none, primitives);
    }
    let seconds = passing.second & !both;
    let mut found = hits(rays, vertices, &passing, rotations, seconds, either);
    let mut names = F::Word::select(seconds, partners, primitives);
    if both.any() {
        let other = hits(rays, vertices, &passing, rotations, both, both);
        let is_nearer =
            other.t.lt(found.t, all) | (other.t.eq(found.t, all) & partners.lt(names, all));
        let is_first = other.mask & (is_nearer | !found.mask);
        found.mask = found.mask | other.mask;
        found.t = F::select(is_first, other.t, found.t);
        found.b1 = F::select(is_first, other.b1, found.b1);
        found.b2 = F::select(is_first, other.b2, found.b2);
        names = F::Word::select(is_first, partners, names);
    }
    (found, names)
}

/// The lanes of `mask`, of which those of `pairs` have two triangles, whose rays pass through the first and through the
/// second triangle with these vertices.
#[inline(always)]
fn pass<F: SimdFloat>(
    rays: &ShearedRays<F>,
    vertices: &[[F; 3]; 4],
    mask: F::Mask,
    pairs: F::Mask,
) -> CrossedTriangles<F> {
    let a = permuted_vertex(rays, vertices[0]);
    let b = permuted_vertex(rays, vertices[1]);
    let c = permuted_vertex(rays, vertices[2]);
    let d = permuted_vertex(rays, vertices[3]);
    let (p, q) = (a.x * c.y, a.y * c.x);
    let mut first = [edge_function(c, b), p - q, edge_function(b, a)];
    let mut second = [edge_function(d, c), edge_function(a, d), q - p];
    let (mut through_first, zero_first) = have_one_sign(first, mask);
    let (mut through_second, zero_second) = have_one_sign(second, pairs);
    if (zero_first | zero_second).any() {
        first[0] = nonzero_edge(first[0], c, b);
        first[1] = nonzero_edge(first[1], a, c);
        first[2] = nonzero_edge(first[2], b, a);
        second[0] = nonzero_edge(second[0], d, c);
        second[1] = nonzero_edge(second[1], a, d);
        second[2] = nonzero_edge(second[2], c, a);
        through_first = through_first | have_no_opposite_signs(first, zero_first);
        through_second = through_second | have_no_opposite_signs(second, zero_second);
    }
    CrossedTriangles {
        first: through_first,
        second: through_second,
        edges: [first, second],
        depths: [a.z, b.z, c.z, d.z],
    }
}

/// The hits in (t_min, t_max) of the lanes of `mask` with the second triangles where `seconds` is set, the first elsewhere.
#[inline(always)]
fn hits<F: SimdFloat>(
    rays: &ShearedRays<F>,
    vertices: &[[F; 3]; 4],
    passing: &CrossedTriangles<F>,
    rotations: F::Word,
    seconds: F::Mask,
    mask: F::Mask,
) -> Hits<F> {
    let [first, second] = passing.edges;
    let [mut u, mut v, mut w] = select3(seconds, second, first);
    let [a, b, c, d] = *vertices;
    let (mut p0, mut p1, mut p2) = (a, select3(seconds, c, b), select3(seconds, d, c));
    // Vertices in the order that the triangle has in the scene: barycentric weights are of those.
    let rotations = F::Word::select(seconds, rotations.shr::<2>(), rotations);
    let once = rotations.test(F::Word::splat(1), mask);
    let twice = rotations.test(F::Word::splat(2), mask);
    if (once | twice).any() {
        [u, v, w] = rotated([u, v, w], once, twice);
        let x = rotated([p0[0], p1[0], p2[0]], once, twice);
        let y = rotated([p0[1], p1[1], p2[1]], once, twice);
        let z = rotated([p0[2], p1[2], p2[2]], once, twice);
        p0 = [x[0], y[0], z[0]];
        p1 = [x[1], y[1], z[1]];
        p2 = [x[2], y[2], z[2]];
    }
    let [za, zb, zc, zd] = passing.depths;
    let depths = [za, F::select(seconds, zc, zb), F::select(seconds, zd, zc)];
    let plane = PlaneHit::new(rays, [u, v, w], [p0, p1, p2], depths, mask);
    let scale = F::splat(1.0) / plane.determinant;
    Hits {
        mask: plane.mask,
        t: plane.t,
        b1: v * scale,
        b2: w * scale,
    }
}

/// a, b, c as c, a, b where `once` is set and as b, c, a where `twice` is.
#[inline(always)]
fn rotated<F: SimdFloat>([a, b, c]: [F; 3], once: F::Mask, twice: F::Mask) -> [F; 3] {
    [
        F::select(twice, b, F::select(once, c, a)),
        F::select(twice, c, F::select(once, a, b)),
        F::select(twice, a, F::select(once, b, c)),
    ]
}

/// Where rays meet the planes of triangles that they pass through.
#[derive(Clone, Copy)]
pub struct PlaneHit<F: SimdFloat> {
    /// Lanes whose hit is in the range.
    pub mask: F::Mask,
    /// Ray parameters.
    pub t: F,
    /// Sum of the edge functions: a barycentric weight is an edge function over it.
    pub determinant: F,
}

impl<F: SimdFloat> PlaneHit<F> {
    /// For the lanes of a mask, by the edge functions, the vertices and their sheared depths, in any order of the three. The
    /// hit is clamped to the range of the vertices along the ray.
    #[inline(always)]
    pub fn new(
        rays: &ShearedRays<F>,
        edges: [F; 3],
        [p0, p1, p2]: [[F; 3]; 3],
        depths: [F; 3],
        mask: F::Mask,
    ) -> PlaneHit<F> {
        let determinant = edges[0] + edges[1] + edges[2];
        let size = determinant.abs();
        let mut hit = size.gt(F::splat(0.0), mask);
        hit = size.lt(F::splat(f32::MAX), hit);
        let n = cross(minus(p1, p0), minus(p2, p0));
        let plane = dot(n, minus(p0, rays.origin)) / dot(n, rays.direction);
        let scale = -rays.shear[2];
        let (za, zb, zc) = (depths[0] * scale, depths[1] * scale, depths[2] * scale);
        // A NaN from 0/0 is replaced by the bounds as well.
        let t = plane.max(za.min(zb).min(zc)).min(za.max(zb).max(zc));
        hit = t.gt(rays.t_min, hit);
        PlaneHit {
            mask: t.lt(rays.t_max, hit),
            t,
            determinant,
        }
    }
}

/// A vertex in sheared space, by its difference from the origin in the order of the longest axis.
#[inline(always)]
pub fn sheared_vertex<F: SimdFloat>([x, y, z]: [F; 3], shear: [F; 2]) -> Sheared<F> {
    Sheared {
        x: x - shear[0] * z,
        y: y - shear[1] * z,
        z,
    }
}

/// A vertex in sheared space.
#[inline(always)]
fn permuted_vertex<F: SimdFloat>(rays: &ShearedRays<F>, p: [F; 3]) -> Sheared<F> {
    let relative = permute(minus(rays.origin, p), rays.is_x, rays.is_y);
    sheared_vertex(relative, [rays.shear[0], rays.shear[1]])
}

/// The edge function p x q.
#[inline(always)]
pub fn edge_function<F: SimdFloat>(p: Sheared<F>, q: Sheared<F>) -> F {
    p.x * q.y - p.y * q.x
}

/// The edge function p x q, where rounding has lost it from the difference of the vertices.
#[inline(always)]
pub fn nonzero_edge<F: SimdFloat>(edge: F, p: Sheared<F>, q: Sheared<F>) -> F {
    let difference = (p.x + q.x) * (q.y - p.y) - (p.y + q.y) * (q.x - p.x);
    let is_zero = edge.eq(F::splat(0.0), F::Mask::all());
    F::select(is_zero, F::splat(0.5) * difference, edge)
}

/// The lanes of a mask where all edge functions have the same sign, and those where one may be zero and no two have
/// opposite signs.
#[inline(always)]
fn have_one_sign<F: SimdFloat>([u, v, w]: [F; 3], mask: F::Mask) -> (F::Mask, F::Mask) {
    let least = u.min(v.min(w));
    let greatest = u.max(v.max(w));
    // Zero also where it is too small for a number. Where it is not a number, the determinant is not finite.
    let product = least * greatest;
    let zero = F::splat(0.0);
    (product.gt(zero, mask), product.eq(zero, mask))
}

/// The lanes of a mask where no two edge functions have opposite signs. A NaN may hide one of them; such triangles are
/// missed either way.
#[inline(always)]
pub fn have_no_opposite_signs<F: SimdFloat>([u, v, w]: [F; 3], mask: F::Mask) -> F::Mask {
    let zero = F::splat(0.0);
    let below = u.min(v.min(w)).lt(zero, mask);
    mask & !u.max(v.max(w)).gt(zero, below)
}
