//! Binary trees over boxes.
//!
//! obvhs builds them (PLOC, Meister and Bittner 2018, with parallel reinsertion). Recursion and the walks' stacks bound the
//! depth, so a tree that comes out too deep (primitives whose sizes span hundreds of octaves) is replaced by a median split
//! tree.

use super::bounds::PrimitiveBounds;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, SortPrecision};

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
pub fn clustered_tree(found: PrimitiveBounds, max_depth: usize) -> Bvh2 {
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
pub fn median_split_tree(other: &Bvh2) -> Bvh2 {
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
        .map(|index| other.primitive_indices[index as usize])
        .collect();
    tree
}
