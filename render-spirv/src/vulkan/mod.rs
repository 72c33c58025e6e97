//! The part of Vulkan that compute shaders over storage buffers need.
//!
//! All unsafe code of the crate is in this module, behind safe interfaces: objects keep their device alive, and the host does
//! not access a buffer while a submission runs, because every call waits for its submission before it returns.

mod allocations;
pub mod device;
pub mod error;
pub mod instance;
pub mod memory;
pub mod pipeline;
mod pipeline_cache;
mod submission;

pub use device::Device;
pub use error::VulkanError;
pub use instance::{DeviceDescription, DeviceKind, Instance, choose};
pub use memory::{Buffer, Memory};
pub use pipeline::Pipeline;
pub(crate) use pipeline::dispatch_in_order;
