//! Measured reflectance, isotropic or anisotropic, tabulated over directions that follow the material.
//!
//! Dupuy and Jakob 2018, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering" (the files of the RGL
//! database). With m the half vector, tables over the incident direction (phi_i, theta_i) hold
//!
//! - the density of visible normals over u_m = (sqrt(2 theta_m / pi), (phi_m + pi) / (2 pi)), phi_m counted from phi_i where the
//!   material is isotropic; inverting its two-dimensional cumulative distribution takes u_m to numbers s in [0, 1)^2;
//! - colours over s, f cos_o = rgb(s) D(u_m) / (4 sigma(u_i)) where the file has its values without the distribution D of normals
//!   and the projected area sigma, else rgb(s);
//! - the luminance over s, by which s is drawn.
//!
//! Tables are bilinear over the square, and so are densities; between incident directions all of them, cumulative ones too, are
//! interpolated linearly. Sampling draws s from the luminance, u_m from s, and mirrors wi about m:
//!
//!   p = p_m(u_m) p_s(s) / (2 pi^2 u_m.x sin theta_m 4 (wi . m)) per solid angle, on the side of the normal.
//!
//! Materials whose incident azimuths cover a half or a quarter are symmetric: directions are mirrored there first. Tables are built
//! on the host by [`super::measured_table`]. Invariants (tests): samples follow the density, values of an independent renderer
//! on the same file, f of the material from which a table is made.

use super::coat_reflection::half_vector;
use super::fresnel::reflect;
use super::measured_grid::{Grid, ONE, Slices, Warped, bilinear};
use super::{BsdfSample, Lobe, event, sample_reflection};
use crate::math::{Rgb, float};
use core::f32::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};
use glam::{Vec2, Vec3};

/// Words of the header, see `Layout`.
pub const HEADER: usize = 12;

/// Incidences of the table of albedos.
pub const INCIDENCES: usize = 32;

/// Smallest Jacobian of u_m, as everywhere.
const MIN_JACOBIAN: f32 = 1e-6;

/// Smallest cosine that a value is divided by.
const MIN_COS: f32 = 1e-7;

/// Where a table has its parts: the numbers of its header, in this order.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) first: usize,
    pub(super) azimuths: usize,
    pub(super) elevations: usize,
    /// Whether the azimuth of m counts from that of wi.
    pub(super) is_isotropic: bool,
    /// How many parts of the circle look alike.
    pub(super) symmetry: u32,
    /// Whether colours are without D and sigma.
    pub(super) is_relative: bool,
    pub(super) normals: Grid,
    pub(super) areas: Grid,
    pub(super) visible: Grid,
    pub(super) values: Grid,
}

impl Layout {
    /// Of the table at a word of `data`.
    #[inline]
    pub(super) fn read(data: &[f32], table: u32) -> Layout {
        let first = table as usize;
        let number = |i: usize| data[first + i] as usize;
        let grid = |at: usize, i: usize| Grid {
            first: at,
            width: number(i),
            height: number(i + 1),
        };
        let (azimuths, elevations) = (number(0), number(1));
        let slices = azimuths * elevations;
        let normals = grid(first + HEADER + azimuths + elevations + 3 * INCIDENCES, 4);
        let areas = grid(normals.first + normals.len(), 6);
        let visible = grid(areas.first + areas.len(), 8);
        let values = grid(visible.first + slices * visible.density_words(), 10);
        let kind = number(2) as u32;
        Layout {
            first,
            azimuths,
            elevations,
            is_isotropic: kind & 1 != 0,
            is_relative: kind & 2 != 0,
            symmetry: number(3) as u32,
            normals,
            areas,
            visible,
            values,
        }
    }

    /// First word of the colours: of each incident direction a grid of red, of green and of blue.
    #[inline]
    pub(super) fn colors(&self) -> usize {
        self.values.first + self.azimuths * self.elevations * self.values.density_words()
    }

    /// The tables around an incident direction.
    #[inline]
    fn slices(&self, data: &[f32], phi: f32, theta: f32) -> Slices {
        let counts = [self.azimuths, self.elevations];
        Slices::around(data, self.first + HEADER, counts, phi, theta)
    }

