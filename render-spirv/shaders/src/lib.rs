//! Entry points of the shaders: bindings in, one call of the kernel, one value out.
//!
//! Set 0 holds the scene: bindings 0 to 14 the tables of `halflight_kernel::scene::Tables` in their order and in the
//! very layout of the records, 15 and 16 the nodes of the kernel's BVH2 walk and what its leaves hold, 17 what is said
//! once per scene, 18 the work items, 19 the results, 20 the paths of `halflight_kernel::transport::staged`.
#![cfg_attr(target_arch = "spirv", no_std)]

#[path = "../../src/interface.rs"]
pub mod interface;
// Either what renders, or what tests run: two modules, because drivers read a module as a whole for each of its entry points.
#[cfg(not(feature = "probes"))]
pub mod canary;
#[cfg(not(feature = "probes"))]
pub mod paths;
#[cfg(feature = "probes")]
pub mod probe;
#[cfg(feature = "probes")]
pub mod probe_texture;
#[cfg(feature = "probes")]
#[path = "../../src/probe/mod.rs"]
pub mod probes;
pub mod scene_entry;

#[cfg(not(feature = "probes"))]
use halflight_kernel::transport::{self, ambient_occlusion, aov};
#[cfg(not(feature = "probes"))]
use scene_entry::{scene_entry, vector};

#[cfg(not(feature = "probes"))]
scene_entry!(occlusion, |view, settings, work, out[slot], paths[path]| {
    let (mut sampler, pixel) = work();
    let radiance = transport::sample_pixel_with(&view, &mut sampler, pixel, |sampler, ray| {
        ambient_occlusion::radiance(&view, &settings, sampler, ray)
    });
    out[slot] = vector(radiance, 0.0);
});

#[cfg(not(feature = "probes"))]
scene_entry!(surface_features, |view,
                                settings,
                                work,
                                out[slot],
                                paths[path]| {
    let (mut sampler, pixel) = work();
    let (features, _) = aov::sample_pixel(&view, &mut sampler, pixel);
    let at = 3 * slot;
    out[at] = vector(features.albedo, features.depth);
    out[at + 1] = vector(features.normal, features.uv.x);
    out[at + 2] = vector(features.position, features.uv.y);
});
