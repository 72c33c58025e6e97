//! `halflight-gpu render`: what `halflight render` does, on a Vulkan device.

use super::{DeviceArgs, check_validation};
use crate::device_backend::DeviceBackend;
use clap::Args;
use halflight::commands::render::{RenderArgs, run_with};
use halflight::render::render_with;
use halflight::say::note;
use std::error::Error;
use std::process::ExitCode;

/// Render a scene on a Vulkan device.
#[derive(Args, Clone, Debug)]
pub struct GpuRenderArgs {
    /// What to render.
    #[command(flatten)]
    pub render: RenderArgs,
    /// Where to render it.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Behave as if the device were lost after N samples per pixel, to see what is kept.
    #[arg(long, value_name = "N", hide = true)]
    pub simulate_device_loss: Option<u32>,
    /// Behave as if the device had so many bytes of memory.
    #[arg(long, value_name = "BYTES", hide = true)]
    pub simulate_memory: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// What keeps the image from being made or written, in one sentence. What was rendered before is written.
pub fn run(args: &GpuRenderArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    if !args.render.estimator.expressions.request().is_empty() {
        return Err("--lpe and --only are for the processor: use halflight render".into());
    }
    if args.render.scene.edit.is_some() {
        return Err("--edit is for the processor: use halflight render".into());
    }
    // Before the scene is read, which may take a while.
    let device = args.device.open()?;
    if let Some(bytes) = args.simulate_memory {
        device.limit_memory(bytes);
    }
    let code = run_with(&args.render, quiet, |job, film, state, stop, observer| {
        if !job.scene.edits.is_empty() {
            return Err("edits of a scene are for the processor: use halflight render".into());
        }
        if !quiet {
            let name = &device.description().name;
            let first = if device.has_compiled_shaders() {
                ""
            } else {
                ", which takes a while the first time"
            };
            note(format_args!("compiling shaders for {name}{first}"));
        }
        let mut backend = DeviceBackend::new(
            &device,
            job.scene,
            job.accel,
            job.options,
            film.aovs().needs_surface(),
        )?;
        if let Some(layers) = args.simulate_device_loss {
            backend.simulate_loss_after(layers);
        }
        render_with(&mut backend, job.options, film, state, stop, observer)
    })?;
    check_validation(&device)?;
    Ok(code)
}
