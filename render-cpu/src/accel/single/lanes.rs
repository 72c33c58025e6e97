//! What the walk needs of a processor: a ray prepared for it, nodes and triangles tested against it.

use super::block::{self, BlockHit, BlockRay};
use super::node::{self, Children, NodeRay};
use crate::accel::build::packed::Place;
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;

/// The tests for one kind of processor.
pub trait Lanes {
    /// A ray with what both tests need of it.
    type Ray;

    /// Prepares a ray; its direction is not zero.
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> Self::Ray;

    /// The children of a node that the ray meets in (t_min, t_max).
    fn children(node: &CwBvhNode, ray: &Self::Ray, t_max: f32) -> Children;

    /// The nearest hit in (t_min, t_max) among those of the `places` whose bits are set in `mask`, of several at the very
    /// same distance the one with the lowest primitive.
    fn nearest(places: &[Place], mask: u32, ray: &Self::Ray, t_max: f32) -> BlockHit;
}

/// A ray for processors without wide vectors.
#[derive(Clone, Copy, Debug)]
pub struct NarrowRay {
    node: NodeRay,
    block: BlockRay,
}

/// Any processor.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Lanes for Portable {
    type Ray = NarrowRay;

    #[inline(always)]
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> NarrowRay {
        NarrowRay {
            node: NodeRay::new(origin, direction, t_min),
            block: BlockRay::new(origin, direction, t_min),
        }
    }

    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &NarrowRay, t_max: f32) -> Children {
        node::portable(node, &ray.node, t_max)
    }

    #[inline(always)]
    fn nearest(places: &[Place], mask: u32, ray: &NarrowRay, t_max: f32) -> BlockHit {
        block::portable(places, mask, &ray.block, t_max)
    }
}

/// Four lanes for nodes, on every x86-64 processor; all else as [`Portable`].
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub struct Sse2;

#[cfg(target_arch = "x86_64")]
impl Lanes for Sse2 {
    type Ray = NarrowRay;

    #[inline(always)]
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> NarrowRay {
        Portable::ray(origin, direction, t_min)
    }

    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &NarrowRay, t_max: f32) -> Children {
        node::twice_four(node, &ray.node, t_max)
    }

    #[inline(always)]
    fn nearest(places: &[Place], mask: u32, ray: &NarrowRay, t_max: f32) -> BlockHit {
        Portable::nearest(places, mask, ray, t_max)
    }
}

#[cfg(target_arch = "x86_64")]
pub use super::avx2::Avx2;
