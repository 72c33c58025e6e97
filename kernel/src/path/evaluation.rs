//! The scattering between two directions at a vertex, and its sampling densities in both directions of transport.
//!
//! All algorithms evaluate one function, f(wc, wl) |cos wl|, where wc points towards the camera end of the path and wl
//! towards its light end. A camera walk comes from wc and goes on along wl; a light walk comes from wl and goes on along wc,
//! and its throughput is multiplied by the same number times the ratio of geometric cosines |wc.n_g| / |wl.n_g|. With the
//! cosine of the shading normal that the number already holds, this is |cos wc| times the adjoint correction
//! |wi.n_s| |wo.n_g| / (|wi.n_g| |wo.n_s|) of Veach (1997, equation 5.19), under normal maps, bump maps and coats as well.
//! Nothing else depends on the direction of transport. All strategies therefore agree on the value of a path up to rounding,
//! even where a model is not exactly reciprocal.
//!
//! Regularisation is a property of the vertex ([`Interaction::regularized`]): its BSDF is then evaluated below tau, with the
//! densities p_hat of equation 13 of Jendersie and Grosch 2019 for the weights ([`crate::regularize::both_ways`]).
//!
//! Where edits turn directions ([`super::retarget`]), the BSDF is evaluated for those before the turn, in which
//! [`Interaction::wi`] is given; geometric cosines are those of the true ones. Hosts only: for shaders nothing is edited.
//!
//! Invariant (tests): with the two directions exchanged, both modes give the same value but for that ratio, and the two
//! densities are exchanged.

#[cfg(not(target_arch = "spirv"))]
use super::retargeted::Retargeted;
use super::rules::PathRules;
#[cfg(not(target_arch = "spirv"))]
use super::scattered::Scattered;
use crate::bsdf::{Bsdf, BsdfSample, BsdfValue, mode};
use crate::math::{Rgb, float};
use crate::regularize::bandwidth::TAU_MAX;
use crate::regularize::both_ways;
use crate::regularize::regularized_bsdf::mixture_eval_cosine_pdf;
use crate::regularize::settings::flag;
use crate::sampler::Sampler;
use crate::scene::{SurfacePoint, Tables};
use glam::Vec3;

/// BSDF value and sampling densities for a pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// f |cos wl|, on light walks times the ratio of geometric cosines.
    pub value: Rgb,
    /// Density per solid angle of sampling the outgoing direction.
    pub pdf: f32,
    /// Density per solid angle of sampling the incident direction for a walk that comes from the outgoing one.
    pub pdf_reverse: f32,
}

impl Evaluation {
    /// Nothing is scattered.
    pub const NONE: Evaluation = Evaluation {
        value: Vec3::ZERO,
        pdf: 0.0,
        pdf_reverse: 0.0,
    };

    /// Whether anything is scattered.
    #[inline]
    pub fn is_some(&self) -> bool {
        self.value.max_element() > 0.0
    }
}

/// A vertex of a walk with everything looked up: surface point, BSDF (for radiance, whatever the walk carries), and the local
/// direction from which the walk came.
#[derive(Clone, Copy)]
pub struct Interaction<'a> {
    /// The point.
    pub point: &'a SurfacePoint,
    /// Its BSDF.
    pub bsdf: &'a Bsdf,
    /// Local direction back along the walk.
    pub wi: Vec3,
    /// Absolute cosine between that direction and the geometric normal.
    pub cosine: f32,
    /// Largest value of the BSDF in connections, [`TAU_MAX`] where the model is evaluated as it is.
    pub tau: f32,
    /// [`flag::PLAIN_WEIGHTS`] or [`flag::PLAIN_VALUES`] among bits of [`flag`].
    pub variant: u32,
    /// What edits do here; nothing where there are none.
    #[cfg(not(target_arch = "spirv"))]
    pub retargeted: Option<&'a Retargeted<'a>>,
}

/// How a walk leaves a vertex: the direction, and what edits do to the sample that it was made of.
#[derive(Clone, Copy, Debug)]
pub struct OutgoingSample {
    /// Unit direction.
    pub direction: Vec3,
    /// Factor on the density of the sample.
    pub pdf: f32,
    /// Factor on the reverse density.
    pub pdf_reverse: f32,
    /// Factor on values.
    pub value: Rgb,
    /// One more than the number of the edit that has turned it; zero for none.
    pub label: u32,
}

