//! Paths of a wavefront whose light is divided by path expressions ([`crate::transport::divided`]).
//!
//! While an image is divided, the sums of the wavefront hold the light of one bounce alone: after each queue the emission that
//! its paths have met, after the shadow rays what they add. Each is taken from there and given to the path's parts. Nothing is
//! kept in lanes: most of it is one look-up in a table for each path and bounce.

use super::bsdf_samples::SampleLanes;
use super::bsdf_variant;
use super::paths::{NextPathLanes, QueuedPaths};
use super::shading::ShadingLanes;
use super::shadow_rays::ShadowRayLanes;
use crate::bsdf::{diffuse_share, event, lobe};
use crate::math::Rgb;
use crate::path::{PathExpressions, Scattered};
use crate::scene::{Tables, lobe_kind};
use crate::transport::divided::DividedPath;
use glam::Vec3;

/// Storage for what accompanies the paths of a wavefront, and for their parts.
pub struct WaveDivision<'a> {
    /// The expressions.
    pub expressions: PathExpressions<'a>,
    /// One for each path.
    pub paths: &'a mut [DividedPath],
    /// The parts of each path, as many as there are expressions, path by path.
    pub parts: &'a mut [Rgb],
}

impl WaveDivision<'_> {
    /// At the sensor, for `count` paths.
    pub(super) fn begin(&mut self, count: usize) {
        for path in &mut self.paths[..count] {
            path.begin(&self.expressions);
        }
        self.parts[..count * self.expressions.count as usize].fill(Vec3::ZERO);
    }

    /// The path of a number, and its parts.
    #[inline(always)]
    pub(super) fn path(&mut self, index: usize) -> (&mut DividedPath, &mut [Rgb]) {
        let count = self.expressions.count as usize;
        let parts = &mut self.parts[index * count..(index + 1) * count];
        (&mut self.paths[index], parts)
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
            let (path, parts) = self.path(index);
            path.emitter_hit(&expressions, found, tables.info.environment, parts);
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
            let (path, parts) = self.path(index);
            let point = lanes.points.get(k);
            let found = core::mem::take(&mut radiance[index]);
            path.emitter_hit(&expressions, found, point.emitter, parts);
            let wi = lanes.points.wi.get(k);
            if may_be_lit && shadow_rays.is_lit(k) {
                let light = lanes.lights.get(k);
                let wo = point.frame.to_local(light.direction);
                let scattered = smooth::<VARIANT, N>(tables, lanes, k, wi, wo);
                if !path.sampled(&expressions, &point, &scattered, light.emitter) {
                    shadow_rays.radiance.set(k, Vec3::ZERO);
                }
            }
            if next.continues[k] != 0 {
                let scattered = sampled::<VARIANT, N>(tables, lanes, &lanes.samples, k, wi);
                if !path.scattered(&expressions, &point, &scattered) {
                    next.continues[k] = 0;
                }
            }
        }
    }

    /// A shadow ray of a path has met nothing.
    #[inline(always)]
    pub(super) fn add_direct(&mut self, index: usize, found: Rgb) {
        let expressions = self.expressions;
        let (path, parts) = self.path(index);
        path.add_direct(&expressions, found, parts);
    }

    /// Multiplies the parts of a path, and returns what counts of it: the whole, or the part that nothing else counts beside.
    pub(super) fn finish(&mut self, index: usize, weight: f32) -> Rgb {
        let is_only = self.expressions.only != 0;
        let (path, parts) = self.path(index);
        for part in &mut *parts {
            *part *= weight;
        }
        if is_only {
            parts[0]
        } else {
            path.whole * weight
        }
    }
}

/// How a lobe that is no discrete event scatters between two directions.
#[inline(always)]
fn smooth<const VARIANT: u32, const N: usize>(
    tables: &Tables<'_>,
    lanes: &ShadingLanes<N>,
    k: usize,
    wi: Vec3,
    wo: Vec3,
) -> Scattered {
    let kind = bsdf_variant::kind(VARIANT);
    let diffuse = if kind == lobe_kind::ROUGH_PLASTIC {
        let lobe = lanes.lobes.get::<VARIANT>(k);
        diffuse_share::of_rough_plastic(&lobe, tables.data, wi, wo)
    } else if diffuse_share::is_diffuse(kind) {
        Vec3::ONE
    } else {
        Vec3::ZERO
    };
    Scattered {
        is_specular: false,
        is_transmitted: wi.z * wo.z < 0.0,
        diffuse,
    }
}

/// How a path has scattered.
#[inline(always)]
fn sampled<const VARIANT: u32, const N: usize>(
    tables: &Tables<'_>,
    lanes: &ShadingLanes<N>,
    samples: &SampleLanes<N>,
    k: usize,
    wi: Vec3,
) -> Scattered {
    let sample = samples.get(k);
    if sample.event & event::DELTA != 0 {
        Scattered::specular(sample.event)
    } else {
        smooth::<VARIANT, N>(tables, lanes, k, wi, sample.wo)
    }
}
