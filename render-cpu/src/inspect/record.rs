//! A choice of the paths of an image, with what happens at their vertices, for a file
//! ([`super::record_file`]).
//!
//! Bright paths are kept rather than dark ones (priority sampling, Duffield, Lund and Thorup 2007): of a path of luminance w the key
//! is u / w, u a hash of seed, pixel, sample and index in the sample, and the least keys are kept. With k the least key that
//! is not, each path stands for the luminance max(w, 1 / k): these numbers of any set of paths add up, on average, to the
//! luminance of all of that set. What is kept is a function of the seed and the samples alone, not of threads.

use super::record_file::{MAX_VERTICES, PathRecord, RecordHeader, RecordedPath, kind_name};
use crate::expression::{PathParts, SceneNames};
use crate::scene::build::Scene;
use glam::Vec3;
use halflight_kernel::math::luminance;
use halflight_kernel::sampler::{FreshSamples, IndependentSampler};
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::camera_ray;
use halflight_kernel::transport::recorded::{RecordedVertex, record_paths, vertex_kind};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Rows that a thread takes at a time.
const ROWS: u32 = 4;
/// Turns the seed of samples into that of the choice among their paths.
const CHOICE_STREAM: u32 = 0x1b87_3593;

/// A path that may enter the reservoir.
struct ReservoirEntry {
    key: f64,
    /// Pixel, sample and index in the sample, which distinguish equal keys.
    order: [u32; 3],
    path: RecordedPath,
}

impl PartialEq for ReservoirEntry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for ReservoirEntry {}

impl PartialOrd for ReservoirEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ReservoirEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        let keys = self.key.total_cmp(&other.key);
        keys.then_with(|| self.order.cmp(&other.order))
    }
}

/// The paths with the least keys.
#[derive(Default)]
struct Reservoir {
    kept: BinaryHeap<ReservoirEntry>,
    found: u64,
    luminance: f64,
}

impl Reservoir {
    fn offer(
        &mut self,
        most: usize,
        key: f64,
        order: [u32; 3],
        path: impl FnOnce() -> RecordedPath,
    ) {
        let is_full = self.kept.len() >= most;
        if is_full && self.kept.peek().is_none_or(|last| key >= last.key) {
            return;
        }
        let path = path();
        self.kept.push(ReservoirEntry { key, order, path });
        if self.kept.len() > most {
            self.kept.pop();
        }
    }

    fn merge(mut self, most: usize, other: Reservoir) -> Reservoir {
        self.found += other.found;
        self.luminance += other.luminance;
        for kept in other.kept {
            self.kept.push(kept);
            if self.kept.len() > most {
                self.kept.pop();
            }
        }
        self
    }
}

/// Which paths are recorded.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Most paths.
    pub most: usize,
    /// Samples of each pixel that are looked at.
    pub samples: u32,
    /// Their seed.
    pub seed: u32,
    /// Index of the first of them.
    pub first_sample: u32,
    /// Pixels of the whole film that are looked at: left, top, width, height; all of the image where nothing is given.
    pub pixels: Option<[u32; 4]>,
}

/// Chooses among the paths of path tracing of a scene: those that all expressions of `parts` match, of which there are at most two, one
/// of the only paths that count and one for a layer.
pub fn record<T: Traverse + Sync>(
    view: &SceneView<'_, T>,
    scene: &Scene,
    parts: &PathParts,
    choice: &Choice,
) -> PathRecord {
    let camera = &view.tables.camera;
    let (most, seed) = (choice.most, choice.seed);
    let ([left, top], [width, height]) = (camera.crop_offset, camera.crop_size);
    let [x, y, w, h] = choice.pixels.unwrap_or([left, top, width, height]);
    let columns = x.max(left)..x.saturating_add(w).min(left + width);
    let rows = y.max(top)..y.saturating_add(h).min(top + height);
    let expressions = parts.view();
    let bands: Vec<Reservoir> = (0..rows.len() as u32)
        .step_by(ROWS as usize)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|band| {
            let mut reservoir = Reservoir::default();
            let zero = bytemuck::Zeroable::zeroed();
            let mut vertices: Vec<RecordedVertex> = vec![zero; MAX_VERTICES];
            for y in (rows.start + band..rows.end).take(ROWS as usize) {
                for x in columns.clone() {
                    let pixel = [x, y];
                    let index = pixel[1] * camera.film_size[0] + pixel[0];
                    for sample in 0..choice.samples {
                        let sample = choice.first_sample.wrapping_add(sample);
                        let mut sampler = IndependentSampler::new(seed, index, sample);
                        let seen = camera_ray(&view.tables, &mut sampler, pixel);
                        let chance = FreshSamples::new(seed ^ CHOICE_STREAM, index, sample);
                        let mut dimension = 0;
                        let take = |vertices: &[RecordedVertex], light: Vec3| {
                            let weight = f64::from(luminance(light));
                            dimension += 1;
                            if !(weight > 0.0) || !light.is_finite() {
                                return;
                            }
                            reservoir.found += 1;
                            reservoir.luminance += weight;
                            let u = f64::from(chance.number(dimension)).max(1e-12);
                            let key = u / weight;
                            let order = [index, sample, dimension];
                            reservoir.offer(most + 1, key, order, || RecordedPath {
                                pixel,
                                light: light.to_array(),
                                weight: weight as f32,
                                vertices: vertices.to_vec(),
                            });
                        };
                        record_paths(
                            view,
                            &scene.settings,
                            expressions.as_ref(),
                            &mut sampler,
                            &seen.ray,
                            seen.weight,
                            &mut vertices,
                            take,
                        );
                    }
                }
            }
            reservoir
        })
        .collect();
    // One after the other, so that the sum does not depend on threads.
    let all = bands
        .into_iter()
        .fold(Reservoir::default(), |a, b| a.merge(most + 1, b));
    let mut kept = all.kept.into_sorted_vec();
    let least = match kept.len() > most {
        true => kept.pop().map_or(0.0, |next| 1.0 / next.key),
        false => 0.0,
    };
    kept.sort_unstable_by_key(|kept| kept.order);
    let weighted = |kept: ReservoirEntry| RecordedPath {
        weight: kept.path.weight.max(least as f32),
        ..kept.path
    };
    let paths: Vec<RecordedPath> = kept.into_iter().map(weighted).collect();
    PathRecord {
        header: RecordHeader {
            count: paths.len(),
            found: all.found,
            luminance: all.luminance,
            samples: choice.samples,
            seed,
            ..header(scene, parts)
        },
        paths,
    }
}

/// What all paths match, in words.
fn expression(parts: &PathParts) -> Option<String> {
    let request = parts.request();
    let texts = request.layers.iter().map(|(_, text)| text);
    let all: Vec<&str> = request
        .only
        .iter()
        .chain(texts)
        .map(String::as_str)
        .collect();
    (!all.is_empty()).then(|| all.join(" and "))
}

/// What the scene says.
fn header(scene: &Scene, parts: &PathParts) -> RecordHeader {
    let names: &SceneNames = &scene.names;
    let material = |shape: &halflight_kernel::scene::Shape| {
        let name = names.materials.get(shape.material as usize);
        name.cloned().unwrap_or_default()
    };
    RecordHeader {
        expression: expression(parts),
        kinds: (0..=vertex_kind::SENSOR)
            .map(|k| kind_name(k).to_owned())
            .collect(),
        shapes: names.shapes.clone(),
        materials: scene.tables.shapes.iter().map(material).collect(),
        emitters: names.emitters.clone(),
        ..RecordHeader::default()
    }
}
