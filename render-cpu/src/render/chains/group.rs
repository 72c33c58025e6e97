//! One group of chains, on all threads: candidates, starts, then rounds of mutations.
//!
//! Candidates are weighed in chunks; the starts of the chains are spread evenly over the sum of the weights, at one random
//! offset (systematic resampling), so that a candidate of weight I starts I / sum of them, up to one more or less.
//! Chains then mutate in rounds: each fills its own list of splats, and the lists are added in the order of the chains,
//! so that sums are a function of seed and group.

use super::super::splat::{Splat, SplatFilter};
use super::super::stop::Stop;
use super::counted_rays::rays_of_thread;
use crate::film::ChainSteps;
use halflight_kernel::transport::markov::ChainAlgorithm;
use halflight_kernel::transport::markov::algorithm::{MutationCounts, StepRecord};
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefMutIterator, ParallelIterator,
};
use rayon::slice::ParallelSliceMut;

/// Candidates that are weighed by one task.
const CHUNK: u32 = 256;

/// Mutations of a chain between two sums.
const ROUND: u32 = 512;

/// Chains that are run together.
const BATCH: usize = 512;

/// Rows whose splats are added by one thread.
const BAND: u32 = 16;

/// The size of a group, and what is kept of it.
#[derive(Clone, Copy, Debug)]
pub struct GroupPlan {
    /// Candidates.
    pub candidates: u32,
    /// Chains.
    pub chains: u32,
    /// Mutations of each chain.
    pub steps: u32,
    /// Offset of the systematic resampling that chooses the starts, in [0, 1).
    pub offset: f32,
    /// Images: one of all light, and one for each part.
    pub images: usize,
    /// Whether pixels keep what became of the mutations of the paths that they see.
    pub with_steps: bool,
}

/// What became of a group.
pub struct GroupImage {
    /// Sums of the splats over all mutations, by rows of pixels: of the image, then of its parts. A pixel has many thousands of
    /// them, whose rounding to single precision would be seen where parts are added.
    pub sums: Vec<Vec<[f64; 3]>>,
    /// What became of each kind of mutation.
    pub counts: Vec<MutationCounts>,
    /// Rays of the mutations.
    pub rays: u64,
    /// What became of the mutations of the paths that each pixel sees, if that was asked for.
    pub steps: Option<Vec<ChainSteps>>,
}

/// The path of a candidate.
#[derive(Clone, Copy, Debug)]
struct WeightedCandidate {
    candidate: u32,
    member: u32,
    weight: f32,
}

/// A chain and what it has splatted since the last sum, by bands of rows.
struct Task<C> {
    chain: C,
    /// Each with the image that it falls on.
    bands: Vec<Vec<(u32, Splat)>>,
    records: Vec<StepRecord>,
    /// Rays of all its mutations.
    rays: u64,
}

