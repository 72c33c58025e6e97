//! Which slot of a wide node each of its children takes.
//!
//! Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.3: a
//! ray visits the slots in an order that the signs of its direction alone decide, so that children lie where that order
//! is theirs. The assignment is theirs too, greedy instead of optimal, as in obvhs.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;

/// Up to eight binary nodes, or a slot without one.
#[derive(Clone, Copy)]
pub struct Children {
    /// By slots, or in the order in which they were added.
    pub nodes: [u32; 8],
    /// How many there are.
    pub count: usize,
}

impl Default for Children {
    fn default() -> Children {
        Children {
            nodes: [Children::NONE; 8],
            count: 0,
        }
    }
}

impl Children {
    /// No node.
    pub const NONE: u32 = u32::MAX;

    /// Adds a node behind the others.
    pub fn push(&mut self, node: u32) {
        self.nodes[self.count] = node;
        self.count += 1;
    }

    /// Gives every child the slot of the direction in which rays come upon it early, as far as they do not want the same: bits
    /// of a slot, z the lowest, are set for directions that are negative, and a ray goes through the slots in the order of
    /// their numbers with the bits of its own direction exchanged.
    pub fn order(&mut self, nodes: &[Bvh2Node], bounds: &Aabb) {
        let center = bounds.center();
        let mut costs = [[0.0; 8]; 8];
        for (child, costs) in costs[..self.count].iter_mut().enumerate() {
            let offset = nodes[self.nodes[child] as usize].aabb().center() - center;
            for (slot, cost) in costs.iter_mut().enumerate() {
                let sign = |bit: usize| if slot & bit != 0 { -1.0 } else { 1.0 };
                *cost = Vec3A::new(sign(4), sign(2), sign(1)).dot(offset);
            }
        }
        let unordered = std::mem::take(self);
        let mut left = (1u32 << unordered.count) - 1;
        while left != 0 {
            // The least cost of any child in any slot that is free.
            let (mut least, mut child, mut slot) = (f32::MAX, 8, 8);
            for c in (0..unordered.count).filter(|c| left & (1 << c) != 0) {
                for s in (0..8).filter(|&s| self.nodes[s] == Children::NONE) {
                    if costs[c][s] < least {
                        (least, child, slot) = (costs[c][s], c, s);
                    }
                }
            }
            if child == 8 {
                // Nothing compares: boxes are beyond all floats. Any order will do.
                child = left.trailing_zeros() as usize;
                slot = (0..8)
                    .find(|&s| self.nodes[s] == Children::NONE)
                    .unwrap_or(0);
            }
            self.nodes[slot] = unordered.nodes[child];
            left &= !(1 << child);
        }
        self.count = unordered.count;
    }

    /// Slots that hold a node, and the nodes.
    pub fn slots(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        let slots = self.nodes.iter().copied().enumerate();
        slots.filter(|&(_, node)| node != Children::NONE)
    }
}
