//! Direct illumination with chosen numbers of emitter and BSDF samples.
//!
//! Emission seen directly plus one scattering: n_e emitter samples and n_b BSDF samples combined with the power
//! heuristic for several samples per technique, w_a = (n_a p_a)^2 / sum (n_i p_i)^2 (Veach 1997, Section 9.2.2). With
//! one of the counts zero the other technique stands alone, as in Veach's comparison figures; light that it cannot find
//! (a delta light with BSDF samples only) is then missing, which is what such a figure shows. Straight passage through
//! masks does not count as scattering, and is deterministic: what is seen behind a mask is scaled by its null weight.
//!
//! The walk from the sensor and those of the BSDF samples, its branches, are [`Path`]s; the order of the stages is that of
//! [`super::bounce::illuminate`].

use super::bounce::{Branches, Rays, Shading, illuminate};
use super::connection::SampleCounts;
use super::path::{Path, SinglePath, step};
use super::settings::IntegratorSettings;
use crate::bsdf::{Bsdf, BsdfSample, event};
use crate::math::{Ray, Rgb};
use crate::path::PathRules;
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{SceneView, SurfacePoint, Tables, Traverse};

/// Radiance along `ray` with at most one scattering.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let mut bsdf = Bsdf::BLACK;
    let mut path = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    path.counts = SampleCounts::of(settings);
    // It sees emitters whatever its depth.
    path.next = step::TRACE;
    let mut driver = DirectPath {
        path,
        branch: Path::new(ray),
        next: step::END,
    };
    while driver.path.next != step::END {
        illuminate(&mut driver, &settings.direct);
    }
    driver.path.path.radiance
}

/// A path and its present branch.
struct DirectPath<'a, T: Traverse, S> {
    path: SinglePath<'a, T, S>,
    branch: Path,
    /// What is next of the branch, one of [`step`].
    next: u32,
}

impl<T: Traverse, S: Sampler> Shading for DirectPath<'_, T, S> {
    fn arrive(&mut self) {
        self.path.arrive();
    }

    fn sample_emitter(&mut self) {
        self.path.sample_emitter();
    }

    fn evaluate_emitter(&mut self) {
        self.path.evaluate_emitter();
    }

    fn sample_bsdf(&mut self) {
        self.path.sample_bsdf();
    }

    fn mix_lobes(&mut self) {
        self.path.mix_lobes();
    }

    fn scatter(&mut self) {
        self.path.scatter();
    }
}

impl<T: Traverse, S> Rays for DirectPath<'_, T, S> {
    fn trace(&mut self) {
        self.path.trace();
    }

    fn trace_shadow_rays(&mut self) {
        self.path.trace_shadow_rays();
    }
}

impl<T: Traverse, S: Sampler> Branches for DirectPath<'_, T, S> {
    fn branch(&mut self) {
        self.next = step::END;
        let path = &self.path;
        if path.next == step::SCATTER {
            self.branch = Path::new(&path.path.subpath.ray);
            let (point, sample) = (&path.point, &path.sample);
            self.next = start_branch(&mut self.branch, &path.rules, path.counts, point, sample);
        }
    }

    fn follow_branch(&mut self) -> bool {
        if self.next != step::TRACE {
            return false;
        }
        let view = self.path.view;
        let branch = &mut self.branch;
        let hit = view.traverse.closest_hit(&branch.subpath.ray);
        self.next = if hit.is_hit() {
            let light =
                surface_with::<{ detail::TANGENTS }>(&view.tables, &branch.subpath.ray, &hit);
            follow_branch(branch, &view.tables, &light)
        } else {
            branch.escape(&view.tables, &self.path.rules);
            step::END
        };
        if self.next == step::END {
            let path = &mut self.path.path;
            path.radiance += path.subpath.throughput * branch.radiance;
        }
        self.next == step::TRACE
    }

    fn continue_through_masks(&mut self) {
        let path = &mut self.path;
        if path.next == step::SCATTER {
            let subpath = &mut path.path.subpath;
            path.next = subpath.continue_through_masks(&path.view.tables, &path.point);
        }
    }
}

/// Makes `branch` one of the BSDF samples, divided by their number; returns what is next, one of [`step`].
#[inline]
pub fn start_branch(
    branch: &mut Path,
    rules: &PathRules,
    counts: SampleCounts,
    point: &SurfacePoint,
    sample: &BsdfSample,
) -> u32 {
    if sample.pdf <= 0.0 || sample.event & event::NULL != 0 {
        return step::END;
    }
    let direction = point.frame.to_world(sample.wo).normalize();
    if !rules.allows(point, direction, sample.wo.z) {
        return step::END;
    }
    branch.last_pdf = counts.bsdf * sample.pdf;
    branch.light_samples = if sample.event & event::DELTA != 0 {
        0.0
    } else {
        counts.emitter
    };
    let subpath = &mut branch.subpath;
    subpath.position = point.position;
    subpath.depth = 1;
    subpath.throughput = sample.weight * (1.0 / counts.bsdf);
    subpath.ray = point.spawn(direction);
    step::TRACE
}

/// What a branch does where it meets a surface: gathers its light, and looks behind its masks.
#[inline]
pub fn follow_branch(branch: &mut Path, tables: &Tables<'_>, point: &SurfacePoint) -> u32 {
    branch.add_emission(tables, point);
    branch.subpath.continue_through_masks(tables, point)
}
