//! The samples of one tile and one layer for algorithms with light walks, on one thread.
//!
//! All samples of the tile are traced together: first their light walks, bounce by bounce, then their camera walks, and
//! the rays of all of a kind are traced in lockstep. Segments that must be free wait until there are enough of them. What a
//! tile gives is a function of its pixels, the sample's index and the seed.

use super::lockstep_walks::{LockstepWalks, RAYS};
use super::splat::Splat;
use glam::{Vec2, Vec3};
use halflight_kernel::math::{Rgb, luminance};
use halflight_kernel::path::visibility::contribution_transmittance;
use halflight_kernel::path::{Contribution, Interaction, PathVertex, Walk};
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::emitter::emission::EmissionSample;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::scene::{HitBatch, NONE, RayBatch, SceneView, scene_flag};
use halflight_kernel::transport::bidirectional::{
    Bidirectional, ConnectedPoints, LightSubpath, SharedWalks, VertexStore,
};
use halflight_kernel::transport::photon::merging::{PassPhotons, merge};
use halflight_kernel::transport::{IntegratorSettings, camera_ray};
use std::cell::Cell;

/// The vertices of all light walks of a tile.
#[derive(Default)]
pub(super) struct Vertices(Vec<PathVertex>);

impl Vertices {
    /// Forgets all, and keeps the room.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

impl VertexStore for Vertices {
    fn push(&mut self, vertex: &PathVertex) -> u32 {
        let index = self.0.len() as u32;
        self.0.push(*vertex);
        index
    }

    fn get(&self, index: u32) -> PathVertex {
        self.0[index as usize]
    }
}

/// A contribution whose segment has not been traced yet.
#[derive(Clone, Copy)]
struct Pending {
    value: Rgb,
    film: Vec2,
    sample: u32,
    is_splat: bool,
    /// See [`Contribution::blur`].
    blur: f32,
}

/// Contributions that wait for their segments to be traced.
pub(super) struct Shadows {
    rays: Box<RayBatch<RAYS>>,
    hits: Box<HitBatch<RAYS>>,
    pending: Vec<Pending>,
}

/// What a tile gives.
#[derive(Default)]
pub struct TileSamples {
    /// Radiance of every pixel, by rows, times its reconstruction weight.
    pub radiance: Vec<Rgb>,
    /// Splats in the order in which they were made.
    pub splats: Vec<Splat>,
    /// What of both is regularised, where that is wanted.
    pub regularized: Option<RegularizedSamples>,
}

/// What is regularised of the samples of a tile, instead of colours: the luminance, its product with the logarithm of tau or
/// of the radius, and nothing.
#[derive(Default)]
pub struct RegularizedSamples {
    /// Of every pixel, by rows, times its reconstruction weight.
    pub radiance: Vec<Rgb>,
    /// Splats in the order in which they were made.
    pub splats: Vec<Splat>,
}

/// The record of [`RegularizedSamples`] of light that a connection blurred by `blur` found.
pub(super) fn regularized(light: Rgb, blur: f32) -> Rgb {
    let luminance = luminance(light);
    Vec3::new(luminance, luminance * blur.ln(), 0.0)
}

/// A sample of a pixel: its pixel in the whole film, and the numbers of its two walks.
#[derive(Clone, Copy)]
pub struct TileSample<S> {
    /// The pixel.
    pub pixel: [u32; 2],
    /// Numbers of the light walk.
    pub light: S,
    /// Numbers of the camera walk.
    pub camera: S,
}

/// What a thread needs for its tiles.
pub struct BidirectionalWorkspace {
    walks: LockstepWalks,
    starts: Vec<EmissionSample>,
    last: Vec<u32>,
    weights: Vec<f32>,
    vertices: Vertices,
    shadows: Shadows,
    points: Box<ConnectedPoints>,
}

impl BidirectionalWorkspace {
    /// Room that grows with the first tiles.
    pub fn new() -> BidirectionalWorkspace {
        BidirectionalWorkspace {
            walks: LockstepWalks::new(),
            starts: Vec::new(),
            last: Vec::new(),
            weights: Vec::new(),
            vertices: Vertices::default(),
            shadows: Shadows::new(),
            points: Box::new(ConnectedPoints::NONE),
        }
    }

    /// Takes the samples of a tile, at most [`RAYS`], among photons to merge if there are any, all with the regularisation of
    /// their layer; what they give replaces what `out` held.
    pub fn run<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        regularization: Regularization,
        photons: Option<&PassPhotons<'_>>,
        samples: &mut [TileSample<S>],
        out: &mut TileSamples,
    ) {
        assert!(samples.len() <= RAYS, "a tile has at most {RAYS} samples");
        out.radiance.clear();
        out.radiance.resize(samples.len(), Vec3::ZERO);
        out.splats.clear();
        if let Some(regularized) = &mut out.regularized {
            regularized.radiance.clear();
            regularized.radiance.resize(samples.len(), Vec3::ZERO);
            regularized.splats.clear();
        }
        if settings.rules.max_depth == 0 {
            return;
        }
        let mut algorithm = Bidirectional::new(&view.tables, settings).regularized(regularization);
        if let Some(photons) = photons {
            algorithm = algorithm.merging(photons.radius, photons.emitted, photons.density);
        }
        self.trace_light(view, settings, &algorithm, samples, out);
        if algorithm.has_camera_walks {
            self.trace_cameras(view, settings, &algorithm, photons, samples, out);
        }
        let regularized = out
            .regularized
            .iter_mut()
            .map(|regularized| &mut regularized.radiance);
        for radiance in regularized.chain([&mut out.radiance]) {
            for (radiance, weight) in radiance.iter_mut().zip(&self.weights) {
                *radiance *= *weight;
            }
        }
    }

