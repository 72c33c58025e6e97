//! The primitives of a group and their boxes, which a tree is built over.
//!
//! Boxes are made once, as the leaves that the builder takes over, and are not kept beside its tree: a build touches memory
//! that is then given back, and touching it costs as much as the work on it.

use super::pairs::TrianglePairs;
use glam::{Vec3, Vec3A};
use halflight_kernel::math::affine::{transform_magnitude, transform_point, translation};
use halflight_kernel::math::vec3;
use halflight_kernel::scene::{NONE, Quadric, Tables, quadric_kind};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator,
};
use std::ops::Range;

/// Coordinates beyond this are not traced: areas of boxes, which the builder adds up, would overflow.
pub const MAX_COORDINATE: f32 = 1e15;

/// The primitives of a group, by their indices in the tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GroupRange {
    /// Triangles.
    pub triangles: Range<u32>,
    /// Quadrics.
    pub quadrics: Range<u32>,
}

/// Primitives with their boxes.
#[derive(Clone, Debug, Default)]
pub struct PrimitiveBounds {
    /// Triangles, the number of triangles plus quadrics, or the number of both plus instances. Of pairs the first.
    pub primitives: Vec<u32>,
    /// The others.
    pub partners: TrianglePairs,
    /// Their boxes: a leaf each, with the index into `primitives`.
    pub leaves: Vec<Bvh2Node>,
    /// Primitives without a usable box.
    pub skipped: usize,
}

impl PrimitiveBounds {
    fn push(&mut self, primitive: u32, bounds: Aabb) {
        if is_usable(&bounds) {
            let index = self.primitives.len() as u32;
            self.leaves.push(Bvh2Node::new(bounds, 1, index));
            self.primitives.push(primitive);
        } else {
            self.skipped += 1;
        }
    }

    /// Makes the leaves of triangles, whose numbers begin with `first`, those of pairs, and leaves out what has no usable box.
    fn compact(&mut self, first: u32) {
        self.primitives.reserve(self.leaves.len());
        let mut kept = 0;
        for index in 0..self.leaves.len() {
            let primitive = first + index as u32;
            if self.partners.is_second(primitive) {
                continue;
            }
            let mut bounds = *self.leaves[index].aabb();
            if !is_usable(&bounds) {
                self.skipped += 1;
                continue;
            }
            let partner = self.partners.of(primitive);
            if partner != NONE {
                bounds = bounds.union(self.leaves[(partner - first) as usize].aabb());
            }
            // Leaves up to here have been read.
            self.leaves[kept] = Bvh2Node::new(bounds, 1, kept as u32);
            self.primitives.push(primitive);
            kept += 1;
        }
        self.leaves.truncate(kept);
    }

    /// The box of everything.
    pub fn total(&self) -> Aabb {
        let boxes = self.leaves.par_iter().map(|leaf| *leaf.aabb());
        boxes.reduce(Aabb::empty, |a, b| a.union(&b))
    }
}

/// Whether a box can be traced; one with NaNs cannot.
fn is_usable(bounds: &Aabb) -> bool {
    bounds.min.cmpge(Vec3A::splat(-MAX_COORDINATE)).all()
        && bounds.max.cmple(Vec3A::splat(MAX_COORDINATE)).all()
}

/// The box of a triangle, NaN where it cannot be traced.
fn triangle_bounds(tables: &Tables<'_>, index: u32) -> Aabb {
    let points = tables.triangles[index as usize]
        .vertices
        .map(|v| Vec3A::from(vec3(tables.positions[v as usize])));
    // NaNs vanish in minima and maxima: they are looked for first.
    let bounds = Aabb::from_points(&points);
    if points.iter().all(|p| p.is_finite()) && is_usable(&bounds) {
        bounds
    } else {
        Aabb::new(Vec3A::NAN, Vec3A::NAN)
    }
}

