//! The backend of the run loop that takes samples on all threads of the processor: a pass is divided into tiles of the film.

use super::backend::{Backend, PassEnd, PassError};
use super::chains::render_groups;
use super::divided_layers::render_divided_layers;
use super::division::Division;
use super::followed_samples::Followed;
use super::options::{Outcome, RenderOptions, RunState};
use super::own_layers::own_layers;
use super::pass_context::PassContext;
use super::passes::render_passes;
use super::pilot::Pilots;
use super::run_loop::{NoObserver, Observer, render_with};
use super::splatting::render_layers;
use super::stop::Stop;
use super::tile_job::{TileJob, Workspace};
use crate::accel::Accel;
use crate::film::aov::AovSet;
use crate::film::{Film, FilmError};
use crate::integrators::{Shape, divides_paths, shape};
use crate::processor;
use crate::scene::build::Scene;
use halflight_kernel::sampler::{IndependentSampler, LaneSampler, SobolSampler, sampler_kind};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::integrator_kind;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Side of the square of pixels that a thread takes at a time.
const TILE: u32 = 16;

/// Renders a scene to its goal in one call, for users of the library.
///
/// # Errors
/// If the film cannot be made.
pub fn render_film(
    scene: &Scene,
    options: &RenderOptions,
    aovs: AovSet,
) -> Result<Film, FilmError> {
    let camera = &scene.tables.camera;
    let [width, height] = camera.crop_size;
    let aovs = own_layers(scene.settings.kind)
        .iter()
        .fold(aovs, AovSet::with);
    let parts = scene.parts.layer_names();
    let mut film = Film::with_parts(width, height, camera.crop_offset, aovs, parts)?;
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let mut state = RunState::default();
    let never = AtomicBool::new(false);
    // Nothing else can fail: the observer does not.
    let _ = render(
        scene,
        &accel,
        options,
        &mut film,
        &mut state,
        &never,
        &mut NoObserver,
    );
    Ok(film)
}

/// Renders passes into `film` on all threads until the goal or until `stop` is set.
///
/// # Errors
/// What the observer returned; the film is complete up to the last pass.
pub fn render(
    scene: &Scene,
    accel: &Accel,
    options: &RenderOptions,
    film: &mut Film,
    state: &mut RunState,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, PassError> {
    let mut threads = CpuBackend::new(scene, accel, options);
    render_with(&mut threads, options, film, state, stop, observer)
}

/// Samples taken by all threads of the processor.
pub struct CpuBackend<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its ray tracer.
    pub accel: &'a Accel,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
    /// What a run knows of its photons before its passes.
    pilots: Pilots,
    /// How often its chains come to the parts of the image, once there are any.
    importance: OnceLock<Vec<f32>>,
}

