//! As much of Vulkan as compute shaders over storage buffers need.
//!
//! All unsafe code of the crate lives in [`instance`] and [`device`]; what they hand out is safe to use: objects keep
//! their device alive, and no buffer is touched by the host while a submission runs, because every submission is waited
//! for before the call returns.

pub mod device;
pub mod error;
pub mod instance;

pub use device::{Buffer, Device, Memory, Pipeline};
pub use error::VulkanError;
pub use instance::{DeviceDescription, DeviceKind, Instance};
