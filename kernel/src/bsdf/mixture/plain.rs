//! [`Bsdf`] of one plain lobe of weight one ([`crate::bsdf::lobe::plain`]). Inlined, so that callers who know the kind get its code alone.

use super::*;

/// [`Bsdf::eval_cosine_pdf`].
#[inline(always)]
pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
    let (f, p) = lobe::plain::eval_cosine_pdf(lobe, data, wi, wo);
    // The sums of the mixture turn negative zeros into positive ones.
    (Vec3::ZERO + f, 0.0 + p)
}

/// [`Bsdf::sample`]; rough models reflect or refract at the normal `m`, in the frame of the model, that they draw with `u2`.
#[inline(always)]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2, m: Vec3) -> BsdfSample {
    let u1 = u1.min(ONE_MINUS_EPSILON);
    let s = lobe::plain::sample(lobe, data, wi, u1, u2, |_| m);
    if s.pdf <= 0.0 { BsdfSample::NONE } else { s }
}
