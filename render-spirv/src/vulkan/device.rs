//! A logical device with one compute queue.
//!
//! Its operations are implemented beside their objects: buffers in [`super::memory`], entry points in [`super::pipeline`],
//! submissions in `submission`.

use super::allocations::Allocations;
use super::error::{VulkanError, call};
use super::instance::{DeviceDescription, Instance};
use super::pipeline_cache::PipelineCache;
use ash::vk;
use std::sync::{Arc, Mutex};

/// A logical device.
pub struct Device {
    pub(super) raw: ash::Device,
    description: DeviceDescription,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    pub(super) allocations: Allocations,
    pub(super) pipeline_cache: PipelineCache,
    /// The queue and what records for it; one submission at a time.
    pub(super) queue: Mutex<Queue>,
    instance: Arc<Instance>,
}

pub(super) struct Queue {
    pub raw: vk::Queue,
    pool: vk::CommandPool,
    pub commands: vk::CommandBuffer,
    pub fence: vk::Fence,
}

impl Device {
    /// A device that was selected from `instance`.
    ///
    /// # Errors
    /// If the driver refuses.
    pub fn new(
        instance: &Arc<Instance>,
        description: DeviceDescription,
    ) -> Result<Arc<Device>, VulkanError> {
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(description.queue_family)
            .queue_priorities(&priorities)];
        // The modules are compiled without bounds checks: the host writes all tables, and a robust device makes even a
        // wrong index harmless.
        let features =
            vk::PhysicalDeviceFeatures::default().robust_buffer_access(description.robust);
        // Records hold vectors packed as on the host.
        let mut features12 = vk::PhysicalDeviceVulkan12Features::default()
            .vulkan_memory_model(true)
            .scalar_block_layout(true);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .push_next(&mut features12);
        // SAFETY: handle and queue family come from this instance, the features were queried.
        let raw = unsafe { instance.raw.create_device(description.handle, &info, None) }
            .map_err(call("vkCreateDevice"))?;
        // SAFETY: objects of the new device; nothing else uses them yet.
        let queue = unsafe {
            let pool = raw
                .create_command_pool(
                    &vk::CommandPoolCreateInfo::default()
                        .queue_family_index(description.queue_family)
                        .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER),
                    None,
                )
                .map_err(call("vkCreateCommandPool"))?;
            let commands = raw
                .allocate_command_buffers(
                    &vk::CommandBufferAllocateInfo::default()
                        .command_pool(pool)
                        .command_buffer_count(1),
                )
                .map_err(call("vkAllocateCommandBuffers"))?[0];
            let fence = raw
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .map_err(call("vkCreateFence"))?;
            Queue {
                raw: raw.get_device_queue(description.queue_family, 0),
                pool,
                commands,
                fence,
            }
        };
        // SAFETY: the handle comes from this instance.
        let properties = unsafe {
            instance
                .raw
                .get_physical_device_properties(description.handle)
        };
        let pipeline_cache = PipelineCache::new(&raw, &properties)?;
        // SAFETY: the handle comes from this instance.
        let memory = unsafe {
            instance
                .raw
                .get_physical_device_memory_properties(description.handle)
        };
        Ok(Arc::new(Device {
            raw,
            description,
            memory,
            allocations: Allocations::default(),
            pipeline_cache,
            queue: Mutex::new(queue),
            instance: instance.clone(),
        }))
    }

    /// What the device is.
    pub fn description(&self) -> &DeviceDescription {
        &self.description
    }

    /// The instance that the device belongs to.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Whether an earlier run left compiled shaders.
    pub fn has_compiled_shaders(&self) -> bool {
        self.pipeline_cache.is_filled()
    }

    /// Keeps the compiled shaders for the next run.
    pub fn keep_compiled_shaders(&self) {
        self.pipeline_cache.save(&self.raw);
    }

    pub(super) fn name(&self) -> String {
        self.description.name.clone()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let queue = self.queue.get_mut().unwrap_or_else(|e| e.into_inner());
        // SAFETY: buffers and pipelines hold an Arc of the device, so none is left.
        unsafe {
            let _ = self.raw.device_wait_idle();
            self.raw.destroy_fence(queue.fence, None);
            self.raw.destroy_command_pool(queue.pool, None);
            self.raw
                .destroy_pipeline_cache(self.pipeline_cache.raw, None);
            self.raw.destroy_device(None);
        }
    }
}
