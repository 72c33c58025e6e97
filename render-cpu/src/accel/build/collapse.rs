//! From binary trees to compressed eight-wide nodes.
//!
//! Which binary nodes become wide nodes and which subtrees become leaves minimises the expected cost of a ray (Ylitie, Karras
//! and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3). With A(n) half
//! the area of the box of n, P(n) the primitives below it and C(n, i) the cost of the subtree in at most i slots of a node:
//!
//! C(n, 1) = min(c A(n) P(n), A(n) + min_k C(l, k) + C(r, 8 - k)), the first only up to three primitives,
//! C(n, i) = min(C(n, i - 1), min_k C(l, k) + C(r, i - k)),
//!
//! where c is the cost of a primitive and that of a node is 1.
//!
//! The same function is in obvhs (`bvh2_to_cwbvh`), with c = 0.3. It keeps 56 bytes for every binary node, walks them with one thread,
//! and took a third of the time before the first ray; here costs live on the stack only, what was chosen takes four
//! bytes, and both walks are shared by all threads. Invariants (tests): the nodes are those of obvhs, to the bit, and the
//! same for any number of threads.
//!
//! In one point they may differ: the step of the grid is found by its bits rather than by logarithms, whose rounding can
//! make it half of what the box needs.

use super::slots::Children;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::node::CwBvhNode;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use std::sync::atomic::{AtomicU32, Ordering};

/// Primitives per leaf of a wide tree; the node format holds three.
const MAX_LEAF: u32 = 3;

/// Binary nodes below this many levels of a large tree are priced by one thread.
const SHARED_LEVELS: usize = 10;

/// Trees with fewer binary nodes are not worth sharing.
const MIN_SHARED: usize = 1 << 13;

/// Level of the wide nodes whose subtrees are made by one thread each.
const PART_LEVEL: usize = 3;

/// A tree of wide nodes.
#[derive(Clone, Debug, Default)]
pub struct WideTree {
    /// Nodes, the root first. Children of a node that are nodes follow one another.
    pub nodes: Vec<CwBvhNode>,
    /// Primitives in the order of the leaves.
    pub primitives: Vec<u32>,
    /// Nodes from the root to the deepest one.
    pub depth: usize,
}

/// The wide nodes of a tree with one primitive per leaf, which costs `primitive_cost` nodes; `None` if it has more than `max_depth` nodes from the root to
/// some leaf.
pub fn collapse(tree: &Bvh2, primitive_cost: f32, max_depth: usize) -> Option<WideTree> {
    if tree.nodes.is_empty() {
        return Some(WideTree::default());
    }
    let plan = Plan {
        tree,
        primitive_cost,
        max_depth: max_depth as u32,
        shared_levels: match tree.nodes.len() {
            0..MIN_SHARED => 0,
            _ => SHARED_LEVELS as u32,
        },
        choices: tree.nodes.iter().map(|_| AtomicU32::new(0)).collect(),
    };
    let root = plan.subtree_cost(0, 1);
    (root.depth <= plan.max_depth).then(|| plan.wide_tree())
}

/// What a subtree costs.
#[derive(Clone, Copy)]
struct SubtreeCost {
    /// In at most 1, 2, ... 7 slots.
    costs: [f32; 7],
    primitives: u32,
    /// Nodes to the deepest leaf; more than the limit where one was found.
    depth: u32,
}

/// What was chosen for a binary node: four bits for each number of slots but the first, 1 + the index of the cost of
/// the left child if the node is dissolved into its children, 0 if it takes fewer slots. The first three bits are the
/// left child's index if it becomes a wide node, the fourth says that it becomes a leaf.
type Choice = u32;

/// In a [`Choice`].
const IS_LEAF: Choice = 8;

struct Plan<'a> {
    tree: &'a Bvh2,
    primitive_cost: f32,
    max_depth: u32,
    shared_levels: u32,
    choices: Vec<AtomicU32>,
}

