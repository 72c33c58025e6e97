//! What an image will cost, from a measure_rate.
//!
//! Where samples belong to their pixels, some of all over the image are taken. Other algorithms take whole images only: they
//! render a small one of the same view, with as many photons for each pixel, or a short group of chains.

use crate::accel::Accel;
use crate::film::Film;
use crate::film::aov::AovSet;
use crate::render::{
    Backend, CpuBackend, Goal, MutationsPerPixel, RenderOptions, Shape, Stop, own_layers, shape,
};
use crate::scene::build::Scene;
use serde::Serialize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Samples that are taken to find out what they cost, about.
const TRIAL_SAMPLES: usize = 1 << 15;

/// Longest time for that.
const TRIAL_TIME: Duration = Duration::from_secs(1);

/// Pixels of small images, one after the other until one is done in time.
const TRIAL_PIXELS: [usize; 3] = [3072, 512, 64];

/// Mutations per pixel and chains of a short group.
const TRIAL_MUTATIONS: u32 = 8;
const TRIAL_CHAINS: u32 = 16;

/// What an image takes.
#[derive(Debug, Serialize)]
pub(super) struct Cost {
    pub film_bytes: usize,
    /// What is counted: samples, or mutations.
    pub unit: &'static str,
    /// Of all threads; none where it was not measured.
    pub samples_per_second: Option<f64>,
    /// For as many samples as the scene asks for.
    pub seconds: Option<f64>,
}

/// Takes some samples to see what an image costs; the scene is afterwards as it was.
pub(super) fn cost(scene: &mut Scene, accel: &Accel) -> Cost {
    let [width, height] = scene.tables.camera.crop_size;
    let pixels = width as usize * height as usize;
    let rate = if shape(scene.settings.kind) == Shape::Pixels {
        rate_of_pixels(scene, accel)
    } else {
        let (camera, settings) = (scene.tables.camera, scene.settings);
        let rate = TRIAL_PIXELS
            .iter()
            .find_map(|wanted| rate_of_small_image(scene, accel, pixels, *wanted));
        (scene.tables.camera, scene.settings) = (camera, settings);
        rate
    };
    let samples = {
        let unit = MutationsPerPixel::of(scene).0;
        // Groups of chains are whole.
        scene.spp.div_ceil(unit).saturating_mul(unit)
    };
    Cost {
        film_bytes: pixels * size_of::<crate::film::PixelStatistics>(),
        unit: if shape(scene.settings.kind) == Shape::Chains {
            "mutations"
        } else {
            "samples"
        },
        samples_per_second: rate,
        seconds: rate.map(|rate| pixels as f64 * f64::from(samples) / rate),
    }
}

/// One pass of `per_pixel` samples, or of those that are counted: samples per second.
fn measure_rate(
    scene: &Scene,
    accel: &Accel,
    per_pixel: u32,
    counts: Option<&[u32]>,
) -> Option<f64> {
    let camera = &scene.tables.camera;
    let [width, height] = camera.crop_size;
    let layers = AovSet::NONE.union(own_layers(scene.settings.kind));
    let mut film = Film::new(width, height, camera.crop_offset, layers).ok()?;
    let options = RenderOptions {
        goal: Goal::Samples(per_pixel),
        seed: 0,
        first_sample: 0,
        adaptive: false,
    };
    let mut threads = CpuBackend::new(scene, accel, &options);
    let request = AtomicBool::new(false);
    let start = Instant::now();
    let stop = Stop::new(&request, Some(start + TRIAL_TIME));
    let pass = threads.pass(&mut film, per_pixel, counts, &stop);
    let taken = film.total_samples() as f64;
    let seconds = start.elapsed().as_secs_f64().max(1e-9);
    (pass.is_ok() && taken > 0.0).then_some(taken / seconds)
}

/// Of samples that are their pixels' alone.
fn rate_of_pixels(scene: &Scene, accel: &Accel) -> Option<f64> {
    let [width, height] = scene.tables.camera.crop_size;
    let pixels = width as usize * height as usize;
    // Pixels from all over the image, an odd number apart so that they do not stand in columns.
    let every = (pixels / TRIAL_SAMPLES).max(1) | 1;
    let of_each = (TRIAL_SAMPLES / pixels).clamp(1, 16) as u32;
    let wanted = |i: usize| if i.is_multiple_of(every) { of_each } else { 0 };
    let counts: Vec<u32> = (0..pixels).map(wanted).collect();
    measure_rate(scene, accel, of_each, Some(&counts))
}

/// Of a small image of the same view, about `wanted` of its `pixels`.
fn rate_of_small_image(
    scene: &mut Scene,
    accel: &Accel,
    pixels: usize,
    wanted: usize,
) -> Option<f64> {
    let camera = &mut scene.tables.camera;
    let scale = (wanted as f64 / pixels as f64).sqrt().min(1.0);
    let scaled = |n: u32, least: u32| ((f64::from(n) * scale).round() as u32).max(least);
    camera.crop_size = camera.crop_size.map(|n| scaled(n, 1));
    camera.crop_offset = camera.crop_offset.map(|n| scaled(n, 0));
    for axis in 0..2 {
        camera.film_size[axis] = scaled(
            camera.film_size[axis],
            camera.crop_offset[axis] + camera.crop_size[axis],
        );
    }
    let [width, height] = camera.crop_size;
    let share = f64::from(width) * f64::from(height) / pixels as f64;
    let settings = &mut scene.settings;
    if settings.photon.photon_count > 0 {
        settings.photon.photon_count =
            ((f64::from(settings.photon.photon_count) * share) as u32).max(1);
    }
    let has_chains = shape(settings.kind) == Shape::Chains;
    if has_chains {
        settings.chains.mutations = TRIAL_MUTATIONS;
        settings.chains.chains = TRIAL_CHAINS;
    }
    let rate = measure_rate(scene, accel, 1, None)?;
    Some(if has_chains {
        rate * f64::from(TRIAL_MUTATIONS)
    } else {
        rate
    })
}
