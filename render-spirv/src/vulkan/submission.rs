//! The queue: work is recorded, submitted and waited for, one submission at a time.

use super::device::Device;
use super::error::{VulkanError, call};
use ash::vk;
use std::time::Duration;

impl Device {
    /// Records, submits and waits.
    pub(super) fn run(
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
}
