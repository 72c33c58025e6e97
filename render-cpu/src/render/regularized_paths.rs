//! Regularised path tracing of many paths in lockstep whose regularisation follows the path (heuristics) or takes other samples
//! (all emitters, virtual merges): their rays and shadow rays are traced together, and each is shaded by itself
//! ([`RegularizedPath`]). All others go through the wavefront.

use super::lockstep_walks::RAYS;
use halflight_kernel::bsdf::Bsdf;
use halflight_kernel::math::{Rgb, luminance};
use halflight_kernel::path::rules::step;
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::scene::{HitBatch, RayBatch, SceneView, scene_flag};
use halflight_kernel::transport::bounce::shade;
use halflight_kernel::transport::connection::ShadowRay;
use halflight_kernel::transport::path::{Path, SinglePath};
use halflight_kernel::transport::regularized_path::{Adaptive, RegularizedPath};
use halflight_kernel::transport::regularized_share::RegularizedShare;
use halflight_kernel::transport::{IntegratorSettings, camera_ray};

/// A path that has not ended.
struct State<S> {
    path: Path,
    adaptive: Adaptive,
    sampler: S,
    regularization: Regularization,
    weight: f32,
    /// See [`RegularizedPaths::run`].
    regularized: [f32; 2],
    /// One of [`step`].
    next: u32,
}

/// The paths, and storage for their rays.
pub struct RegularizedPaths<S> {
    rays: Box<RayBatch<RAYS>>,
    hits: Box<HitBatch<RAYS>>,
    shadows: Shadows,
    states: Vec<State<S>>,
    active: Vec<u32>,
    radiance: Vec<Rgb>,
    regularized: Vec<[f32; 2]>,
    bsdf: Box<Bsdf>,
}

/// Shadow rays that wait for others.
struct Shadows {
    rays: Box<RayBatch<RAYS>>,
    hits: Box<HitBatch<RAYS>>,
    /// What each adds, and to which of the active paths.
    lights: Vec<(u32, Rgb, RegularizedShare)>,
    /// What a bounce adds to the active paths.
    sums: Vec<Sum>,
}

/// Light, and how much of it is regularised ([`RegularizedPaths::run`]).
#[derive(Clone, Copy, Default)]
struct Sum {
    light: Rgb,
    regularized: [f32; 2],
}

impl Sum {
    fn add(&mut self, light: Rgb, share: RegularizedShare) {
        self.light += light;
        if share.share > 0.0 {
            let part = share.share * luminance(light);
            self.regularized[0] += part;
            self.regularized[1] += part * share.blur.ln();
        }
    }
}

impl<S: LaneSampler> RegularizedPaths<S> {
    /// No path.
    pub fn new() -> RegularizedPaths<S> {
        RegularizedPaths {
            rays: bytemuck::zeroed_box(),
            hits: bytemuck::zeroed_box(),
            shadows: Shadows {
                rays: bytemuck::zeroed_box(),
                hits: bytemuck::zeroed_box(),
                lights: Vec::with_capacity(RAYS),
                sums: Vec::with_capacity(RAYS),
            },
            states: Vec::with_capacity(RAYS),
            active: Vec::with_capacity(RAYS),
            radiance: Vec::with_capacity(RAYS),
            regularized: Vec::with_capacity(RAYS),
            bsdf: Box::new(Bsdf::BLACK),
        }
    }

    /// Whether there is no space for another path.
    pub fn is_full(&self) -> bool {
        self.states.len() >= RAYS
    }

