//! The Vulkan instance, its devices, and the choice among them.
//!
//! Discrete GPUs come before integrated ones, virtual ones and CPUs; `--device` names one by its number in that order or
//! by a part of its name. A device needs Vulkan 1.2, the Vulkan memory model and a compute queue.

use super::error::{VulkanError, call};
use ash::{Entry, ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What kind of machine a device is; the order is that of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A discrete graphics card.
    Discrete,
    /// Part of the processor's chip.
    Integrated,
    /// A share of a device.
    Virtual,
    /// The processor itself.
    Cpu,
    /// Anything else.
    Other,
}

/// A device of the instance.
#[derive(Clone, Debug)]
pub struct DeviceDescription {
    pub(super) handle: vk::PhysicalDevice,
    /// The driver's name for it.
    pub name: String,
    /// What it is.
    pub kind: DeviceKind,
    /// Vulkan version: major, minor.
    pub version: (u32, u32),
    /// Driver and its version in words.
    pub driver: String,
    /// Bytes of device-local memory.
    pub memory: u64,
    /// Largest buffer that a shader may see, in bytes.
    pub max_buffer: u64,
    /// What the shaders need and the device lacks; empty for a usable device.
    pub missing: Vec<&'static str>,
    pub(super) queue_family: u32,
    pub(super) robust: bool,
}

/// A Vulkan instance.
pub struct Instance {
    pub(super) raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Arc<AtomicU32>,
    // Keeps the library loaded.
    _entry: Entry,
}

/// Storage buffers that an entry point binds.
const STORAGE_BUFFERS: u32 = 21;

impl Instance {
    /// An instance of Vulkan 1.2, with the validation layer on request.
    ///
    /// # Errors
    /// If there is no loader, no layer, or the driver refuses.
    pub fn new(validate: bool) -> Result<Arc<Instance>, VulkanError> {
        // SAFETY: loading runs the initialisers of the system's Vulkan library, which is what the caller asks for.
        let entry = unsafe { Entry::load() }.map_err(|e| VulkanError::NoLoader(e.to_string()))?;
        let messages = Arc::new(AtomicU32::new(0));
        let application = vk::ApplicationInfo::default()
            .application_name(c"halflight")
            .api_version(vk::API_VERSION_1_2);
        let layers = [VALIDATION_LAYER.as_ptr()];
        let extensions = [ext::debug_utils::NAME.as_ptr()];
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validate {
            // SAFETY: the entry is loaded.
            let known = unsafe { entry.enumerate_instance_layer_properties() }
                .map_err(call("vkEnumerateInstanceLayerProperties"))?;
            if !known
                .iter()
                .any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
            {
                return Err(VulkanError::NoValidation);
            }
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions);
        }
        // SAFETY: all pointers of `info` live until the end of this function.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|e| match e {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => VulkanError::NoDevice,
            result => VulkanError::Call {
                call: "vkCreateInstance",
                result,
            },
        })?;
        let messenger = if validate {
            let utils = ext::debug_utils::Instance::new(&entry, &raw);
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(
                    vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                        | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
                )
                .message_type(
                    vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                        | vk::DebugUtilsMessageTypeFlagsEXT::GENERAL,
                )
                .pfn_user_callback(Some(on_message))
                .user_data(Arc::as_ptr(&messages).cast_mut().cast());
            // SAFETY: the counter behind `user_data` lives as long as the instance, which destroys the messenger first.
            let messenger = unsafe { utils.create_debug_utils_messenger(&info, None) }
                .map_err(call("vkCreateDebugUtilsMessengerEXT"))?;
            Some((utils, messenger))
        } else {
            None
        };
        Ok(Arc::new(Instance {
            raw,
            messenger,
            messages,
            _entry: entry,
        }))
    }

    /// Warnings and errors of the validation layer so far.
    pub fn validation_messages(&self) -> u32 {
        self.messages.load(Ordering::Relaxed)
    }

    /// All devices, the preferred ones first.
    ///
    /// # Errors
    /// If the driver fails.
    pub fn devices(&self) -> Result<Vec<DeviceDescription>, VulkanError> {
        // SAFETY: the instance is alive.
        let handles = unsafe { self.raw.enumerate_physical_devices() }
            .map_err(call("vkEnumeratePhysicalDevices"))?;
        let mut devices: Vec<_> = handles.into_iter().map(|h| self.describe(h)).collect();
        devices.sort_by_key(|d| (!d.missing.is_empty(), d.kind));
        Ok(devices)
    }

    /// The device of that number or name, or the best one.
    ///
    /// # Errors
    /// If none fits, or it lacks what the shaders need.
    pub fn select(&self, wanted: Option<&str>) -> Result<DeviceDescription, VulkanError> {
        choose(&self.devices()?, wanted).cloned()
    }

    fn describe(&self, handle: vk::PhysicalDevice) -> DeviceDescription {
        // SAFETY: the handle comes from this instance.
        let basic = unsafe { self.raw.get_physical_device_properties(handle) };
        let version = (
            vk::api_version_major(basic.api_version),
            vk::api_version_minor(basic.api_version),
        );
        let mut missing = Vec::new();
        let mut driver = String::new();
        let mut robust = false;
        if version < (1, 2) {
            missing.push("Vulkan 1.2");
        } else {
            let mut names = vk::PhysicalDeviceDriverProperties::default();
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut names);
            let mut features12 = vk::PhysicalDeviceVulkan12Features::default();
            let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut features12);
            // SAFETY: the device has Vulkan 1.2, which defines both chained structures.
            unsafe {
                self.raw
                    .get_physical_device_properties2(handle, &mut properties);
                self.raw
                    .get_physical_device_features2(handle, &mut features);
            }
            robust = features.features.robust_buffer_access == vk::TRUE;
            if features12.vulkan_memory_model == vk::FALSE {
                missing.push("the feature vulkanMemoryModel");
            }
            if features12.scalar_block_layout == vk::FALSE {
                missing.push("the feature scalarBlockLayout");
            }
            let text = |s: Result<&CStr, _>| s.map(|s| s.to_string_lossy().into_owned());
            driver = format!(
                "{} {}",
                text(names.driver_name_as_c_str()).unwrap_or_default(),
                text(names.driver_info_as_c_str()).unwrap_or_default()
            );
        }
        if basic.limits.max_per_stage_descriptor_storage_buffers < STORAGE_BUFFERS {
            missing.push("21 storage buffers per stage");
        }
        // SAFETY: the handle comes from this instance.
        let families = unsafe { self.raw.get_physical_device_queue_family_properties(handle) };
        let family = families
            .iter()
            .position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE));
        if family.is_none() {
            missing.push("a compute queue");
        }
        // SAFETY: the handle comes from this instance.
        let memory = unsafe { self.raw.get_physical_device_memory_properties(handle) };
        DeviceDescription {
            handle,
            name: basic
                .device_name_as_c_str()
                .map(|s| s.to_string_lossy().into_owned())
                .unwrap_or_default(),
            kind: match basic.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
                _ => DeviceKind::Other,
            },
            version,
            driver,
            memory: memory
                .memory_heaps_as_slice()
                .iter()
                .filter(|h| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
                .map(|h| h.size)
                .sum(),
            max_buffer: basic.limits.max_storage_buffer_range.into(),
            missing,
            queue_family: family.unwrap_or(0) as u32,
            robust,
        }
    }
}

