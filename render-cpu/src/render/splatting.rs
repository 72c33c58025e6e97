//! The driver of algorithms whose samples also splat: layers of samples, one of every pixel at a time.
//!
//! The value of a pixel in a layer is what its own sample found plus the splats that fall on it from all samples of the layer.
//! Layers are independent, so the film's statistics give a variance for splatted images too, all correlations within a
//! layer included. Several layers are taken together, as many as keep the threads busy on a small film; a layer of a large film
//! is taken in parts. So the memory for splats is that of a quarter of a million pixels, whatever the film and the number of
//! threads, and a pass can end soon. Samples and splats are added in the order of tiles and samples, so that the sums depend on
//! the layer's index alone.

use super::backend::PassEnd;
use super::bidirectional_job::{BidirectionalWorkspace, RegularizedSamples, TileSamples};
use super::film_tiles::{Tile, pixel, tile_samples, tiles};
use super::layer_photons::{regularization, trace_photons};
use super::pass_context::PassContext;
use super::photon_cache::SortedPhotons;
use super::photon_pass::WorkspacePool;
use super::pilot::PilotDensity;
use super::splat::{Splat, SplatFilter};
use super::surface_sample::surface_sample;
use crate::film::Film;
use crate::film::aov::Aov;
use glam::Vec3;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::photon::merging::PassPhotons;
use halflight_kernel::transport::photon::progressive::{light_walks, pass_radius};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Side of the square of pixels whose samples are traced together.
const TILE: u32 = 32;

/// Rows whose splats are added by one thread.
const BAND: u32 = 32;

/// Tiles that are taken before their splats are added. Which tiles decides how sums round, so it depends on the film alone.
const TILES_AT_A_TIME: usize = 256;

/// Light walks of layers that are taken together, where their photons are merged.
const PHOTONS_AT_A_TIME: u32 = 1 << 18;

/// Adds `layers` samples to every pixel of the film, or fewer when it is to stop; a layer that is not complete is dropped.
pub fn render_layers<T: Traverse + Sync, S: LaneSampler + Send>(
    pass: &PassContext<'_, T, S>,
    film: &mut Film,
    layers: u32,
    pilot: &OnceLock<PilotDensity>,
) -> PassEnd {
    let (view, settings, options) = (pass.view, pass.settings, pass.options);
    let tiles = tiles(film, TILE);
    let mut together = (TILES_AT_A_TIME / tiles.len()).clamp(1, 64) as u32;
    let merges = settings.kind == integrator_kind::VERTEX_MERGING;
    if merges {
        together = together.min((PHOTONS_AT_A_TIME / light_walks(&view.tables, settings)).max(1));
    }
    let density = PilotDensity::of_run(pilot, pass);
    let Some(density) = density else {
        return PassEnd::Cut;
    };
    let idle_tracers = WorkspacePool::new();
    let filter = SplatFilter::new(&view.tables.camera);
    let idle = Mutex::new(Vec::new());
    let keeps_regularized = film.aovs().contains(Aov::Regularization);
    let images = 1 + usize::from(keeps_regularized);
    let mut sums = vec![vec![[0.0; 3]; film.statistics().len()]; images];
    let mut done = 0;
    while done < layers {
        let count = together.min(layers - done);
        let first = options.first_sample.wrapping_add(film.pixel(0, 0).count);
        let tasks = count as usize * tiles.len();
        let layers_photons: Option<Vec<SortedPhotons>> = (0..if merges { count } else { 0 })
            .map(|layer| {
                let layer = first.wrapping_add(layer);
                trace_photons(pass, layer, density, None, None, &idle_tracers)
            })
            .collect();
        let Some(layers_photons) = layers_photons else {
            return PassEnd::Cut;
        };
        for from in (0..tasks).step_by(TILES_AT_A_TIME) {
            // Several layers at once have no more tasks than fit.
            let to = tasks.min(from + TILES_AT_A_TIME);
            let taken: Option<Vec<TaskResult>> = (from..to)
                .into_par_iter()
                .map(|task| {
                    if pass.stop.is_urgent() {
                        return None;
                    }
                    let lock = || idle.lock().unwrap_or_else(PoisonError::into_inner);
                    let workspace = lock().pop();
                    let mut workspace = workspace.unwrap_or_else(BidirectionalWorkspace::new);
                    let in_group = task / tiles.len();
                    let layer = first.wrapping_add(in_group as u32);
                    let photons = layers_photons.get(in_group).map(|sorted| PassPhotons {
                        cache: sorted.view(),
                        radius: pass_radius(&view.tables, settings, layer),
                        emitted: light_walks(&view.tables, settings),
                        density,
                    });
                    let tile = tiles[task % tiles.len()];
                    let mut samples =
                        tile_samples(view, options.seed, layer, tile, &pass.new_sampler);
                    let mut out = TileSamples {
                        regularized: keeps_regularized.then(RegularizedSamples::default),
                        ..TileSamples::default()
                    };
                    let of_layer = regularization(view, settings, layer);
                    workspace.run(
                        view,
                        settings,
                        of_layer,
                        photons.as_ref(),
                        &mut samples,
                        &mut out,
                    );
                    lock().push(workspace);
                    pass.stop.took(samples.len());
                    Some(TaskResult::new(tile, out, &filter, film.height()))
                })
                .collect();
            let Some(results) = taken else {
                return PassEnd::Cut;
            };
            let part = Part {
                results: &results,
                tiles: tiles.len(),
                begins: from == 0,
                ends: to == tasks,
            };
            add_part(pass, first, film, &mut sums, &filter, &part);
        }
        done += count;
        if done < layers && pass.stop.is_set() {
            return PassEnd::Cut;
        }
    }
    PassEnd::Complete
}

