//! The backend of the run loop that takes samples on a Vulkan device.
//!
//! A layer is one sample of every pixel. It is taken in slices, each a submission that is waited for: their size is adapted
//! to the device's speed, so that none takes long enough for a watchdog. A layer is added to the film when it is complete, in
//! f64 as on the CPU; if the device is lost or the run is stopped before, the film consists of complete layers.

use crate::interface::{Dispatch, FEATURE_VECTORS, WORKGROUP, WorkItem};
use crate::module::{self, StaleModule};
use crate::path_stages::{Stages, TIME_LIMIT};
use crate::scene_buffers::SceneBuffers;
use crate::vulkan::{Buffer, Device, Memory, Pipeline, VulkanError};
use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::AovSample;
use halflight::render::{Backend, PassEnd, PassError, RenderOptions, Stop};
use halflight::scene::build::Scene;
use halflight_kernel::scene::{camera_kind, features};
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::staged::PathRecord;
use rayon::prelude::*;
use std::ffi::CStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Largest number of samples of a submission.
const MAX_SLICE: u32 = 1 << 20;

/// The first slice; later ones follow the measured speed.
const FIRST_SLICE: u32 = 1 << 12;

/// Time that a submission should take.
const SLICE_TIME: Duration = Duration::from_millis(200);

/// Largest number of samples of a submission for integrators that keep their paths in a buffer.
const MAX_PATHS: u32 = 1 << 17;

/// A device that takes samples of one scene.
pub struct DeviceBackend {
    // Pipelines first: they are dropped before the buffers that they bind.
    radiance: Radiance,
    features: Option<Pipeline>,
    items: Buffer,
    results: Buffer,
    /// What the stages keep between them; only they read it.
    _paths: Buffer,
    scene: SceneBuffers,
    options: RenderOptions,
    sampler: u32,
    slice: u32,
    /// The work items that the buffers hold.
    max_slice: u32,
    /// Layers to take before the loss of the device is simulated.
    lose_after: Option<u32>,
    device: Arc<Device>,
}

/// What a sample of a pixel is.
#[derive(Clone, Copy)]
struct Sample {
    radiance: [f32; 4],
    features: [[f32; 4]; FEATURE_VECTORS as usize],
}

/// What estimates radiance.
enum Radiance {
    /// One entry point takes a whole sample.
    Sample(Pipeline),
    /// Paths that go on in stages.
    Paths(Stages),
}

