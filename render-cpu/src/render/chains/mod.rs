//! The driver of Metropolis algorithms: groups of chains, each an independent estimate of the whole image.
//!
//! A group is to a chain what a layer of samples is to a pixel: **one sample of every pixel is one group**, the value of a pixel in
//! it what the group's chains splat there. So the film's statistics give the variance of the image, whatever is correlated
//! within a group; groups are numbered by the sample's index and are functions of seed and number alone, so that checkpoints,
//! interrupted runs, shares of an image and merges are exact as those of other algorithms, by count; a run that is killed
//! loses the unfinished group and makes it again to the same bits.
//!
//! A group has a fixed number of mutations per pixel, as few as make a million in all
//! ([`halflight_kernel::transport::settings::ChainSettings::mutations_per_pixel`]): a second or so of one processor. What users
//! ask for, as samples per pixel, are mutations per pixel; [`MutationsPerPixel`] converts.

mod counted_rays;
mod first_stage;
mod group;
mod path_tracing;

use super::backend::PassEnd;
use super::followed_samples::Followed;
use super::options::{Goal, RenderOptions};
use super::pass_context::PassContext;
use super::splat::SplatFilter;
use super::surface_sample::surface_sample;
use crate::film::Film;
use crate::film::aov::Aov;
use crate::film::chain_counts::describe;
use crate::integrators::{Shape, shape};
use crate::scene::build::Scene;
use counted_rays::CountedRays;
use first_stage::{PILOT, first_stage};
use glam::Vec3;
use group::{GroupImage, GroupPlan};
use halflight_kernel::path::PathRules;
use halflight_kernel::path::expression::MAX_PARTS;
use halflight_kernel::sampler::{FreshSamples, IndependentSampler};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::divided::sample_divided_pixel;
use halflight_kernel::transport::markov::annealing::Annealing;
use halflight_kernel::transport::markov::importance::Importance;
use halflight_kernel::transport::markov::primary_space::PrimarySpace;
use halflight_kernel::transport::markov::{ChainAlgorithm, PrimaryChains, VeachChains};
use halflight_kernel::transport::{IntegratorSettings, integrator_kind, retargeted, sample_pixel};
use path_tracing::PathTracing;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::sync::OnceLock;

/// Rows that a thread adds to the film at a time.
const BAND: u32 = 16;

/// Tells the numbers that choose starts and those of direct illumination from all others.
const START_STREAM: u32 = 0x6295_c58d;
const DIRECT_STREAM: u32 = 0x2f3a_91e7;

/// How many mutations per pixel a sample stands for: one where there are no chains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MutationsPerPixel(pub u32);

impl MutationsPerPixel {
    /// Of the algorithm that will run.
    pub fn of(scene: &Scene) -> MutationsPerPixel {
        Self::of_settings(&scene.settings, scene.tables.camera.crop_size)
    }

    /// Of an algorithm for a window of so many pixels.
    pub fn of_settings(settings: &IntegratorSettings, [width, height]: [u32; 2]) -> Self {
        if shape(settings.kind) != Shape::Chains {
            return MutationsPerPixel(1);
        }
        let pixels = width.saturating_mul(height);
        MutationsPerPixel(settings.chains.mutations_per_pixel(pixels))
    }

    /// Turns mutations per pixel into groups, rounded up to whole ones.
    ///
    /// # Errors
    /// If the share of an image does not begin with a group; the message says where groups begin.
    pub fn groups(self, options: &RenderOptions) -> Result<RenderOptions, String> {
        let n = self.0;
        if !options.first_sample.is_multiple_of(n) {
            return Err(format!(
                "--samples: chains run in groups of {n} mutations per pixel here, so FROM is a multiple of {n}"
            ));
        }
        Ok(RenderOptions {
            goal: match options.goal {
                Goal::Samples(count) => Goal::Samples(count.div_ceil(n)),
                time => time,
            },
            first_sample: options.first_sample / n,
            ..options.clone()
        })
    }
}

/// The mollification of a group's chains.
fn annealing<T: Traverse>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    group: u32,
) -> Annealing {
    Annealing::of_group(&settings.regularization, view.tables.info.radius, group)
}

/// Samples per pixel of a group for direct illumination. Regularised chains of primary samples find all of it, because they do not
/// know which of their light is regularised.
fn direct_samples(settings: &IntegratorSettings, pixels: u32) -> u32 {
    let is_primary = settings.kind == integrator_kind::PRIMARY_SAMPLE_MLT;
    if is_primary && settings.regularization.is_some() {
        0
    } else {
        settings.chains.direct_samples_per_pixel(pixels)
    }
}

