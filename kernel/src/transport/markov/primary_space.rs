//! Paths as functions of primary samples: F of the vectors of a light walk and of a camera walk.
//!
//! | technique | F |
//! |---|---|
//! | [`technique::PATH`] | what path tracing finds |
//! | [`technique::BIDIRECTIONAL`] | what all strategies of bidirectional path tracing find, each weighted |
//! | [`technique::MULTIPLEXED`] | what one strategy finds, weighted, times the inverse probability of its choice (`multiplexed.rs`) |
//!
//! The film position is even over the window; values are for one sample per pixel of it. Where path expressions divide the image,
//! F has an image for each of its parts, which I does not count; where edits turn light, paths are those of
//! [`crate::transport::retargeted`]. Multiplexed chains then follow both walks and keep what the chosen strategy finds.

use super::importance::Importance;
use super::state::State;
use crate::bsdf::Bsdf;
use crate::math::{Ray, Rgb};
use crate::path::expression::MAX_PARTS;
use crate::path::retarget_states::Edits;
use crate::path::rules::step;
use crate::path::{Contribution, PathExpressions, PathStates, PathVertex, Shares};
use crate::regularize::settings::Regularization;
use crate::sampler::{FreshSamples, PrimarySamples, Sampler};
use crate::scene::camera::CameraSample;
use crate::scene::{NONE, SceneView, Traverse, camera};
use crate::transport::bidirectional::{
    Bidirectional, DividedSample, PathObserver, StateStore, Unshadowed, VertexStore,
    sample_observed,
};
use crate::transport::bounce::{Rays, shade};
use crate::transport::divided::{DividedPath, Mixture};
use crate::transport::path::{Path, SinglePath};
use crate::transport::retargeted;
use crate::transport::retargeted::bidirectional::EditedSample;
use crate::transport::settings::IntegratorSettings;
use arrayvec::ArrayVec;
use glam::Vec2;

/// How paths are made of primary samples.
pub mod technique {
    /// By path tracing.
    pub const PATH: u32 = 0;
    /// By bidirectional path tracing.
    pub const BIDIRECTIONAL: u32 = 1;
    /// By one strategy of it.
    pub const MULTIPLEXED: u32 = 2;
}

/// Vertices of a light walk that are kept; a walk ends where there is no more space.
const MAX_VERTICES: usize = 128;

/// Numbers of a chain.
pub trait PrimaryNumbers: Sampler {
    /// A number that small steps leave as it is.
    fn fixed_1d(&mut self) -> f32;
}

impl PrimaryNumbers for FreshSamples {
    #[inline]
    fn fixed_1d(&mut self) -> f32 {
        self.number(u32::MAX)
    }
}

impl PrimaryNumbers for PrimarySamples {
    #[inline]
    fn fixed_1d(&mut self) -> f32 {
        self.number(u32::MAX)
    }
}

/// The function.
pub struct PrimarySpace<'a, T: Traverse> {
    pub(super) view: &'a SceneView<'a, T>,
    pub(super) settings: &'a IntegratorSettings,
    technique: u32,
    /// Fewest edges of a path that counts; shorter paths are estimated elsewhere.
    min_edges: u32,
    importance: Importance<'a>,
    /// What the image is divided by.
    expressions: Option<PathExpressions<'a>>,
    /// The edits of its light transport.
    edits: Option<Edits<'a>>,
}

impl<T: Traverse> Clone for PrimarySpace<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Traverse> Copy for PrimarySpace<'_, T> {}

#[derive(Default)]
struct Vertices(ArrayVec<PathVertex, MAX_VERTICES>);

/// The states along a light walk.
#[derive(Default)]
struct States(ArrayVec<PathStates, MAX_VERTICES>);

impl StateStore for States {
    fn clear(&mut self) {
        self.0.clear();
    }

    fn push(&mut self, states: &PathStates) {
        // A walk of more vertices matches nothing.
        let _ = self.0.try_push(*states);
    }

    fn get(&self, index: usize) -> PathStates {
        self.0.get(index).copied().unwrap_or(PathStates::DEAD)
    }
}

impl VertexStore for Vertices {
    fn push(&mut self, vertex: &PathVertex) -> u32 {
        let index = self.0.len() as u32;
        match self.0.try_push(*vertex) {
            Ok(()) => index,
            Err(_) => NONE,
        }
    }

