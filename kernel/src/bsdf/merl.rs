//! Measured isotropic reflectance, tabulated over half and difference angles.
//!
//! Matusik, Pfister, Brand and McMillan 2003, "A Data-Driven Reflectance Model" (the MERL database), in the
//! parametrisation of Rusinkiewicz 1998: theta_h is the polar angle of the half vector h, (theta_d, phi_d) are the
//! spherical angles of wi in the frame whose pole is h and whose x axis points along growing theta_h. Cells are uniform in
//! sqrt(theta_h), theta_d and phi_d, which has the period pi because of reciprocity. The value is trilinear between the
//! centres of the cells, constant beyond the first and the last centre of theta_h and theta_d, and equal to the
//! stored one at a centre. Invalid measurements are stored as zero.
//!
//! Sampling: h is drawn from a distribution over the theta_h cells that belongs to the cell of theta_i, uniform in solid
//! angle within the cell and in phi_h, and wi is mirrored about it; with probability [`DEFENSIVE`] a cosine-distributed
//! direction is drawn instead, since cells are conditioned on the incident angle only roughly. Densities per solid angle,
//! on the side of the normal. Tables are built on the host by [`super::merl_table`], whose layout they have.
//!
//! Invariants (tests): stored values at centres, reciprocity, samples follow the density, the albedo of the table is that of
//! the sampler.

use super::coat_reflection::half_vector;
use super::fresnel::reflect;
use super::{BsdfSample, Lobe, event, weighted};
use crate::math::{Rgb, float, warp};
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use glam::{Vec2, Vec3};

/// Probability of a cosine-distributed direction.
pub const DEFENSIVE: f32 = 0.2;

/// Words before the values: the numbers of cells in theta_h, theta_d, phi_d and theta_i.
pub const HEADER: usize = 4;

/// The locations of the parts of a table.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) first: usize,
    pub(super) cells: [usize; 3],
    pub(super) incidences: usize,
}

impl Layout {
    #[inline]
    pub(super) fn read(data: &[f32], table: u32) -> Layout {
        let first = table as usize;
        Layout {
            first,
            cells: [
                data[first] as usize,
                data[first + 1] as usize,
                data[first + 2] as usize,
            ],
            incidences: data[first + 3] as usize,
        }
    }

    /// First word of the cumulative distributions, one row of theta_h cells per incidence.
    #[inline]
    pub(super) fn distributions(&self) -> usize {
        self.first + HEADER + 3 * self.cells[0] * self.cells[1] * self.cells[2]
    }

    /// First word of the albedos, three per incidence.
    #[inline]
    pub(super) fn albedos(&self) -> usize {
        self.distributions() + self.incidences * self.cells[0]
    }

    /// The cell of an incident cosine.
    #[inline]
    fn incidence(&self, cos: f32) -> usize {
        let cos = cos.max(0.0).min(1.0);
        let theta = float::atan2(float::safe_sqrt(1.0 - cos * cos), cos);
        ((theta / FRAC_PI_2 * self.incidences as f32) as usize).min(self.incidences - 1)
    }

    /// The value of the cell (h, d, p).
    #[inline]
    fn cell(&self, data: &[f32], h: usize, d: usize, p: usize) -> Rgb {
        let i = (h * self.cells[1] + d) * self.cells[2] + p;
        let at = self.first + HEADER + 3 * i;
        Vec3::new(data[at], data[at + 1], data[at + 2])
    }

    /// Probability of the theta_h cell `h` at an incidence.
    #[inline]
    fn probability(&self, data: &[f32], incidence: usize, h: usize) -> f32 {
        let row = self.distributions() + incidence * self.cells[0];
        let below = if h == 0 { 0.0 } else { data[row + h - 1] };
        data[row + h] - below
    }
}

/// Rusinkiewicz' angles of two directions above the surface: theta_h, theta_d, phi_d in [0, pi).
#[inline]
pub fn half_difference_angles(wi: Vec3, wo: Vec3) -> Vec3 {
    let h = half_vector(wi, wo);
    let sin_h = float::sqrt(h.x * h.x + h.y * h.y);
    let (cos_phi, sin_phi) = if sin_h > 1e-12 {
        (h.x / sin_h, h.y / sin_h)
    } else {
        (1.0, 0.0)
    };
    let x = wi.dot(Vec3::new(h.z * cos_phi, h.z * sin_phi, -sin_h));
    let y = wi.y * cos_phi - wi.x * sin_phi;
    let z = wi.dot(h);
    let phi = float::atan2(y, x);
    let phi = if phi < 0.0 { phi + PI } else { phi };
    Vec3::new(
        float::atan2(sin_h, h.z),
        float::atan2(float::sqrt(x * x + y * y), z),
        if phi >= PI { phi - PI } else { phi },
    )
}

/// A pair of directions with the given angles, the half vector at azimuth zero; wi and wo may lie below the surface.
#[inline]
pub fn directions(angles: Vec3) -> (Vec3, Vec3) {
    let (sin_h, cos_h) = float::sin_cos(angles.x);
    let (sin_d, cos_d) = float::sin_cos(angles.y);
    let (sin_phi, cos_phi) = float::sin_cos(angles.z);
    let h = Vec3::new(sin_h, 0.0, cos_h);
    let across = Vec3::new(cos_h, 0.0, -sin_h);
    let wi = across * (sin_d * cos_phi) + Vec3::Y * (sin_d * sin_phi) + h * cos_d;
    (wi, reflect(wi, h))
}

