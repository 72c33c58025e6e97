//! The ray tracer of the CPU front end: compressed eight-wide trees, one per group of primitives.
//!
//! [`build`] makes the trees of an [`Accel`], with the help of obvhs. Group 0 is the world; its tree holds its own triangles and
//! quadrics and, as further primitives, the instances, each of which leads into the tree of its group. Rays
//! go through them one by one ([`single`]) or, on processors with AVX-512, many at a time (`stream`); [`simd`] holds the tests of
//! boxes, triangles and spheres that both share. [`CpuTraverse`] is the door.
//!
//! Intersections are those of [`halflight_kernel::scene::intersect`], with the same rounding: the CPU and a shader find the
//! same hit, also where surfaces coincide (see [`halflight_kernel::scene::Traverse::closest_hit`]).
//!
//! Primitives with NaN, infinite or absurd coordinates (beyond [`build::MAX_COORDINATE`]) are left out and counted; rays
//! that are not finite miss. Checked: the same hits as a search of all primitives and as the kernel's BVH2 walk.

pub mod build;
pub mod simd;
pub mod single;
#[cfg(target_arch = "x86_64")]
mod stream;
mod traverse;
mod trees;

pub use build::GroupRange;
pub use build::shader_nodes::ShaderNodes;
pub use traverse::CpuTraverse;
pub use trees::{Accel, Statistics};
