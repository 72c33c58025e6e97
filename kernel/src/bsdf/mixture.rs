//! The scattering function of a material at a surface point: the weighted sum of its lobes.
//!
//! f = sum_i w_i f_i, with w_i the product of the lobe's mixing factors. Sampling chooses lobe i with probability q_i
//! proportional to w_i times the lobe's colour, then a direction of that lobe. A smooth sample carries the density of
//! the whole mixture, p = sum_j q_j p_j over the smooth parts, and the value of the whole mixture (one-sample multiple
//! importance sampling with the balance heuristic, Veach 1997, section 9.2.4); a discrete one carries q_i times its
//! probability. The number that chooses the lobe is stretched back to [0, 1) and used again inside.
//!
//! Everything is per solid angle in the local frame of the surface point (z along the unperturbed shading normal).
//! Invariants (tests): sum of q_i is 1; weight * pdf = `eval_cosine` for smooth samples; samples follow `pdf`.

use super::lookup::{fill_lobe, weight};
use super::{BsdfSample, Lobe, event, lobe};
use crate::math::{Rgb, float};
#[cfg(target_arch = "spirv")]
use crate::scene::features;
use crate::scene::{MAX_LOBES, NONE, SurfacePoint, Tables, lobe_kind};
use glam::{Vec2, Vec3};

/// A reference to a lobe of the mixture. In shaders it is to a copy in a variable: a function is copied to callers that pass it
/// part of a larger value. On hosts the element of the array itself is the cheaper argument.
#[cfg(target_arch = "spirv")]
macro_rules! variable {
    ($self:ident.lobes[$i:ident]) => {{
        let mut lobe = $self.lobes[$i];
        // Not the value from the array, which shader compilers do not optimise.
        lobe.features = $self.features;
        &{ lobe }
    }};
}
#[cfg(not(target_arch = "spirv"))]
macro_rules! variable {
    ($self:ident.lobes[$i:ident]) => {
        &$self.lobes[$i]
    };
}

/// A material looked up at a point, for one known direction `wi`.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    lobes: [Lobe; MAX_LOBES],
    /// Probability of each lobe.
    selection: [f32; MAX_LOBES],
    count: u32,
    #[cfg(target_arch = "spirv")]
    features: u32,
}

impl Bsdf {
    /// Scatters nothing.
    pub const BLACK: Bsdf = Bsdf {
        lobes: [Lobe::NONE; MAX_LOBES],
        selection: [0.0; MAX_LOBES],
        count: 0,
        #[cfg(target_arch = "spirv")]
        features: features::ALL,
    };

    /// The material of `point` for the local direction `wi`: lobes of the other side or without weight are left out.
    /// `mode` is one of [`super::mode`].
    pub fn at(tables: &Tables<'_>, point: &SurfacePoint, wi: Vec3, mode: u32) -> Bsdf {
        let mut bsdf = Bsdf::BLACK;
        bsdf.look_up(tables, point, wi, mode);
        bsdf
    }

    /// [`Bsdf::at`] that overwrites `self`, so that a walk does not clear and copy all of [`MAX_LOBES`] at every point.
    #[inline]
    pub fn look_up(&mut self, tables: &Tables<'_>, point: &SurfacePoint, wi: Vec3, mode: u32) {
        self.count = 0;
        #[cfg(target_arch = "spirv")]
        {
            self.features = tables.features;
        }
        if point.material == NONE {
            return;
        }
        let material = &tables.materials[point.material as usize];
        for i in 0..material.lobe_count {
            self.add(tables, material.first_lobe + i, point, wi, mode);
        }
        self.select(tables.data, wi);
    }

    /// Looks up one lobe of the material.
    #[inline]
    fn add(&mut self, tables: &Tables<'_>, lobe: u32, point: &SurfacePoint, wi: Vec3, mode: u32) {
        let record = &tables.lobes[lobe as usize];
        if !lobe::is_active(record.flags, wi) && record.kind != lobe_kind::NULL {
            return;
        }
        let weight = weight(tables, record, point);
        let i = self.slot(self.count as usize);
        if weight > 0.0 && i < MAX_LOBES {
            fill_lobe(&mut self.lobes[i], tables, record, point, wi, mode);
            self.lobes[i].weight = weight;
            self.count += 1;
        }
    }

    /// Whether there may be more than one lobe.
    #[inline]
    fn may_mix(&self) -> bool {
        #[cfg(target_arch = "spirv")]
        {
            self.features & features::MIXTURES != 0
        }
        #[cfg(not(target_arch = "spirv"))]
        {
            true
        }
    }