impl Plan<'_> {
    /// Chooses for the subtree at `index`, which is node number `level` from the root on.
    fn subtree_cost(&self, index: usize, level: u32) -> SubtreeCost {
        let node = &self.tree.nodes[index];
        let area = node.aabb().half_area();
        if node.is_leaf() {
            self.choices[index].store(IS_LEAF, Ordering::Relaxed);
            return SubtreeCost {
                costs: [area * self.primitive_cost; 7],
                primitives: 1,
                depth: 1,
            };
        }
        if level >= self.max_depth {
            return SubtreeCost {
                costs: [0.0; 7],
                primitives: 0,
                depth: self.max_depth + 1,
            };
        }
        let first = node.first_index as usize;
        let left = || self.subtree_cost(first, level + 1);
        let right = || self.subtree_cost(first + 1, level + 1);
        let (left, right) = if level < self.shared_levels {
            rayon::join(left, right)
        } else {
            (left(), right())
        };
        let primitives = left.primitives + right.primitives;
        let (l, r) = (&left.costs, &right.costs);
        let mut costs = [0.0; 7];

        let mut least = f32::INFINITY;
        let mut choice = 0;
        for k in 0..7 {
            let cost = l[k] + r[6 - k];
            if cost < least {
                (least, choice) = (cost, k as Choice);
            }
        }
        costs[0] = least + area;
        if primitives <= MAX_LEAF {
            let leaf = primitives as f32 * area * self.primitive_cost;
            if leaf < costs[0] {
                costs[0] = leaf;
                choice |= IS_LEAF;
            }
        }
        for i in 1..7 {
            let mut least = costs[i - 1];
            let mut best = 0;
            for k in 0..i {
                let cost = l[k] + r[i - 1 - k];
                if cost < least {
                    (least, best) = (cost, k as Choice + 1);
                }
            }
            costs[i] = least;
            choice |= best << (4 * i);
        }
        self.choices[index].store(choice, Ordering::Relaxed);
        SubtreeCost {
            costs,
            primitives,
            depth: (1 + left.depth.max(right.depth)).min(self.max_depth + 1),
        }
    }

    fn choice(&self, index: u32) -> Choice {
        self.choices[index as usize].load(Ordering::Relaxed)
    }

    /// The binary nodes that are the children of the wide node of a binary one, in their slots.
    fn children(&self, index: u32) -> Children {
        let mut children = Children::default();
        if self.tree.nodes[index as usize].is_leaf() {
            children.push(index);
        } else {
            let left = self.choice(index) & 7;
            self.append_children(index, left, 6 - left, &mut children);
        }
        children.order(&self.tree.nodes, self.tree.nodes[index as usize].aabb());
        children
    }

    /// Appends the children of `index`, which have the costs of the given indices, or what they append_children into.
    fn append_children(&self, index: u32, left: u32, right: u32, children: &mut Children) {
        let first = self.tree.nodes[index as usize].first_index;
        for (child, slots) in [(first, left), (first + 1, right)] {
            // The choices for 2 to `slots` + 1 slots, of which the last that is not "fewer" counts.
            let choices = self.choice(child) & ((16 << (4 * slots)) - 16);
            if choices == 0 {
                children.push(child);
            } else {
                let slots = choices.ilog2() / 4;
                let left = (choices >> (4 * slots)) - 1;
                self.append_children(child, left, slots - 1 - left, children);
            }
        }
    }

    fn wide_tree(&self) -> WideTree {
        let mut tree = WideTree {
            nodes: vec![CwBvhNode::default()],
            primitives: Vec::with_capacity(self.tree.nodes.len() / 2 + 1),
            depth: 0,
        };
        if self.tree.nodes.len() < MIN_SHARED || rayon::current_num_threads() == 1 {
            self.fill(&mut tree, 0, 0, 1, &mut [].into_iter());
            return tree;
        }
        let mut roots = Vec::new();
        self.part_roots(0, 1, &mut roots);
        let parts: Vec<WideTree> = roots.par_iter().map(|&root| self.part(root)).collect();
        let nodes = parts.iter().map(|part| part.nodes.len()).sum::<usize>();
        tree.nodes.reserve(nodes + 8 * parts.len());
        self.fill(&mut tree, 0, 0, 1, &mut parts.into_iter());
        tree
    }

    /// Binary nodes of the wide ones at [`PART_LEVEL`], in the order in which [`Self::fill`] comes upon them.
    fn part_roots(&self, index: u32, level: usize, roots: &mut Vec<u32>) {
        if level == PART_LEVEL {
            roots.push(index);
            return;
        }
        for (_, child) in self.children(index).slots() {
            if self.choice(child) & IS_LEAF == 0 {
                self.part_roots(child, level + 1, roots);
            }
        }
    }

    /// The wide tree of a part.
    fn part(&self, root: u32) -> WideTree {
        let mut tree = WideTree {
            nodes: vec![CwBvhNode::default()],
            ..WideTree::default()
        };
        self.fill(&mut tree, 0, root, PART_LEVEL, &mut [].into_iter());
        tree
    }

    /// Makes the wide node of a binary one at `target`, and everything below it. `parts` are what was made before of the
    /// nodes at [`PART_LEVEL`], or nothing.
    fn fill(
        &self,
        tree: &mut WideTree,
        target: usize,
        index: u32,
        level: usize,
        parts: &mut dyn Iterator<Item = WideTree>,
    ) {
        if level == PART_LEVEL
            && let Some(part) = parts.next()
        {
            tree.splice(target, part);
            return;
        }
        tree.depth = tree.depth.max(level);
        let children = self.children(index);
        let nodes = &self.tree.nodes;
        let mut node = new_node(nodes[index as usize].aabb());
        node.primitive_base_idx = tree.primitives.len() as u32;
        node.child_base_idx = tree.nodes.len() as u32;
        for (slot, child) in children.slots() {
            quantize(&mut node, slot, nodes[child as usize].aabb());
            node.child_meta[slot] = if self.choice(child) & IS_LEAF != 0 {
                let first = tree.primitives.len();
                self.push_primitives(child, &mut tree.primitives);
                let count = tree.primitives.len() - first;
                // Counted in unary.
                let unary = ((1 << count) - 1) << 5;
                unary | (first - node.primitive_base_idx as usize) as u8
            } else {
                node.imask |= 1 << slot;
                0b0010_0000 | (24 + slot as u8)
            };
        }
        tree.nodes[target] = node;
        let mut target = tree.nodes.len();
        let inner = node.imask.count_ones() as usize;
        tree.nodes.resize(target + inner, CwBvhNode::default());
        for (slot, child) in children.slots() {
            if node.imask & (1 << slot) != 0 {
                self.fill(tree, target, child, level + 1, parts);
                target += 1;
            }
        }
    }

    /// The primitives below a binary node, from left to right.
    fn push_primitives(&self, index: u32, primitives: &mut Vec<u32>) {
        let node = &self.tree.nodes[index as usize];
        if node.is_leaf() {
            primitives.push(self.tree.primitive_indices[node.first_index as usize]);
        } else {
            self.push_primitives(node.first_index, primitives);
            self.push_primitives(node.first_index + 1, primitives);
        }
    }
}

