//! Kernel functions on the device against the same functions on the processor.

mod chains;
#[path = "../common.rs"]
mod common;
mod harness;
#[path = "../../../kernel/tests/common/mod.rs"]
mod kernel_common;
mod lobes;
mod microfacets;
mod numbers;
mod random;
mod textures;
mod tolerance;
mod vectors;