    /// First word of the albedos.
    #[inline]
    pub(super) fn albedos(&self) -> usize {
        self.first + HEADER + self.azimuths + self.elevations
    }
}

/// The two signs by which directions are mirrored into the measured part of the circle.
#[inline]
fn mirroring(layout: &Layout, wi: Vec3) -> Vec3 {
    let sign = |x: f32| if x < 0.0 { 1.0 } else { -1.0 };
    if layout.symmetry < 2 {
        return Vec3::ONE;
    }
    let y = sign(wi.y);
    let x = if layout.symmetry == 4 { sign(wi.x) } else { y };
    Vec3::new(x, y, 1.0)
}

/// Polar angle of a direction above the surface.
#[inline]
fn elevation(w: Vec3) -> f32 {
    float::atan2(float::sqrt(w.x * w.x + w.y * w.y), w.z)
}

/// Point of the square of a polar angle and an azimuth in any turn.
#[inline]
fn to_square(theta: f32, phi: f32) -> Vec2 {
    let turn = (phi + PI) / TAU;
    Vec2::new(float::sqrt(theta * FRAC_2_PI), turn - float::floor(turn))
}

/// What a pair of directions looks up.
#[derive(Clone, Copy)]
struct Lookup {
    slices: Slices,
    /// Of wi and of the half vector.
    u_i: Vec2,
    u_m: Vec2,
    /// The numbers that lead to the half vector, and its density.
    numbers: Warped,
    /// Solid angle of wo per unit of the square of half vectors.
    jacobian: f32,
}

/// `m` is the half vector; both directions are above the surface and mirrored.
#[inline]
fn look_up(layout: &Layout, data: &[f32], wi: Vec3, m: Vec3) -> Lookup {
    let (theta_i, phi_i) = (elevation(wi), float::atan2(wi.y, wi.x));
    let (theta_m, phi_m) = (elevation(m), float::atan2(m.y, m.x));
    let slices = layout.slices(data, phi_i, theta_i);
    let from = if layout.is_isotropic { phi_i } else { 0.0 };
    let u_m = to_square(theta_m, phi_m - from);
    let sin_m = float::sqrt(m.x * m.x + m.y * m.y);
    let jacobian = (2.0 * PI * PI * u_m.x * sin_m).max(MIN_JACOBIAN) * 4.0 * wi.dot(m);
    Lookup {
        slices,
        u_i: to_square(theta_i, phi_i),
        u_m,
        numbers: layout.visible.invert(data, &slices, u_m),
        jacobian,
    }
}

/// One of the colours of a pair of directions, as the table has it. A function, because shaders cannot call a closure over
/// references three times.
#[inline]
fn channel(layout: &Layout, data: &[f32], at: &Lookup, c: usize) -> f32 {
    let grid = layout.values;
    let first = layout.colors() + c * grid.len();
    bilinear(data, &at.slices, &grid, first, 3 * grid.len(), at.numbers.u)
}

/// A table that does not depend on the incident direction.
#[inline]
fn plain(data: &[f32], grid: &Grid, u: Vec2) -> f32 {
    bilinear(data, &ONE, grid, grid.first, 0, u)
}

/// f cos_o.
#[inline]
fn value(layout: &Layout, data: &[f32], at: &Lookup) -> Rgb {
    let mut color = Vec3::new(
        channel(layout, data, at, 0),
        channel(layout, data, at, 1),
        channel(layout, data, at, 2),
    )
    .max(Vec3::ZERO);
    if layout.is_relative {
        let area = plain(data, &layout.areas, at.u_i).max(f32::MIN_POSITIVE);
        color *= (plain(data, &layout.normals, at.u_m) / (4.0 * area)).max(0.0);
    }
    color
}

/// Density per solid angle.
#[inline]
fn density(layout: &Layout, data: &[f32], at: &Lookup) -> f32 {
    let grid = layout.values;
    let words = grid.density_words();
    let by_luminance = bilinear(data, &at.slices, &grid, grid.first, words, at.numbers.u);
    (at.numbers.pdf * by_luminance * grid.per_square() / at.jacobian).max(0.0)
}

