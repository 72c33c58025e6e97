//! Paths as functions of primary samples: F of the vectors of a light walk and of a camera walk.
//!
//! | technique | F |
//! |---|---|
//! | [`technique::PATH`] | what path tracing finds |
//! | [`technique::BIDIRECTIONAL`] | what all strategies of bidirectional path tracing find, each weighted |
//! | [`technique::MULTIPLEXED`] | what one strategy finds, weighted, times the inverse probability of its choice (`multiplexed.rs`) |
//!
//! The film position is even over the window; values are for one sample per pixel of it.

use super::state::State;
use crate::bsdf::Bsdf;
use crate::path::rules::step;
use crate::path::{Contribution, PathVertex, Walk};
use crate::sampler::{FreshSamples, PrimarySamples, Sampler};
use crate::scene::{NONE, SceneView, Traverse, camera};
use crate::transport::bidirectional::{VertexStore, sample};
use crate::transport::bounce::{Rays, shade};
use crate::transport::path::{Path, SinglePath};
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

/// Vertices of a light walk that are kept; a walk ends where there is no more room.
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
    /// Fewest edges of a path that counts: shorter ones are somebody else's.
    min_edges: u32,
}

impl<T: Traverse> Clone for PrimarySpace<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Traverse> Copy for PrimarySpace<'_, T> {}

#[derive(Default)]
struct Vertices(ArrayVec<PathVertex, MAX_VERTICES>);

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
        }
    }

    /// F of the numbers.
    pub fn evaluate<S: PrimaryNumbers>(&self, light: &mut S, sensor: &mut S, state: &mut State) {
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
        let mut add = |found: Contribution| {
            if found.s + found.t > min_edges {
                if found.is_splat() {
                    state.add(found.film, found.value);
                } else {
                    state.add(seen.film, found.value * seen.weight);
                }
            }
        };
        if self.technique == technique::PATH {
            self.path(sensor, Path::new(&seen.ray), &mut add);
        } else if self.technique == technique::BIDIRECTIONAL {
            let mut store = Vertices::default();
            sample(
                self.view,
                self.settings,
                light,
                sensor,
                &seen,
                &mut store,
                &mut add,
            );
        } else {
            self.one_strategy(light, sensor, Walk::from_sensor(&seen), &mut add);
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
