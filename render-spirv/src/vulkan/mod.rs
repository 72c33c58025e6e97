//! As much of Vulkan as compute shaders over storage buffers need.
//!
//! All unsafe code of the crate lives in this module; what its files hand out is safe to use: objects keep
//! their device alive, and no buffer is touched by the host while a submission runs, because every submission is waited
//! for before the call returns.

mod allocations;
pub mod device;
pub mod error;
pub mod instance;
pub mod memory;
pub mod pipeline;
mod submission;

pub use device::Device;
pub use error::VulkanError;
pub use instance::{DeviceDescription, DeviceKind, Instance, choose};
pub use memory::{Buffer, Memory};
pub use pipeline::Pipeline;
pub(crate) use pipeline::dispatch_in_order;
