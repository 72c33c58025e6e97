//! The driver's pipeline cache, kept in a file between runs, so that shaders are compiled once on a machine.
//!
//! The file is in `$XDG_CACHE_HOME/halflight` or `~/.cache/halflight`, one for each device and version of its driver (the
//! cache's UUID). Drivers check the header of what they are given but not each byte, so the file has a checksum. A cache that
//! is missing, damaged or not writable costs time and nothing else.

use super::error::{VulkanError, call};
use ash::vk;
use halflight::atomic_file::write_atomically;
use halflight::bytes::read_file;
use std::io::Write;
use std::path::PathBuf;

/// Start of a file.
const MAGIC: [u8; 8] = *b"HLPIPES1";

/// Length of the start and the checksum.
const HEADER: usize = 16;

/// Longest file that is read.
const MAX_BYTES: u64 = 1 << 28;

/// A cache and its file.
pub(super) struct PipelineCache {
    /// What pipelines are created with.
    pub raw: vk::PipelineCache,
    file: Option<PathBuf>,
    /// Bytes that the file held.
    loaded: Vec<u8>,
}

impl PipelineCache {
    /// The cache of a device, with what its file holds.
    pub fn new(
        device: &ash::Device,
        properties: &vk::PhysicalDeviceProperties,
    ) -> Result<PipelineCache, VulkanError> {
        let file = folder().map(|folder| folder.join(file_name(properties)));
        let loaded = file.as_ref().and_then(|file| {
            let bytes = read_file(file, MAX_BYTES).ok()?;
            content(&bytes).map(<[u8]>::to_vec)
        });
        let loaded = loaded.unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&loaded);
        // SAFETY: the device is alive, and drivers ignore data that are not theirs by the header.
        let raw = unsafe { device.create_pipeline_cache(&info, None) }
            .map_err(call("vkCreatePipelineCache"))?;
        Ok(PipelineCache { raw, file, loaded })
    }

    /// Whether there was something in the file.
    pub fn is_filled(&self) -> bool {
        !self.loaded.is_empty()
    }

    /// Writes the file if there is something new.
    pub fn save(&self, device: &ash::Device) {
        let Some(file) = &self.file else {
            return;
        };
        // SAFETY: both are alive.
        let Ok(data) = (unsafe { device.get_pipeline_cache_data(self.raw) }) else {
            return;
        };
        if data == self.loaded {
            return;
        }
        let write = || {
            if let Some(folder) = file.parent() {
                std::fs::create_dir_all(folder).map_err(|e| e.to_string())?;
            }
            write_atomically(file, |stream| {
                stream.write_all(&MAGIC)?;
                stream.write_all(&checksum(&data).to_le_bytes())?;
                stream.write_all(&data)
            })
            .map_err(|e| e.to_string())
        };
        match write() {
            Ok(()) => tracing::debug!("saved {}, {} bytes", file.display(), data.len()),
            Err(error) => tracing::info!("shaders are compiled again next time: {error}"),
        }
    }
}

/// Where caches are.
fn folder() -> Option<PathBuf> {
    let of = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let base = match of("XDG_CACHE_HOME") {
        Some(folder) => PathBuf::from(folder),
        None => PathBuf::from(of("HOME")?).join(".cache"),
    };
    base.is_absolute().then(|| base.join("halflight"))
}

fn file_name(properties: &vk::PhysicalDeviceProperties) -> String {
    let uuid = properties.pipeline_cache_uuid;
    let uuid: String = uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    let (vendor, device) = (properties.vendor_id, properties.device_id);
    format!("pipelines-{vendor:04x}-{device:04x}-{uuid}")
}

/// What a file holds, if it is whole.
fn content(bytes: &[u8]) -> Option<&[u8]> {
    let (header, data) = bytes.split_at_checked(HEADER)?;
    let is_whole = header[..8] == MAGIC && header[8..] == checksum(data).to_le_bytes();
    is_whole.then_some(data)
}

/// FNV-1a.
fn checksum(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_files_hold_nothing() {
        let data = b"what a driver wrote";
        let mut file = MAGIC.to_vec();
        file.extend(checksum(data).to_le_bytes());
        file.extend(data);
        assert_eq!(content(&file), Some(&data[..]));
        for i in 0..file.len() {
            let mut damaged = file.clone();
            damaged[i] ^= 1;
            assert_eq!(content(&damaged), None, "byte {i}");
            assert_eq!(content(&file[..i]), None, "{i} bytes");
        }
    }
}