    fn trace_light<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        algorithm: &Bidirectional<'_>,
        samples: &mut [TileSample<S>],
        out: &mut TileSamples,
    ) {
        self.walks.clear();
        self.starts.clear();
        self.last.clear();
        self.vertices.clear();
        if !algorithm.connector.strategies.heuristic.connects {
            // Photons are all the light there is.
            self.starts.resize(samples.len(), EmissionSample::NONE);
            self.last.resize(samples.len(), NONE);
            return;
        }
        for (i, sample) in samples.iter_mut().enumerate() {
            let start = algorithm.emit(&mut sample.light);
            self.walks.push(Walk::from_emitter(&start), start.is_some());
            self.starts.push(start);
            self.last.push(NONE);
            if start.is_some() {
                let seen = algorithm.start(&start, &mut sample.light);
                self.shadows.push(view, settings, i as u32, &seen, out);
            }
        }
        while !self.walks.is_done() {
            let shadows = &mut self.shadows;
            self.walks.bounce(view, |i, walk, hit| {
                algorithm.light_bounce(
                    walk,
                    &mut samples[i].light,
                    hit,
                    &mut self.points.arrived,
                    &mut self.vertices,
                    &mut self.last[i],
                    |contribution| shadows.push(view, settings, i as u32, &contribution, out),
                )
            });
        }
        self.shadows.trace(view, out);
    }

    fn trace_cameras<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        algorithm: &Bidirectional<'_>,
        photons: Option<&PassPhotons<'_>>,
        samples: &mut [TileSample<S>],
        out: &mut TileSamples,
    ) {
        let connector = &algorithm.connector;
        let merged = Cell::new(Vec3::ZERO);
        let merge = |walk: &Walk, at: &Interaction<'_>| match photons {
            Some(photons) => {
                let found = merge(connector, photons, walk, at);
                if at.is_regularized() {
                    merged.set(regularized(found, at.blur()));
                }
                found
            }
            None => Vec3::ZERO,
        };
        let shared = if algorithm.connections > 0 {
            SharedWalks {
                vertices: self.vertices.0.len() as u32,
                walks: samples.len() as u32,
            }
        } else {
            SharedWalks::NONE
        };
        self.walks.clear();
        self.weights.clear();
        for sample in samples.iter_mut() {
            let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
            self.walks.push(Walk::from_sensor(&seen), true);
            self.weights.push(seen.weight);
        }
        while !self.walks.is_done() {
            let shadows = &mut self.shadows;
            let points = &mut *self.points;
            self.walks.bounce(view, |i, walk, hit| {
                let light = LightSubpath {
                    store: &self.vertices,
                    last: self.last[i],
                    start: &self.starts[i],
                    shared,
                };
                let (found, next) = algorithm.camera_bounce_merging(
                    walk,
                    &mut samples[i].camera,
                    hit,
                    points,
                    &light,
                    merge,
                    |contribution| shadows.push(view, settings, i as u32, &contribution, out),
                );
                out.radiance[i] += found;
                if let Some(regularized) = &mut out.regularized {
                    regularized.radiance[i] += merged.take();
                }
                next
            });
            // Before light of the next bounce, so that sums do not depend on what else waited.
            self.shadows.trace(view, out);
        }
    }
}

impl Shadows {
    /// None that wait.
    pub fn new() -> Shadows {
        Shadows {
            rays: bytemuck::zeroed_box(),
            hits: bytemuck::zeroed_box(),
            pending: Vec::with_capacity(RAYS),
        }
    }

    /// Adds a contribution now if its transmittance may lie between zero and one, after its shadow ray has been traced otherwise.
    pub fn push<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        sample: u32,
        contribution: &Contribution,
        out: &mut TileSamples,
    ) {
        if !contribution.is_some() {
            return;
        }
        let mut pending = Pending {
            value: contribution.value,
            film: contribution.film,
            sample,
            is_splat: contribution.is_splat(),
            blur: contribution.blur,
        };
        let passes_emitters = settings.rules.hide_emitters != 0 && pending.is_splat;
        let has_masks = view.tables.info.flags & scene_flag::HAS_NULL != 0;
        if contribution.t == 0 || passes_emitters || has_masks {
            pending.value *= contribution_transmittance(view, &settings.rules, contribution);
            out.add(&pending);
            return;
        }
        if self.pending.len() == RAYS {
            self.trace(view, out);
        }
        self.rays.set(self.pending.len(), &contribution.ray);
        self.pending.push(pending);
    }

    /// Adds what does not lie in shadow.
    pub fn trace<T: Traverse>(&mut self, view: &SceneView<'_, T>, out: &mut TileSamples) {
        view.traverse
            .are_occluded(&self.rays, self.pending.len(), &mut self.hits);
        for (i, pending) in self.pending.iter().enumerate() {
            if !self.hits.is_hit(i) {
                out.add(pending);
            }
        }
        self.pending.clear();
    }
}

impl TileSamples {
    fn add(&mut self, pending: &Pending) {
        if let Some(samples) = &mut self.regularized
            && pending.blur > 0.0
        {
            let value = regularized(pending.value, pending.blur);
            if !pending.is_splat {
                samples.radiance[pending.sample as usize] += value;
            } else if value.x > 0.0 {
                samples.splats.push(Splat {
                    film: pending.film,
                    value,
                });
            }
        }
        if pending.is_splat {
            if pending.value.max_element() > 0.0 {
                self.splats.push(Splat {
                    film: pending.film,
                    value: pending.value,
                });
            }
        } else {
            self.radiance[pending.sample as usize] += pending.value;
        }
    }
}
