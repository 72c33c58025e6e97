//! A logical device with one compute queue: buffers, pipelines, and submissions that are waited for.

use super::error::{VulkanError, call};
use super::instance::{DeviceDescription, Instance};
use ash::vk;
use bytemuck::{NoUninit, Pod};
use std::ffi::CStr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Where a buffer lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Fast for the device.
    Device,
    /// Readable and writable by the host, and visible to the device.
    Host,
}

/// A logical device.
pub struct Device {
    raw: ash::Device,
    description: DeviceDescription,
    memory: vk::PhysicalDeviceMemoryProperties,
    /// The queue and what records for it; one submission at a time.
    queue: Mutex<Queue>,
    instance: Arc<Instance>,
}

struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

/// A buffer with memory of its own.
pub struct Buffer {
    raw: vk::Buffer,
    memory: vk::DeviceMemory,
    /// Start of the mapping, for [`Memory::Host`].
    mapped: *mut u8,
    /// Bytes asked for; the buffer itself holds at least one word.
    size: u64,
    device: Arc<Device>,
}

/// An entry point with its buffers bound.
pub struct Pipeline {
    raw: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    device: Arc<Device>,
}

// SAFETY: the mapping is only reached through &self (reads) and &mut self (writes), as any memory.
unsafe impl Send for Buffer {}

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
        let mut features12 =
            vk::PhysicalDeviceVulkan12Features::default().vulkan_memory_model(true);
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
        let memory = unsafe {
            instance
                .raw
                .get_physical_device_memory_properties(description.handle)
        };
        Ok(Arc::new(Device {
            raw,
            description,
            memory,
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

    fn name(&self) -> String {
        self.description.name.clone()
    }

    fn memory_type(&self, allowed: u32, place: Memory) -> Option<u32> {
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let wishes = match place {
            Memory::Device => [
                vk::MemoryPropertyFlags::DEVICE_LOCAL,
                vk::MemoryPropertyFlags::empty(),
            ],
            // Cached memory is what the host reads fast.
            Memory::Host => [host | vk::MemoryPropertyFlags::HOST_CACHED, host],
        };
        let types = self.memory.memory_types_as_slice();
        wishes.into_iter().find_map(|wish| {
            (0..types.len() as u32).find(|&i| {
                allowed & (1 << i) != 0 && types[i as usize].property_flags.contains(wish)
            })
        })
    }

    /// An uninitialised storage buffer of `size` bytes; `what` names it in messages.
    ///
    /// # Errors
    /// If it is larger than a shader may see or does not fit into memory.
    pub fn create_buffer(
        self: &Arc<Self>,
        what: &str,
        size: u64,
        place: Memory,
    ) -> Result<Buffer, VulkanError> {
        if size > self.description.max_buffer {
            return Err(VulkanError::TooLarge {
                what: what.to_string(),
                bytes: size,
                device: self.name(),
                limit: self.description.max_buffer,
            });
        }
        let failed = |result| match result {
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
                VulkanError::OutOfMemory {
                    what: what.to_string(),
                    bytes: size,
                    device: self.name(),
                }
            }
            result => VulkanError::Call {
                call: "vkAllocateMemory",
                result,
            },
        };
        let info = vk::BufferCreateInfo::default().size(size.max(4)).usage(
            vk::BufferUsageFlags::STORAGE_BUFFER
                | vk::BufferUsageFlags::TRANSFER_SRC
                | vk::BufferUsageFlags::TRANSFER_DST,
        );
        // SAFETY: a fresh buffer; the guard below destroys it should a later step fail.
        let raw = unsafe { self.raw.create_buffer(&info, None) }.map_err(failed)?;
        let mut buffer = Buffer {
            raw,
            memory: vk::DeviceMemory::null(),
            mapped: std::ptr::null_mut(),
            size,
            device: self.clone(),
        };
        // SAFETY: the buffer is alive.
        let needs = unsafe { self.raw.get_buffer_memory_requirements(raw) };
        let kind = self
            .memory_type(needs.memory_type_bits, place)
            .ok_or_else(|| failed(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY))?;
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(needs.size)
            .memory_type_index(kind);
        // SAFETY: the allocation is as large as the buffer needs, of a type that it allows, bound once and mapped once.
        unsafe {
            buffer.memory = self.raw.allocate_memory(&info, None).map_err(failed)?;
            self.raw
                .bind_buffer_memory(raw, buffer.memory, 0)
                .map_err(failed)?;
            if place == Memory::Host {
                buffer.mapped = self
                    .raw
                    .map_memory(
                        buffer.memory,
                        0,
                        vk::WHOLE_SIZE,
                        vk::MemoryMapFlags::empty(),
                    )
                    .map_err(call("vkMapMemory"))?
                    .cast();
            }
        }
        Ok(buffer)
    }

    /// A buffer in device memory that holds `table`, copied there through staging memory.
    ///
    /// # Errors
    /// As [`Device::create_buffer`], or if the copy fails.
    pub fn upload<T: NoUninit>(
        self: &Arc<Self>,
        what: &str,
        table: &[T],
    ) -> Result<Buffer, VulkanError> {
        let bytes: &[u8] = bytemuck::cast_slice(table);
        let buffer = self.create_buffer(what, bytes.len() as u64, Memory::Device)?;
        if bytes.is_empty() {
            return Ok(buffer);
        }
        let mut staging = self.create_buffer(what, bytes.len() as u64, Memory::Host)?;
        staging.write(bytes);
        self.run(what, Duration::from_secs(60), |commands| {
            let region = [vk::BufferCopy::default().size(bytes.len() as u64)];
            // SAFETY: both buffers are as large as the region and live until the submission ends.
            unsafe {
                self.raw
                    .cmd_copy_buffer(commands, staging.raw, buffer.raw, &region);
            }
        })?;
        Ok(buffer)
    }

    /// Records, submits and waits.
    fn run(
        &self,
        what: &str,
        limit: Duration,
        record: impl FnOnce(vk::CommandBuffer),
    ) -> Result<(), VulkanError> {
        let queue = self.queue.lock().unwrap_or_else(|e| e.into_inner());
        let lost = |result| match result {
            vk::Result::ERROR_DEVICE_LOST => VulkanError::DeviceLost(self.name()),
            vk::Result::TIMEOUT => VulkanError::Timeout {
                device: self.name(),
                what: what.to_string(),
                seconds: limit.as_secs(),
            },
            result => VulkanError::Call {
                call: "vkQueueSubmit",
                result,
            },
        };
        // SAFETY: the lock makes this the only user of queue, commands and fence; the wait ends the use of all
        // buffers before the caller can drop them. After a time-out the device is waited for before anything is
        // destroyed (see the destructors).
        unsafe {
            self.raw
                .begin_command_buffer(
                    queue.commands,
                    &vk::CommandBufferBeginInfo::default()
                        .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT),
                )
                .map_err(call("vkBeginCommandBuffer"))?;
            record(queue.commands);
            // The host reads what was written as soon as the fence is signalled.
            let barrier = [vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::SHADER_WRITE | vk::AccessFlags::TRANSFER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ)];
            self.raw.cmd_pipeline_barrier(
                queue.commands,
                vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER,
                vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
            self.raw
                .end_command_buffer(queue.commands)
                .map_err(call("vkEndCommandBuffer"))?;
            let commands = [queue.commands];
            let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
            self.raw
                .queue_submit(queue.raw, &submit, queue.fence)
                .map_err(lost)?;
            let fences = [queue.fence];
            self.raw
                .wait_for_fences(&fences, true, limit.as_nanos() as u64)
                .map_err(lost)?;
            self.raw
                .reset_fences(&fences)
                .map_err(call("vkResetFences"))
        }
    }

    /// The entry point `entry` of a module, with `buffers` bound to set 0 in order and push constants of
    /// `push_constant_size` bytes.
    ///
    /// # Errors
    /// If the driver refuses the module.
    pub fn create_pipeline(
        self: &Arc<Self>,
        module: &[u32],
        entry: &CStr,
        buffers: &[&Buffer],
        push_constant_size: u32,
    ) -> Result<Pipeline, VulkanError> {
        let bindings: Vec<_> = (0..buffers.len() as u32)
            .map(|i| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(i)
                    .descriptor_count(1)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let mut pipeline = Pipeline {
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            device: self.clone(),
        };
        // SAFETY: every object is made from live ones of this device and stored in the guard at once, which destroys
        // what exists should a later step fail. The shader module is only needed while the pipeline is created.
        unsafe {
            pipeline.set_layout = self
                .raw
                .create_descriptor_set_layout(
                    &vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings),
                    None,
                )
                .map_err(call("vkCreateDescriptorSetLayout"))?;
            let sizes = [vk::DescriptorPoolSize {
                ty: vk::DescriptorType::STORAGE_BUFFER,
                descriptor_count: buffers.len() as u32,
            }];
            pipeline.pool = self
                .raw
                .create_descriptor_pool(
                    &vk::DescriptorPoolCreateInfo::default()
                        .max_sets(1)
                        .pool_sizes(&sizes),
                    None,
                )
                .map_err(call("vkCreateDescriptorPool"))?;
            let set_layouts = [pipeline.set_layout];
            pipeline.set = self
                .raw
                .allocate_descriptor_sets(
                    &vk::DescriptorSetAllocateInfo::default()
                        .descriptor_pool(pipeline.pool)
                        .set_layouts(&set_layouts),
                )
                .map_err(call("vkAllocateDescriptorSets"))?[0];
            let ranges = [vk::PushConstantRange {
                stage_flags: vk::ShaderStageFlags::COMPUTE,
                offset: 0,
                size: push_constant_size,
            }];
            pipeline.layout = self
                .raw
                .create_pipeline_layout(
                    &vk::PipelineLayoutCreateInfo::default()
                        .set_layouts(&set_layouts)
                        .push_constant_ranges(&ranges),
                    None,
                )
                .map_err(call("vkCreatePipelineLayout"))?;
            let shader = self
                .raw
                .create_shader_module(&vk::ShaderModuleCreateInfo::default().code(module), None)
                .map_err(call("vkCreateShaderModule"))?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(shader)
                .name(entry);
            let result = self.raw.create_compute_pipelines(
                vk::PipelineCache::null(),
                &[vk::ComputePipelineCreateInfo::default()
                    .stage(stage)
                    .layout(pipeline.layout)],
                None,
            );
            self.raw.destroy_shader_module(shader, None);
            pipeline.raw = result
                .map_err(|(_, e)| e)
                .map_err(call("vkCreateComputePipelines"))?[0];
        }
        for (i, buffer) in buffers.iter().enumerate() {
            pipeline.bind(i as u32, buffer);
        }
        Ok(pipeline)
    }
}

