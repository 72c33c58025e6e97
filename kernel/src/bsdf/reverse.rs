//! The scattering function with its directions exchanged, for densities of walks that come the other way.
//!
//! Bidirectional methods ask of a pair of directions (wi, wo) also for the density of sampling wi where wo is known, and, on
//! light walks, for the value that a camera walk would have found. A material looked up for wi mostly holds what it needs:
//! its lobes do not depend on the known direction, only the probabilities of choosing them do. It is looked up once more
//! where that fails, which is rare: under normal and bump maps, whose frame may be mirrored towards the known direction, and
//! across the surface where some lobe exists on one side only.
//!
//! Invariant (tests): value and density are those of [`Bsdf::eval_cosine_pdf`] of the material looked up for wo.

use super::{Bsdf, lobe};
use crate::math::Rgb;
use crate::scene::{SurfacePoint, Tables, lobe_flag, lobe_kind};
use glam::Vec3;

impl Bsdf {
    /// f(wo, wi) |cos wi| and the density of sampling wi where wo is known, of a material looked up for wi in the mode of
    /// radiance; the discrete parts are in neither.
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

    /// Whether the lobes that were looked up for wi are those that would be for wo.
    #[inline]
    fn holds_reverse(&self, tables: &Tables<'_>, point: &SurfacePoint, wi: Vec3, wo: Vec3) -> bool {
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
