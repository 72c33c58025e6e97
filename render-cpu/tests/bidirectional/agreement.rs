//! Whether two estimators of one image have the same mean, by a test that knows their noise.
//!
//! Each estimator renders independent batches of samples, so that sums over pixels, which share light walks, have a variance
//! too. Block by block and for the whole image, channel by channel, the difference of the means over its standard error is
//! Student's t of Welch's degrees of freedom; it becomes a normal deviate by Wallace's formula
//!
//! ```text
//! z = (8 v + 1) / (8 v + 3) sqrt(v log(1 + t^2 / v))
//! ```
//!
//! (Wallace 1959), and must stay below [`LARGEST_DEVIATE`]: about 30 000 deviates in all tests of this binary, 3.8e-8 of
//! false alarms each, so 1e-3 for all together. Random numbers are fixed, so a run that passes always passes.
//! `HALFLIGHT_STATISTICS=N` takes N times the samples, to look closer.

use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Goal, NoObserver, RenderOptions, RunState, render};
use halflight::scene::build::Scene;
use halflight_kernel::scene::NONE;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::settings::integrator_kind;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::AtomicBool;

/// Largest normal deviate: 3.8e-8 of false alarms.
const LARGEST_DEVIATE: f64 = 5.5;

/// Independent renderings of each estimator.
const BATCHES: u32 = 24;

/// Side of the blocks in pixels.
const BLOCK: usize = 4;

/// What `HALFLIGHT_STATISTICS` multiplies the samples by.
pub fn effort() -> u32 {
    let text = std::env::var("HALFLIGHT_STATISTICS").unwrap_or_default();
    text.parse().unwrap_or(1).max(1)
}

/// Means over blocks and over the image in the batches: the values of a batch are its entries of a row.
pub struct Batches(Vec<Vec<f64>>);

impl Batches {
    /// Batches of `samples` samples per pixel with the settings; the numbers are others for each `name`
    /// and algorithm, but the same for all depths.
    pub fn render(
        name: &str,
        scene: &mut Scene,
        settings: IntegratorSettings,
        samples: u32,
    ) -> Batches {
        let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
        let camera = scene.tables.camera;
        let before = std::mem::replace(&mut scene.settings, settings);
        let samples = samples * effort();
        let mut hasher = DefaultHasher::new();
        (
            name,
            settings.kind,
            // The words that there were first: numbers stay the same when there are more.
            &bytemuck::bytes_of(&settings.bidirectional)[..24],
        )
            .hash(&mut hasher);
        if settings.bidirectional.connections > 0 {
            settings.bidirectional.connections.hash(&mut hasher);
        }
        let seed = hasher.finish() as u32;
        let batches = (0..BATCHES).map(|batch| {
            let options = RenderOptions {
                goal: Goal::Samples(samples),
                seed,
                first_sample: batch * samples,
                adaptive: false,
            };
            let [width, height] = camera.crop_size;
            let mut film = Film::new(width, height, camera.crop_offset, AovSet::NONE).unwrap();
            let mut state = RunState::default();
            let stop = AtomicBool::new(false);
            render(
                scene,
                &accel,
                &options,
                &mut film,
                &mut state,
                &stop,
                &mut NoObserver,
            )
            .unwrap();
            assert_eq!(film.total_rejected(), 0, "values that are not finite");
            blocks(&film)
        });
        let batches = Batches(batches.collect());
        scene.settings = before;
        batches
    }

    /// The differences of two renderings, batch by batch.
    pub fn minus(&self, other: &Batches) -> Batches {
        let rows = self.0.iter().zip(&other.0);
        Batches(
            rows.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect())
                .collect(),
        )
    }

    /// The mean of several renderings, batch by batch.
    #[allow(dead_code)] // Not all binaries have use for it.
    pub fn mean_of(all: &[Batches]) -> Batches {
        let mut rows = all[0].0.clone();
        for (batch, row) in rows.iter_mut().enumerate() {
            for (i, value) in row.iter_mut().enumerate() {
                *value = all.iter().map(|own| own.0[batch][i]).sum::<f64>() / all.len() as f64;
            }
        }
        Batches(rows)
    }

    /// Mean and variance of the mean of each entry.
    fn moments(&self) -> Vec<(f64, f64)> {
        let n = self.0.len() as f64;
        (0..self.0[0].len())
            .map(|i| {
                let mean = self.0.iter().map(|row| row[i]).sum::<f64>() / n;
                let squares = self
                    .0
                    .iter()
                    .map(|row| (row[i] - mean).powi(2))
                    .sum::<f64>();
                (mean, squares / (n * (n - 1.0)))
            })
            .collect()
    }

    /// Mean of the whole image, its three channels.
    pub fn mean(&self) -> [f64; 3] {
        let moments = self.moments();
        std::array::from_fn(|c| moments[moments.len() - 3 + c].0)
    }

    /// Largest standard error of the whole image's channels over their mean.
    pub fn relative_error(&self) -> f64 {
        let moments = self.moments();
        let whole = &moments[moments.len() - 3..];
        whole
            .iter()
            .map(|(mean, variance)| variance.sqrt() / mean.abs())
            .fold(0.0, f64::max)
    }
}