impl Pipeline {
    fn bind(&mut self, binding: u32, buffer: &Buffer) {
        let info = [vk::DescriptorBufferInfo {
            buffer: buffer.raw,
            offset: 0,
            range: vk::WHOLE_SIZE,
        }];
        let write = [vk::WriteDescriptorSet::default()
            .dst_set(self.set)
            .dst_binding(binding)
            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
            .buffer_info(&info)];
        // SAFETY: no submission is running (they are all waited for), set and buffer are alive.
        unsafe { self.device.raw.update_descriptor_sets(&write, &[]) };
    }

    /// Runs `groups` workgroups and waits for them. The bound buffers must still exist, which the owner of both sees to.
    ///
    /// # Errors
    /// If the device is lost or does not finish within `limit`.
    pub(crate) fn dispatch<P: NoUninit>(
        &self,
        what: &str,
        constants: &P,
        groups: u32,
        limit: Duration,
    ) -> Result<(), VulkanError> {
        let raw = &self.device.raw;
        self.device.run(what, limit, |commands| {
            // SAFETY: recording into a begun command buffer with live objects.
            unsafe {
                raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, self.raw);
                raw.cmd_bind_descriptor_sets(
                    commands,
                    vk::PipelineBindPoint::COMPUTE,
                    self.layout,
                    0,
                    &[self.set],
                    &[],
                );
                raw.cmd_push_constants(
                    commands,
                    self.layout,
                    vk::ShaderStageFlags::COMPUTE,
                    0,
                    bytemuck::bytes_of(constants),
                );
                raw.cmd_dispatch(commands, groups, 1, 1);
            }
        })
    }
}

