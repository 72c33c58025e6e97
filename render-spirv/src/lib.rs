//! Halflight on Vulkan: the kernel, compiled to SPIR-V by rust-gpu, run by any device with Vulkan 1.2.
//!
//! The same scene tables that the CPU renders are uploaded as storage buffers ([`scene_buffers`]); every invocation of a
//! compute shader (`render-spirv/shaders`) takes one sample of one pixel, or one step of it, with the same functions of
//! [`halflight_kernel::transport`] and the same random numbers, and the samples are added to the same film
//! ([`device_backend`]). Two images of the same seed therefore differ by rounding only, and by the few paths that take another
//! course because of it.
//!
//! # Modules
//! The modules in `render-spirv/spirv` are committed, so that building this crate needs no shader compiler: that of
//! rendering, one with [`probe`]s of single functions for tests, and that of the example for readers' own shaders
//! (`render-spirv/examples/shader`). Each carries a stamp of the sources it was made from ([`module`]); a test fails when
//! one is older than they are. `render-spirv/build-shaders` makes them anew:
//!
//! - with the rustc 1.95 toolchain of this project: `HALFLIGHT_SPIRV_TOOLCHAIN=DIR render-spirv/build-shaders`, DIR
//!   holding `bin/spirv-build`;
//! - with the upstream tools, which this project could not run: `cargo install cargo-gpu`, then in
//!   `render-spirv/shaders` `cargo gpu build`, which fetches the nightly that spirv-std 0.10.0-alpha.1 pins
//!   (nightly-2026-04-11); pass `--abort-strategy=unreachable` as a codegen argument, or every index check becomes an
//!   early return and the module more than twice as large.
//!
//! # Stages and features
//! SPIR-V functions that touch buffers are copied to every call, so a full path in one shader is a quarter of a million
//! instructions, for which the compiler of Mesa's software device takes more than six minutes. Path tracing and direct
//! illumination therefore run in [`path_stages`], one step of all paths at a time, and every stage is compiled for the
//! features of the scene ([`halflight_kernel::scene::features`]): models, textures and lights that the scene lacks are
//! removed by the driver.
//!
//! # Limits
//! Path tracing, direct illumination, ambient occlusion and the layers of the first surface have entry points; other
//! integrators are refused with a message. Mesa's software device (lavapipe, 22.3) ends every loop of an invocation
//! after 65,535 iterations in total; [`canary`] measures the budget of a device, `halflight-gpu devices` prints it, and an
//! invocation takes one step of one sample only.

pub mod canary;
pub mod commands;
pub mod device_backend;
pub mod interface;
pub mod module;
pub mod no_contraction;
pub mod path_stages;
pub mod probe;
pub mod probe_runner;
pub mod scene_buffers;
pub mod vulkan;