/// Adds `groups` groups of chains to the film, or fewer when it is to stop; a group that is not complete is dropped. `importance` is
/// what the first stage of a two-stage start has found for the run, once there is a group.
pub(super) fn render_groups<T: Traverse + Sync>(
    pass: &PassContext<'_, T, IndependentSampler>,
    followed: Followed<'_>,
    film: &mut Film,
    groups: u32,
    importance: &OnceLock<Vec<f32>>,
) -> PassEnd {
    let (view, settings, options) = (pass.view, pass.settings, pass.options);
    let chain_settings = &settings.chains;
    let pixels = film.width() * film.height();
    let min_edges = if direct_samples(settings, pixels) > 0 {
        3
    } else {
        1
    };
    let first = options.first_sample.wrapping_add(film.pixel(0, 0).count);
    // It adds to the image, not to parts of it.
    let is_plain = followed.division.is_none() && followed.edits.is_none();
    let path_tracing = if is_plain {
        PathTracing::new(view, settings, options.seed, pixels)
    } else {
        None
    };
    let path_tracing = path_tracing.as_ref();
    let traverse = CountedRays(view.traverse);
    let view = &SceneView {
        tables: view.tables,
        traverse: &traverse,
    };
    let is_primary = settings.kind == integrator_kind::PRIMARY_SAMPLE_MLT;
    let expressions = followed.division.map(|division| division.expressions);
    let space = PrimarySpace::new(view, settings, chain_settings.technique, min_edges)
        .following(expressions, followed.edits.copied());
    let (size, offset) = (
        [film.width(), film.height()],
        view.tables.camera.crop_offset,
    );
    // Both are those of all groups, whichever are rendered.
    let of_first = annealing(view, settings, 0);
    let cells = importance.get_or_init(|| {
        if chain_settings.two_stage == 0 {
            return Vec::new();
        }
        if is_primary {
            let chains = PrimaryChains::new(space, chain_settings.p_large, options.seed, PILOT);
            first_stage(&chains.annealed(of_first), size, offset)
        } else {
            let chains = VeachChains::new(view, settings, min_edges, options.seed, PILOT);
            let chains = chains.edited(followed.edits);
            let chains = chains.with_path_tracing(path_tracing.map(|paths| paths.remainder));
            first_stage(&chains.annealed(of_first), size, offset)
        }
    });
    let importance = Importance::new(cells, size, offset);
    let of_samples = is_primary.then(|| {
        let space = space.with_importance(importance);
        PrimaryChains::with_constant(space, chain_settings.p_large, of_first, options.seed)
    });
    let job = |group, path_tracing| GroupJob {
        pass,
        followed,
        path_tracing,
        group,
    };
    for group in first..first + groups {
        if group > first && pass.stop.is_set() {
            return PassEnd::Cut;
        }
        let is_complete = match &of_samples {
            Some(chains) => {
                let chains = chains.of_group(group);
                let chains = chains.annealed(annealing(view, settings, group));
                job(group, None).add(film, &chains)
            }
            None => {
                let chains = VeachChains::new(view, settings, min_edges, options.seed, group);
                let division = followed.division;
                let chains = chains.divided(division.map(|division| division.expressions));
                let chains = chains.edited(followed.edits);
                let chains = chains.with_path_tracing(path_tracing.map(|paths| paths.remainder));
                let chains = chains.annealed(annealing(view, settings, group));
                let chains = chains.with_importance(importance);
                job(group, path_tracing).add(film, &chains)
            }
        };
        if !is_complete {
            return PassEnd::Cut;
        }
    }
    PassEnd::Complete
}

/// A group of chains with the path tracing that accompanies them.
struct GroupJob<'a, T: Traverse> {
    pass: &'a PassContext<'a, T, IndependentSampler>,
    followed: Followed<'a>,
    path_tracing: Option<&'a PathTracing>,
    group: u32,
}

