//! From primitives to trees.
//!
//! obvhs builds a binary tree (PLOC, Meister and Bittner 2018, with parallel reinsertion), which [`collapse()`] folds into
//! eight-wide nodes. Recursion and the walks' stacks bound the depth, so a binary tree that comes out deeper than
//! [`MAX_BINARY_DEPTH`] (primitives whose sizes span hundreds of octaves) is replaced by a median split tree.
//!
//! A build touches memory that is then given back, and touching it costs as much as the work on it. So boxes are made
//! once, as the leaves that the builder takes over, and are not kept beside its tree.

use super::collapse::{WideTree, collapse};
use super::pairs::Partners;
use crate::accel::GroupRange;
use glam::{Vec3, Vec3A};
use halflight_kernel::math::affine::{transform_magnitude, transform_point, translation};
use halflight_kernel::math::vec3;
use halflight_kernel::scene::{NONE, Quadric, Tables, quadric_kind};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ploc::{PlocBuilder, SortPrecision};
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator,
};

/// Coordinates beyond this are not traced: areas of boxes, which the builder adds up, would overflow.
pub const MAX_COORDINATE: f32 = 1e15;

/// The deepest binary tree that is accepted from the builder.
pub const MAX_BINARY_DEPTH: usize = 96;

/// The deepest wide tree that the walk's stack has room for.
pub const MAX_WIDE_DEPTH: usize = 32;

/// Cost of a place, where that of a node is 1. From 0.4 to 0.7 times of rendering do not differ.
const PLACE_COST: f32 = 0.5;

/// Neighbours on either side among which the builder looks for a node's partner.
const SEARCH_DISTANCE: usize = 14;

/// Rounds at the start in which it looks at the next ones only.
const NEAREST_ROUNDS: usize = 3;

/// Fraction of a tree's nodes that the first round of reinsertion moves. 0.2 instead of the library's 0.05 gains 5 to 10 %
/// of the rays per second.
const REINSERTED: f32 = 0.2;

/// Most nodes of a round, the uppermost. In a tree of two million nodes the rest took longer to move than a picture of a
/// million paths gained from it.
const MAX_REINSERTED: f32 = 80_000.0;

/// Primitives with their boxes.
#[derive(Clone, Debug, Default)]
pub struct PrimitiveBounds {
    /// Triangles, the number of triangles plus quadrics, or the number of both plus instances. Of pairs the first.
    pub primitives: Vec<u32>,
    /// The others.
    pub partners: Partners,
    /// Their boxes: a leaf each, with the place in `primitives`.
    pub leaves: Vec<Bvh2Node>,
    /// Primitives without a usable box.
    pub skipped: usize,
}

impl PrimitiveBounds {
    fn push(&mut self, primitive: u32, bounds: Aabb) {
        if is_usable(&bounds) {
            let place = self.primitives.len() as u32;
            self.leaves.push(Bvh2Node::new(bounds, 1, place));
            self.primitives.push(primitive);
        } else {
            self.skipped += 1;
        }
    }

