//! The samples of one tile of the film, on one thread.
//!
//! Paths are traced in waves ([`Wavefront`]) of consecutive samples: those of one pixel, or of neighbouring pixels where each
//! gets but a few. Between two waves a tile may be left: pixels then have the first of their samples. Samples enter their pixel in the order of their indices whatever the wave, so that sums round alike.

use super::backend::PassEnd;
use super::division::Division;
use super::options::RenderOptions;
use super::regularized_paths::RegularizedPaths;
use super::stop::Stop;
use super::surface_sample::surface_sample;
use crate::film::FilmTile;
use glam::Vec3;
use halflight_kernel::path::expression::MAX_PARTS;
use halflight_kernel::path::retarget_states::Edits;
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::{LaneSampler, Sampler};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::simd::SimdLevel;
use halflight_kernel::transport::divided::{DividedPath, Mixture};
use halflight_kernel::transport::wavefront::{WaveDivision, Wavefront};
use halflight_kernel::transport::{self, IntegratorSettings, integrator_kind, retargeted};

/// Slots for paths side by side: enough for whole vectors of every class, few enough that their state stays in the second
/// cache. A row of them takes an odd number of cache lines, so that the same slot of many rows does not compete for the same
/// sets of the first cache (a tenth of the time of cornell-box at 1024).
pub const SLOTS: usize = 97 * 16;

/// Samples of a pixel that are taken one by one between two looks at whether to stop.
const SAMPLES_BETWEEN_LOOKS: u32 = 16;

/// Numbers of samples whose regularisation is kept.
const SCHEDULE: usize = 1024;

/// What all tiles of a pass have in common.
pub struct TileJob<'a, T: Traverse> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// The algorithm.
    pub settings: &'a IntegratorSettings,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
    /// What the image is divided by, if anything.
    pub division: Option<Division<'a>>,
    /// The edits of its light transport, if there are any.
    pub edits: Option<Edits<'a>>,
    /// Whether layers of surface features are wanted.
    pub needs_surface: bool,
    /// When to leave a tile.
    pub stop: &'a Stop<'a>,
    /// Those of the processor.
    pub simd: SimdLevel,
}

/// Samples of a pixel that are being traced.
#[derive(Clone, Copy)]
struct Run {
    x: u32,
    y: u32,
    count: u32,
}

/// What a thread needs for its tiles.
pub struct Workspace<S> {
    wave: Box<Wavefront<S, SLOTS>>,
    /// Instead of the wavefront where the regularisation of a path follows the path.
    followed: Option<RegularizedPaths<S>>,
    /// The regularisation of samples by their numbers, which neighbouring pixels share.
    schedule: Vec<(u32, Regularization)>,
    runs: Vec<Run>,
    /// The numbers of those samples from the first on, where surfaces are wanted.
    samplers: Vec<S>,
    /// What accompanies the paths of an image that is divided, and their parts.
    divided: Vec<DividedPath>,
    mixtures: Vec<Mixture>,
    parts: Vec<Vec3>,
}

impl<S: LaneSampler> Workspace<S> {
    /// Storage for a wave of paths by the settings.
    pub fn new(settings: &IntegratorSettings) -> Workspace<S> {
        let own = &settings.regularization;
        let length = if own.is_some() { SCHEDULE } else { 0 };
        Workspace {
            wave: bytemuck::zeroed_box(),
            followed: own.follows_paths().then(RegularizedPaths::new),
            schedule: vec![(u32::MAX, Regularization::NONE); length],
            runs: Vec::with_capacity(SLOTS),
            samplers: Vec::with_capacity(SLOTS),
            divided: Vec::new(),
            mixtures: Vec::new(),
            parts: Vec::new(),
        }
    }

    fn is_full(&self) -> bool {
        match &self.followed {
            None => self.wave.is_full(),
            Some(paths) => paths.is_full(),
        }
    }
}