/// The primitives of a group; for the world `group_bounds` are the boxes of the other groups.
pub fn primitive_bounds(
    tables: &Tables<'_>,
    range: &GroupRange,
    group_bounds: Option<&[Aabb]>,
) -> PrimitiveBounds {
    bounds(tables, range, group_bounds, false)
}

/// The primitives of a group, triangles in pairs where they can be.
pub fn paired_bounds(
    tables: &Tables<'_>,
    range: &GroupRange,
    group_bounds: Option<&[Aabb]>,
) -> PrimitiveBounds {
    bounds(tables, range, group_bounds, true)
}

/// The primitives of a group, triangles as they are or in pairs.
fn bounds(
    tables: &Tables<'_>,
    range: &GroupRange,
    group_bounds: Option<&[Aabb]>,
    in_pairs: bool,
) -> PrimitiveBounds {
    let mut found = PrimitiveBounds::default();
    let first = range.triangles.start;
    let leaf = |index: u32| Bvh2Node::new(triangle_bounds(tables, index), 1, index - first);
    let triangles = range.triangles.clone().into_par_iter();
    triangles.map(leaf).collect_into_vec(&mut found.leaves);
    if in_pairs {
        let triangles = &tables.triangles[first as usize..range.triangles.end as usize];
        found.partners = TrianglePairs::new(triangles, &found.leaves, first);
    }
    found.compact(first);
    let quadric_start = tables.triangles.len() as u32;
    for index in range.quadrics.clone() {
        let quadric = &tables.quadrics[index as usize];
        found.push(quadric_start + index, quadric_bounds(quadric));
    }
    let instance_start = quadric_start + tables.quadrics.len() as u32;
    for (index, instance) in tables.instances.iter().enumerate().skip(1) {
        let Some(bounds) = group_bounds.and_then(|b| b.get(instance.group as usize)) else {
            continue;
        };
        // The world does not hold itself, and an empty group holds nothing.
        if instance.group != 0 && bounds.valid() {
            let placed = transform_bounds(&instance.to_world, bounds);
            found.push(instance_start + index as u32, placed);
        }
    }
    found
}

/// A box around the image of a box, enlarged by the rounding error of the map.
fn transform_bounds(to_world: &[f32; 12], bounds: &Aabb) -> Aabb {
    let center = bounds.center();
    let half = bounds.max - center;
    let image = transform_point(to_world, center.into());
    let reach = transform_magnitude(to_world, half.into());
    let magnitude = transform_magnitude(to_world, center.into()) + translation(to_world).abs();
    enlarged(image, reach, magnitude)
}

/// The exact box of a quadric: under p -> A p + c the extent along an axis with row a of A is |a| for the sphere,
/// |(a_x, a_y)| for the disk, and that plus the sweep along z for the cylinder.
fn quadric_bounds(quadric: &Quadric) -> Aabb {
    let m = &quadric.to_world;
    let row = |i: usize| Vec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    let rows = [row(0), row(1), row(2)];
    let round = Vec3::from_array(rows.map(|r| r.truncate().length()));
    let along = Vec3::from_array(rows.map(|r| r.z));
    let (center, reach) = match quadric.kind {
        quadric_kind::SPHERE => (Vec3::ZERO, Vec3::from_array(rows.map(Vec3::length))),
        quadric_kind::DISK => (Vec3::ZERO, round),
        _ => (along * 0.5, round + along.abs() * 0.5),
    };
    let magnitude = transform_magnitude(m, Vec3::ONE) + translation(m).abs();
    enlarged(center + translation(m), reach, magnitude)
}

/// The box center +- reach, enlarged by a few roundings of `magnitude`; NaN where anything is NaN.
fn enlarged(center: Vec3, reach: Vec3, magnitude: Vec3) -> Aabb {
    let reach = reach + magnitude * 1e-6;
    if (center + reach).is_nan() {
        return Aabb::new(Vec3A::NAN, Vec3A::NAN);
    }
    Aabb::new((center - reach).into(), (center + reach).into())
}
