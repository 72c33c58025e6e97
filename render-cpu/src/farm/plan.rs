//! What a farm renders, and how it is divided among its tasks.
//!
//! Three divisions:
//! - by *samples*, task i of N takes the samples `floor(i S / N)` to `floor((i + 1) S / N)` of every pixel. All together are
//!   those of one run; means of its film round differently in the last bits of f64, see [`super`]. Of algorithms with passes over
//!   photons a sample is a pass, of Markov chains a group of chains;
//! - by *pixels*, task i takes all samples of the tiles i, i + N, i + 2 N ..., so that no pixel's samples are ever summed in
//!   two machines, and the image is that of one run to the last bit. Not for algorithms whose samples splat on other pixels;
//! - by *seeds*, each task takes as many samples with a seed of its own, for sequences that are better not divided (Sobol').
//!
//! The plan holds the settings of the run as a checkpoint does. Every task compares them with those of the scene that it has
//! loaded: a scene that was edited in between, or another version of the program, is refused.

use super::error::FarmError;
pub use super::planned_scene::{PlannedLook, PlannedScene, settings_words};
use crate::film::aov::{Aov, AovSet};
use crate::film::checkpoint::{Settings, settings_differences};
use crate::image::camera_attributes::CameraAttributes;
use crate::image::metadata::SampleRange;
use crate::render::record::{CLAMP, FIRST_SAMPLE, SEED, run_settings, sampler_name};
use crate::render::{Goal, MutationsPerPixel, RenderOptions, Shape, own_layers, shape};
use crate::scene::build::Scene;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Most tasks of a farm.
pub const MAX_TASKS: u32 = 1 << 20;
/// Number of films per merge, by default.
pub const FAN_IN: u32 = 32;
/// Side of the squares of pixels that a division by pixels hands out in turn, so that each task has some of every region.
const TILE: u32 = 16;

/// How the samples are divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Division {
    /// Ranges of the samples of one seed: together those of one run.
    #[default]
    Samples,
    /// Tiles of the image.
    Pixels,
    /// A seed for each task.
    Seeds,
}

/// The request for a farm, beside its scene.
#[derive(Clone, Debug)]
pub struct Request {
    /// The image.
    pub output: PathBuf,
    /// Number of tasks.
    pub tasks: u32,
    /// Samples per pixel of the image; otherwise those that the scene asks for.
    pub spp: Option<u32>,
    /// Seed; otherwise the scene's.
    pub seed: Option<u32>,
    /// How samples are divided.
    pub division: Division,
    /// Layers beside the image.
    pub layers: AovSet,
    /// Films that a merge takes in.
    pub fan_in: u32,
}

/// A farm's plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The scene.
    pub scene: PlannedScene,
    /// The image.
    pub output: PathBuf,
    /// Number of tasks.
    pub tasks: u32,
    /// Samples per pixel of the image.
    pub spp: u32,
    /// Mutations per pixel that a sample stands for; one but for Markov chains.
    #[serde(default = "one")]
    pub unit: u32,
    /// Seed, the first of several for a division by seeds.
    pub seed: u32,
    /// How samples are divided.
    pub division: Division,
    /// Names of the layers.
    pub layers: Vec<String>,
    /// Films that a merge takes in.
    pub fan_in: u32,
    /// Size of the whole image.
    pub full_size: [u32; 2],
    /// Name of the algorithm.
    pub integrator: String,
    /// Name of the random numbers.
    pub sampler: String,
    /// Settings of task 0.
    pub settings: Settings,
    /// The camera, for the image's metadata.
    #[serde(default)]
    pub camera: CameraAttributes,
}

fn one() -> u32 {
    1
}

/// The share of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Seed.
    pub seed: u32,
    /// First sample of every pixel.
    pub first: u32,
    /// Samples per pixel.
    pub count: u32,
}

impl Share {
    /// The share as image metadata name it.
    pub fn range(&self) -> SampleRange {
        SampleRange {
            seed: self.seed.into(),
            from: self.first,
            to: self.first + self.count,
        }
    }
}

impl Plan {
    /// Plans a farm. Loads the scene once, so that its mistakes show here and not in every task.
    ///
    /// # Errors
    /// What is wrong with the scene; or there are no tasks, more than samples, or too many of either.
    pub fn new(scene: PlannedScene, request: &Request) -> Result<Plan, FarmError> {
        let built = scene.load()?;
        Plan::of(scene, &built, request)
    }