    fn get(&self, index: u32) -> PathVertex {
        self.0[index as usize]
    }
}

impl<'a, T: Traverse> PrimarySpace<'a, T> {
    /// By one of [`technique`], of paths with at least `min_edges` edges.
    pub fn new(
        view: &'a SceneView<'a, T>,
        settings: &'a IntegratorSettings,
        technique: u32,
        min_edges: u32,
    ) -> Self {
        PrimarySpace {
            view,
            settings,
            technique,
            min_edges,
            importance: Importance::EVEN,
            expressions: None,
            edits: None,
        }
    }

    /// With parts of the image that count more than others.
    #[must_use]
    pub fn with_importance(mut self, importance: Importance<'a>) -> Self {
        self.importance = importance;
        self
    }

    /// With an image for each path expression beside the whole, and with edits. Where nothing counts but the paths of the first
    /// expression, those are the image, and the others follow.
    #[must_use]
    pub fn following(
        mut self,
        expressions: Option<PathExpressions<'a>>,
        edits: Option<Edits<'a>>,
    ) -> Self {
        self.expressions = expressions;
        self.edits = edits;
        self
    }

    /// Whether paths are followed vertex by vertex.
    pub(super) fn follows(&self) -> bool {
        self.expressions.is_some() || self.edits.is_some()
    }

    /// F of the numbers; `regularization` is of connections of bidirectional path tracing alone.
    pub fn evaluate<S: PrimaryNumbers>(
        &self,
        light: &mut S,
        sensor: &mut S,
        regularization: &Regularization,
        state: &mut State,
    ) {
        state.clear();
        let u_film = sensor.next_2d();
        let u_lens = sensor.next_2d();
        let window = &self.view.tables.camera;
        let [x, y] = [0, 1].map(|i| {
            let (offset, size) = (window.crop_offset[i], window.crop_size[i]);
            // The sum may round to the upper end, which is outside.
            let end = offset as f32 + size as f32;
            (offset as f32 + u_film[i] * size as f32).min(end - end * f32::EPSILON)
        });
        let seen = camera::sample_through(&self.view.tables, Vec2::new(x, y), u_lens);
        let min_edges = self.min_edges;
        let expressions = self.expressions;
        let mut add = |found: Contribution, shares: &Shares| {
            if found.s + found.t <= min_edges {
                return;
            }
            let (film, value) = if found.is_splat() {
                (found.film, found.value)
            } else {
                (seen.film, found.value * seen.weight)
            };
            let importance = self.importance.at(film);
            let Some(expressions) = &expressions else {
                state.add(film, value, importance);
                return;
            };
            if expressions.only == 0 {
                state.add(film, value, importance);
            }
            for part in 0..expressions.count {
                let light = value * shares.of(part as usize);
                match part + 1 - expressions.only {
                    0 => state.add(film, light, importance),
                    image => state.add_part(film, light, image),
                }
            }
        };
        if self.technique == technique::PATH {
            if let Some(edits) = &self.edits {
                self.edited_path(edits, sensor, &seen.ray, &mut add);
            } else if let Some(expressions) = &expressions {
                self.divided_path(expressions, sensor, &seen.ray, &mut add);
            } else {
                let mut add = |found: Contribution| add(found, &Shares::NONE);
                self.path(sensor, Path::new(&seen.ray), &mut add);
            }
        } else if self.technique == technique::BIDIRECTIONAL {
            let tables = &self.view.tables;
            let algorithm = Bidirectional::new(tables, self.settings).regularized(*regularization);
            self.follow_both(&algorithm, light, sensor, &seen, add);
        } else {
            self.one_strategy(light, sensor, &seen, &mut add);
        }
    }

    /// Whether there are edits.
    pub(super) fn is_edited(&self) -> bool {
        self.edits.is_some()
    }

    /// What both walks and their connections find, followed vertex by vertex.
    pub(super) fn follow_both<S: Sampler>(
        &self,
        algorithm: &Bidirectional<'_>,
        light: &mut S,
        sensor: &mut S,
        seen: &CameraSample,
        mut add: impl FnMut(Contribution, &Shares),
    ) {
        let mut states = States::default();
        if let Some(expressions) = self.expressions {
            let connector = &algorithm.connector;
            let mut observer =
                DividedSample::new(self.view, connector, expressions, None, &mut states, add);
            self.watch(algorithm, light, sensor, seen, &mut observer);
        } else {
            let add = |found: Contribution| add(found, &Shares::NONE);
            let mut observer = Unshadowed::new(self.view, algorithm.connector.rules, add);
            self.watch(algorithm, light, sensor, seen, &mut observer);
        }
    }