/// Why a device cannot take a scene's samples.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BackendError {
    /// The algorithm has no entry point.
    #[error("there is no shader for the integrator \"{0}\"; `halflight render` has it")]
    NoShader(String),
    /// The sensor has no shader.
    #[error("there is no shader for irradiance meters; `halflight render` has them")]
    NoMeter,
    /// Shaders hold the plain algorithms.
    #[error("there is no shader for --regularize and --mollify; `halflight render` has them")]
    NoRegularization,
    /// The committed module is older than the program.
    #[error(transparent)]
    StaleModule(#[from] StaleModule),
    /// The device.
    #[error(transparent)]
    Device(#[from] VulkanError),
}

impl DeviceBackend {
    /// Uploads the scene and compiles the pipelines; `with_features` is for films with layers of the surface.
    ///
    /// # Errors
    /// If there is no shader for the scene, the device has no room, or its driver refuses the shaders.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        accel: &Accel,
        options: &RenderOptions,
        with_features: bool,
    ) -> Result<DeviceBackend, BackendError> {
        let kind = scene.settings.kind;
        let in_stages = Stages::serve(kind);
        if !in_stages && kind != integrator_kind::AMBIENT_OCCLUSION {
            return Err(BackendError::NoShader(scene.integrator.clone()));
        }
        if scene.tables.camera.kind == camera_kind::IRRADIANCE_METER {
            return Err(BackendError::NoMeter);
        }
        if scene.settings.regularization.is_some() {
            return Err(BackendError::NoRegularization);
        }
        let tables = SceneBuffers::upload(device, scene, accel)?;
        let [width, height] = scene.tables.camera.crop_size;
        let max_slice = if in_stages { MAX_PATHS } else { MAX_SLICE };
        let items = width.saturating_mul(height).min(max_slice);
        let list = device.create_buffer(
            "work items",
            u64::from(items) * size_of::<WorkItem>() as u64,
            Memory::Host,
        )?;
        let vectors = if with_features { FEATURE_VECTORS } else { 1 };
        let results = device.create_buffer(
            "results",
            u64::from(items) * u64::from(vectors) * 16,
            Memory::Host,
        )?;
        let mut bound: Vec<&Buffer> = tables.buffers().iter().collect();
        let paths = if in_stages {
            Stages::paths(&scene.settings, items) * size_of::<PathRecord>() as u64
        } else {
            0
        };
        let paths = device.create_buffer("paths", paths, Memory::Device)?;
        bound.push(&list);
        bound.push(&results);
        bound.push(&paths);
        let words = module::words();
        let features = features::of(&scene.tables.view());
        let push_constants = size_of::<Dispatch>() as u32;
        let known = module::entry_points(&words);
        let pipeline = |entry: &CStr| {
            let name = entry.to_string_lossy();
            module::require(&known, &name)?;
            let start = Instant::now();
            let made = device.create_specialized_pipeline(
                &words,
                entry,
                &bound,
                push_constants,
                &[features],
            )?;
            let created = start.elapsed().as_secs_f64();
            // Some drivers compile at the first use.
            made.dispatch("an empty slice", &Dispatch::default(), 1, TIME_LIMIT)?;
            let used = start.elapsed().as_secs_f64() - created;
            tracing::info!("compiled {name}: created in {created:.2} s, first used in {used:.2} s");
            Ok::<_, BackendError>(made)
        };
        let features = with_features
            .then(|| pipeline(c"surface_features"))
            .transpose()?;
        let radiance = if in_stages {
            let stages = Stages::new(device, scene.settings, items, pipeline)?;
            Radiance::Paths(stages)
        } else {
            Radiance::Sample(pipeline(c"occlusion")?)
        };
        device.keep_compiled_shaders();
        Ok(DeviceBackend {
            radiance,
            features,
            items: list,
            results,
            _paths: paths,
            scene: tables,
            options: options.clone(),
            sampler: scene.sampler,
            slice: FIRST_SLICE.min(items),
            max_slice: items,
            lose_after: None,
            device: device.clone(),
        })
    }

    /// Bytes of the scene on the device.
    pub fn scene_bytes(&self) -> u64 {
        self.scene.bytes()
    }

    /// Reports the device as lost after so many more layers: what a test of that case needs.
    pub fn simulate_loss_after(&mut self, layers: u32) {
        self.lose_after = Some(layers);
    }

    /// One sample of every listed pixel, in the order of the list; none if it is to stop before that.
    fn layer(
        &mut self,
        list: &[WorkItem],
        stop: &Stop<'_>,
    ) -> Result<Option<Vec<Sample>>, VulkanError> {
        if let Some(left) = &mut self.lose_after {
            if *left == 0 {
                return Err(VulkanError::DeviceLost(
                    self.device.description().name.clone(),
                ));
            }
            *left -= 1;
        }
        let mut samples = Vec::with_capacity(list.len());
        let mut rest = list;
        while !rest.is_empty() {
            if stop.is_urgent() {
                return Ok(None);
            }
            let count = (rest.len() as u32).min(self.slice);
            let (slice, after) = rest.split_at(count as usize);
            rest = after;
            let start = Instant::now();
            self.sample_slice(slice, &mut samples)?;
            let time = match &self.radiance {
                Radiance::Sample(_) => start.elapsed(),
                Radiance::Paths(stages) => stages.longest_submission(),
            };
            if time < SLICE_TIME / 2 && count == self.slice {
                self.slice = (self.slice * 2).min(self.max_slice);
            } else if time > SLICE_TIME * 2 {
                self.slice = (self.slice / 2).max(WORKGROUP);
            }
        }
        Ok(Some(samples))
    }

    /// Takes the samples of one slice.
    fn sample_slice(
        &mut self,
        slice: &[WorkItem],
        samples: &mut Vec<Sample>,
    ) -> Result<(), VulkanError> {
        let count = slice.len();
        let slice: Vec<WorkItem> = slice
            .iter()
            .zip(0..)
            .map(|(item, slot)| WorkItem { slot, ..*item })
            .collect();
        let dispatch = Dispatch {
            count: count as u32,
            seed: self.options.seed,
            sampler: self.sampler,
            first: 0,
        };
        let groups = dispatch.count.div_ceil(WORKGROUP);
        let mut radiance = vec![[0.0f32; 4]; count];
        match &mut self.radiance {
            Radiance::Sample(pipeline) => {
                self.items.write(&slice);
                pipeline.dispatch("a slice of samples", &dispatch, groups, TIME_LIMIT)?;
                self.results.read(&mut radiance);
            }
            Radiance::Paths(stages) => stages.take(
                dispatch,
                &slice,
                &mut self.items,
                &self.results,
                &mut radiance,
            )?,
        }
        self.items.write(&slice);
        let mut features = Vec::new();
        if let Some(pipeline) = &self.features {
            pipeline.dispatch("a slice of features", &dispatch, groups, TIME_LIMIT)?;
            features = vec![[[0.0f32; 4]; FEATURE_VECTORS as usize]; count];
            self.results.read(&mut features);
        }
        samples.extend((0..count).map(|i| Sample {
            radiance: radiance[i],
            features: features.get(i).copied().unwrap_or_default(),
        }));
        Ok(())
    }
}