impl<'a> CpuBackend<'a> {
    /// For a scene, its ray tracer, a seed and a first sample.
    pub fn new(scene: &'a Scene, accel: &'a Accel, options: &'a RenderOptions) -> CpuBackend<'a> {
        CpuBackend {
            scene,
            accel,
            options,
            pilots: Pilots::default(),
            importance: OnceLock::new(),
        }
    }
}

impl Backend for CpuBackend<'_> {
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
        stop: &Stop<'_>,
    ) -> Result<PassEnd, PassError> {
        let tables = self.scene.tables.view();
        let traverse = self.accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        let (settings, options) = (&self.scene.settings, self.options);
        let is_sobol = self.scene.sampler == sampler_kind::SOBOL;
        let division = Division::new(&self.scene.parts);
        if division.is_some() && !divides_paths(settings.kind) {
            return Err("this algorithm does not know the paths of what it adds".into());
        }
        let edits = self.scene.edits.view();
        let is_shared = matches!(shape(settings.kind), Shape::Splats | Shape::Passes);
        let is_adaptive = is_shared && settings.regularization.is_adaptive();
        let connects_through = settings.kind == integrator_kind::MANIFOLD_BIDIRECTIONAL;
        let follows_paths =
            division.is_some() || edits.is_some() || is_adaptive || connects_through;
        if is_shared && follows_paths && counts.is_none() {
            let pilots = &self.pilots;
            let followed = Followed {
                division: division.as_ref(),
                edits: edits.as_ref(),
                is_adaptive,
            };
            return Ok(if is_sobol {
                let pass = PassContext::new(&view, settings, options, stop, SobolSampler::new);
                render_divided_layers(&pass, followed, film, per_pixel, pilots)
            } else {
                let pass =
                    PassContext::new(&view, settings, options, stop, IndependentSampler::new);
                render_divided_layers(&pass, followed, film, per_pixel, pilots)
            });
        }
        Ok(match shape(settings.kind) {
            Shape::Pixels => {
                let job = TileJob {
                    view: &view,
                    settings,
                    options,
                    stop,
                    division,
                    edits,
                    needs_surface: film.aovs().needs_surface(),
                    simd: processor::simd_level(),
                };
                // Compiled once per sampler, so that numbers are drawn without a choice and a call each.
                if is_sobol {
                    sample_tiles(&job, film, per_pixel, counts, SobolSampler::new)
                } else {
                    sample_tiles(&job, film, per_pixel, counts, IndependentSampler::new)
                }
            }
            Shape::Splats | Shape::Passes | Shape::Chains if counts.is_some() => {
                return Err(
                    "samples cannot go where the error is when pixels share their light".into(),
                );
            }
            Shape::Passes
                if own_layers(settings.kind)
                    .iter()
                    .any(|aov| !film.aovs().contains(aov)) =>
            {
                return Err("the film has no layer for the statistics of photons".into());
            }
            Shape::Passes if is_sobol => {
                let pass = PassContext::new(&view, settings, options, stop, SobolSampler::new);
                render_passes(&pass, film, per_pixel, &self.pilots.radii)
            }
            Shape::Passes => {
                let pass =
                    PassContext::new(&view, settings, options, stop, IndependentSampler::new);
                render_passes(&pass, film, per_pixel, &self.pilots.radii)
            }
            Shape::Splats if is_sobol => {
                let pass = PassContext::new(&view, settings, options, stop, SobolSampler::new);
                render_layers(&pass, film, per_pixel, &self.pilots.density)
            }
            Shape::Splats => {
                let pass =
                    PassContext::new(&view, settings, options, stop, IndependentSampler::new);
                render_layers(&pass, film, per_pixel, &self.pilots.density)
            }
            Shape::Chains => {
                let followed = Followed {
                    division: division.as_ref(),
                    edits: edits.as_ref(),
                    is_adaptive: false,
                };
                let importance = &self.importance;
                let new = IndependentSampler::new;
                let pass = PassContext::new(&view, settings, options, stop, new);
                render_groups(&pass, followed, film, per_pixel, importance)
            }
        })
    }
}

/// Adds `per_pixel` samples to every pixel, or `counts` where given; `new` makes the sampler of (seed, pixel, sample).
fn sample_tiles<T: Traverse + Sync, S: LaneSampler + Send>(
    job: &TileJob<'_, T>,
    film: &mut Film,
    per_pixel: u32,
    counts: Option<&[u32]>,
    new: impl Fn(u32, u32, u32) -> S + Sync,
) -> PassEnd {
    let width = film.width();
    let count = |x: u32, y: u32| match counts {
        Some(counts) => counts[y as usize * width as usize + x as usize],
        None => per_pixel,
    };
    // As many as there are threads, however finely the work is divided.
    let idle = Mutex::new(Vec::new());
    let is_cut = AtomicBool::new(false);
    film.tiles_mut(TILE).into_par_iter().for_each(|mut tile| {
        if job.stop.is_set() {
            is_cut.store(true, Ordering::Relaxed);
            return;
        }
        let lock = || idle.lock().unwrap_or_else(PoisonError::into_inner);
        let workspace = lock().pop();
        let mut workspace = workspace.unwrap_or_else(|| Workspace::new(job.settings));
        if job.sample_tile(&mut workspace, &mut tile, count, &new) == PassEnd::Cut {
            is_cut.store(true, Ordering::Relaxed);
        }
        lock().push(workspace);
    });
    if is_cut.into_inner() {
        PassEnd::Cut
    } else {
        PassEnd::Complete
    }
}