/// Channel means of all blocks, then of the image.
fn blocks(film: &Film) -> Vec<f64> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let columns = width.div_ceil(BLOCK);
    let count = columns * height.div_ceil(BLOCK);
    let mut sums = vec![0.0; 3 * (count + 1)];
    for (i, mean) in film.mean().iter().enumerate() {
        let block = i / width / BLOCK * columns + i % width / BLOCK;
        for c in 0..3 {
            sums[3 * block + c] += mean[c];
            sums[3 * count + c] += mean[c];
        }
    }
    sums.iter_mut()
        .for_each(|sum| *sum /= (width * height) as f64);
    sums
}

/// Wallace's normal deviate for Welch's t of two means with the variances of the means `a` and `b`, of [`BATCHES`] each.
fn deviate(difference: f64, a: f64, b: f64) -> f64 {
    let variance = a + b;
    if !(variance > 0.0) {
        return if difference == 0.0 {
            0.0
        } else {
            f64::INFINITY
        };
    }
    let freedom = f64::from(BATCHES - 1) * variance * variance / (a * a + b * b);
    let t2 = difference * difference / variance;
    let scale = (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0);
    scale * (freedom * (t2 / freedom).ln_1p()).sqrt()
}

/// What makes two estimators differ, or nothing; with the largest deviate on standard error.
pub fn compare(what: &str, a: &Batches, b: &Batches) -> Result<(), String> {
    let is_rare =
        |x: &Batches, i: usize| 2 * x.0.iter().filter(|row| row[i] != 0.0).count() < x.0.len();
    let rare: Vec<bool> = (0..a.0[0].len())
        .map(|i| is_rare(a, i) || is_rare(b, i))
        .collect();
    let (a, b) = (a.moments(), b.moments());
    let mut worst = (0.0, 0);
    let scale = a[a.len() - 3..]
        .iter()
        .map(|m| m.0.abs())
        .fold(0.0, f64::max);
    for (i, (a, b)) in a.iter().zip(&b).enumerate() {
        // Dark blocks in which most batches found nothing have no usable variance.
        if rare[i] && a.0.max(b.0) < 0.1 * scale {
            continue;
        }
        // Sums of thousands of f32 and shared cosines of f32 directions.
        let rounding = 2e-5 * scale.max(a.0.abs());
        let difference = ((a.0 - b.0).abs() - rounding).max(0.0);
        let z = deviate(difference, a.1, b.1);
        if z > worst.0 {
            worst = (z, i);
        }
    }
    let (z, i) = worst;
    let place = if i / 3 + 1 == a.len() / 3 {
        "the image".to_string()
    } else {
        format!("block {}", i / 3)
    };
    let (a, b) = (a[i], b[i]);
    let message = format!(
        "{what}: z = {z:.1}, channel {} of {place}, {:.6} +- {:.6} and {:.6} +- {:.6}",
        i % 3,
        a.0,
        a.1.sqrt(),
        b.0,
        b.1.sqrt()
    );
    if std::env::var_os("HALFLIGHT_STATISTICS").is_some() {
        eprintln!("{message}");
    }
    if z < LARGEST_DEVIATE {
        Ok(())
    } else {
        Err(message)
    }
}

/// Fails with all that differed.
pub fn report(results: impl IntoIterator<Item = Result<(), String>>) {
    let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// The scene's settings with another algorithm.
pub fn settings_of(scene: &Scene, kind: u32) -> IntegratorSettings {
    IntegratorSettings {
        kind,
        ..scene.settings
    }
}

/// Settings that show one strategy without weights.
pub fn settings_of_strategy(scene: &Scene, s: u32, t: u32) -> IntegratorSettings {
    let mut settings = settings_of(scene, integrator_kind::BIDIRECTIONAL);
    settings.bidirectional.only_s = s;
    settings.bidirectional.only_t = t;
    settings.bidirectional.unweighted = 1;
    assert!(s != NONE && t != NONE);
    settings
}

/// Which algorithms must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithms {
    /// All three.
    All,
    /// Path tracing and bidirectional path tracing: something is seen that light walks do not reach.
    PathAndBidirectional,
    /// Light tracing and bidirectional path tracing: light arrives in ways that camera walks cannot find.
    LightAndBidirectional,
}

/// Insists that the algorithms make the same image of the scene, in `samples` samples per pixel and batch of the bidirectional
/// one and three times as many of the others, with an error that leaves differences of a few percent visible.
pub fn agree(
    what: &str,
    scene: &mut Scene,
    algorithms: Algorithms,
    samples: u32,
) -> Vec<Result<(), String>> {
    let mut of = |kind: u32, samples: u32| {
        let settings = settings_of(scene, kind);
        Batches::render(what, scene, settings, samples)
    };
    let both = of(integrator_kind::BIDIRECTIONAL, samples);
    let mut results = Vec::new();
    if both.mean().iter().any(|m| !(*m > 0.0)) {
        return vec![Err(format!(
            "{what}: there is no light in {:?}",
            both.mean()
        ))];
    }
    let mut compare_with = |name: &str, other: &Batches| {
        let error = both.relative_error().hypot(other.relative_error());
        results.push(if error < 0.06 {
            compare(&format!("{what}, bdpt and {name}"), &both, other)
        } else {
            Err(format!(
                "{what}, bdpt and {name}: noise of {error:.3} hides everything"
            ))
        });
    };
    if algorithms != Algorithms::LightAndBidirectional {
        compare_with("path", &of(integrator_kind::PATH, 3 * samples));
    }
    if algorithms != Algorithms::PathAndBidirectional {
        compare_with("ptracer", &of(integrator_kind::LIGHT_TRACING, 3 * samples));
    }
    results
}