impl Buffer {
    /// Bytes asked for.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Copies `values` to the start of a host buffer.
    ///
    /// # Panics
    /// If the buffer is the device's alone or too small.
    pub fn write<T: NoUninit>(&mut self, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        assert!(!self.mapped.is_null() && bytes.len() as u64 <= self.size);
        // SAFETY: the mapping is `size` bytes long and no submission is running.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.mapped, bytes.len()) }
    }

    /// Copies the start of a host buffer to `values`.
    ///
    /// # Panics
    /// If the buffer is the device's alone or too small.
    pub fn read<T: Pod>(&self, values: &mut [T]) {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(values);
        assert!(!self.mapped.is_null() && bytes.len() as u64 <= self.size);
        // SAFETY: the mapping is `size` bytes long and no submission is running.
        unsafe { std::ptr::copy_nonoverlapping(self.mapped, bytes.as_mut_ptr(), bytes.len()) }
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for; one that timed out is waited for here. Null handles are ignored.
        unsafe {
            let _ = self.device.raw.device_wait_idle();
            self.device.raw.destroy_buffer(self.raw, None);
            self.device.raw.free_memory(self.memory, None);
        }
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let raw = &self.device.raw;
        // SAFETY: as for buffers; null handles are ignored.
        unsafe {
            let _ = raw.device_wait_idle();
            raw.destroy_pipeline(self.raw, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_pool(self.pool, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
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
            self.raw.destroy_device(None);
        }
    }
}