    /// [`Plan::new`] for a scene that was loaded.
    ///
    /// # Errors
    /// As there, but for the scene's.
    pub fn of(scene: PlannedScene, built: &Scene, request: &Request) -> Result<Plan, FarmError> {
        let wrong = |what: String| Err(FarmError::Request(what));
        let unit = MutationsPerPixel::of(built).0;
        let spp = request.spp.unwrap_or(built.spp).div_ceil(unit);
        let tasks = request.tasks;
        if tasks == 0 || tasks > MAX_TASKS {
            return wrong(format!("a farm has 1 to {MAX_TASKS} tasks, not {tasks}"));
        }
        if tasks > spp && request.division != Division::Pixels && unit > 1 {
            return wrong(format!(
                "{tasks} tasks cannot share {spp} groups of {unit} mutations per pixel; each needs at least one: ask for more samples per pixel"
            ));
        }
        if tasks > spp && request.division != Division::Pixels {
            return wrong(format!(
                "{tasks} tasks cannot share {spp} samples per pixel; each needs at least one"
            ));
        }
        if request.fan_in < 2 {
            return wrong("a merge takes in at least 2 films".to_owned());
        }
        let seed = request.seed.unwrap_or(built.seed);
        if request.division == Division::Seeds && seed.checked_add(tasks - 1).is_none() {
            return wrong(format!(
                "seeds from {seed} on are not enough for {tasks} tasks"
            ));
        }
        if tasks > 1 && !own_layers(built.settings.kind).is_empty() {
            return wrong(format!(
                "each pass of {} takes its radii from all before it, so that tasks cannot share them",
                built.integrator
            ));
        }
        if request.division == Division::Pixels {
            if shape(built.settings.kind) != Shape::Pixels {
                return wrong(format!(
                    "samples of {} share their light among all pixels; divide them by samples or seeds",
                    built.integrator
                ));
            }
            let [width, height] = built.tables.camera.crop_size;
            let tiles = width.div_ceil(TILE) * height.div_ceil(TILE);
            if tasks > tiles {
                return wrong(format!(
                    "{tasks} tasks cannot share {tiles} tiles of {TILE} x {TILE} pixels"
                ));
            }
        }
        let mut plan = Plan {
            output: request.output.clone(),
            tasks,
            spp,
            unit,
            seed,
            division: request.division,
            layers: request.layers.iter().map(|a| a.name().to_owned()).collect(),
            fan_in: request.fan_in,
            full_size: built.tables.camera.film_size,
            integrator: built.integrator.clone(),
            sampler: sampler_name(built.sampler).to_owned(),
            settings: Settings::new(),
            camera: CameraAttributes::of(&built.tables.camera),
            scene,
        };
        plan.settings = plan.found_settings(built)?;
        Ok(plan)
    }

    /// Whether the numbers of a plan that was read fit together.
    pub(super) fn is_sound(&self) -> bool {
        (1..=MAX_TASKS).contains(&self.tasks)
            && self.spp > 0
            && self.unit > 0
            && (self.tasks <= self.spp || self.division == Division::Pixels)
            && self.fan_in >= 2
            && (self.division != Division::Seeds || self.seed.checked_add(self.tasks).is_some())
    }

    /// The share of a task.
    pub fn share(&self, task: u32) -> Share {
        let cut = |i: u32| (u64::from(i) * u64::from(self.spp) / u64::from(self.tasks)) as u32;
        let (from, to) = (cut(task), cut(task + 1));
        match self.division {
            Division::Samples => Share {
                seed: self.seed,
                first: from,
                count: to - from,
            },
            Division::Pixels => Share {
                seed: self.seed,
                first: 0,
                count: self.spp,
            },
            Division::Seeds => Share {
                seed: self.seed + task,
                first: 0,
                count: to - from,
            },
        }
    }

    /// Whether a pixel of the film is a task's.
    pub fn has_pixel(&self, task: u32, x: u32, y: u32, width: u32) -> bool {
        match self.division {
            Division::Samples | Division::Seeds => true,
            Division::Pixels => {
                let tile = y / TILE * width.div_ceil(TILE) + x / TILE;
                tile % self.tasks == task
            }
        }
    }

    /// The samples of all tasks together, as image metadata name them.
    pub fn ranges(&self) -> Vec<SampleRange> {
        match self.division {
            Division::Samples | Division::Pixels => vec![SampleRange {
                seed: self.seed.into(),
                from: 0,
                to: self.spp,
            }],
            Division::Seeds => (0..self.tasks).map(|i| self.share(i).range()).collect(),
        }
    }

    /// How a share is rendered.
    pub fn options(&self, share: Share) -> RenderOptions {
        RenderOptions {
            goal: Goal::Samples(share.count),
            seed: share.seed,
            first_sample: share.first,
            adaptive: false,
        }
    }

    /// The settings of task 0 with a scene that was loaded.
    fn found_settings(&self, scene: &Scene) -> Result<Settings, FarmError> {
        let options = self.options(self.share(0));
        let mut settings = run_settings(&self.scene.file, scene, &options, self.aovs()?);
        if let Some(clamp) = self.scene.look.clamp {
            settings.insert(CLAMP.to_owned(), clamp.to_string());
        }
        Ok(settings)
    }

    /// The settings in the checkpoint of a share.
    pub fn settings_of(&self, share: Share) -> Settings {
        let mut settings = self.settings.clone();
        settings.insert(SEED.to_owned(), share.seed.to_string());
        settings.insert(FIRST_SAMPLE.to_owned(), share.first.to_string());
        settings
    }

    /// The layers.
    ///
    /// # Errors
    /// When the plan names one that is not known.
    pub fn aovs(&self) -> Result<AovSet, FarmError> {
        let parsed: Result<AovSet, _> =
            self.layers.iter().map(|name| name.parse::<Aov>()).collect();
        let aovs = parsed.map_err(|e| FarmError::Request(e.to_string()))?;
        Ok(aovs.with(Aov::Samples))
    }

    /// Makes sure that a scene is the one that was planned.
    ///
    /// # Errors
    /// What differs.
    pub fn check(&self, scene: &Scene) -> Result<(), FarmError> {
        let found = self.found_settings(scene)?;
        let differences = settings_differences(&self.settings, &found);
        if differences.is_empty() {
            Ok(())
        } else {
            Err(FarmError::OtherScene { differences })
        }
    }

    /// How many films each level of the merge has: tasks first, the image last.
    pub fn levels(&self) -> Vec<u32> {
        let mut levels = vec![self.tasks];
        while let Some(&last) = levels.last()
            && (last > 1 || levels.len() == 1)
        {
            levels.push(last.div_ceil(self.fan_in));
        }
        levels
    }
}
