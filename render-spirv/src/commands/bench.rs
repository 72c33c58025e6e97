//! `halflight-gpu bench`: the speed of a device on a scene, beside that of the processor.

use super::{DeviceArgs, check_validation};
use crate::device_backend::DeviceBackend;
use clap::Args;
use halflight::accel::Accel;
use halflight::commands::scene_args::{SceneArgs, build_accel};
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Backend, CpuBackend, Goal, RenderOptions, Stop};
use halflight::say::print_line;
use halflight::scene::build::Scene;
use halflight_kernel::math::Ray;
use halflight_kernel::sampler::AnySampler;
use halflight_kernel::scene::{Hit, SceneView, Traverse};
use halflight_kernel::transport;
use std::cell::Cell;
use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

/// Measure a scene on a Vulkan device and on the processor.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Seconds to measure each for.
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    pub seconds: f64,
}

/// Runs the command.
///
/// # Errors
/// If the scene or the device cannot be used.
pub fn run(args: &BenchArgs) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let device = args.device.open()?;
    let scene = args.scene.load()?;
    let accel = build_accel(&scene);
    let options = RenderOptions {
        goal: Goal::Samples(u32::MAX),
        seed: 0,
        first_sample: 0,
        adaptive: false,
    };
    let start = Instant::now();
    let mut backend = DeviceBackend::new(&device, &scene, &accel, &options, false)?;
    let ready = start.elapsed().as_secs_f64();
    let [width, height] = scene.tables.camera.crop_size;
    let measure = |backend: &mut dyn Backend| {
        let mut film = Film::new(width, height, [0, 0], AovSet::NONE)?;
        // The first pass finds the size of the slices.
        backend.pass(&mut film, 1, None, &Stop::NEVER)?;
        let before = film.total_samples();
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < args.seconds {
            backend.pass(&mut film, 1, None, &Stop::NEVER)?;
        }
        let samples = film.total_samples() - before;
        Ok::<f64, Box<dyn Error + Send + Sync>>(samples as f64 / start.elapsed().as_secs_f64())
    };
    let on_device = measure(&mut backend)?;
    let on_cpu = measure(&mut CpuBackend::new(&scene, &accel, &options))?;
    let rays = rays_per_sample(&scene, &accel);
    let name = &device.description().name;
    print_line(format_args!("{}", args.scene.scene.display()))?;
    print_line(format_args!(
        "  {width} x {height}, {} triangles",
        scene.tables.triangles.len()
    ))?;
    print_line(format_args!("  {rays:.2} rays per sample"))?;
    print_line(format_args!(
        "  {name}: {:.3} Msamples/s, {:.2} Mrays/s, {:.1} MiB of which {:.1} are the scene, ready in {ready:.2} s",
        on_device * 1e-6,
        on_device * rays * 1e-6,
        mebibytes(device.peak_memory_used()),
        mebibytes(backend.scene_bytes())
    ))?;
    print_line(format_args!(
        "  processor, {} threads: {:.3} Msamples/s, {:.2} Mrays/s",
        rayon::current_num_threads(),
        on_cpu * 1e-6,
        on_cpu * rays * 1e-6
    ))?;
    print_line(format_args!("  ratio {:.2}", on_device / on_cpu))?;
    check_validation(&device)?;
    Ok(ExitCode::SUCCESS)
}

fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// Rays of a mean sample, counted on the processor: the device takes the same paths.
fn rays_per_sample(scene: &Scene, accel: &Accel) -> f64 {
    let tables = scene.tables.view();
    let count = Counted {
        traverse: accel.traverse(tables),
        rays: Cell::new(0),
    };
    let view = SceneView {
        tables,
        traverse: &count,
    };
    let [width, height] = scene.tables.camera.crop_size;
    let [left, top] = scene.tables.camera.crop_offset;
    // Some ten thousand pixels are enough for three digits.
    let step = (f64::from(width) * f64::from(height) / 1e4).sqrt().max(1.0) as usize;
    let mut samples = 0;
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            let mut sampler = AnySampler::new(scene.sampler, 0, y * width + x, 0);
            transport::sample_pixel(&view, &scene.settings, &mut sampler, [left + x, top + y]);
            samples += 1;
        }
    }
    count.rays.get() as f64 / f64::from(samples.max(1))
}

/// A ray tracer that counts.
struct Counted<T> {
    traverse: T,
    rays: Cell<u64>,
}

impl<T: Traverse> Traverse for Counted<T> {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        self.rays.set(self.rays.get() + 1);
        self.traverse.closest_hit(ray)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.rays.set(self.rays.get() + 1);
        self.traverse.is_occluded(ray)
    }
}