    /// The slot of lobe `i`: a constant if there may be only one lobe, so that the shader needs no array.
    #[inline]
    fn slot(&self, i: usize) -> usize {
        if self.may_mix() { i } else { 0 }
    }

    /// A mixture of given lobes (the first `count`), for tests and for materials that are not in a table.
    pub fn from_lobes(lobes: [Lobe; MAX_LOBES], count: u32, data: &[f32], wi: Vec3) -> Bsdf {
        let mut bsdf = Bsdf {
            lobes,
            selection: [0.0; MAX_LOBES],
            count: count.min(MAX_LOBES as u32),
            #[cfg(target_arch = "spirv")]
            features: features::ALL,
        };
        bsdf.select(data, wi);
        bsdf
    }

    /// Fills the selection probabilities.
    #[inline]
    fn select(&mut self, data: &[f32], wi: Vec3) {
        if self.count == 1 || !self.may_mix() {
            self.selection[0] = 1.0;
            return;
        }
        let mut sum = 0.0;
        for i in 0..self.count as usize {
            let lobe = variable!(self.lobes[i]);
            let w = lobe::selection_weight(lobe, data, wi);
            self.selection[i] = w;
            sum += w;
        }
        if sum <= 0.0 {
            self.count = 0;
            return;
        }
        for i in 0..self.count as usize {
            self.selection[i] /= sum;
        }
    }

    /// Makes those rough metals and glass specular that `is_smooth` takes for such; `wi` is the direction for which the material was
    /// looked up. Hosts only, as the regularisation of path space is, which asks for it.
    #[cfg(not(target_arch = "spirv"))]
    pub fn sharpen(&mut self, data: &[f32], wi: Vec3, is_smooth: impl Fn(&Lobe) -> bool) {
        let mut is_changed = false;
        for i in 0..self.count as usize {
            let lobe = &mut self.lobes[i];
            let kind = match lobe.kind {
                lobe_kind::ROUGH_CONDUCTOR => lobe_kind::CONDUCTOR,
                lobe_kind::ROUGH_DIELECTRIC if !lobe::has_delta(lobe) => lobe_kind::DIELECTRIC,
                _ => continue,
            };
            if is_smooth(lobe) {
                lobe.kind = kind;
                is_changed = true;
            }
        }
        if is_changed {
            self.select(data, wi);
        }
    }

    /// Number of lobes.
    #[inline]
    pub fn lobe_count(&self) -> u32 {
        self.count
    }

    /// A reference to lobe `i`.
    #[inline]
    pub(crate) fn lobe_at(&self, i: u32) -> &Lobe {
        &self.lobes[self.slot(i as usize)]
    }

    /// Lobe `i`.
    #[inline]
    pub fn lobe(&self, i: u32) -> Lobe {
        self.lobes[i as usize]
    }

    /// Probability of choosing lobe `i`.
    #[inline]
    pub fn selection(&self, i: u32) -> f32 {
        self.selection[i as usize]
    }

    /// f |cos| without the discrete parts; each lobe's cosine is that of its own normal.
    #[inline]
    pub fn eval_cosine(&self, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
        let mut f = Vec3::ZERO;
        for i in 0..self.count as usize {
            let i = self.slot(i);
            let lobe = variable!(self.lobes[i]);
            f += lobe::eval_cosine(lobe, data, wi, wo) * lobe.weight;
        }
        f
    }

    /// Density of [`Bsdf::sample`] per solid angle, without the discrete parts.
    #[inline]
    pub fn pdf(&self, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
        let mut p = 0.0;
        for i in 0..self.count as usize {
            let i = self.slot(i);
            let lobe = variable!(self.lobes[i]);
            p += lobe::pdf(lobe, data, wi, wo) * self.selection[i];
        }
        p
    }

    /// [`Bsdf::eval_cosine`] and [`Bsdf::pdf`] in one pass.
    #[inline]
    pub fn eval_cosine_pdf(&self, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
        self.eval_cosine_pdf_but(data, wi, wo, MAX_LOBES)
    }

    /// Sum over all lobes but the one at `skip`.
    #[inline]
    fn eval_cosine_pdf_but(&self, data: &[f32], wi: Vec3, wo: Vec3, skip: usize) -> (Rgb, f32) {
        let mut f = Vec3::ZERO;
        let mut p = 0.0;
        for i in 0..self.count as usize {
            let i = self.slot(i);
            if i != skip {
                let lobe = variable!(self.lobes[i]);
                let (lobe_f, lobe_p) = lobe::eval_cosine_pdf(lobe, data, wi, wo);
                f += lobe_f * lobe.weight;
                p += lobe_p * self.selection[i];
            }
        }
        (f, p)
    }

