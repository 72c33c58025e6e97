//! What the walk of a single ray needs of a processor: a ray prepared for it, nodes and triangles tested against it.
//!
//! Implementations for any processor and for four lanes are here, that for eight lanes is in `super::avx2`.

use super::node::{self, Children, NodeRay};
use super::triangles::{self, TriangleHit, TriangleRay};
use crate::accel::build::leaf_entry::LeafEntry;
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;

/// The tests for one instruction set.
pub trait InstructionSet {
    /// A ray with what both tests need of it.
    type Ray;

    /// Prepares a ray; its direction is not zero.
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> Self::Ray;

    /// The children of a node that the ray meets in (t_min, t_max).
    fn children(node: &CwBvhNode, ray: &Self::Ray, t_max: f32) -> Children;

    /// The nearest hit in (t_min, t_max) among those of the `entries` whose bits are set in `mask`, of several at the very
    /// same distance the one with the lowest primitive.
    fn nearest(entries: &[LeafEntry], mask: u32, ray: &Self::Ray, t_max: f32) -> TriangleHit;
}

/// A ray for processors without wide vectors.
#[derive(Clone, Copy, Debug)]
pub struct NarrowRay {
    node: NodeRay,
    triangles: TriangleRay,
}

/// Any processor.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl InstructionSet for Portable {
    type Ray = NarrowRay;

    #[inline(always)]
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> NarrowRay {
        NarrowRay {
            node: NodeRay::new(origin, direction, t_min),
            triangles: TriangleRay::new(origin, direction, t_min),
        }
    }

    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &NarrowRay, t_max: f32) -> Children {
        node::portable(node, &ray.node, t_max)
    }

    #[inline(always)]
    fn nearest(entries: &[LeafEntry], mask: u32, ray: &NarrowRay, t_max: f32) -> TriangleHit {
        triangles::portable(entries, mask, &ray.triangles, t_max)
    }
}

/// Four lanes for nodes, on every x86-64 processor; all else as [`Portable`].
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub struct Sse2;

#[cfg(target_arch = "x86_64")]
impl InstructionSet for Sse2 {
    type Ray = NarrowRay;

    #[inline(always)]
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> NarrowRay {
        Portable::ray(origin, direction, t_min)
    }

    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &NarrowRay, t_max: f32) -> Children {
        node::four_lanes(node, &ray.node, t_max)
    }

    #[inline(always)]
    fn nearest(entries: &[LeafEntry], mask: u32, ray: &NarrowRay, t_max: f32) -> TriangleHit {
        Portable::nearest(entries, mask, ray, t_max)
    }
}
