//! From primitives to trees.
//!
//! obvhs builds a binary tree (PLOC, Meister and Bittner 2018, with parallel reinsertion) and folds it into eight-wide
//! nodes. Its recursion and the walks' stacks bound the depth, so a binary tree that comes out deeper than
//! [`MAX_BINARY_DEPTH`] (primitives whose sizes span hundreds of octaves) is replaced by a median split tree.

use super::GroupRange;
use glam::{Vec3, Vec3A};
use halflight_kernel::math::affine::{transform_magnitude, transform_point, translation};
use halflight_kernel::math::vec3;
use halflight_kernel::scene::{Quadric, Tables, quadric_kind};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Coordinates beyond this are not traced: areas of boxes, which the builder adds up, would overflow.
pub const MAX_COORDINATE: f32 = 1e15;

/// The deepest binary tree that is accepted from the builder.
pub const MAX_BINARY_DEPTH: usize = 96;

/// The deepest wide tree that the walk's stack has room for.
pub const MAX_WIDE_DEPTH: usize = 32;

/// Primitives per leaf of a wide tree, at most three.
const MAX_LEAF: u32 = 3;

/// Fraction of a tree's nodes that the first round of reinsertion moves. 0.2 instead of the library's 0.05 gains 5 to 10 %
/// of the rays per second.
const REINSERTED: f32 = 0.2;

/// Most nodes of a round, the uppermost. In a tree of two million nodes the rest took longer to move than a picture of a
/// million paths gained from it.
const MAX_REINSERTED: f32 = 80_000.0;

/// Primitives with their boxes.
#[derive(Clone, Debug, Default)]
pub struct PrimitiveBounds {
    /// Triangles, the number of triangles plus quadrics, or the number of both plus instances.
    pub primitives: Vec<u32>,
    /// Their boxes.
    pub boxes: Vec<Aabb>,
    /// Primitives without a usable box.
    pub skipped: usize,
}

impl PrimitiveBounds {
    fn push(&mut self, primitive: u32, bounds: Aabb) {
        let usable = bounds.min.cmpge(Vec3A::splat(-MAX_COORDINATE)).all()
            && bounds.max.cmple(Vec3A::splat(MAX_COORDINATE)).all();
        if usable {
            self.primitives.push(primitive);
            self.boxes.push(bounds);
        } else {
            self.skipped += 1;
        }
    }
}

/// The primitives of a group; for the world `group_bounds` are the boxes of the other groups.
pub fn primitive_bounds(
    tables: &Tables<'_>,
    range: &GroupRange,
    group_bounds: Option<&[Aabb]>,
) -> PrimitiveBounds {
    let mut found = PrimitiveBounds::default();
    for index in range.triangles.clone() {
        let points = tables.triangles[index as usize]
            .vertices
            .map(|v| Vec3A::from(vec3(tables.positions[v as usize])));
        // NaNs vanish in minima and maxima: they are looked for first.
        if points.iter().all(|p| p.is_finite()) {
            found.push(index, Aabb::from_points(&points));
        } else {
            found.skipped += 1;
        }
    }
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
    /// Primitives in the order of the leaves.
    pub primitives: Vec<u32>,
    /// The box of everything.
    pub bounds: Aabb,
    /// Wide nodes from the root to the deepest leaf.
    pub depth: usize,
}

impl GroupTree {
    /// Builds the tree.
    pub fn build(found: &PrimitiveBounds) -> GroupTree {
        if found.boxes.is_empty() {
            return GroupTree {
                bounds: Aabb::empty(),
                ..GroupTree::default()
            };
        }
        let binary = binary_tree(&found.boxes, MAX_BINARY_DEPTH);
        let mut wide = bvh2_to_cwbvh(&binary, MAX_LEAF, false, false);
        if wide_depth(&wide.nodes) > MAX_WIDE_DEPTH {
            wide = bvh2_to_cwbvh(&median_split_tree(&found.boxes), MAX_LEAF, false, false);
        }
        GroupTree {
            depth: wide_depth(&wide.nodes),
            primitives: wide
                .primitive_indices
                .iter()
                .map(|&i| found.primitives[i as usize])
                .collect(),
            nodes: wide.nodes,
            bounds: wide.total_aabb,
        }
    }
}

/// A binary tree with one primitive per leaf and at most `max_depth` nodes from the root to a leaf.
pub fn binary_tree(boxes: &[Aabb], max_depth: usize) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect::<Vec<_>>();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        indices,
        SortPrecision::U64,
        3,
    );
    if binary_depth(&tree) <= 2 * max_depth {
        let fraction = REINSERTED.min(MAX_REINSERTED / tree.nodes.len() as f32);
        ReinsertionOptimizer::default().run(&mut tree, fraction, None);
    }
    if binary_depth(&tree) > max_depth {
        tree = median_split_tree(boxes);
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

/// Wide nodes from the root to the deepest one.
fn wide_depth(nodes: &[CwBvhNode]) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0u32, 1usize)];
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &nodes[index as usize];
        for child in 0..node.imask.count_ones() {
            stack.push((node.child_base_idx + child, depth + 1));
        }
    }
    deepest
}

/// A tree of depth log2 n: halves by the median along the longest axis of the centres.
fn median_split_tree(boxes: &[Aabb]) -> Bvh2 {
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
    tree.primitive_indices = order;
    tree
}
