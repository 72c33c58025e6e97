//! Light transport algorithms, one per file, and their drivers.
//!
//! Each algorithm is a function of a scene view, a sampler and a pixel or ray, and returns radiance. They hold no state
//! between calls, so a front end may call them in any order and from any thread.
//!
//! | file | content |
//! |---|---|
//! | [`path`], [`direct`], [`ambient_occlusion`] | algorithms: radiance along a ray |
//! | [`bidirectional`] | bidirectional path tracing and light tracing |
//! | [`aov`] | surface features of a camera sample |
//! | [`regularized_path`] | path tracing whose next event estimation is regularised |
//! | [`divided`] | path tracing whose light is divided by path expressions |
//! | `retargeted` | path tracing, bidirectional path tracing and merging with edits of light transport (hosts only) |
//! | `manifold_connection`, `manifold_path` | connections to lights through refracting interfaces, and path tracing that makes them (hosts only) |
//! | [`irradiance`], `recorded`, `light_volume` | what falls on a surface; paths with their vertices, and light in voxels (hosts only) |
//! | [`connection`] | next event estimation |
//! | [`bounce`] | the order of the stages of a bounce, for all drivers of path tracing |
//! | [`pixel`] | one sample of a pixel by the algorithm of the settings |
//! | [`staged`], `wavefront` | path tracing in stages over buffers, and over lanes |
//! | `markov` | Metropolis chains (hosts only) |
//! | [`photon`] | radii and statistics of photon mapping |
//! | [`settings`] | parameters of the algorithms |

pub mod ambient_occlusion;
pub mod aov;
pub mod bidirectional;
pub mod bounce;
pub mod connection;
pub mod direct;
pub mod divided;
pub mod irradiance;
// Grids of voxels are in the memory of hosts.
#[cfg(not(target_arch = "spirv"))]
pub mod light_volume;
#[cfg(not(target_arch = "spirv"))]
pub mod manifold_connection;
#[cfg(not(target_arch = "spirv"))]
pub mod manifold_path;
#[cfg(not(target_arch = "spirv"))]
pub mod markov;
pub mod path;
pub mod photon;
pub mod pixel;
mod regularized_connection;
pub mod regularized_path;
pub mod regularized_share;
// Paths are noted for hosts only, in lists without a limit that shaders have.
#[cfg(not(target_arch = "spirv"))]
pub mod recorded;
// Edits are for hosts only.
#[cfg(not(target_arch = "spirv"))]
pub mod retargeted;
pub mod settings;
pub mod staged;
#[cfg(not(target_arch = "spirv"))]
pub mod wavefront;

pub use pixel::{camera_ray, sample_pixel, sample_pixel_with};
pub use settings::{IntegratorSettings, integrator_kind};
