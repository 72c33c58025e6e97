//! Normals of microfacets, side by side, in the frames of the lobes' models.

use super::bsdf_variant;
use super::lobes::LobeLanes;
use super::segment::Segment;
use super::surfaces::PointLanes;
use crate::bsdf::Lobe;
use crate::bsdf::lobe::{is_flipped, mirrored};
use crate::bsdf::microfacet::beckmann::VisibleSlope;
use crate::bsdf::rough_dielectric::above;
use crate::scene::distribution;
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// The normals at which up to `N` paths scatter.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct NormalLanes<const N: usize> {
    /// The normals.
    pub m: Vec3Lanes<N>,
    /// Directions stretched to unit roughness.
    w: Vec3Lanes<N>,
    /// See [`VisibleSlope`].
    cos: [f32; N],
    sin: [f32; N],
    start: [f32; N],
    end: [f32; N],
    target: [f32; N],
    along: [f32; N],
    across: [f32; N],
    continues: [u32; N],
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

    /// Draws the normals of rough lobes.
    pub fn draw<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        lobes: &LobeLanes<N>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
    ) {
        if bsdf_variant::microfacets(VARIANT) == distribution::GGX {
            draw_ggx::<VARIANT, N>(simd, lobes, points, numbers, segment, self);
            return;
        }
        begin_beckmann::<VARIANT, N>(simd, lobes, points, numbers, segment, self);
        for _ in 0..VisibleSlope::STEPS {
            let mut continues = false;
            step_beckmann(simd, segment, self, &mut continues);
            if !continues {
                break;
            }
        }
        finish_beckmann::<VARIANT, N>(simd, lobes, numbers, segment, self);
    }
}

/// The direction that a rough lobe's normals are visible from.
#[inline(always)]
fn viewer(lobe: &Lobe, wi: Vec3) -> Vec3 {
    above(mirrored(is_flipped(lobe, wi), wi))
}

multiversioned! {
    fn draw_ggx<; const VARIANT: u32, const N: usize>(
        lobes: &LobeLanes<N>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        normals: &mut NormalLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let lobe = lobes.get::<VARIANT>(k);
            let facets = lobe.microfacets();
            let u = Vec2::new(numbers[4][k], numbers[5][k]);
            let visible = facets.sample_visible_normal(viewer(&lobe, points.wi.get(k)), u);
            let any = facets.sample_normal(u);
            let all = lobe.samples_all_normals();
            normals.m.set(k, if all { any } else { visible });
        }
    }

    fn begin_beckmann<; const VARIANT: u32, const N: usize>(
        lobes: &LobeLanes<N>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        normals: &mut NormalLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let lobe = lobes.get::<VARIANT>(k);
            let w = lobe.microfacets().stretched(viewer(&lobe, points.wi.get(k)));
            let slope = VisibleSlope::new(w, Vec2::new(numbers[4][k], numbers[5][k]));
            normals.w.set(k, w);
            normals.cos[k] = slope.cos;
            normals.sin[k] = slope.sin;
            normals.start[k] = slope.start;
            normals.end[k] = slope.end;
            normals.target[k] = slope.target;
            normals.along[k] = slope.along;
            normals.across[k] = slope.across;
            normals.continues[k] = 1;
        }
    }

    fn step_beckmann<; const N: usize>(
        segment: Segment,
        normals: &mut NormalLanes<N>,
        continues: &mut bool,
    ) {
        let mut any = 0;
        for k in segment.slots::<N>() {
            let mut slope = normals.slope(k);
            let before = slope.along;
            let continues = slope.step();
            let went_on = normals.continues[k];
            normals.along[k] = if went_on != 0 { slope.along } else { before };
            let still = went_on & u32::from(continues);
            normals.continues[k] = still;
            any |= still;
        }
        *continues = any != 0;
    }

    fn finish_beckmann<; const VARIANT: u32, const N: usize>(
        lobes: &LobeLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        normals: &mut NormalLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let lobe = lobes.get::<VARIANT>(k);
            let facets = lobe.microfacets();
            let w = normals.w.get(k);
            let h = normals.slope(k).normal(w);
            // Nothing is seen from the plane of the surface.
            let visible = if w == Vec3::ZERO {
                Vec3::Z
            } else {
                facets.unstretched(h)
            };
            let any = facets.sample_normal(Vec2::new(numbers[4][k], numbers[5][k]));
            let all = lobe.samples_all_normals();
            normals.m.set(k, if all { any } else { visible });
        }
    }
}
