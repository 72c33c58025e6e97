//! Measures how many loop iterations an invocation can take: some software devices end all loops early.

use crate::interface::Dispatch;
use crate::module;
use crate::vulkan::{Device, Memory, VulkanError};
use std::sync::Arc;
use std::time::Duration;

/// Number of iterations tried: twice the known limit.
const ITERATIONS: u32 = 1 << 17;

/// Loop iterations that one invocation completes on `device`, [`u32::MAX`] if there is no limit in sight.
///
/// # Errors
/// If the device fails.
pub fn loop_budget(device: &Arc<Device>) -> Result<u32, VulkanError> {
    let mut result = device.create_buffer("the canary's result", 4, Memory::Host)?;
    result.write(&[0u32]);
    let pipeline = device.create_pipeline(
        &module::words(),
        c"canary::canary",
        &[&result],
        size_of::<Dispatch>() as u32,
    )?;
    let dispatch = Dispatch {
        count: ITERATIONS,
        ..Dispatch::default()
    };
    pipeline.dispatch("the canary", &dispatch, 1, Duration::from_secs(30))?;
    let mut counted = [0u32];
    result.read(&mut counted);
    Ok(if counted[0] >= ITERATIONS {
        u32::MAX
    } else {
        counted[0]
    })
}
