//! A device for tests, or the reason why there is none.

use halflight_spirv::vulkan::{Device, Instance};
use std::sync::Arc;

/// The first device with validation where it is installed. Without one the test is skipped, unless
/// `HALFLIGHT_REQUIRE_VULKAN=1` demands it.
pub fn device() -> Option<Arc<Device>> {
    let opened = Instance::new(false).and_then(|instance| {
        let description = instance.select(None)?;
        Device::new(&instance, description)
    });
    match opened {
        Ok(device) => Some(device),
        Err(error) if std::env::var_os("HALFLIGHT_REQUIRE_VULKAN").is_some() => {
            panic!("HALFLIGHT_REQUIRE_VULKAN is set: {error}")
        }
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}
