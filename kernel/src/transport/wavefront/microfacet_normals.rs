//! Sampled microfacet normals, in lanes, in the frames of the scattering models.
//!
//! Beckmann's visible normals are found by Newton's method, of which all lanes make a step before the next.

use super::bsdf_variant;
use super::scattering::ScatteringInputs;
use super::segment::Segment;
use crate::bsdf::Lobe;
use crate::bsdf::lobe::{is_flipped, mirrored};
use crate::bsdf::microfacet::beckmann::VisibleSlope;
use crate::bsdf::rough_dielectric::to_upper_hemisphere;
use crate::scene::distribution;
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;
use glam::Vec3;

/// The microfacet normals at which up to `N` paths scatter.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct NormalLanes<const N: usize> {
    /// The normals.
    pub m: Vec3Lanes<N>,
    /// The known directions, stretched to unit roughness.
    w: Vec3Lanes<N>,
    /// See [`VisibleSlope`].
    cos: [f32; N],
    sin: [f32; N],
    start: [f32; N],
    end: [f32; N],
    target: [f32; N],
    along: [f32; N],
    across: [f32; N],
    active: [u32; N],
}

impl<const N: usize> NormalLanes<N> {
    #[inline(always)]
    fn slope(&self, k: usize) -> VisibleSlope {
        VisibleSlope {
            cos: self.cos[k],
            sin: self.sin[k],
            start: self.start[k],
            end: self.end[k],
            target: self.target[k],
            along: self.along[k],
            across: self.across[k],
        }
    }

    /// Samples the normals of rough lobes.
    pub fn sample<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        scattering: &ScatteringInputs<'_, N>,
    ) {
        if bsdf_variant::microfacets(VARIANT) == distribution::GGX {
            sample_ggx::<VARIANT, N>(simd, scattering, self);
            return;
        }
        begin_beckmann::<VARIANT, N>(simd, scattering, self);
        for _ in 0..VisibleSlope::STEPS {
            let mut active = false;
            step_beckmann(simd, scattering.segment, self, &mut active);
            if !active {
                break;
            }
        }
        finish_beckmann::<VARIANT, N>(simd, scattering, self);
    }
}

/// The direction from which the normals of a rough lobe are visible.
#[inline(always)]
fn viewer(lobe: &Lobe, wi: Vec3) -> Vec3 {
    to_upper_hemisphere(mirrored(is_flipped(lobe, wi), wi))
}

multiversioned! {
    fn sample_ggx<; const VARIANT: u32, const N: usize>(
        scattering: &ScatteringInputs<'_, N>,
        normals: &mut NormalLanes<N>,
    ) {
        for k in scattering.segment.padded::<N>() {
            let lobe = scattering.lobes.get::<VARIANT>(k);
            let facets = lobe.microfacets();
            let u = scattering.numbers.direction(k);
            let visible = facets.sample_visible_normal(viewer(&lobe, scattering.points.wi.get(k)), u);
            let any = facets.sample_normal(u);
            let all = lobe.samples_all_normals();
            normals.m.set(k, if all { any } else { visible });
        }
    }

    fn begin_beckmann<; const VARIANT: u32, const N: usize>(
        scattering: &ScatteringInputs<'_, N>,
        normals: &mut NormalLanes<N>,
    ) {
        for k in scattering.segment.padded::<N>() {
            let lobe = scattering.lobes.get::<VARIANT>(k);
            let w = lobe.microfacets().stretched(viewer(&lobe, scattering.points.wi.get(k)));
            let slope = VisibleSlope::new(w, scattering.numbers.direction(k));
            normals.w.set(k, w);
            normals.cos[k] = slope.cos;
            normals.sin[k] = slope.sin;
            normals.start[k] = slope.start;
            normals.end[k] = slope.end;
            normals.target[k] = slope.target;
            normals.along[k] = slope.along;
            normals.across[k] = slope.across;
            normals.active[k] = 1;
        }
    }

    fn step_beckmann<; const N: usize>(
        segment: Segment,
        normals: &mut NormalLanes<N>,
        active: &mut bool,
    ) {
        let mut any = 0;
        for k in segment.padded::<N>() {
            let mut slope = normals.slope(k);
            let before = slope.along;
            let active = slope.step();
            let was_active = normals.active[k];
            normals.along[k] = if was_active != 0 { slope.along } else { before };
            let remains = was_active & u32::from(active);
            normals.active[k] = remains;
            any |= remains;
        }
        *active = any != 0;
    }

    fn finish_beckmann<; const VARIANT: u32, const N: usize>(
        scattering: &ScatteringInputs<'_, N>,
        normals: &mut NormalLanes<N>,
    ) {
        for k in scattering.segment.padded::<N>() {
            let lobe = scattering.lobes.get::<VARIANT>(k);
            let facets = lobe.microfacets();
            let w = normals.w.get(k);
            let h = normals.slope(k).normal(w);
            // Nothing is seen from the plane of the surface.
            let visible = if w == Vec3::ZERO {
                Vec3::Z
            } else {
                facets.unstretched(h)
            };
            let any = facets.sample_normal(scattering.numbers.direction(k));
            let all = lobe.samples_all_normals();
            normals.m.set(k, if all { any } else { visible });
        }
    }
}