impl WideTree {
    /// Puts the root of `part` at `target` and appends the rest.
    fn splice(&mut self, target: usize, part: WideTree) {
        let (nodes, primitives) = (self.nodes.len() as u32 - 1, self.primitives.len() as u32);
        let mut moved = part.nodes.iter().map(|node| CwBvhNode {
            child_base_idx: node.child_base_idx + nodes,
            primitive_base_idx: node.primitive_base_idx + primitives,
            ..*node
        });
        if let Some(root) = moved.next() {
            self.nodes[target] = root;
        }
        self.nodes.extend(moved);
        self.primitives.extend_from_slice(&part.primitives);
        self.depth = self.depth.max(part.depth);
    }
}

/// A node without children, with the grid of a box: 255 steps of a power of two from its lower corner on.
fn new_node(bounds: &Aabb) -> CwBvhNode {
    let extent = (bounds.max - bounds.min).max(Vec3A::splat(1e-20));
    // The least power of two that is no less; `x` is positive and normal.
    let exponent = |x: f32| (x.to_bits().wrapping_add(0x7f_ffff) >> 23) as u8;
    CwBvhNode {
        p: bounds.min.into(),
        e: (extent * (1.0 / 255.0)).to_array().map(exponent),
        ..CwBvhNode::default()
    }
}

/// Sets the box of a child, rounded outwards to the node's grid.
fn quantize(node: &mut CwBvhNode, slot: usize, bounds: &Aabb) {
    let corner = Vec3A::from(node.p);
    let per_step = 1.0 / Vec3A::from_array(node.e.map(|e| f32::from_bits(u32::from(e) << 23)));
    let limit = |v: Vec3A| v.clamp(Vec3A::ZERO, Vec3A::splat(255.0)).to_array();
    let min = limit(((bounds.min - corner) * per_step).floor());
    let max = limit(((bounds.max - corner) * per_step).ceil());
    node.child_min_x[slot] = min[0] as u8;
    node.child_min_y[slot] = min[1] as u8;
    node.child_min_z[slot] = min[2] as u8;
    node.child_max_x[slot] = max[0] as u8;
    node.child_max_y[slot] = max[1] as u8;
    node.child_max_z[slot] = max[2] as u8;
}
