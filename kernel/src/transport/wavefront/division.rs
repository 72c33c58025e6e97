//! Paths of a wavefront whose light is divided by path expressions ([`crate::transport::divided`]).
//!
//! While an image is divided, the sums of the wavefront hold the light of one bounce alone: after each queue the emission that
//! its paths have met, after the shadow rays what they add. Each is taken from there and given to the path's parts. Nothing is
//! kept in lanes: most of it is one look-up in a table for each path and bounce, of a record that is small enough for the records of
//! all paths to stay in the cache.

use super::bsdf_variant;
use super::paths::{NextPathLanes, QueuedPaths};
use super::shading::ShadingLanes;
use super::shadow_rays::ShadowRayLanes;
use crate::bsdf::{diffuse_share, event, lobe};
use crate::math::Rgb;
use crate::path::PathExpressions;
use crate::path::expression::scattering;
use crate::scene::{NONE, Tables, lobe_kind};
use crate::simd::SimdLevel;
use crate::transport::divided::{DividedPath, Letters, Mixture};
use glam::Vec3;

/// Storage for what accompanies the paths of a wavefront, and for their parts.
pub struct WaveDivision<'a> {
    expressions: PathExpressions<'a>,
    /// Whether any of them tells diffuse from glossy scattering.
    tells_glossy: bool,
    paths: &'a mut [DividedPath],
    mixtures: &'a mut [Mixture],
    parts: &'a mut [Rgb],
}

impl<'a> WaveDivision<'a> {
    /// With storage for each path, for the same of paths that are in several states (most are never looked at), and for the parts of each
    /// path, as many as there are expressions, path by path.
    pub fn new(
        expressions: PathExpressions<'a>,
        paths: &'a mut [DividedPath],
        mixtures: &'a mut [Mixture],
        parts: &'a mut [Rgb],
    ) -> WaveDivision<'a> {
        WaveDivision {
            tells_glossy: expressions.tells_glossy(),
            expressions,
            paths,
            mixtures,
            parts,
        }
    }

    /// At the sensor, for `count` paths.
    pub(super) fn begin(&mut self, count: usize) {
        let mut start = DividedPath::NONE;
        start.begin(&self.expressions);
        self.paths[..count].fill(start);
        self.parts[..count * self.expressions.count as usize].fill(Rgb::ZERO);
    }

    /// The expressions.
    pub(super) fn expressions(&self) -> PathExpressions<'a> {
        self.expressions
    }

    /// The path of a number, and its parts.
    #[inline(always)]
    pub(super) fn path(&mut self, index: usize) -> (&mut DividedPath, &mut Mixture, &mut [Rgb]) {
        let count = self.expressions.count as usize;
        let parts = &mut self.parts[index * count..(index + 1) * count];
        (&mut self.paths[index], &mut self.mixtures[index], parts)
    }

    /// Light from infinity that the paths of a queue have met.
    pub(super) fn escaped<const N: usize>(
        &mut self,
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        radiance: &mut [Rgb; N],
    ) {
        let expressions = self.expressions;
        for k in queued.segment.occupied::<N>() {
            let index = queued.index(k);
            let found = core::mem::take(&mut radiance[index]);
            let (path, mixture, parts) = self.path(index);
            path.emitter_hit(&expressions, mixture, found, tables.info.environment, parts);
        }
    }

    /// The queue of a variant has been shaded.
    ///
    /// What is neither lit nor goes on is read all the same where that is one look-up: nothing asks for it, and it costs less than
    /// a branch that cannot be foreseen.
    pub(super) fn shaded<const VARIANT: u32, const N: usize>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        lanes: &mut ShadingLanes<N>,
        next: &mut NextPathLanes<N>,
        shadow_rays: &mut ShadowRayLanes<N>,
        radiance: &mut [Rgb; N],
    ) {
        let expressions = self.expressions;
        let kind = bsdf_variant::kind(VARIANT);
        let is_mixed = kind == lobe_kind::ROUGH_PLASTIC && self.tells_glossy;
        if is_mixed {
            let (points, lobes, lights) = (&lanes.points, &lanes.lobes, &lanes.lights);
            let (segment, wo) = (queued.segment, &lanes.samples.wo);
            let shares = &mut lanes.diffuse_shares;
            shares.divide::<VARIANT>(simd, tables.data, segment, points, lobes, lights, wo);
        }
        let (is_only, has_one_first_letter) =
            (expressions.only != 0, expressions.has_one_first_letter());
        for k in queued.segment.occupied::<N>() {
            let index = queued.index(k);
            let (path, mixture, parts) = self.path(index);
            let emitter = lanes.points.emitter[k];
            if emitter != NONE {
                let found = core::mem::take(&mut radiance[index]);
                path.emitter_hit(&expressions, mixture, found, emitter, parts);
            }
            let first_letter = if has_one_first_letter {
                0
            } else {
                lanes.points.first_letter(&expressions, k)
            };
            let letters_at = Readings::<VARIANT, N> {
                lanes,
                first_letter,
                k,
            };
            let is_simple = !is_mixed && !path.is_mixed();
            if !lobe::is_delta(kind) {
                let emitter = lanes.lights.emitter[k];
                let counts = if is_simple {
                    path.lit_by(&expressions, letters_at.of_light(&expressions), emitter)
                } else if shadow_rays.is_lit(k) {
                    let letters = if is_mixed {
                        Letters::two(
                            &expressions,
                            first_letter,
                            0,
                            lanes.diffuse_shares.lit.get(k),
                        )
                    } else {
                        Letters::one(letters_at.of_light(&expressions))
                    };
                    path.lit(&expressions, mixture, letters, emitter)
                } else {
                    true
                };
                if is_only && !counts {
                    shadow_rays.radiance.set(k, Vec3::ZERO);
                }
            }
            let goes_on = if is_simple {
                path.scattered_by(&expressions, letters_at.of_sample(&expressions))
            } else if next.continues[k] != 0 {
                let letters = if is_mixed {
                    let share = lanes.diffuse_shares.scattered.get(k);
                    Letters::two(&expressions, first_letter, 0, share)
                } else {
                    Letters::one(letters_at.of_sample(&expressions))
                };
                path.scattered(&expressions, mixture, letters)
            } else {
                true
            };
            if is_only && !goes_on {
                next.continues[k] = 0;
            }
        }
    }

    /// A shadow ray of a path has met nothing.
    #[inline(always)]
    pub(super) fn add_direct(&mut self, index: usize, found: Rgb) {
        let (path, mixture, parts) = self.path(index);
        path.add_direct(mixture, found, parts);
    }

    /// Multiplies the parts of a path, and returns what counts of it: the whole, or the part that nothing else counts beside.
    #[inline(always)]
    pub(super) fn finish(&mut self, index: usize, weight: f32) -> Rgb {
        let is_only = self.expressions.only != 0;
        let (path, _, parts) = self.path(index);
        // All of them, by vectors: most have no light, but which have cannot be foreseen.
        for value in bytemuck::cast_slice_mut::<Rgb, f32>(parts) {
            *value *= weight;
        }
        if is_only {
            parts[0]
        } else {
            path.whole * weight
        }
    }
}

