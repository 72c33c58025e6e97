//! The commands of `halflight-gpu`.

pub mod bench;
pub mod devices;
pub mod render;

use crate::vulkan::{Device, Instance, VulkanError};
use clap::Args;
use std::sync::Arc;

/// Which device, and how carefully.
#[derive(Args, Clone, Debug, Default)]
pub struct DeviceArgs {
    /// Device to use: its number in `halflight-gpu devices`, or a part of its name. Default: the first.
    #[arg(long, value_name = "NAME|N")]
    pub device: Option<String>,
    /// Let the Vulkan validation layer watch; a message of it is an error.
    #[arg(long)]
    pub validate: bool,
}

impl DeviceArgs {
    /// Opens the device.
    ///
    /// # Errors
    /// If there is none that fits.
    pub fn open(&self) -> Result<Arc<Device>, VulkanError> {
        let instance = Instance::new(self.validate)?;
        let description = instance.select(self.device.as_deref())?;
        tracing::info!("{} ({})", description.name, description.driver);
        Device::new(&instance, description)
    }
}

/// An error if the validation layer reported anything.
pub(crate) fn check_validation(device: &Device) -> Result<(), VulkanError> {
    match device.instance().validation_messages() {
        0 => Ok(()),
        messages => Err(VulkanError::Validation(messages)),
    }
}
