//! What host and shaders exchange beside the kernel's own records; the shader crate compiles this very file.

use bytemuck::{Pod, Zeroable};
use halflight_kernel::scene::{Camera, SceneInfo};
use halflight_kernel::transport::IntegratorSettings;

/// Invocations of a workgroup.
pub const WORKGROUP: u32 = 64;

/// Vectors of four that the surface features of a sample take.
pub const FEATURE_VECTORS: u32 = 3;

/// Constants of a scene.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SceneConstants {
    /// The sensor.
    pub camera: Camera,
    /// Facts about the whole scene.
    pub info: SceneInfo,
    /// Parameters of the algorithm.
    pub settings: IntegratorSettings,
}

/// Constants of a dispatch: push constants, at most 128 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Dispatch {
    /// Number of samples to take.
    pub count: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// One of [`halflight_kernel::sampler::sampler_kind`].
    pub sampler: u32,
    /// Offset from a slot to the index of its path: branches follow the paths that they belong to.
    pub first: u32,
}

/// A sample to take or to go on with. Pixels are listed because in adaptive runs they differ in their number of samples.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct WorkItem {
    /// Pixel of the crop window, by rows.
    pub pixel: u32,
    /// Index of the sample.
    pub sample: u32,
    /// Index of its result and of its path.
    pub slot: u32,
}