/// The letters of a vertex that scatters in one way.
struct Readings<'a, const VARIANT: u32, const N: usize> {
    lanes: &'a ShadingLanes<N>,
    /// [`PathExpressions::first_letter`].
    first_letter: u32,
    k: usize,
}

impl<const VARIANT: u32, const N: usize> Readings<'_, VARIANT, N> {
    /// For a local direction that is no discrete one.
    #[inline(always)]
    fn smooth(&self, wo: impl Fn() -> Vec3) -> u32 {
        let kind = bsdf_variant::kind(VARIANT);
        let may_transmit = lobe::events(kind) & event::TRANSMISSION != 0;
        let side = may_transmit && self.lanes.points.wi.get(self.k).z * wo().z < 0.0;
        // Rough plastic comes here where no expression tells diffuse from glossy.
        let first = if diffuse_share::is_diffuse(kind) {
            scattering::DIFFUSE_REFLECTION
        } else {
            scattering::GLOSSY_REFLECTION
        };
        first + side as u32
    }

    /// Of light from the emitter sample.
    #[inline(always)]
    fn of_light(&self, expressions: &PathExpressions<'_>) -> u32 {
        let kind = self.smooth(|| {
            let frame = self.lanes.points.get(self.k).frame;
            frame.to_local(self.lanes.lights.get(self.k).direction)
        });
        expressions.letter(self.first_letter, kind)
    }

    /// Of the direction in which the path goes on.
    #[inline(always)]
    fn of_sample(&self, expressions: &PathExpressions<'_>) -> u32 {
        let sample = self.lanes.samples.get(self.k);
        let is_discrete = lobe::events(bsdf_variant::kind(VARIANT)) & event::DELTA != 0
            && sample.event & event::DELTA != 0;
        let kind = if is_discrete {
            let side = (sample.event & event::TRANSMISSION != 0) as u32;
            scattering::SPECULAR_REFLECTION + side
        } else {
            self.smooth(|| sample.wo)
        };
        expressions.letter(self.first_letter, kind)
    }
}