impl<T: Traverse> TileJob<'_, T> {
    /// Adds the next samples of every pixel of the tile, as many as `count` says of its coordinates; `new` makes a sampler
    /// of (seed, pixel, sample). A tile that is cut has the first samples of some pixels.
    pub fn sample_tile<S: LaneSampler>(
        &self,
        workspace: &mut Workspace<S>,
        tile: &mut FilmTile<'_>,
        count: impl Fn(u32, u32) -> u32,
        new: impl Fn(u32, u32, u32) -> S,
    ) -> PassEnd {
        let film_width = self.view.tables.camera.film_size[0];
        for y in tile.y()..tile.y() + tile.height() {
            for x in tile.x()..tile.x() + tile.width() {
                let pixel = self.pixel(x, y);
                let index = pixel[1].wrapping_mul(film_width).wrapping_add(pixel[0]);
                let first = self
                    .options
                    .first_sample
                    .wrapping_add(tile.pixel_mut(x, y).statistics.count);
                let new = |i: u32| new(self.options.seed, index, first.wrapping_add(i));
                let count = count(x, y);
                if let Some(edits) = &self.edits {
                    for i in 0..count {
                        if i % SAMPLES_BETWEEN_LOOKS == 0 && self.stop.is_set() {
                            return PassEnd::Cut;
                        }
                        self.add_edited(tile, [x, y], edits, new(i));
                    }
                    self.stop.took(count as usize);
                    continue;
                }
                if self.settings.kind != integrator_kind::PATH {
                    for i in 0..count {
                        if i % SAMPLES_BETWEEN_LOOKS == 0 && self.stop.is_set() {
                            return PassEnd::Cut;
                        }
                        let sampler = new(i);
                        let mut numbers = sampler;
                        let radiance =
                            transport::sample_pixel(self.view, self.settings, &mut numbers, pixel);
                        tile.pixel_mut(x, y).add_sample(radiance);
                        if self.needs_surface {
                            self.add_surface(tile, [x, y], sampler);
                        }
                    }
                    self.stop.took(count as usize);
                    continue;
                }
                let mut done = 0;
                while done < count {
                    let left = count - done;
                    let first = first.wrapping_add(done);
                    let new = |i: u32| new(done + i);
                    let taken = self.push(workspace, pixel, left, first, new);
                    workspace.runs.push(Run { x, y, count: taken });
                    if self.needs_surface {
                        workspace.samplers.extend((0..taken).map(new));
                    }
                    done += taken;
                    if workspace.is_full() {
                        self.finish(tile, workspace);
                        if self.stop.is_set() {
                            return PassEnd::Cut;
                        }
                    }
                }
            }
        }
        self.finish(tile, workspace);
        PassEnd::Complete
    }

    /// Adds at most `count` samples of a pixel to the paths of the workspace, the first of the number `first`; returns how many.
    fn push<S: LaneSampler>(
        &self,
        workspace: &mut Workspace<S>,
        pixel: [u32; 2],
        count: u32,
        first: u32,
        new: impl Fn(u32) -> S,
    ) -> u32 {
        if !self.settings.regularization.is_some() {
            return workspace.wave.push_samples(pixel, count, new);
        }
        let schedule = &mut workspace.schedule;
        let mut regularization = |i: u32| {
            let sample = first.wrapping_add(i);
            let entry = &mut schedule[sample as usize % SCHEDULE];
            if entry.0 != sample {
                *entry = (sample, self.regularization(sample));
            }
            entry.1
        };
        match &mut workspace.followed {
            Some(paths) => {
                let sample = |i: u32| (new(i), regularization(i));
                paths.push_samples(self.view, self.settings, pixel, count, sample)
            }
            None => workspace
                .wave
                .push_regularized(pixel, count, new, regularization),
        }
    }

    /// Adds a sample of path tracing with edits.
    fn add_edited<S: LaneSampler>(
        &self,
        tile: &mut FilmTile<'_>,
        [x, y]: [u32; 2],
        edits: &Edits<'_>,
        sampler: S,
    ) {
        let mut parts = [Vec3::ZERO; MAX_PARTS];
        let expressions = self.division.as_ref().map(|d| &d.expressions);
        let count = expressions.map_or(0, |e| e.count as usize);
        let radiance = retargeted::path::sample_pixel(
            self.view,
            self.settings,
            edits,
            expressions,
            &mut sampler.clone(),
            self.pixel(x, y),
            &mut parts[..count],
        );
        let mut pixel = tile.pixel_mut(x, y);
        pixel.add_sample(radiance);
        if let Some(division) = &self.division {
            pixel.add_parts(radiance, &parts[division.first..count]);
        }
        if self.needs_surface {
            self.add_surface(tile, [x, y], sampler);
        }
    }

    /// The regularisation of the sample with an index.
    fn regularization(&self, sample: u32) -> Regularization {
        let radius = self.view.tables.info.radius;
        Regularization::of_sample(&self.settings.regularization, radius, sample)
    }

    /// Coordinates in the whole film of a pixel of the window.
    fn pixel(&self, x: u32, y: u32) -> [u32; 2] {
        let [left, top] = self.view.tables.camera.crop_offset;
        [left + x, top + y]
    }

    /// Traces the wave and adds its samples.
    fn finish<S: LaneSampler>(&self, tile: &mut FilmTile<'_>, workspace: &mut Workspace<S>) {
        let Workspace {
            wave,
            runs,
            samplers,
            divided,
            mixtures,
            parts,
            followed,
            schedule: _,
        } = workspace;
        let mut shares: &[[f32; 2]] = &[];
        let mut radiance = match (followed, &self.division) {
            (Some(paths), _) => {
                let (radiance, of_paths) = paths.run(self.view, self.settings);
                shares = of_paths;
                radiance
            }
            (None, _) if self.settings.regularization.is_some() => {
                let (radiance, of_paths) =
                    wave.run_regularized(self.simd, self.view, self.settings);
                shares = of_paths;
                radiance
            }
            (None, None) => wave.run(self.simd, self.view, self.settings),
            (None, Some(division)) => {
                divided.resize(SLOTS, DividedPath::NONE);
                mixtures.resize(SLOTS, Mixture::NONE);
                parts.resize(SLOTS * division.expressions.count as usize, Vec3::ZERO);
                let expressions = division.expressions;
                let mut division = WaveDivision::new(expressions, divided, mixtures, parts);
                wave.run_divided(self.simd, self.view, self.settings, &mut division)
            }
        };
        self.stop.took(radiance.len());
        let mut samplers = samplers.drain(..);
        let mut done = 0;
        for run in runs.drain(..) {
            let (of_run, rest) = radiance.split_at(run.count as usize);
            radiance = rest;
            let mut pixel = tile.pixel_mut(run.x, run.y);
            pixel.add_samples(of_run);
            if !shares.is_empty() {
                let (of_samples, rest) = shares.split_at(of_run.len());
                shares = rest;
                for (sample, share) in of_run.iter().zip(of_samples) {
                    pixel.add_regularized(*sample, *share);
                }
            }
            if let Some(division) = &self.division {
                let count = division.expressions.count as usize;
                let end = done + of_run.len();
                let parts = parts[done * count..end * count].chunks_exact(count);
                for (sample, parts) in of_run.iter().zip(parts) {
                    pixel.add_parts(*sample, &parts[division.first..]);
                }
                done = end;
            }
            for sampler in samplers.by_ref().take(of_run.len()) {
                self.add_surface(tile, [run.x, run.y], sampler);
            }
        }
    }

    /// Adds the surface that the first ray of a sample meets to its pixel.
    fn add_surface<S: Sampler>(&self, tile: &mut FilmTile<'_>, [x, y]: [u32; 2], sampler: S) {
        let sample = surface_sample(self.view, sampler, self.pixel(x, y));
        tile.pixel_mut(x, y).add_aovs(&sample);
    }
}
