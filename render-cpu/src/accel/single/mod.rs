//! Single rays: nodes and triangles tested for one ray at a time, with as many lanes as the processor has.

#[cfg(target_arch = "x86_64")]
pub mod avx2;
pub mod block;
pub mod lanes;
pub mod node;