/// What a tile gave in a layer: its image, and that of what is regularised of it, where that is wanted.
struct TaskResult {
    tile: Tile,
    images: Vec<TileImage>,
}

/// An image of a tile, its splats by the bands that they reach.
struct TileImage {
    radiance: Vec<Vec3>,
    bands: Vec<Vec<Splat>>,
}

impl TaskResult {
    fn new(tile: Tile, samples: TileSamples, filter: &SplatFilter, height: u32) -> TaskResult {
        let mut images = vec![TileImage::new(
            samples.radiance,
            &samples.splats,
            filter,
            height,
        )];
        if let Some(regularized) = samples.regularized {
            images.push(TileImage::new(
                regularized.radiance,
                &regularized.splats,
                filter,
                height,
            ));
        }
        TaskResult { tile, images }
    }
}

impl TileImage {
    fn new(radiance: Vec<Vec3>, splats: &[Splat], filter: &SplatFilter, height: u32) -> TileImage {
        let mut bands = vec![Vec::new(); height.div_ceil(BAND) as usize];
        for splat in splats {
            let rows = filter.rows(splat);
            if !rows.is_empty() {
                for band in rows.start / BAND..=(rows.end - 1) / BAND {
                    bands[band as usize].push(*splat);
                }
            }
        }
        TileImage { radiance, bands }
    }

    /// Adds the samples of the rows from `top` on, `height` of them of `width` pixels.
    fn add_samples(&self, tile: Tile, [top, width, height]: [u32; 3], sums: &mut [[f32; 3]]) {
        for y in tile.y.max(top)..(tile.y + tile.height).min(top + height) {
            let from = ((y - tile.y) * tile.width) as usize;
            let to = ((y - top) * width + tile.x) as usize;
            for x in 0..tile.width as usize {
                let sum = &mut sums[to + x];
                *sum = (Vec3::from_array(*sum) + self.radiance[from + x]).to_array();
            }
        }
    }

    /// Adds the splats that reach the band of rows from `top` on.
    fn add_splats(&self, top: u32, filter: &SplatFilter, sums: &mut [[f32; 3]]) {
        for splat in &self.bands[(top / BAND) as usize] {
            filter.add(splat, top, sums);
        }
    }
}

/// Whole layers, or a part of one.
struct Part<'a> {
    results: &'a [TaskResult],
    /// Tiles of a layer.
    tiles: usize,
    /// Whether it has the first tile of its layer.
    begins: bool,
    /// Whether it has the last one.
    ends: bool,
}

/// Adds a part to the sums of its layer, and layers that it ends, from `first` on, to the film.
fn add_part<T: Traverse + Sync, S: LaneSampler>(
    pass: &PassContext<'_, T, S>,
    first: u32,
    film: &mut Film,
    sums: &mut [Vec<[f32; 3]>],
    filter: &SplatFilter,
    part: &Part<'_>,
) {
    let needs_surface = film.aovs().needs_surface();
    let of_band = film.width() as usize * BAND as usize;
    let bands = film.bands_mut(BAND);
    let mut of_bands: Vec<Vec<&mut [[f32; 3]]>> = bands.iter().map(|_| Vec::new()).collect();
    for image in sums {
        for (band, rows) in of_bands.iter_mut().zip(image.chunks_mut(of_band)) {
            band.push(rows);
        }
    }
    let with_sums = bands.into_par_iter().zip(of_bands);
    with_sums.for_each(|(mut band, mut sums)| {
        let (top, width, height) = (band.y(), band.width(), band.height());
        for (layer, of_layer) in part.results.chunks(part.tiles).enumerate() {
            for (image, sums) in sums.iter_mut().enumerate() {
                if part.begins {
                    sums.fill([0.0; 3]);
                }
                for result in of_layer {
                    let rows = [top, width, height];
                    result.images[image].add_samples(result.tile, rows, sums);
                }
                for result in of_layer {
                    result.images[image].add_splats(top, filter, sums);
                }
            }
            if !part.ends {
                continue;
            }
            for (i, sum) in sums[0].iter().enumerate() {
                let (x, y) = (i as u32 % width, top + i as u32 / width);
                let mut entry = band.pixel_mut(x, y);
                let whole = Vec3::from_array(*sum);
                entry.add_sample(whole);
                if let Some(regularized) = sums.get(1) {
                    entry.add_regularized(whole, [regularized[i][0], regularized[i][1]]);
                }
                if needs_surface {
                    let (pixel, index) = pixel(pass.view, x, y);
                    let layer = first.wrapping_add(layer as u32);
                    let sampler = (pass.new_sampler)(pass.options.seed, index, layer);
                    entry.add_aovs(&surface_sample(pass.view, sampler, pixel));
                }
            }
        }
    });
}
