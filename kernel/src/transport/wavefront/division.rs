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
use crate::path::{PathExpressions, Scattered};
use crate::scene::{Tables, lobe_kind};
use crate::transport::divided::{DividedPath, Mixture};
use glam::Vec3;

/// Storage for what accompanies the paths of a wavefront, and for their parts.
pub struct WaveDivision<'a> {
    /// The expressions.
    pub expressions: PathExpressions<'a>,
    /// One for each path.
    pub paths: &'a mut [DividedPath],
    /// The same of paths that are in several states: most are never looked at.
    pub mixtures: &'a mut [Mixture],
    /// The parts of each path, as many as there are expressions, path by path; valid where they have been touched.
    pub parts: &'a mut [Rgb],
}

impl WaveDivision<'_> {
    /// At the sensor, for `count` paths.
    pub(super) fn begin(&mut self, count: usize) {
        let mut start = DividedPath::NONE;
        start.begin(&self.expressions);
        self.paths[..count].fill(start);
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
    pub(super) fn shaded<const VARIANT: u32, const N: usize>(
        &mut self,
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        lanes: &ShadingLanes<N>,
        next: &mut NextPathLanes<N>,
        shadow_rays: &mut ShadowRayLanes<N>,
        radiance: &mut [Rgb; N],
    ) {
        let expressions = self.expressions;
        let may_be_lit = !lobe::is_delta(bsdf_variant::kind(VARIANT));
        for k in queued.segment.occupied::<N>() {
            let index = queued.index(k);
            let (path, mixture, parts) = self.path(index);
            let found = core::mem::take(&mut radiance[index]);
            path.emitter_hit(&expressions, mixture, found, lanes.points.emitter[k], parts);
            let is_lit = may_be_lit && shadow_rays.is_lit(k);
            let goes_on = next.continues[k] != 0;
            if !is_lit && !goes_on {
                continue;
            }
            let first_letter = lanes.points.first_letter(&expressions, k);
            if is_lit {
                let scattered = smooth::<VARIANT, N>(tables, lanes, k, || {
                    let frame = lanes.points.get(k).frame;
                    frame.to_local(lanes.lights.get(k).direction)
                });
                let emitter = lanes.lights.get(k).emitter;
                if !path.sampled(&expressions, mixture, first_letter, &scattered, emitter) {
                    shadow_rays.radiance.set(k, Vec3::ZERO);
                }
            }
            if goes_on {
                let sample = lanes.samples.get(k);
                let scattered = if sample.event & event::DELTA != 0 {
                    Scattered::specular(sample.event)
                } else {
                    smooth::<VARIANT, N>(tables, lanes, k, || sample.wo)
                };
                if !path.scattered(&expressions, mixture, first_letter, &scattered) {
                    next.continues[k] = 0;
                }
            }
        }
    }

    /// A shadow ray of a path has met nothing.
    #[inline(always)]
    pub(super) fn add_direct(&mut self, index: usize, found: Rgb) {
        let expressions = self.expressions;
        let (path, mixture, parts) = self.path(index);
        path.add_direct(&expressions, mixture, found, parts);
    }

    /// Multiplies the parts of a path, and returns what counts of it: the whole, or the part that nothing else counts beside.
    #[inline(always)]
    pub(super) fn finish(&mut self, index: usize, weight: f32) -> Rgb {
        let is_only = self.expressions.only != 0;
        let (path, _, parts) = self.path(index);
        let mut left = path.touched();
        while left != 0 {
            parts[left.trailing_zeros() as usize] *= weight;
            left &= left - 1;
        }
        if !is_only {
            path.whole * weight
        } else if path.touched() & 1 != 0 {
            parts[0]
        } else {
            Rgb::ZERO
        }
    }
}

/// How a lobe that is no discrete event scatters towards the local direction that `wo` looks up, if that says anything.
#[inline(always)]
fn smooth<const VARIANT: u32, const N: usize>(
    tables: &Tables<'_>,
    lanes: &ShadingLanes<N>,
    k: usize,
    wo: impl Fn() -> Vec3,
) -> Scattered {
    let kind = bsdf_variant::kind(VARIANT);
    let wi = || lanes.points.wi.get(k);
    let diffuse = if kind == lobe_kind::ROUGH_PLASTIC {
        let lobe = lanes.lobes.get::<VARIANT>(k);
        diffuse_share::of_rough_plastic(&lobe, tables.data, wi(), wo())
    } else if diffuse_share::is_diffuse(kind) {
        Vec3::ONE
    } else {
        Vec3::ZERO
    };
    let may_transmit = lobe::events(kind) & event::TRANSMISSION != 0;
    Scattered {
        is_specular: false,
        is_transmitted: may_transmit && wi().z * wo().z < 0.0,
        diffuse,
    }
}
