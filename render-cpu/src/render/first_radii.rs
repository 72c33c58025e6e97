//! The first radii of pixels: the distance from where a camera walk arrives to the k-th nearest photon of a pilot pass.
//!
//! Photons and walks of the pilot are those of streams of numbers of their own, so all passes of a run have the same radii,
//! whatever was rendered before them, and runs that share a seed agree.

use super::bidirectional_job::TileSamples;
use super::film_tiles::{Tile, tile_samples, tiles};
use super::pass_context::PassContext;
use super::photon_job::Radii;
use super::photon_pass::{PhotonTask, WorkspacePool};
use crate::film::Film;
use halflight_kernel::path::PhotonDensity;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::photon::merging::PassPhotons;
use halflight_kernel::transport::photon::nearest::nearest_distance;
use halflight_kernel::transport::photon::progressive::{
    Progressive, first_radius, light_walks, nearest_of_pixels,
};
use halflight_kernel::transport::photon::statistics::LARGEST_RADIUS;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::sync::OnceLock;

/// Turns the seed of a run into that of its pilot pass.
const PILOT_STREAM: u32 = 0x3c6e_f372;

/// Side of the square of pixels whose camera walks are traced together.
const TILE: u32 = 32;

/// The radii of all pixels, by rows.
#[derive(Clone, Debug)]
pub struct FirstRadii {
    width: usize,
    radii: Vec<f32>,
}

impl FirstRadii {
    /// Those of a run, none where one radius is for all pixels; the first call finds them. Nothing if that is to stop.
    pub(super) fn of_run<'a, T: Traverse + Sync, S: LaneSampler + Send>(
        pilot: &'a OnceLock<FirstRadii>,
        pass: &PassContext<'_, T, S>,
        film: &Film,
    ) -> Option<Option<&'a FirstRadii>> {
        let nearest = nearest_of_pixels(pass.settings);
        if nearest == 0 {
            return Some(None);
        }
        if pilot.get().is_none() {
            let found = FirstRadii::find(pass, nearest, film)?;
            // There is one writer: a backend takes one pass at a time.
            let _ = pilot.set(found);
        }
        Some(pilot.get())
    }

    fn find<T: Traverse + Sync, S: LaneSampler + Send>(
        pass: &PassContext<'_, T, S>,
        nearest: u32,
        film: &Film,
    ) -> Option<FirstRadii> {
        let (view, settings, stop) = (pass.view, pass.settings, pass.stop);
        let (seed, idle) = (pass.options.seed ^ PILOT_STREAM, WorkspacePool::new());
        let algorithm = Progressive::new(&view.tables, settings);
        let emitted = light_walks(&view.tables, settings);
        let task = PhotonTask {
            view,
            tracer: algorithm.tracer(),
            expressions: None,
            edits: None,
            adaptive: None,
            emitted,
            seed,
            index: 0,
        };
        let sorted = task.trace(&idle, stop, &pass.new_sampler)?;
        let photons = PassPhotons {
            cache: sorted.view(),
            radius: 0.0,
            emitted,
            density: PhotonDensity::unknown(&view.tables),
        };
        let largest = LARGEST_RADIUS * view.tables.info.radius;
        let otherwise = first_radius(&view.tables, settings);
        let tiles = tiles(film, TILE);
        let found: Option<Vec<Vec<f32>>> = (0..tiles.len())
            .into_par_iter()
            .map(|i| {
                if stop.is_urgent() {
                    return None;
                }
                let mut samples = tile_samples(view, seed, 0, tiles[i], &pass.new_sampler);
                let mut distances = vec![f32::NAN; samples.len()];
                idle.with(|workspace| {
                    let radii = Radii::Found(&mut |i, at| {
                        if distances[i].is_nan() {
                            let center = at.point.position;
                            distances[i] =
                                nearest_distance(&photons.cache, center, nearest, largest);
                        }
                    });
                    let out = &mut TileSamples::default();
                    workspace.gather(
                        view,
                        settings,
                        &algorithm,
                        &photons,
                        radii,
                        &mut samples,
                        out,
                    )
                });
                Some(distances)
            })
            .collect();
        let width = film.width() as usize;
        let mut radii = vec![otherwise; width * film.height() as usize];
        for (tile, distances) in tiles.iter().zip(found?) {
            for (pixel, distance) in tile.pixels(width).zip(distances) {
                if distance > 0.0 {
                    radii[pixel] = distance;
                }
            }
        }
        Some(FirstRadii { width, radii })
    }

    /// Of the pixels of a tile, by rows.
    pub(super) fn of_tile(&self, tile: Tile) -> impl Iterator<Item = f32> + '_ {
        tile.pixels(self.width).map(|pixel| self.radii[pixel])
    }

    /// Of a pixel of the film.
    pub(super) fn of_pixel(&self, x: u32, y: u32) -> f32 {
        self.radii[y as usize * self.width + x as usize]
    }
}