/// Runs a group for a window of `width` x `height` pixels. None when it must stop before.
pub fn run<A: ChainAlgorithm>(
    algorithm: &A,
    plan: GroupPlan,
    filter: &SplatFilter,
    [width, height]: [u32; 2],
    stop: &Stop<'_>,
) -> Option<GroupImage> {
    let pixels = width as usize * height as usize;
    let mut image = GroupImage {
        sums: vec![vec![[0.0; 3]; pixels]; plan.images],
        counts: vec![MutationCounts::default(); algorithm.mutations().len()],
        rays: 0,
        steps: plan.with_steps.then(|| vec![ChainSteps::default(); pixels]),
    };
    let candidates = weigh(algorithm, plan.candidates);
    let total: f64 = candidates.iter().map(|c| f64::from(c.weight)).sum();
    if !(total > 0.0) {
        return Some(image);
    }
    let b = (total / f64::from(plan.candidates)) as f32;
    let starts = resample(&candidates, total, plan.chains, plan.offset);
    let bands = height.div_ceil(BAND) as usize;
    for (batch, starts) in starts.chunks(BATCH).enumerate() {
        let numbers = (batch * BATCH) as u32..;
        let starts: Vec<(u32, WeightedCandidate)> = numbers.zip(starts.iter().copied()).collect();
        let mut tasks: Vec<Task<A::Chain>> = starts
            .into_par_iter()
            .map(|(number, start)| Task {
                chain: algorithm.start(start.candidate, start.member, number),
                bands: vec![Vec::new(); bands],
                records: Vec::new(),
                rays: 0,
            })
            .collect();
        let mut done = 0;
        while done < plan.steps {
            if stop.is_urgent() {
                return None;
            }
            let round = ROUND.min(plan.steps - done);
            done += round;
            let is_last = done == plan.steps;
            // The share of this round in the group, which is one sample of every pixel.
            let all = f64::from(plan.steps) * f64::from(plan.chains);
            let share = f64::from(round) * tasks.len() as f64 / all;
            tasks.par_iter_mut().for_each(|task| {
                let Task {
                    chain,
                    bands,
                    records,
                    rays,
                } = task;
                bands.iter_mut().for_each(Vec::clear);
                records.clear();
                let mut add = |splat: halflight_kernel::transport::markov::Splat| {
                    let image = splat.image;
                    let splat = Splat {
                        film: splat.film,
                        value: splat.value,
                    };
                    let rows = filter.rows(&splat);
                    if !rows.is_empty() {
                        for band in rows.start / BAND..=(rows.end - 1) / BAND {
                            bands[band as usize].push((image, splat));
                        }
                    }
                };
                let rays_before = rays_of_thread();
                for _ in 0..round {
                    algorithm.step(chain, b, &mut add);
                    if plan.with_steps {
                        records.extend(A::last_step(chain));
                    }
                }
                *rays += rays_of_thread() - rays_before;
                if is_last {
                    algorithm.finish(chain, b, &mut add);
                }
            });
            stop.took((share * pixels as f64) as usize);
            if let Some(steps) = &mut image.steps {
                let records = tasks.iter().flat_map(|task| &task.records);
                records.for_each(|record| add_record(steps, record, filter, [width, height]));
            }
            let rows = BAND as usize * width as usize;
            for (index, sums) in image.sums.iter_mut().enumerate() {
                let bands = sums.par_chunks_mut(rows).enumerate();
                bands.for_each(|(band, sums)| {
                    let splats = tasks.iter().flat_map(|task| &task.bands[band]);
                    for (_, splat) in splats.filter(|(image, _)| *image as usize == index) {
                        filter.add(splat, band as u32 * BAND, sums);
                    }
                });
            }
        }
        for task in &tasks {
            image.rays += task.rays;
            for (sum, counts) in image.counts.iter_mut().zip(A::counts(&task.chain)) {
                sum.merge(counts);
            }
        }
    }
    Some(image)
}

/// Adds a mutation to the sums of the pixel that saw its path before.
fn add_record(
    steps: &mut [ChainSteps],
    record: &StepRecord,
    filter: &SplatFilter,
    [width, height]: [u32; 2],
) {
    let at = filter.in_window(record.film);
    let [x, y] = [(at.x, width), (at.y, height)].map(|(at, size)| (at as u32).min(size - 1));
    let sum = &mut steps[(y * width + x) as usize];
    sum.acceptance += record.acceptance;
    sum.walks += record.walks as f32;
    sum.iterations += record.iterations as f32;
    sum.jumps += if record.is_jump { 1.0 } else { 0.0 };
    sum.mutations += 1.0;
}

/// All paths of candidates that carry light, in order.
fn weigh<A: ChainAlgorithm>(algorithm: &A, count: u32) -> Vec<WeightedCandidate> {
    let chunks: Vec<Vec<WeightedCandidate>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut found = Vec::new();
            for candidate in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                let mut member = 0;
                algorithm.candidate_weights(candidate, &mut |weight| {
                    if weight > 0.0 && weight.is_finite() {
                        found.push(WeightedCandidate {
                            candidate,
                            member,
                            weight,
                        });
                    }
                    member += 1;
                });
            }
            found
        })
        .collect();
    chunks.concat()
}