impl Backend for DeviceBackend {
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
        stop: &Stop<'_>,
    ) -> Result<PassEnd, PassError> {
        let most = counts.map_or(per_pixel, |c| c.iter().copied().max().unwrap_or(0));
        let with_features = self.features.is_some();
        for layer in 0..most {
            if layer > 0 && stop.is_set() {
                return Ok(PassEnd::Cut);
            }
            let list: Vec<WorkItem> = film
                .statistics()
                .iter()
                .enumerate()
                .filter(|(pixel, _)| counts.is_none_or(|c| layer < c[*pixel]))
                .map(|(pixel, statistics)| WorkItem {
                    pixel: pixel as u32,
                    sample: self.options.first_sample.wrapping_add(statistics.count),
                    slot: 0,
                })
                .collect();
            let Some(samples) = self.layer(&list, stop)? else {
                return Ok(PassEnd::Cut);
            };
            let width = film.width();
            // The index of each pixel in the list; `u32::MAX` for pixels that are not in it.
            let mut places = vec![u32::MAX; film.statistics().len()];
            for (index, item) in list.iter().enumerate() {
                places[item.pixel as usize] = index as u32;
            }
            film.tiles_mut(64).into_par_iter().for_each(|mut tile| {
                for y in tile.y()..tile.y() + tile.height() {
                    for x in tile.x()..tile.x() + tile.width() {
                        let index = places[y as usize * width as usize + x as usize];
                        let Some(sample) = samples.get(index as usize) else {
                            continue;
                        };
                        let [r, g, b, _] = sample.radiance;
                        let mut pixel = tile.pixel_mut(x, y);
                        pixel.add_sample(halflight_kernel::math::Rgb::new(r, g, b));
                        if with_features {
                            let [a, n, p] = sample.features;
                            pixel.add_aovs(&AovSample {
                                albedo: [a[0], a[1], a[2]],
                                normal: [n[0], n[1], n[2]],
                                depth: a[3],
                                position: [p[0], p[1], p[2]],
                                uv: [n[3], p[3]],
                            });
                        }
                    }
                }
            });
        }
        Ok(PassEnd::Complete)
    }
}