/// The look-up of a pair of directions, and whether anything is reflected.
#[inline]
fn look_up_pair(layout: &Layout, data: &[f32], wi: Vec3, wo: Vec3) -> (Lookup, bool) {
    let signs = mirroring(layout, wi);
    let (wi, wo) = (wi * signs, wo * signs);
    let m = half_vector(wi, wo);
    let is_lit = wi.z > 0.0 && wo.z > 0.0 && wi.dot(m) > 0.0;
    (look_up(layout, data, wi, m), is_lit)
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    let layout = Layout::read(data, lobe.table);
    let (at, is_lit) = look_up_pair(&layout, data, wi, wo);
    if !is_lit {
        return Vec3::ZERO;
    }
    value(&layout, data, &at) / wo.z.max(MIN_COS)
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let layout = Layout::read(data, lobe.table);
    let (at, is_lit) = look_up_pair(&layout, data, wi, wo);
    if !is_lit {
        return 0.0;
    }
    density(&layout, data, &at)
}

/// The mirror image of wi about a half vector of the tables; `u1` is not used.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, _u1: f32, u2: Vec2) -> BsdfSample {
    sample_reflection(
        wi,
        || direction(lobe, data, wi, u2),
        |wo| (eval(lobe, data, wi, wo), pdf(lobe, data, wi, wo)),
    )
}

/// The direction of [`sample`], which may lie below the horizon.
#[inline]
fn direction(lobe: &Lobe, data: &[f32], wi: Vec3, u2: Vec2) -> BsdfSample {
    let layout = Layout::read(data, lobe.table);
    let signs = mirroring(&layout, wi);
    let inner = wi * signs;
    let phi_i = float::atan2(inner.y, inner.x);
    let slices = layout.slices(data, phi_i, elevation(inner));
    let numbers = layout.values.sample(data, &slices, u2);
    let m = half_vector_of(&layout, data, &slices, phi_i, numbers.u);
    let wo = reflect(inner, m).normalize() * signs;
    // Normals that face away reflect nothing.
    let is_seen = inner.dot(m) > 0.0;
    BsdfSample::towards(
        if is_seen { wo } else { -Vec3::Z },
        event::REFLECTION | event::GLOSSY,
    )
}

/// The half vector of numbers.
#[inline]
fn half_vector_of(
    layout: &Layout,
    data: &[f32],
    slices: &Slices,
    phi_i: f32,
    numbers: Vec2,
) -> Vec3 {
    let u_m = layout.visible.sample(data, slices, numbers).u;
    let theta = u_m.x * u_m.x * FRAC_PI_2;
    let from = if layout.is_isotropic { phi_i } else { 0.0 };
    let (sin_phi, cos_phi) = float::sin_cos(u_m.y * TAU - PI + from);
    let (sin, cos) = float::sin_cos(theta);
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// The half vector whose colour a table holds at some numbers, for an incident direction: for those who make tables.
#[cfg(not(target_arch = "spirv"))]
pub fn half_vector_at(table: &[f32], phi_i: f32, theta_i: f32, numbers: Vec2) -> Vec3 {
    let layout = Layout::read(table, 0);
    let slices = layout.slices(table, phi_i, theta_i);
    half_vector_of(&layout, table, &slices, phi_i, numbers)
}

/// Directional albedo at an incident cosine, averaged over azimuths.
#[inline]
pub fn albedo(lobe: &Lobe, data: &[f32], cos: f32) -> Rgb {
    let layout = Layout::read(data, lobe.table);
    let cos = cos.max(0.0).min(1.0);
    let theta = float::atan2(float::safe_sqrt(1.0 - cos * cos), cos);
    let incidence = ((theta * FRAC_2_PI * INCIDENCES as f32) as usize).min(INCIDENCES - 1);
    let at = layout.albedos() + 3 * incidence;
    Vec3::new(data[at], data[at + 1], data[at + 2])
}