    /// Adds samples of a pixel at absolute film coordinates, as many of `count` as fit; `sample` gives each its
    /// numbers and its regularisation. Returns how many were added.
    pub fn push_samples<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        pixel: [u32; 2],
        count: u32,
        mut sample: impl FnMut(u32) -> (S, Regularization),
    ) -> u32 {
        let count = count.min((RAYS - self.states.len()) as u32);
        for i in 0..count {
            let (mut sampler, regularization) = sample(i);
            let seen = camera_ray(&view.tables, &mut sampler, pixel);
            if settings.rules.max_depth > 0 {
                self.active.push(self.states.len() as u32);
            }
            self.states.push(State {
                path: Path::new(&seen.ray),
                adaptive: Adaptive::START,
                sampler,
                regularization,
                weight: seen.weight,
                regularized: [0.0; 2],
                next: step::TRACE,
            });
        }
        count
    }

    /// Traces the paths to their ends; returns the weighted radiance of each, in the order in which they were added, and of what
    /// is regularised of it the luminance and that times the logarithm of tau or of the radius. Leaves no path.
    pub fn run<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
    ) -> (&[Rgb], &[[f32; 2]]) {
        while !self.active.is_empty() {
            self.bounce(view, settings);
        }
        self.radiance.clear();
        self.regularized.clear();
        for s in self.states.drain(..) {
            self.radiance.push(s.path.radiance * s.weight);
            self.regularized.push(s.regularized.map(|v| v * s.weight));
        }
        (&self.radiance, &self.regularized)
    }

    fn bounce<T: Traverse>(&mut self, view: &SceneView<'_, T>, settings: &IntegratorSettings) {
        for (k, &i) in self.active.iter().enumerate() {
            self.rays.set(k, &self.states[i as usize].path.subpath.ray);
        }
        view.traverse
            .closest_hits(&self.rays, self.active.len(), &mut self.hits);
        self.shadows.sums.clear();
        self.shadows.sums.resize(self.active.len(), Sum::default());
        let (rules, shadows) = (settings.rules, &mut self.shadows);
        for (k, &i) in self.active.iter().enumerate() {
            let state = &mut self.states[i as usize];
            let bsdf = &mut self.bsdf;
            let mut single = SinglePath::new(view, rules, &mut state.sampler, bsdf, state.path);
            single.hit = self.hits.get(k);
            let add =
                |ray: &ShadowRay, share: RegularizedShare| shadows.push(view, k as u32, ray, share);
            let mut driver =
                RegularizedPath::new(single, state.regularization, state.adaptive, add);
            shade(&mut driver);
            state.next = driver.single.next;
            state.path = driver.single.path;
            state.adaptive = driver.adaptive;
        }
        // Before light of the next bounce, so that sums do not depend on what else waited.
        shadows.trace(view);
        let mut kept = 0;
        for k in 0..self.active.len() {
            let i = self.active[k];
            let state = &mut self.states[i as usize];
            let sum = &shadows.sums[k];
            state.path.radiance += sum.light;
            for (to, from) in state.regularized.iter_mut().zip(sum.regularized) {
                *to += from;
            }
            if state.next == step::TRACE {
                self.active[kept] = i;
                kept += 1;
            }
        }
        self.active.truncate(kept);
    }
}

impl Shadows {
    /// Adds the light now if its transmittance may lie between zero and one, after its shadow ray has been traced otherwise.
    fn push<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        path: u32,
        ray: &ShadowRay,
        share: RegularizedShare,
    ) {
        if view.tables.info.flags & scene_flag::HAS_NULL != 0 {
            self.sums[path as usize].add(ray.unshadowed(view), share);
            return;
        }
        if self.lights.len() == RAYS {
            self.trace(view);
        }
        self.rays.set(self.lights.len(), &ray.ray);
        self.lights.push((path, ray.radiance, share));
    }

    /// Adds the light that does not lie in shadow.
    fn trace<T: Traverse>(&mut self, view: &SceneView<'_, T>) {
        view.traverse
            .are_occluded(&self.rays, self.lights.len(), &mut self.hits);
        for (k, (path, light, share)) in self.lights.iter().enumerate() {
            if !self.hits.is_hit(k) {
                self.sums[*path as usize].add(*light, *share);
            }
        }
        self.lights.clear();
    }
}
