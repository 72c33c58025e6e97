//! Single rays: a walk over eight-wide nodes, compiled for each instruction set.
//!
//! `walk` goes through the tree; a node's eight children ([`node`]) and the triangles of its leaves ([`triangles`]) are tested with
//! as many lanes as the [`instruction_set`] has.

#[cfg(target_arch = "x86_64")]
pub mod avx2;
pub mod instruction_set;
pub mod node;
pub mod triangles;
pub(super) mod walk;