impl<T: Traverse + Sync> GroupJob<'_, T> {
    /// Runs the group and adds it to the film; returns whether it was complete.
    fn add<A: ChainAlgorithm>(&self, film: &mut Film, algorithm: &A) -> bool {
        let (pass, group) = (self.pass, self.group);
        let view = pass.view;
        let chain_settings = &pass.settings.chains;
        let size = [film.width(), film.height()];
        let pixels = size[0] * size[1];
        let mutations = u64::from(chain_settings.mutations_per_pixel(pixels)) * u64::from(pixels);
        let chains = match chain_settings.chain_length {
            0 => chain_settings.chains.max(1),
            length => mutations.div_ceil(u64::from(length)).max(1) as u32,
        };
        let steps = mutations.div_ceil(u64::from(chains)) as u32;
        let offset = FreshSamples::new(pass.options.seed ^ START_STREAM, group, 0).number(0);
        let filter = SplatFilter::new(&view.tables.camera);
        let plan = GroupPlan {
            candidates: match chain_settings.candidates {
                0 => (mutations / 16).max(1) as u32,
                candidates => candidates,
            },
            chains,
            steps,
            offset,
            images: 1 + self.followed.division.map_or(0, |division| division.count),
            with_steps: Aov::OF_CHAINS.iter().any(|aov| film.aovs().contains(*aov)),
        };
        let Some(image) = group::run(algorithm, plan, &filter, size, pass.stop) else {
            return false;
        };
        for (name, counts) in algorithm.mutations().iter().zip(&image.counts) {
            if counts.proposed > 0 {
                tracing::debug!("group {group}: {}", describe(name, counts));
            }
            film.chain_counts_mut().add(name, counts);
        }
        tracing::debug!(
            "group {group}: {} rays, {} bytes for each chain",
            image.rays,
            size_of::<A::Chain>()
        );
        film.chain_counts_mut().add_rays(image.rays);
        let scale = f64::from(pixels) / (f64::from(steps) * f64::from(chains));
        self.add_to_film(film, &image, scale);
        true
    }

    /// Adds the image of a group as a sample of every pixel, with direct illumination if that is apart.
    fn add_to_film(&self, film: &mut Film, image: &GroupImage, scale: f64) {
        let (followed, group) = (self.followed, self.group);
        let PassContext {
            view,
            settings,
            options,
            ..
        } = *self.pass;
        let camera = &view.tables.camera;
        let needs_surface = film.aovs().needs_surface();
        let pixels = film.width() * film.height();
        // Path tracing that accompanies the chains finds all direct illumination.
        let kept = self
            .path_tracing
            .map(|paths| paths.render(view, options.seed, group, film));
        let direct = match kept {
            Some(_) => 0,
            None => direct_samples(settings, pixels),
        };
        let direct_settings = IntegratorSettings {
            kind: integrator_kind::PATH,
            rules: PathRules {
                max_depth: settings.rules.max_depth.min(2),
                ..settings.rules
            },
            ..*settings
        };
        film.bands_mut(BAND).into_par_iter().for_each(|mut band| {
            let (top, width, height) = (band.y(), band.width(), band.height());
            for y in top..top + height {
                for x in 0..width {
                    let pixel = [camera.crop_offset[0] + x, camera.crop_offset[1] + y];
                    let index = pixel[1]
                        .wrapping_mul(camera.film_size[0])
                        .wrapping_add(pixel[0]);
                    let sum = |image: &Vec<[f64; 3]>| {
                        Vec3::from_array(
                            image[(y * width + x) as usize].map(|v| (v * scale) as f32),
                        )
                    };
                    let mut value = sum(&image.sums[0]);
                    if let Some(kept) = &kept {
                        value += kept[(y * width + x) as usize];
                    }
                    let mut parts: Vec<Vec3> = image.sums[1..].iter().map(sum).collect();
                    for i in 0..direct {
                        let number = group.wrapping_mul(direct).wrapping_add(i);
                        let seed = options.seed ^ DIRECT_STREAM;
                        let mut sampler = IndependentSampler::new(seed, index, number);
                        let mut of_sample = [Vec3::ZERO; MAX_PARTS];
                        let expressions = followed.division.map(|division| &division.expressions);
                        let of_sample =
                            &mut of_sample[..expressions.map_or(0, |e| e.count as usize)];
                        let found = match (followed.edits, expressions) {
                            (Some(edits), _) => retargeted::path::sample_pixel(
                                view,
                                &direct_settings,
                                edits,
                                expressions,
                                &mut sampler,
                                pixel,
                                of_sample,
                            ),
                            (None, None) => {
                                sample_pixel(view, &direct_settings, &mut sampler, pixel)
                            }
                            (None, Some(expressions)) => sample_divided_pixel(
                                view,
                                &direct_settings,
                                expressions,
                                &mut sampler,
                                pixel,
                                of_sample,
                            ),
                        };
                        if let Some(division) = followed.division {
                            for (part, light) in parts.iter_mut().zip(&of_sample[division.first..])
                            {
                                *part += *light / direct as f32;
                            }
                        }
                        value += found / direct as f32;
                    }
                    let mut entry = band.pixel_mut(x, y);
                    entry.add_sample(value);
                    entry.add_parts(value, &parts);
                    if let Some(steps) = &image.steps {
                        entry.add_chain_steps(&steps[(y * width + x) as usize]);
                    }
                    if needs_surface {
                        let sampler = IndependentSampler::new(options.seed, index, group);
                        entry.add_aovs(&surface_sample(view, sampler, pixel));
                    }
                }
            }
        });
    }
}