/// The starts of the chains.
fn resample(
    candidates: &[WeightedCandidate],
    total: f64,
    chains: u32,
    offset: f32,
) -> Vec<WeightedCandidate> {
    let mut starts = Vec::with_capacity(chains as usize);
    let spacing = total / f64::from(chains);
    let mut below = 0.0;
    for candidate in candidates {
        below += f64::from(candidate.weight);
        while starts.len() < chains as usize
            && (starts.len() as f64 + f64::from(offset)) * spacing < below
        {
            starts.push(*candidate);
        }
    }
    // Rounding may leave the last one out.
    while starts.len() < chains as usize
        && let Some(last) = candidates.last()
    {
        starts.push(*last);
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use glam::{Vec2, Vec3};
    use halflight_kernel::scene::{Camera, filter_kind};
    use halflight_kernel::transport::markov::Splat as StateSplat;
    use std::sync::atomic::AtomicBool;

    /// Light of which every step adds as much, divided into two parts.
    struct Even;

    const WHOLE: f32 = 0.1;
    const PART: f32 = 0.07;

    impl ChainAlgorithm for Even {
        type Chain = ();

        fn candidate_weights(&self, _: u32, add: &mut impl FnMut(f32)) {
            add(1.0);
        }

        fn candidate_luminances(&self, _: u32, _: &mut impl FnMut(Vec2, f32)) {}

        fn start(&self, _: u32, _: u32, _: u32) {}

        fn step(&self, (): &mut (), _: f32, add: &mut impl FnMut(StateSplat)) {
            for (image, value) in [(0, WHOLE), (1, PART), (2, WHOLE - PART)] {
                add(StateSplat {
                    film: Vec2::splat(0.5),
                    value: Vec3::splat(value),
                    image,
                });
            }
        }

        fn finish(&self, (): &mut (), _: f32, _: &mut impl FnMut(StateSplat)) {}

        fn mutations(&self) -> &'static [&'static str] {
            &[]
        }

        fn counts((): &()) -> &[MutationCounts] {
            &[]
        }
    }

    #[test]
    fn parts_of_very_many_splats_add_up_to_the_image() {
        let camera = Camera {
            film_size: [1, 1],
            crop_size: [1, 1],
            filter: filter_kind::BOX,
            filter_parameters: [0.5, 0.0, 0.0],
            ..Camera::zeroed()
        };
        let steps = 1 << 20;
        let plan = GroupPlan {
            candidates: 1,
            chains: 1,
            steps,
            offset: 0.5,
            images: 3,
            with_steps: false,
        };
        let request = AtomicBool::new(false);
        let stop = Stop::new(&request, None);
        let image = run(&Even, plan, &SplatFilter::new(&camera), [1, 1], &stop).unwrap();
        let [whole, a, b] = [0, 1, 2].map(|i| image.sums[i][0][0]);
        assert!(((a + b) / whole - 1.0).abs() < 1e-7, "{a} + {b}, {whole}");
        assert!((whole / (f64::from(steps) * f64::from(WHOLE)) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn starts_are_spread_by_weight() {
        let candidates: Vec<WeightedCandidate> = [0.5, 3.0, 0.25, 0.25]
            .into_iter()
            .zip(0..)
            .map(|(weight, candidate)| WeightedCandidate {
                candidate,
                member: 0,
                weight,
            })
            .collect();
        let mut counts = [0.0; 4];
        let trials = 1000;
        for trial in 0..trials {
            let offset = (trial as f32 + 0.5) / trials as f32;
            let starts = resample(&candidates, 4.0, 6, offset);
            assert_eq!(starts.len(), 6);
            // Never far from what is due.
            let of_second = starts.iter().filter(|s| s.candidate == 1).count();
            assert!((4..=5).contains(&of_second), "{of_second} of 4.5");
            starts
                .iter()
                .for_each(|s| counts[s.candidate as usize] += 1.0 / f64::from(trials));
        }
        for (count, expected) in counts.iter().zip([0.75, 4.5, 0.375, 0.375]) {
            assert!((count - expected).abs() < 2e-3, "{count} and {expected}");
        }
    }
}
