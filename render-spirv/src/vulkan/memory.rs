//! Buffers: their memory, uploads, and reads by the host.

use super::device::Device;
use super::error::{VulkanError, call};
use ash::vk;
use bytemuck::{NoUninit, Pod};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// The kind of memory of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Fast for the device.
    Device,
    /// Readable and writable by the host, and visible to the device.
    Host,
}

/// A buffer with memory of its own.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    memory: vk::DeviceMemory,
    /// Start of the mapping, for [`Memory::Host`].
    mapped: *mut u8,
    /// Bytes asked for; the buffer itself holds at least one word.
    size: u64,
    /// Bytes that count as allocated.
    allocated: u64,
    device: Arc<Device>,
}

// SAFETY: the mapping is only reached through &self (reads) and &mut self (writes), as any memory.
unsafe impl Send for Buffer {}

impl Device {
    fn memory_type(&self, allowed: u32, memory: Memory) -> Option<u32> {
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let wishes = match memory {
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

    /// Bytes of all buffers that exist.
    pub fn memory_used(&self) -> u64 {
        self.allocations.used.load(Ordering::Relaxed)
    }

    /// The most that [`Device::memory_used`] has been.
    pub fn peak_memory_used(&self) -> u64 {
        self.allocations.peak.load(Ordering::Relaxed)
    }

    /// Behaves from now on as if the device had a memory of so many bytes: what a test of that case needs.
    pub fn limit_memory(&self, bytes: u64) {
        self.allocations.limit.store(bytes, Ordering::Relaxed);
    }

    /// An uninitialised storage buffer of `size` bytes; `what` names it in messages.
    ///
    /// # Errors
    /// If it is larger than a shader may see or does not fit into memory.
    pub fn create_buffer(
        self: &Arc<Self>,
        what: &str,
        size: u64,
        memory: Memory,
    ) -> Result<Buffer, VulkanError> {
        if size > self.description().max_buffer {
            return Err(VulkanError::TooLarge {
                what: what.to_string(),
                bytes: size,
                device: self.name(),
                limit: self.description().max_buffer,
            });
        }
        let failed = |result| match result {
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
                VulkanError::OutOfMemory {
                    what: what.to_string(),
                    bytes: size,
                    used: self.memory_used(),
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
            allocated: 0,
            device: self.clone(),
        };
        // SAFETY: the buffer is alive.
        let needs = unsafe { self.raw.get_buffer_memory_requirements(raw) };
        let kind = self
            .memory_type(needs.memory_type_bits, memory)
            .ok_or_else(|| failed(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY))?;
        if !self.allocations.add(needs.size) {
            return Err(failed(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY));
        }
        buffer.allocated = needs.size;
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(needs.size)
            .memory_type_index(kind);
        // SAFETY: the allocation is as large as the buffer needs, of a type that it allows, bound once and mapped once.
        unsafe {
            buffer.memory = self.raw.allocate_memory(&info, None).map_err(failed)?;
            self.raw
                .bind_buffer_memory(raw, buffer.memory, 0)
                .map_err(failed)?;
            if memory == Memory::Host {
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
        self.device.allocations.remove(self.allocated);
    }
}
