//! One image by the device and by the processor, with the same random numbers.

use halflight::commands::scene_args::{SceneArgs, build_accel};
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Backend, CpuBackend, Goal, RenderOptions, Stop};
use halflight::scene::build::Scene;
use halflight_spirv::device_backend::DeviceBackend;
use halflight_spirv::vulkan::Device;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// A scene file at a width; its own integrator with `None`.
pub fn load(
    path: &Path,
    width: u32,
    integrator: Option<&str>,
    defines: Vec<(String, String)>,
) -> Scene {
    let args = SceneArgs {
        scene: path.to_path_buf(),
        defines,
        size: None,
        width: Some(width),
        crop: None,
        integrator: integrator.map(String::from),
        sampler: None,
        sensor: 0,
        edit: None,
        edit_time: None,
        strict: false,
    };
    args.load()
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// How far two images are apart.
#[allow(dead_code, reason = "not every test reads or asserts everything")]
#[derive(Debug)]
pub struct Difference {
    /// Mean absolute difference over the mean.
    pub mean: f64,
    /// Share of the pixels of which a channel is off by more than 1 %.
    pub outside: f64,
    /// Pixels that are not finite on the device.
    pub not_finite: usize,
    /// Time until the device could start, in seconds.
    pub ready: f64,
    /// Time that the device took for the samples, in seconds.
    pub seconds: f64,
}

#[allow(dead_code, reason = "as above")]
impl Difference {
    /// Panics unless the images agree: mean absolute difference at most 1e-3 of the mean, at most 1 % of the pixels outside
    /// 1 % (paths that took another branch because of a rounding), nothing that is not finite.
    pub fn assert_small(&self, name: &str) {
        assert!(self.is_small(), "{name}: {self:?}");
    }

    /// See [`Difference::assert_small`].
    pub fn is_small(&self) -> bool {
        self.mean <= 1e-3 && self.outside <= 0.01 && self.not_finite == 0
    }
}

/// Renders with `spp` samples per pixel on both and compares.
///
/// # Errors
/// What the device said.
pub fn compare(device: &Arc<Device>, scene: &Scene, spp: u32) -> Result<Difference, String> {
    let accel = build_accel(scene);
    let options = RenderOptions {
        goal: Goal::Samples(spp),
        seed: 7,
        first_sample: 0,
        adaptive: false,
    };
    let [width, height] = scene.tables.camera.crop_size;
    let film = || Film::new(width, height, [0, 0], AovSet::NONE).expect("a small film");
    let start = Instant::now();
    let mut backend =
        DeviceBackend::new(device, scene, &accel, &options, false).map_err(|e| e.to_string())?;
    let ready = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut on_device = film();
    backend
        .pass(&mut on_device, spp, None, &Stop::NEVER)
        .map_err(|e| format!("{e}"))?;
    let seconds = start.elapsed().as_secs_f64();
    let mut on_cpu = film();
    CpuBackend::new(scene, &accel, &options)
        .pass(&mut on_cpu, spp, None, &Stop::NEVER)
        .map_err(|e| format!("{e}"))?;
    let (mut difference, mut sum, mut outside, mut not_finite) = (0.0, 0.0, 0, 0);
    for (a, b) in on_device.mean().iter().zip(&on_cpu.mean()) {
        not_finite += usize::from(a.iter().any(|x| !x.is_finite()));
        let off = |c: usize| (a[c] - b[c]).abs() > 0.01 * b[c].abs().max(1e-3);
        outside += usize::from((0..3).any(off));
        for c in 0..3 {
            difference += (a[c] - b[c]).abs();
            sum += b[c].abs();
        }
    }
    if sum == 0.0 {
        return Err(String::from("the processor's image is black"));
    }
    Ok(Difference {
        mean: difference / sum,
        outside: outside as f64 / f64::from(width * height),
        not_finite,
        ready,
        seconds,
    })
}
