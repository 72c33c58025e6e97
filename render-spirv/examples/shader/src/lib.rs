//! A reader's own shader: rough gold that is never brighter than `tau` per steradian, for each pair of directions.
//!
//! Built with rust-gpu's tools and the nightly that this spirv-std pins, nightly-2026-04-11 (a way that Halflight's
//! authors could not run): `cargo install cargo-gpu`, then `cargo gpu build` in this folder. As they build it:
//! `HALFLIGHT_SPIRV_TOOLCHAIN=DIR render-spirv/build-shaders example`. Keep glam at the release of `Cargo.lock`, which
//! this spirv-std needs, by `cargo update -p glam --precise 0.32.1`.
#![cfg_attr(target_arch = "spirv", no_std)]

use halflight_kernel::bsdf::{Lobe, rough_conductor};
use halflight_kernel::glam::{UVec3, Vec2, Vec3};
use halflight_kernel::regularize::bounds;
use halflight_kernel::scene::{distribution, lobe_kind};
use spirv_std::spirv;

/// The BSDF of gold of roughness 0.05, raised until no pair of directions exceeds `tau`.
fn gold(wi: Vec3, wo: Vec3, tau: f32) -> Vec3 {
    // Jendersie and Grosch 2019: the roughness whose bound is tau.
    let alpha_hat = bounds::reflection_alpha(bounds::SMITH, distribution::GGX, tau);
    let lobe = Lobe {
        kind: lobe_kind::ROUGH_CONDUCTOR,
        distribution: distribution::GGX,
        alpha: bounds::raise(Vec2::splat(0.05), alpha_hat),
        eta: Vec3::new(0.143, 0.375, 1.442),
        k: Vec3::new(3.983, 2.386, 1.603),
        specular_reflectance: Vec3::ONE,
        ..Lobe::NONE
    };
    rough_conductor::eval(&lobe, wi, wo)
}

/// Per invocation: `wi` and `tau`, then `wo`, in local frames with z along the normal; the result is RGB.
#[spirv(compute(threads(64)))]
pub fn main_cs(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] pairs: &[[[f32; 4]; 2]],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] out: &mut [[f32; 4]],
) {
    let i = id.x as usize;
    if i < pairs.len() {
        let [[x, y, z, tau], [u, v, w, _]] = pairs[i];
        let f = gold(Vec3::new(x, y, z), Vec3::new(u, v, w), tau);
        out[i] = [f.x, f.y, f.z, 1.0];
    }
}
