//! Function probes: kernel functions over buffers of inputs, to compare devices with the processor.
//!
//! Host and shaders compile the same files: a probe unpacks a record, calls the kernel and packs the result. On a device every
//! invocation processes one record (`render-spirv/shaders/src/probe.rs`); on the host the same functions give the expected
//! results (`render-spirv/tests/probes`, with the tolerances and their reasons). There is no formula here.

pub mod chains;
pub mod layout;
pub mod lobes;
pub mod microfacets;
pub mod numbers;
pub mod vectors;

use bytemuck::{Pod, Zeroable};

/// Constants of a dispatch of probes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ProbeDispatch {
    /// Number of inputs.
    pub count: u32,
    /// Which function of the family.
    pub function: u32,
}
