//! Errors of Vulkan devices, with messages that suggest a remedy.

use ash::vk;

/// Why a device cannot be used, or can no longer be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VulkanError {
    /// There is no loader library.
    #[error("no Vulkan loader was found ({0}); install a driver with Vulkan 1.2 and libvulkan")]
    NoLoader(String),
    /// The loader finds no device.
    #[error("no Vulkan device was found; `halflight render` needs none")]
    NoDevice,
    /// `--device` matches no device.
    #[error("no Vulkan device is \"{wanted}\"; there are: {known}")]
    UnknownDevice {
        /// The argument of `--device`.
        wanted: String,
        /// Numbers and names of all devices.
        known: String,
    },
    /// The device is older or simpler than the modules need.
    #[error("{device} lacks {feature}, which the shaders need")]
    MissingFeature {
        /// Name of the device.
        device: String,
        /// What it lacks.
        feature: String,
    },
    /// The validation layer is not installed.
    #[error(
        "the validation layer VK_LAYER_KHRONOS_validation is not installed (Debian: vulkan-validationlayers); leave out --validate"
    )]
    NoValidation,
    /// A buffer is larger than a shader may see.
    #[error("{what} takes {bytes} bytes, {device} allows {limit} in one buffer")]
    TooLarge {
        /// What the buffer holds.
        what: String,
        /// Its size.
        bytes: u64,
        /// Name of the device.
        device: String,
        /// The device's limit.
        limit: u64,
    },
    /// Neither the device nor the host has room.
    #[error("{device} has no room for {bytes} bytes of {what}; {used} bytes are in use here")]
    OutOfMemory {
        /// What the buffer holds.
        what: String,
        /// Its size.
        bytes: u64,
        /// Bytes of all other buffers.
        used: u64,
        /// Name of the device.
        device: String,
    },
    /// The device was lost: by a crash, a reset, or its removal.
    #[error("{0} was lost while it rendered")]
    DeviceLost(String),
    /// A submission did not end in time.
    #[error("{device} did not finish {what} within {seconds} s")]
    Timeout {
        /// Name of the device.
        device: String,
        /// What was submitted.
        what: String,
        /// The limit.
        seconds: u64,
    },
    /// The validation layer complained.
    #[error("the validation layer reported {0} messages")]
    Validation(u32),
    /// Anything else, with the call that failed.
    #[error("{call} failed: {result}")]
    Call {
        /// The call.
        call: &'static str,
        /// Vulkan's result.
        result: vk::Result,
    },
}

/// Names the call that failed.
pub(crate) fn call(name: &'static str) -> impl FnOnce(vk::Result) -> VulkanError {
    move |result| VulkanError::Call { call: name, result }
}
