//! Function probes: kernel functions over buffers of inputs, to compare devices with the processor.
//!
//! Host and shaders compile these very files: a probe unpacks a record, calls the kernel and packs what it returns. On a
//! device every invocation takes one record (`render-spirv/shaders/src/probe.rs`), on the host the same functions give
//! what is expected (`render-spirv/tests/probes.rs`, with the tolerances and their reasons). There is no formula here.

pub mod chains;
pub mod layout;
pub mod lobes;
pub mod microfacets;
pub mod numbers;
pub mod vectors;

use bytemuck::{Pod, Zeroable};

/// What a dispatch of probes is told.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ProbeDispatch {
    /// Number of inputs.
    pub count: u32,
    /// Which function of the family.
    pub function: u32,
}