impl OutgoingSample {
    /// Where nothing is edited.
    #[inline]
    pub fn unedited(direction: Vec3) -> OutgoingSample {
        OutgoingSample {
            direction,
            pdf: 1.0,
            pdf_reverse: 1.0,
            value: Vec3::ONE,
            label: 0,
        }
    }
}

impl<'a> Interaction<'a> {
    /// At a point that was hit along the unit world `direction`; the BSDF must have been looked up for the same ray.
    #[inline]
    pub fn new(point: &'a SurfacePoint, bsdf: &'a Bsdf, direction: Vec3) -> Interaction<'a> {
        Interaction {
            point,
            bsdf,
            wi: point.frame.to_local(-direction),
            cosine: float::abs(point.geometric_normal.dot(direction)),
            tau: TAU_MAX,
            variant: 0,
            #[cfg(not(target_arch = "spirv"))]
            retargeted: None,
        }
    }

    /// The same where edits turn directions: the one from which the walk came, and that in which it is evaluated.
    #[cfg(not(target_arch = "spirv"))]
    #[inline]
    pub fn retargeted(mut self, retargeted: &'a Retargeted<'a>) -> Interaction<'a> {
        self.wi = self.point.frame.to_local(retargeted.incoming.back);
        self.retargeted = Some(retargeted);
        self
    }

    /// The local direction that the BSDF knows for the world `direction`.
    #[inline]
    pub fn effective(&self, direction: Vec3) -> Vec3 {
        #[cfg(not(target_arch = "spirv"))]
        if let Some(retargeted) = self.retargeted
            && let Some(origin) = retargeted.origin(self.point, direction)
        {
            return self.point.frame.to_local(origin.direction);
        }
        self.point.frame.to_local(direction)
    }

    /// How a walk leaves along a sample whose unit world direction is `direction`; the sampler is asked for a number where edits
    /// turn a part of what is scattered.
    #[inline]
    pub fn outgoing<S: Sampler>(
        &self,
        tables: &Tables<'_>,
        sample: &BsdfSample,
        direction: Vec3,
        sampler: &mut S,
    ) -> OutgoingSample {
        #[cfg(not(target_arch = "spirv"))]
        if let Some(retargeted) = self.retargeted {
            let (wi, wo) = (self.wi, sample.wo);
            let scattered = Scattered::sampled(self.bsdf, tables.data, wi, wo, sample.event);
            let turned =
                retargeted.redirect(self.point, &scattered, direction, || sampler.next_1d());
            return OutgoingSample {
                direction: turned.direction,
                pdf: turned.pdf,
                pdf_reverse: retargeted.incoming.jacobian,
                value: turned.value,
                label: turned.label,
            };
        }
        #[cfg(target_arch = "spirv")]
        let _ = (tables, sample, sampler);
        OutgoingSample::unedited(direction)
    }

    /// The same with the BSDF below `tau` where it is evaluated for connections; nothing else changes for a BSDF that has no
    /// larger values. `variant` holds bits of [`flag`].
    #[inline]
    pub fn regularized(mut self, tau: f32, variant: u32) -> Interaction<'a> {
        if both_ways::is_raised(self.bsdf, tau) {
            self.tau = tau;
            self.variant = variant;
        }
        self
    }

    /// Whether the BSDF is evaluated below some tau.
    #[inline]
    pub fn is_regularized(&self) -> bool {
        self.tau < TAU_MAX
    }

    /// tau where the BSDF is evaluated below it, zero where it is evaluated as it is ([`super::Contribution::blur`]).
    #[inline]
    pub fn blur(&self) -> f32 {
        if self.is_regularized() { self.tau } else { 0.0 }
    }

    /// Whether some direction has a density, so that the vertex can be connected. Regularisation gives one to specular lobes.
    #[inline]
    pub fn is_connectable(&self) -> bool {
        self.is_regularized() || self.bsdf.has_smooth()
    }

    /// Scattering of a walk of `transport_mode` (one of [`mode`]) into the unit world `direction`.
    pub fn evaluate(
        &self,
        tables: &Tables<'_>,
        rules: &PathRules,
        transport_mode: u32,
        direction: Vec3,
    ) -> Evaluation {
        let point = self.point;
        let wo = point.frame.to_local(direction);
        if !rules.allows(point, direction, wo.z) {
            return Evaluation::NONE;
        }
        let is_light_walk = transport_mode == mode::IMPORTANCE;
        #[cfg(not(target_arch = "spirv"))]
        if let Some(retargeted) = self.retargeted {
            return self.evaluate_retargeted(tables, retargeted, is_light_walk, direction);
        }
        let both = self.eval_cosine_pdf_both(tables, wo, is_light_walk);
        if both.value.max_element() <= 0.0 {
            return Evaluation::NONE;
        }
        let ratio = if is_light_walk {
            self.adjoint_ratio(direction)
        } else {
            1.0
        };
        Evaluation {
            value: both.value * ratio,
            pdf: both.pdf,
            pdf_reverse: both.pdf_reverse,
        }
    }

    /// [`Interaction::evaluate`] where edits turn directions.
    #[cfg(not(target_arch = "spirv"))]
    fn evaluate_retargeted(
        &self,
        tables: &Tables<'_>,
        retargeted: &Retargeted<'_>,
        is_light_walk: bool,
        direction: Vec3,
    ) -> Evaluation {
        let Some(origin) = retargeted.origin(self.point, direction) else {
            return Evaluation::NONE;
        };
        let wo = self.point.frame.to_local(origin.direction);
        let both = self.eval_cosine_pdf_both(tables, wo, is_light_walk);
        if both.value.max_element() <= 0.0 {
            return Evaluation::NONE;
        }
        let ratio = if is_light_walk {
            self.adjoint_ratio(direction)
        } else {
            1.0
        };
        Evaluation {
            value: both.value * ratio * retargeted.value(self.point, &origin, direction),
            pdf: both.pdf * origin.jacobian,
            pdf_reverse: both.pdf_reverse * retargeted.incoming.jacobian,
        }
    }

    /// Value and densities for a local direction, below tau where the vertex is regularised.
    #[inline]
    pub fn eval_cosine_pdf_both(
        &self,
        tables: &Tables<'_>,
        wo: Vec3,
        is_light_walk: bool,
    ) -> BsdfValue {
        let (bsdf, point, wi) = (self.bsdf, self.point, self.wi);
        if !self.is_regularized() {
            return bsdf.eval_cosine_pdf_both(tables, point, wi, wo, is_light_walk);
        }
        let tau = self.tau;
        let hat = both_ways::eval_cosine_pdf_both(bsdf, tables, point, wi, wo, is_light_walk, tau);
        if self.variant & (flag::PLAIN_WEIGHTS | flag::PLAIN_VALUES) == 0 {
            return hat;
        }
        let plain = bsdf.eval_cosine_pdf_both(tables, point, wi, wo, is_light_walk);
        if self.variant & flag::PLAIN_VALUES != 0 {
            return BsdfValue {
                value: plain.value,
                ..hat
            };
        }
        // Densities are undefined where there is no value.
        let has_value = plain.value.max_element() > 0.0;
        let of = |pdf: f32| if has_value { pdf } else { 0.0 };
        BsdfValue {
            value: hat.value,
            pdf: of(plain.pdf),
            pdf_reverse: of(plain.pdf_reverse),
        }
    }

    /// f |cos| and the density of a local direction for a camera walk alone, below tau where the vertex is regularised.
    #[inline]
    pub fn eval_cosine_pdf(&self, tables: &Tables<'_>, wo: Vec3) -> (Rgb, f32) {
        let plain = |at: &Self| at.bsdf.eval_cosine_pdf(tables.data, at.wi, wo);
        if !self.is_regularized() {
            return plain(self);
        }
        let hat = mixture_eval_cosine_pdf(self.bsdf, tables.data, self.wi, wo, self.tau);
        if self.variant & flag::PLAIN_WEIGHTS != 0 {
            (hat.0, plain(self).1)
        } else if self.variant & flag::PLAIN_VALUES != 0 {
            (plain(self).0, hat.1)
        } else {
            hat
        }
    }

    /// The shading normal on the side from which the walk came, if the surface is opaque; zero if it may transmit. An opaque
    /// surface scatters nothing into the hemisphere behind this normal.
    #[inline]
    pub fn facing(&self) -> Vec3 {
        if !self.bsdf.is_opaque() {
            Vec3::ZERO
        } else if self.wi.z > 0.0 {
            self.point.frame.n
        } else {
            -self.point.frame.n
        }
    }

    /// |wo.n_g| / |wi.n_g| for the world `direction` wo; zero where the walk came along the surface.
    #[inline]
    pub fn adjoint_ratio(&self, direction: Vec3) -> f32 {
        if !(self.cosine > 0.0) {
            return 0.0;
        }
        float::abs(self.point.geometric_normal.dot(direction)) / self.cosine
    }
}
