//! A device for tests, or the reason why there is none.

#[path = "../../render-cpu/tests/common/skip.rs"]
pub mod skip;

use halflight_spirv::vulkan::{Device, Instance};
use std::sync::Arc;

/// The first device with validation where it is installed. Without one the test is skipped, unless
/// `HALFLIGHT_REQUIRE_VULKAN=1` demands it.
pub fn device() -> Option<Arc<Device>> {
    let opened = Instance::new(false).and_then(|instance| {
        let description = instance.select(None)?;
        Device::new(&instance, description)
    });
    skip::available(opened, "HALFLIGHT_REQUIRE_VULKAN")
}
