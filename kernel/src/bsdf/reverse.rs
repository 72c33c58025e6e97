//! The BSDF with its directions exchanged: reverse densities, and values on light walks.
//!
//! Bidirectional methods need, for a pair of directions (wi, wo), also the density of sampling wi where wo is known, and, on
//! light walks, the value that a camera walk would have evaluated. A material looked up for wi usually holds all of this: its
//! lobes do not depend on the known direction, only the probabilities of choosing them do. It is looked up a second time,
//! for wo, where that fails: under normal and bump maps, whose frame may be flipped towards the known direction, and for
//! transmission through a material with a lobe that exists on one side only.
//!
//! Invariant (tests): value and density are those of [`Bsdf::eval_cosine_pdf`] of the material looked up for wo.

use super::{Bsdf, BsdfValue, lobe};
use crate::math::{Rgb, float};
use crate::scene::{SurfacePoint, Tables, lobe_flag, lobe_kind};
use glam::Vec3;

/// Largest squared distance of normals that differ by rounding only.
const SAME_NORMAL: f32 = 1e-8;

impl Bsdf {
    /// f(wi, wo) |cos wo|, or f(wo, wi) |cos wi| if `is_exchanged`, and the densities in both directions, of a material looked
    /// up for wi and for radiance; in one pass where the model allows it. The densities are undefined where the value is zero.
    pub fn eval_cosine_pdf_both(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        wi: Vec3,
        wo: Vec3,
        is_exchanged: bool,
    ) -> BsdfValue {
        if self.lobe_count() == 1 {
            let only = self.lobe_at(0);
            if lobe::is_reciprocal_and_plain(only) {
                let both = lobe::eval_pdf_both(only, wi, wo);
                let cosine = float::abs(if is_exchanged { wi.z } else { wo.z });
                return BsdfValue {
                    value: both.value * (only.weight * cosine),
                    pdf: both.pdf,
                    pdf_reverse: both.pdf_reverse,
                };
            }
        }
        let mut both = BsdfValue::ZERO;
        if is_exchanged {
            (both.value, both.pdf_reverse) = self.eval_cosine_pdf_reverse(tables, point, wi, wo);
            if both.value.max_element() > 0.0 {
                both.pdf = self.pdf(tables.data, wi, wo);
            }
        } else {
            (both.value, both.pdf) = self.eval_cosine_pdf(tables.data, wi, wo);
            if both.value.max_element() > 0.0 {
                both.pdf_reverse = self.pdf_reverse(tables, point, wi, wo);
            }
        }
        both
    }

    /// Whether no light passes to the other side of the surface, null scattering aside.
    #[inline]
    pub fn is_opaque(&self) -> bool {
        for i in 0..self.lobe_count() {
            if !lobe::is_opaque(self.lobe_at(i).kind) {
                return false;
            }
        }
        true
    }

    /// f(wo, wi) |cos wi| and the density of sampling wi where wo is known, of a material looked up for wi and for radiance;
    /// without the discrete parts.
    pub fn eval_cosine_pdf_reverse(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        wi: Vec3,
        wo: Vec3,
    ) -> (Rgb, f32) {
        if !self.holds_reverse(tables, point, wi, wo) {
            let reverse = Bsdf::at(tables, point, wo, super::mode::RADIANCE);
            return reverse.eval_cosine_pdf(tables.data, wo, wi);
        }
        let count = self.lobe_count();
        if count == 1 {
            let only = self.lobe_at(0);
            let (value, pdf) = lobe::eval_cosine_pdf(only, tables.data, wo, wi);
            return (value * only.weight, pdf);
        }
        let mut value = Vec3::ZERO;
        let mut pdf = 0.0;
        let mut sum = 0.0;
        for i in 0..count {
            let lobe = self.lobe_at(i);
            let (f, p) = lobe::eval_cosine_pdf(lobe, tables.data, wo, wi);
            let selection = lobe::selection_weight(lobe, tables.data, wo);
            value += f * lobe.weight;
            pdf += p * selection;
            sum += selection;
        }
        if sum > 0.0 {
            (value, pdf / sum)
        } else {
            (Vec3::ZERO, 0.0)
        }
    }

    /// The density of [`Bsdf::eval_cosine_pdf_reverse`] alone.
    pub fn pdf_reverse(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        wi: Vec3,
        wo: Vec3,
    ) -> f32 {
        if !self.holds_reverse(tables, point, wi, wo) {
            let reverse = Bsdf::at(tables, point, wo, super::mode::RADIANCE);
            return reverse.pdf(tables.data, wo, wi);
        }
        let count = self.lobe_count();
        if count == 1 {
            return lobe::pdf(self.lobe_at(0), tables.data, wo, wi);
        }
        let mut pdf = 0.0;
        let mut sum = 0.0;
        for i in 0..count {
            let lobe = self.lobe_at(i);
            let selection = lobe::selection_weight(lobe, tables.data, wo);
            pdf += lobe::pdf(lobe, tables.data, wo, wi) * selection;
            sum += selection;
        }
        if sum > 0.0 { pdf / sum } else { 0.0 }
    }

    /// Whether the lobe `index` has the frame that it would have if the material were looked up for wo: a perturbed normal is
    /// flipped towards the known direction where it faces away from it.
    pub fn has_same_frame(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        index: u32,
        wo: Vec3,
    ) -> bool {
        let lobe = self.lobe_at(index);
        if !lobe.has_frame {
            return true;
        }
        let reverse = Bsdf::at(tables, point, wo, super::mode::RADIANCE);
        for i in 0..reverse.lobe_count() {
            let other = reverse.lobe_at(i);
            let is_same_kind = other.kind == lobe.kind && other.has_frame;
            if is_same_kind && (other.frame.n - lobe.frame.n).length_squared() < SAME_NORMAL {
                return true;
            }
        }
        false
    }

    /// Whether the lobes that were looked up for wi are those that would be for wo.
    #[inline]
    pub(crate) fn holds_reverse(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        wi: Vec3,
        wo: Vec3,
    ) -> bool {
        for i in 0..self.lobe_count() {
            if self.lobe_at(i).has_frame {
                return false;
            }
        }
        if wi.z * wo.z > 0.0 {
            return true;
        }
        let both = lobe_flag::FRONT | lobe_flag::BACK;
        let material = &tables.materials[point.material as usize];
        for i in 0..material.lobe_count {
            let record = &tables.lobes[(material.first_lobe + i) as usize];
            if record.kind != lobe_kind::NULL && record.flags & both != both {
                return false;
            }
        }
        true
    }
}
