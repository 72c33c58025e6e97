//! `halflight-gpu devices`: lists the devices.

use crate::canary::loop_budget;
use crate::vulkan::{Device, Instance, VulkanError};
use std::error::Error;
use std::process::ExitCode;

/// Prints all devices, in the order of preference.
///
/// # Errors
/// If there is no loader or no device.
pub fn run() -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let instance = Instance::new(false)?;
    let devices = instance.devices()?;
    if devices.is_empty() {
        return Err(VulkanError::NoDevice.into());
    }
    for (number, d) in devices.into_iter().enumerate() {
        println!("{number}  {}", d.name);
        println!(
            "   {:?}, Vulkan {}.{}, {}, {} MiB, buffers up to {} MiB",
            d.kind,
            d.version.0,
            d.version.1,
            d.driver.trim(),
            d.memory >> 20,
            d.max_buffer >> 20
        );
        if !d.missing.is_empty() {
            println!("   cannot render: lacks {}", d.missing.join(", "));
            continue;
        }
        match loop_budget(&Device::new(&instance, d)?) {
            Ok(u32::MAX) => {}
            Ok(budget) => println!("   ends loops after {budget} iterations of an invocation"),
            Err(error) => println!("   cannot render: {error}"),
        }
    }
    Ok(ExitCode::SUCCESS)
}