    /// Makes the leaves of triangles, whose numbers begin with `first`, those of pairs, and leaves out what has no usable box.
    fn close_up(&mut self, first: u32) {
        self.primitives.reserve(self.leaves.len());
        let mut place = 0;
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
            self.leaves[place] = Bvh2Node::new(bounds, 1, place as u32);
            self.primitives.push(primitive);
            place += 1;
        }
        self.leaves.truncate(place);
    }

    /// The box of everything.
    fn total(&self) -> Aabb {
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
pub fn place_bounds(
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
        found.partners = Partners::new(triangles, &found.leaves, first);
    }
    found.close_up(first);
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

/// A box around the image of a box, with room for the rounding of the map.
fn transform_bounds(to_world: &[f32; 12], bounds: &Aabb) -> Aabb {
    let center = bounds.center();
    let half = bounds.max - center;
    let image = transform_point(to_world, center.into());
    let reach = transform_magnitude(to_world, half.into());
    let magnitude = transform_magnitude(to_world, center.into()) + translation(to_world).abs();
    grown(image, reach, magnitude)
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
    grown(center + translation(m), reach, magnitude)
}

/// The box center +- reach, grown by a few roundings of `magnitude`; NaN where anything is NaN.
fn grown(center: Vec3, reach: Vec3, magnitude: Vec3) -> Aabb {
    let reach = reach + magnitude * 1e-6;
    if (center + reach).is_nan() {
        return Aabb::new(Vec3A::NAN, Vec3A::NAN);
    }
    Aabb::new((center - reach).into(), (center + reach).into())
}

/// The wide tree of a group.
#[derive(Clone, Debug, Default)]
pub struct GroupTree {
    /// Nodes; empty for an empty group.
    pub nodes: Vec<CwBvhNode>,
    /// Primitives in the order of the leaves, with their partners or [`NONE`].
    pub places: Vec<[u32; 2]>,
    /// The box of everything.
    pub bounds: Aabb,
    /// Wide nodes from the root to the deepest leaf.
    pub depth: usize,
}

impl GroupTree {
    /// Builds the tree.
    pub fn build(mut found: PrimitiveBounds) -> GroupTree {
        let partners = std::mem::take(&mut found.partners);
        if found.leaves.is_empty() {
            return GroupTree {
                bounds: Aabb::empty(),
                ..GroupTree::default()
            };
        }
        let mut binary = clustered_tree(found, MAX_BINARY_DEPTH);
        let wide = collapse(&binary, PLACE_COST, MAX_BINARY_DEPTH);
        let wide = wide
            .filter(|wide| wide.depth <= MAX_WIDE_DEPTH)
            .unwrap_or_else(|| {
                binary = median_split_tree(&binary);
                // It is as shallow as can be.
                collapse(&binary, PLACE_COST, MAX_BINARY_DEPTH).unwrap_or_default()
            });
        let WideTree {
            nodes,
            primitives,
            depth,
        } = wide;
        let places = primitives.into_iter();
        GroupTree {
            nodes,
            places: places.map(|p| [p, partners.of(p)]).collect(),
            bounds: *binary.nodes[0].aabb(),
            depth,
        }
    }
}

/// A binary tree with one primitive per leaf and at most `max_depth` nodes from the root to a leaf. Its indices are those
/// of the primitives.
pub fn binary_tree(found: PrimitiveBounds, max_depth: usize) -> Bvh2 {
    let tree = clustered_tree(found, max_depth);
    if binary_depth(&tree) > max_depth {
        return median_split_tree(&tree);
    }
    tree
}

/// [`binary_tree`] of any depth.
fn clustered_tree(found: PrimitiveBounds, max_depth: usize) -> Bvh2 {
    let count = found.leaves.len();
    let total = found.total();
    let mut tree = Bvh2::zeroed(count);
    tree.primitive_indices = found.primitives;
    let mut builder = PlocBuilder::with_capacity(count);
    builder.current_nodes = found.leaves;
    builder.build_ploc_from_leaves::<SEARCH_DISTANCE, false>(
        &mut tree,
        total,
        SortPrecision::U64,
        NEAREST_ROUNDS,
    );
    drop(builder);
    // The builder's rounds are an upper bound.
    if tree.max_depth <= 2 * max_depth || binary_depth(&tree) <= 2 * max_depth {
        let fraction = REINSERTED.min(MAX_REINSERTED / tree.nodes.len() as f32);
        ReinsertionOptimizer::default().run(&mut tree, fraction, None);
    }
    tree
}

/// Nodes from the root to the deepest leaf.
pub fn binary_depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0usize, 1usize)];
    while let Some((index, depth)) = stack.pop() {
        let Some(node) = tree.nodes.get(index) else {
            break;
        };
        deepest = deepest.max(depth);
        if !node.is_leaf() {
            stack.push((node.first_index as usize, depth + 1));
            stack.push((node.first_index as usize + 1, depth + 1));
        }
    }
    deepest
}

/// A tree of depth log2 n over the leaves of another one: halves by the median along the longest axis of the centres.
fn median_split_tree(other: &Bvh2) -> Bvh2 {
    let mut boxes = vec![Aabb::empty(); other.primitive_indices.len()];
    for leaf in other.nodes.iter().filter(|node| node.is_leaf()) {
        boxes[leaf.first_index as usize] = *leaf.aabb();
    }
    let mut tree = Bvh2::zeroed(boxes.len());
    let mut order = (0..boxes.len() as u32).collect::<Vec<_>>();
    let mut next = 1;
    let mut stack = vec![(0usize, 0..boxes.len())];
    while let Some((index, range)) = stack.pop() {
        let slice = &mut order[range.clone()];
        let bounds = slice
            .iter()
            .fold(Aabb::empty(), |b, &i| b.union(&boxes[i as usize]));
        if slice.len() == 1 {
            tree.nodes[index] = Bvh2Node::new(bounds, 1, range.start as u32);
            continue;
        }
        let mut centers = Aabb::empty();
        for &i in slice.iter() {
            centers.extend(boxes[i as usize].center());
        }
        let axis = centers.largest_axis();
        let middle = slice.len() / 2;
        slice.select_nth_unstable_by(middle, |&a, &b| {
            let key = |i: u32| boxes[i as usize].center_axis(axis);
            key(a).total_cmp(&key(b))
        });
        tree.nodes[index] = Bvh2Node::new(bounds, 0, next as u32);
        stack.push((next, range.start..range.start + middle));
        stack.push((next + 1, range.start + middle..range.end));
        next += 2;
    }
    tree.primitive_indices = order
        .into_iter()
        .map(|place| other.primitive_indices[place as usize])
        .collect();
    tree
}
