//! Many paths side by side: one bounce of each before the next of any.
//!
//! A path is a chain in which everything waits for what came before. Bounces of different paths do not wait for each
//! other, so that a processor begins the next while the last is under way, and what a step needs of code and of the tree
//! stays at hand (Laine, Karras and Aila 2013, "Megakernels Considered Harmful", on a small scale). The steps are those of
//! [`super::path`]. Invariant (tests): so are the results, to the bit, for any number of paths.

use super::IntegratorSettings;
use super::path::{Arrival, Path, step};
use crate::bsdf::Bsdf;
use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::{Hit, SceneView, Traverse};
use arrayvec::ArrayVec;

/// Up to `N` paths.
pub struct Wave<S, const N: usize> {
    paths: ArrayVec<(Path, S), N>,
}

impl<S: Sampler, const N: usize> Default for Wave<S, N> {
    fn default() -> Wave<S, N> {
        Wave::new()
    }
}

impl<S: Sampler, const N: usize> Wave<S, N> {
    /// No paths.
    pub fn new() -> Wave<S, N> {
        Wave {
            paths: ArrayVec::new(),
        }
    }

    /// Whether there is no room for another.
    pub fn is_full(&self) -> bool {
        self.paths.is_full()
    }

    /// Adds a path along `ray`, if there is room.
    pub fn push(&mut self, ray: &Ray, sampler: S) {
        if !self.is_full() {
            self.paths.push((Path::new(ray), sampler));
        }
    }

    /// Traces the paths to their ends. Returns the radiance of each, in the order in which they were added, and leaves the
    /// wave empty.
    pub fn run<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
    ) -> ArrayVec<Rgb, N> {
        let tables = &view.tables;
        let mut bsdf = Bsdf::BLACK;
        // Paths that go on, by their places; what they meet; and light that may reach them.
        let mut active = ArrayVec::<usize, N>::new();
        let mut hits = ArrayVec::<Hit, N>::new();
        let mut lights = ArrayVec::<(usize, Arrival), N>::new();
        for (place, (path, _)) in self.paths.iter().enumerate() {
            if path.may_go_on(settings) {
                active.push(place);
            }
        }
        while !active.is_empty() {
            hits.clear();
            for &place in &active {
                hits.push(view.traverse.closest_hit(&self.paths[place].0.ray));
            }
            lights.clear();
            let mut hit = hits.iter();
            active.retain(|place| {
                let (path, sampler) = &mut self.paths[*place];
                let hit = hit.next().unwrap_or(&Hit::MISS);
                let mut light = Arrival::NONE;
                let next = path.bounce(tables, settings, sampler, hit, &mut bsdf, &mut light);
                if light.connection.is_some() {
                    lights.push((*place, light));
                }
                next != step::END
            });
            for (place, light) in &lights {
                self.paths[*place].0.radiance += light.unshadowed(view);
            }
        }
        self.paths
            .drain(..)
            .map(|(path, _)| path.radiance)
            .collect()
    }
}