    /// A direction with weight f |cos| / pdf of the whole mixture.
    #[inline]
    pub fn sample(&self, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
        let (sample, chosen) = self.sample_lobe(data, wi, u1, u2);
        self.mix(data, wi, sample, chosen)
    }

    /// A direction of one of the lobes, and which; [`Bsdf::mix`] makes it a sample of the mixture. The two are apart for
    /// shaders, whose compilers take long for both at once.
    #[inline]
    pub fn sample_lobe(&self, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> (BsdfSample, u32) {
        if self.count == 0 {
            return (BsdfSample::NONE, 0);
        }
        // Inversion of the discrete distribution; the remainder of u1 is uniform again.
        let mut chosen = 0;
        let mut u = u1;
        if self.may_mix() {
            while chosen + 1 < self.count as usize && u >= self.selection[chosen] {
                u -= self.selection[chosen];
                chosen += 1;
            }
        }
        let q = self.selection[chosen];
        if q <= 0.0 {
            return (BsdfSample::NONE, 0);
        }
        let lobe = variable!(self.lobes[chosen]);
        let u = (u / q).min(ONE_MINUS_EPSILON);
        (lobe::sample(lobe, data, wi, u, u2), chosen as u32)
    }

    /// A sample of the mixture from one of its lobe `chosen`.
    #[inline]
    pub fn mix(&self, data: &[f32], wi: Vec3, sample: BsdfSample, chosen: u32) -> BsdfSample {
        let mut s = sample;
        if s.pdf <= 0.0 {
            return BsdfSample::NONE;
        }
        let chosen = self.slot(chosen as usize);
        let q = self.selection[chosen];
        // Only the direction is known, in shaders: see `model::sample`.
        let is_direction = self.may_need_values() && s.event & event::UNWEIGHTED != 0;
        if !is_direction {
            if self.count == 1 || !self.may_mix() {
                s.weight *= self.lobes[chosen].weight;
                return s;
            }
            if s.event & event::DELTA != 0 {
                s.weight *= self.lobes[chosen].weight / q;
                s.pdf *= q;
                return s;
            }
        }
        let skip = if is_direction { MAX_LOBES } else { chosen };
        let (f, p) = self.eval_cosine_pdf_but(data, wi, s.wo, skip);
        if is_direction {
            if p <= 0.0 {
                return BsdfSample::NONE;
            }
            s.event &= !event::UNWEIGHTED;
            s.pdf = p;
            s.weight = f / p;
            return s;
        }
        let value = s.weight * (s.pdf * self.lobes[chosen].weight) + f;
        s.pdf = s.pdf * q + p;
        s.weight = value / s.pdf;
        s
    }

    /// Whether lobes may leave their value and density to [`Bsdf::mix`]: in shaders, see [`super::model::sample`].
    #[inline]
    fn may_need_values(&self) -> bool {
        #[cfg(target_arch = "spirv")]
        {
            self.features & super::model::UNWEIGHTED_KINDS != 0
        }
        #[cfg(not(target_arch = "spirv"))]
        {
            false
        }
    }

    /// Whether some direction has a density: whether next event estimation can contribute.
    #[inline]
    pub fn has_smooth(&self) -> bool {
        let mut found = false;
        for i in 0..self.count as usize {
            let i = self.slot(i);
            found = found || !lobe::is_delta(self.lobes[i].kind);
        }
        found
    }

    /// Whether some direction is a discrete one.
    #[inline]
    pub fn has_delta(&self) -> bool {
        for i in 0..self.count as usize {
            if lobe::has_delta(&self.lobes[i]) {
                return true;
            }
        }
        false
    }

    /// Share of the light that passes straight on, for shadow rays through masks.
    #[inline]
    pub fn null_transmittance(&self) -> Rgb {
        let mut sum = 0.0;
        for i in 0..self.count as usize {
            if self.lobes[i].kind == lobe_kind::NULL {
                sum += self.lobes[i].weight;
            }
        }
        Vec3::splat(float::abs(sum).min(1.0))
    }

    /// Approximate directional albedo for the albedo layer: weighted sum of the lobes' colours.
    #[inline]
    pub fn albedo(&self, data: &[f32], wi: Vec3) -> Rgb {
        let mut sum = Vec3::ZERO;
        for i in 0..self.count as usize {
            let lobe = variable!(self.lobes[i]);
            sum += lobe::albedo(lobe, data, wi) * lobe.weight;
        }
        sum
    }
}

#[cfg(not(target_arch = "spirv"))]
pub(crate) mod plain;

/// Largest `f32` below one.
const ONE_MINUS_EPSILON: f32 = 1.0 - 0.5 * f32::EPSILON;
