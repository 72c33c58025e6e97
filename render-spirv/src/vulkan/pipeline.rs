//! Entry points of modules with their buffers bound.

use super::device::Device;
use super::error::{VulkanError, call};
use super::memory::Buffer;
use ash::vk;
use bytemuck::NoUninit;
use std::ffi::CStr;
use std::sync::Arc;
use std::time::Duration;

/// An entry point with its buffers bound.
pub struct Pipeline {
    raw: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    device: Arc<Device>,
}

impl Device {
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
        self.create_specialized_pipeline(module, entry, buffers, push_constant_size, &[])
    }

    /// [`Device::create_pipeline`] with values for the module's specialisation constants 0, 1, ...
    ///
    /// # Errors
    /// If the driver refuses the module.
    pub fn create_specialized_pipeline(
        self: &Arc<Self>,
        module: &[u32],
        entry: &CStr,
        buffers: &[&Buffer],
        push_constant_size: u32,
        constants: &[u32],
    ) -> Result<Pipeline, VulkanError> {
        let entries: Vec<_> = (0..constants.len() as u32)
            .map(|i| vk::SpecializationMapEntry {
                constant_id: i,
                offset: 4 * i,
                size: 4,
            })
            .collect();
        let specialization = vk::SpecializationInfo::default()
            .map_entries(&entries)
            .data(bytemuck::cast_slice(constants));
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
            let range = vk::PushConstantRange {
                stage_flags: vk::ShaderStageFlags::COMPUTE,
                offset: 0,
                size: push_constant_size,
            };
            // An empty range is not allowed.
            let ranges: Vec<_> = (push_constant_size > 0)
                .then_some(range)
                .into_iter()
                .collect();
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
                .name(entry)
                .specialization_info(&specialization);
            let result = self.raw.create_compute_pipelines(
                self.pipeline_cache.raw,
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

/// Runs `groups` workgroups of each pipeline, each after the one before it has written its results, and waits for them.
/// The bound buffers must still exist, which their owner sees to.
///
/// # Errors
/// If the device is lost or does not finish within `limit`.
pub(crate) fn dispatch_in_order<P: NoUninit>(
    device: &Device,
    what: &str,
    pipelines: &[&Pipeline],
    constants: &P,
    groups: u32,
    limit: Duration,
) -> Result<(), VulkanError> {
    let raw = &device.raw;
    device.run(what, limit, |commands| {
        for pipeline in pipelines {
            let barrier = [vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::SHADER_WRITE)
                .dst_access_mask(vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE)];
            // SAFETY: recording into a begun command buffer with live objects.
            unsafe {
                raw.cmd_pipeline_barrier(
                    commands,
                    vk::PipelineStageFlags::COMPUTE_SHADER,
                    vk::PipelineStageFlags::COMPUTE_SHADER,
                    vk::DependencyFlags::empty(),
                    &barrier,
                    &[],
                    &[],
                );
                raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw);
                raw.cmd_bind_descriptor_sets(
                    commands,
                    vk::PipelineBindPoint::COMPUTE,
                    pipeline.layout,
                    0,
                    &[pipeline.set],
                    &[],
                );
                raw.cmd_push_constants(
                    commands,
                    pipeline.layout,
                    vk::ShaderStageFlags::COMPUTE,
                    0,
                    bytemuck::bytes_of(constants),
                );
                raw.cmd_dispatch(commands, groups, 1, 1);
            }
        }
    })
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
        dispatch_in_order(&self.device, what, &[self], constants, groups, limit)
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