    fn watch<S: Sampler>(
        &self,
        algorithm: &Bidirectional<'_>,
        light: &mut S,
        sensor: &mut S,
        seen: &CameraSample,
        observer: &mut impl PathObserver,
    ) {
        let mut store = Vertices::default();
        match &self.edits {
            Some(edits) => EditedSample::new(self.view, algorithm, edits, None)
                .sample_observed(light, sensor, seen, &mut store, observer),
            None => sample_observed(
                self.view, algorithm, light, sensor, seen, &mut store, observer,
            ),
        }
    }

    fn edited_path<S: Sampler>(
        &self,
        edits: &Edits<'_>,
        sampler: &mut S,
        ray: &Ray,
        add: &mut impl FnMut(Contribution, &Shares),
    ) {
        let expressions = self.expressions.as_ref();
        let rules = self.settings.rules;
        retargeted::path::radiance(
            self.view,
            rules,
            edits,
            expressions,
            sampler,
            ray,
            |found, read| {
                let shares = expressions.map_or(Shares::NONE, |expressions| {
                    read.reach_emitter(expressions, found.emitter)
                });
                let found = Contribution {
                    value: found.value,
                    s: found.s,
                    t: found.t,
                    ..Contribution::NONE
                };
                add(found, &shares);
            },
        );
    }

    /// [`PrimarySpace::path`] whose light is divided.
    fn divided_path<S: Sampler>(
        &self,
        expressions: &PathExpressions<'_>,
        sampler: &mut S,
        ray: &Ray,
        add: &mut impl FnMut(Contribution, &Shares),
    ) {
        let mut bsdf = Bsdf::BLACK;
        let (rules, path) = (self.settings.rules, Path::new(ray));
        let mut driver = SinglePath::new(self.view, rules, sampler, &mut bsdf, path);
        let mut divided = DividedPath::NONE;
        let mut mixture = Mixture::NONE;
        divided.begin(expressions);
        let mut parts = [Rgb::ZERO; MAX_PARTS];
        let parts = &mut parts[..expressions.count as usize];
        while driver.next != step::END {
            let subpath = driver.path.subpath;
            let t = subpath.depth + 2;
            let bounce = subpath.depth.saturating_add(subpath.crossings);
            driver.sampler.start_bounce(bounce);
            driver.trace();
            shade(&mut driver);
            for s in 0..2 {
                divided.whole = Rgb::ZERO;
                parts.fill(Rgb::ZERO);
                if s == 0 {
                    let direction = subpath.ray.direction;
                    divided.shaded(
                        expressions,
                        &mut mixture,
                        &mut driver,
                        direction,
                        subpath.depth,
                        parts,
                    );
                } else {
                    driver.trace_shadow_rays();
                    let found = core::mem::take(&mut driver.path.radiance);
                    if found.max_element() > 0.0 {
                        divided.add_direct(&mixture, found, parts);
                    }
                }
                let found = Contribution {
                    value: divided.whole,
                    s,
                    t,
                    ..Contribution::NONE
                };
                if found.is_some() {
                    add(found, &Shares::of_parts(found.value, parts));
                }
            }
        }
    }

    fn path<S: Sampler>(&self, sampler: &mut S, path: Path, add: &mut impl FnMut(Contribution)) {
        let mut bsdf = Bsdf::BLACK;
        let mut driver = SinglePath::new(self.view, self.settings.rules, sampler, &mut bsdf, path);
        while driver.next != step::END {
            let subpath = &driver.path.subpath;
            let t = subpath.depth + 2;
            let bounce = subpath.depth.saturating_add(subpath.crossings);
            driver.sampler.start_bounce(bounce);
            driver.trace();
            shade(&mut driver);
            for s in 0..2 {
                if s == 1 {
                    driver.trace_shadow_rays();
                }
                add(Contribution {
                    value: core::mem::take(&mut driver.path.radiance),
                    s,
                    t,
                    ..Contribution::NONE
                });
            }
        }
    }
}
