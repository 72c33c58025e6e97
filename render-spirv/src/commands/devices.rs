//! `halflight-gpu devices`: lists the devices.

use crate::canary::loop_budget;
use crate::vulkan::{Device, Instance, VulkanError};
use halflight::say::print_line;
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
        print_line(format_args!("{number}  {}", d.name))?;
        print_line(format_args!(
            "   {:?}, Vulkan {}.{}, {}, {} MiB, buffers up to {} MiB",
            d.kind,
            d.version.0,
            d.version.1,
            d.driver.trim(),
            d.memory >> 20,
            d.max_buffer >> 20
        ))?;
        if !d.missing.is_empty() {
            print_line(format_args!(
                "   cannot render: lacks {}",
                d.missing.join(", ")
            ))?;
            continue;
        }
        let said = match loop_budget(&Device::new(&instance, d)?) {
            Ok(u32::MAX) => continue,
            Ok(budget) => format!("ends loops after {budget} iterations of an invocation"),
            Err(error) => format!("cannot render: {error}"),
        };
        print_line(format_args!("   {said}"))?;
    }
    Ok(ExitCode::SUCCESS)
}