/// The device of that number or name in a list, or the first.
///
/// # Errors
/// If none fits, or it lacks what the shaders need.
pub fn choose<'a>(
    devices: &'a [DeviceDescription],
    wanted: Option<&str>,
) -> Result<&'a DeviceDescription, VulkanError> {
    let best = devices.first().ok_or(VulkanError::NoDevice)?;
    let device = match wanted {
        None => best,
        Some(wanted) => find(devices, wanted).ok_or_else(|| VulkanError::UnknownDevice {
            wanted: wanted.to_string(),
            known: devices
                .iter()
                .enumerate()
                .map(|(i, d)| format!("{i} {}", d.name))
                .collect::<Vec<_>>()
                .join(", "),
        })?,
    };
    match device.missing.first() {
        None => Ok(device),
        Some(feature) => Err(VulkanError::MissingFeature {
            device: device.name.clone(),
            feature: (*feature).to_string(),
        }),
    }
}

/// The device of a number in the list, or the first whose name holds `wanted` in any case.
fn find<'a>(devices: &'a [DeviceDescription], wanted: &str) -> Option<&'a DeviceDescription> {
    if let Ok(number) = wanted.parse::<usize>() {
        return devices.get(number);
    }
    let wanted = wanted.to_lowercase();
    devices
        .iter()
        .find(|d| d.name.to_lowercase().contains(&wanted))
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: devices hold an Arc of the instance, so none is left; the messenger goes before the instance.
        unsafe {
            if let Some((utils, messenger)) = self.messenger.take() {
                utils.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

/// Counts and logs the messages of the validation layer.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    counter: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer hands over valid data, and `counter` is the AtomicU32 given at creation.
    let (data, counter) = unsafe { (&*data, &*counter.cast::<AtomicU32>()) };
    counter.fetch_add(1, Ordering::Relaxed);
    // SAFETY: the message is a string that lives during the callback.
    if let Some(text) = unsafe { data.message_as_c_str() } {
        tracing::warn!("validation: {}", text.to_string_lossy());
    }
    vk::FALSE
}