/// Trilinear value at angles of [`half_difference_angles`].
#[inline]
pub fn lookup(data: &[f32], table: u32, angles: Vec3) -> Rgb {
    let layout = Layout::read(data, table);
    let [n_h, n_d, n_p] = layout.cells;
    let x_h = float::sqrt((angles.x / FRAC_PI_2).max(0.0).min(1.0)) * n_h as f32 - 0.5;
    let x_d = (angles.y / FRAC_PI_2).max(0.0).min(1.0) * n_d as f32 - 0.5;
    // Shifted by one period to be positive.
    let x_p = (angles.z / PI).max(0.0).min(1.0) * n_p as f32 - 0.5 + n_p as f32;
    let x_h = x_h.max(0.0).min((n_h - 1) as f32);
    let x_d = x_d.max(0.0).min((n_d - 1) as f32);
    let (h0, d0, p) = (x_h as usize, x_d as usize, x_p as usize);
    let (t_h, t_d, t_p) = (x_h - h0 as f32, x_d - d0 as f32, x_p - p as f32);
    let (h1, d1) = ((h0 + 1).min(n_h - 1), (d0 + 1).min(n_d - 1));
    let (p0, p1) = (p % n_p, (p + 1) % n_p);
    let mut sum = Vec3::ZERO;
    for corner in 0..8_u32 {
        let (h, w_h) = if corner & 1 == 0 {
            (h0, 1.0 - t_h)
        } else {
            (h1, t_h)
        };
        let (d, w_d) = if corner & 2 == 0 {
            (d0, 1.0 - t_d)
        } else {
            (d1, t_d)
        };
        let (p, w_p) = if corner & 4 == 0 {
            (p0, 1.0 - t_p)
        } else {
            (p1, t_p)
        };
        sum += layout.cell(data, h, d, p) * (w_h * w_d * w_p);
    }
    sum
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    lookup(data, lobe.table, half_difference_angles(wi, wo))
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let layout = Layout::read(data, lobe.table);
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    let mut density = DEFENSIVE * wo.z * FRAC_1_PI;
    if cos_h > 0.0 {
        let sin_h = float::sqrt(h.x * h.x + h.y * h.y);
        let theta = float::atan2(sin_h, h.z);
        let n = layout.cells[0];
        let x = float::sqrt((theta / FRAC_PI_2).max(0.0).min(1.0)) * n as f32;
        let cell = (x as usize).min(n - 1);
        let p = layout.probability(data, layout.incidence(wi.z), cell) / cell_solid_angle(n, cell);
        // Jacobian of the reflection at h: d omega_h / d omega_o = 1 / (4 wi . h).
        density += (1.0 - DEFENSIVE) * p / (4.0 * cos_h);
    }
    density
}

/// A direction mirrored about a half vector of the table, or cosine-distributed; `u1` chooses.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let wo = if u1 < DEFENSIVE {
        warp::square_to_cosine_hemisphere(u2)
    } else {
        let u = (u1 - DEFENSIVE) / (1.0 - DEFENSIVE);
        reflect(wi, sample_half_vector(data, lobe.table, wi.z, u, u2))
    };
    let s = BsdfSample::towards(wo, event::REFLECTION | event::GLOSSY);
    weighted!(s, pdf(lobe, data, wi, s.wo), eval(lobe, data, wi, s.wo))
}

/// Directional albedo of the cell of theta_i.
#[inline]
pub fn albedo(lobe: &Lobe, data: &[f32], cos: f32) -> Rgb {
    let layout = Layout::read(data, lobe.table);
    let at = layout.albedos() + 3 * layout.incidence(cos);
    Vec3::new(data[at], data[at + 1], data[at + 2])
}

/// A half vector for an incident cosine.
#[inline]
fn sample_half_vector(data: &[f32], table: u32, cos: f32, u: f32, u2: Vec2) -> Vec3 {
    let layout = Layout::read(data, table);
    let n = layout.cells[0];
    let row = layout.distributions() + layout.incidence(cos) * n;
    // The first cell whose cumulative probability exceeds u.
    let (mut low, mut high) = (0, n - 1);
    while low < high {
        let middle = (low + high) / 2;
        if data[row + middle] > u {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    let (theta_0, theta_1) = cell_edges(n, low);
    // Uniform in solid angle: 1 - cos(theta) = 2 sin^2(theta / 2) is linear in the random number.
    let half_0 = float::sin(0.5 * theta_0);
    let half_1 = float::sin(0.5 * theta_1);
    let half2 = float::lerp(half_0 * half_0, half_1 * half_1, u2.x);
    let sin = 2.0 * float::sqrt(half2 * (1.0 - half2));
    let (sin_phi, cos_phi) = float::sin_cos(TAU * u2.y);
    Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - 2.0 * half2)
}

/// The polar angles between which cell `h` of `n` lies.
#[inline]
pub(super) fn cell_edges(n: usize, h: usize) -> (f32, f32) {
    let (a, b) = (h as f32 / n as f32, (h + 1) as f32 / n as f32);
    (a * a * FRAC_PI_2, b * b * FRAC_PI_2)
}

/// Solid angle of the half vectors of cell `h` of `n`: 2 pi (cos a - cos b) without the cancellation.
#[inline]
pub(super) fn cell_solid_angle(n: usize, h: usize) -> f32 {
    let (a, b) = cell_edges(n, h);
    2.0 * TAU * float::sin(0.5 * (a + b)) * float::sin(0.5 * (b - a))
}
