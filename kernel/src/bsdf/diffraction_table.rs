//! Tables of the diffraction by a rough surface's finer scale, for [`super::diffracting_conductor`].
//!
//! The finer scale has the K-correlation power spectrum of Harvey-Shack theory, per area of spatial frequency `f` and
//! normalised: `S(f) = b^2 (c - 1) / (2 pi) (1 + b^2 f^2)^(-(c + 1) / 2)`, `c > 1` (its integral over the plane is 1). Two
//! things follow from it and have no closed form:
//!
//! - `rho(theta)`: the share of the spectrum that scatters into real directions at incidence theta, the integral of
//!   `S(|o_xy + i_xy| / lambda) / lambda^2` over the unit disk of `o_xy`. In polar coordinates about the mirror direction
//!   the radius integrates to `1 - (1 + (b r / lambda)^2)^((1 - c) / 2)`; the angle is a sum.
//! - the spectrum convolved with the facets' normals, `S~(theta_h, u) = integral of D(m) m.z S(2 u sin(gamma) / b) dm`, gamma
//!   the angle between `m` and the half vector, `u = b cos(theta_d) / lambda`: what a facet scatters depends on the
//!   frequency in its own plane, `|i + o| sin(gamma) / lambda`, `|i + o| = 2 cos(theta_d)`.
//!
//! Layout in `data`: [`HEADER`] words (three wavelengths, sigma, b, c, the largest u, the alpha), then
//! 3 x [`COSINES`] words of rho, as many of the energy limit of [`super::diffracting_conductor`], then [`ROWS`] x [`COLUMNS`] words of `ln S~` with `u = u_max (row / (ROWS - 1))^2` and
//! `theta_h = pi/2 (column / (COLUMNS - 1))^3`. Lengths are in micrometres. Filling sums in f64, on the host when a scene
//! is built. Invariants (tests): rho is 1 for a coarse scale at normal incidence; S~ tends to S for smooth facets and
//! to D for a coarse finer scale; its mass stays 1.

use crate::math::float::{lerp, ln, pow, sqrt};
use core::f32::consts::FRAC_PI_2;

/// Words before the tables.
pub const HEADER: usize = 8;
/// Entries of rho per wavelength, over the cosine.
pub const COSINES: usize = 32;
/// Entries of the convolved spectrum over u.
pub const ROWS: usize = 24;
/// Entries of the convolved spectrum over theta_h.
pub const COLUMNS: usize = 96;
/// First word of the energy limits.
const LIMITS: usize = HEADER + 3 * COSINES;
/// First word of the convolved spectrum.
const SPECTRUM: usize = LIMITS + 3 * COSINES;
/// Words of a table.
pub const WORDS: usize = SPECTRUM + ROWS * COLUMNS;

/// The finer scale of the surface; lengths in micrometres.
#[derive(Clone, Copy, Debug)]
pub struct FineScale {
    /// Wavelengths of the three channels.
    pub wavelengths: [f32; 3],
    /// Standard deviation of the heights.
    pub sigma: f32,
    /// Correlation length.
    pub b: f32,
    /// Exponent of the spectrum's decay, above 1.
    pub c: f32,
}

/// The finer scale that a table was made for.
#[inline]
pub fn fine_scale(data: &[f32], table: u32) -> FineScale {
    let t = table as usize;
    FineScale {
        wavelengths: [data[t], data[t + 1], data[t + 2]],
        sigma: data[t + 3],
        b: data[t + 4],
        c: data[t + 5],
    }
}

/// rho of one channel at a cosine.
#[inline]
pub fn scattered_share(data: &[f32], table: u32, channel: usize, cos: f32) -> f32 {
    over_cosine(data, table as usize + HEADER + channel * COSINES, cos)
}

/// Share of the diffraction of one channel that conserves energy at a cosine.
#[inline]
pub fn energy_limit(data: &[f32], table: u32, channel: usize, cos: f32) -> f32 {
    over_cosine(data, table as usize + LIMITS + channel * COSINES, cos)
}

#[inline]
fn over_cosine(data: &[f32], first: usize, cos: f32) -> f32 {
    let x = cos.max(0.0).min(1.0) * (COSINES - 1) as f32;
    let i = (x as usize).min(COSINES - 2);
    lerp(data[first + i], data[first + i + 1], x - i as f32)
}

/// Writes the energy limit of one channel at `k / (COSINES - 1)`.
#[cfg(not(target_arch = "spirv"))]
pub(super) fn set_energy_limit(data: &mut [f32], channel: usize, k: usize, limit: f32) {
    data[LIMITS + channel * COSINES + k] = limit;
}

/// `ln S~` at a half vector's polar angle, `u = b cos(theta_d) / lambda`.
#[inline]
pub fn ln_spectrum(data: &[f32], table: u32, theta_h: f32, u: f32) -> f32 {
    let row = sqrt((u / data[table as usize + 6]).max(0.0).min(1.0)) * (ROWS - 1) as f32;
    let column = pow((theta_h / FRAC_PI_2).max(0.0).min(1.0), 1.0 / 3.0) * (COLUMNS - 1) as f32;
    let i = (row as usize).min(ROWS - 2);
    let j = (column as usize).min(COLUMNS - 2);
    let at = table as usize + SPECTRUM + i * COLUMNS + j;
    let (x, y) = (column - j as f32, row - i as f32);
    lerp(
        lerp(data[at], data[at + 1], x),
        lerp(data[at + COLUMNS], data[at + COLUMNS + 1], x),
        y,
    )
}

/// Fills a table of [`WORDS`] words for facets of width `alpha` and exponent `exponent`, all but the energy limits, which
/// are left at one.
#[cfg(not(target_arch = "spirv"))]
pub(super) fn fill_spectrum(scale: &FineScale, alpha: f32, exponent: f32, out: &mut [f32]) {
    let shortest = scale.wavelengths[0]
        .min(scale.wavelengths[1])
        .min(scale.wavelengths[2]);
    let u_max = scale.b / shortest;
    out[..3].copy_from_slice(&scale.wavelengths);
    out[3] = scale.sigma;
    out[4] = scale.b;
    out[5] = scale.c;
    out[6] = u_max;
    out[7] = alpha;
    out[LIMITS..SPECTRUM].fill(1.0);
    for channel in 0..3 {
        for k in 0..COSINES {
            let cos = k as f64 / (COSINES - 1) as f64;
            out[HEADER + channel * COSINES + k] =
                rho(scale, f64::from(scale.wavelengths[channel]), cos) as f32;
        }
    }
    let facets = Facets::new(f64::from(alpha), f64::from(exponent));
    for i in 0..ROWS {
        let s = i as f64 / (ROWS - 1) as f64;
        for j in 0..COLUMNS {
            let t = j as f64 / (COLUMNS - 1) as f64;
            let theta = core::f64::consts::FRAC_PI_2 * t * t * t;
            let value = convolved(scale, &facets, theta, f64::from(u_max) * s * s);
            out[SPECTRUM + i * COLUMNS + j] = ln(value.max(1e-30) as f32);
        }
    }
}

/// rho of a wavelength at a cosine.
#[cfg(not(target_arch = "spirv"))]
pub fn rho(scale: &FineScale, wavelength: f64, cos: f64) -> f64 {
    const NODES: u32 = 512;
    let sin2 = (1.0 - cos * cos).max(0.0);
    let b = f64::from(scale.b) / wavelength;
    let decay = 0.5 * (1.0 - f64::from(scale.c));
    let mut sum = 0.0;
    for k in 0..NODES {
        let phi = core::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(NODES);
        // From the mirror direction, sin(theta) away from the centre, to the edge of the unit disk.
        let (s, c) = (libm::sin(phi), libm::cos(phi));
        let r = libm::sqrt((1.0 - sin2 * s * s).max(0.0)) - libm::sqrt(sin2) * c;
        sum += 1.0 - libm::pow(1.0 + b * b * r * r, decay);
    }
    sum / f64::from(NODES)
}

/// The exponential power distribution in f64.
#[cfg(not(target_arch = "spirv"))]
struct Facets {
    beta: f64,
    p: f64,
    norm: f64,
}

#[cfg(not(target_arch = "spirv"))]
impl Facets {
    fn new(beta: f64, p: f64) -> Facets {
        let beta = beta.max(f64::from(super::microfacet::ALPHA_MIN));
        let p = p.max(0.2).min(5.0);
        Facets {
            beta,
            p,
            norm: 1.0 / (core::f64::consts::PI * beta * beta * libm::tgamma(1.0 + 1.0 / p)),
        }
    }

    /// `D(m) m.z sin(theta_m)`.
    fn ring(&self, theta: f64) -> f64 {
        let (s, c) = (libm::sin(theta), libm::cos(theta));
        if c <= 1e-9 {
            return 0.0;
        }
        let t = s / (c * self.beta);
        self.norm * libm::exp(-libm::pow(t * t, self.p)) * s / (c * c * c)
    }
}

/// The spectrum convolved with the normals of the facets.
#[cfg(not(target_arch = "spirv"))]
fn convolved(scale: &FineScale, facets: &Facets, theta_h: f64, u: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    let (b, c) = (f64::from(scale.b), f64::from(scale.c));
    let peak = b * b * (c - 1.0) / (2.0 * PI);
    // Half the width of the spectrum as an angle.
    let width = 0.5 / u.max(1e-6);
    let (sin_h, cos_h) = (libm::sin(theta_h), libm::cos(theta_h));
    let ring = |theta: f64| {
        let (s, c_m) = (libm::sin(theta), libm::cos(theta));
        let around = |phi: f64| {
            let cos = cos_h * c_m + sin_h * s * libm::cos(phi);
            if cos <= 0.0 {
                return 0.0;
            }
            // sin^2(gamma) from the chords, which do not cancel where gamma is small.
            let (d, e) = (libm::sin(0.5 * (theta - theta_h)), libm::sin(0.5 * phi));
            let half2 = d * d + sin_h * s * e * e;
            let sin2 = 4.0 * half2 * (1.0 - half2);
            libm::pow(1.0 + 4.0 * u * u * sin2, -0.5 * (c + 1.0))
        };
        let step = (width / libm::sqrt((sin_h * s).max(1e-12))).min(PI);
        let mut edges = Edges::new(0.0, PI);
        edges.spread(0.0, step, 0.5, 12);
        2.0 * edges.integrate(around) * facets.ring(theta)
    };
    let mut edges = Edges::new(0.0, FRAC_PI_2);
    edges.spread(0.0, facets.beta, 0.01, 20);
    edges.spread(theta_h, width.min(1.0), 0.25, 12);
    peak * edges.integrate(ring)
}

/// Edges of the intervals of a sum, finer where the integrand is steep.
#[cfg(not(target_arch = "spirv"))]
struct Edges {
    at: [f64; 64],
    count: usize,
}

#[cfg(not(target_arch = "spirv"))]
impl Edges {
    fn new(low: f64, high: f64) -> Edges {
        let mut at = [0.0; 64];
        at[0] = low;
        at[1] = high;
        Edges { at, count: 2 }
    }

    /// Adds `centre` and edges around it at distances that double, from `width * first`.
    fn spread(&mut self, centre: f64, width: f64, first: f64, steps: u32) {
        self.add(centre);
        let mut distance = width * first;
        for _ in 0..steps {
            self.add(centre - distance);
            self.add(centre + distance);
            distance *= 2.0;
        }
    }

    /// Inserts an edge in order, if it lies inside.
    fn add(&mut self, x: f64) {
        if x <= self.at[0] || x >= self.at[self.count - 1] || self.count == self.at.len() {
            return;
        }
        let mut i = self.count;
        while self.at[i - 1] > x {
            self.at[i] = self.at[i - 1];
            i -= 1;
        }
        self.at[i] = x;
        self.count += 1;
    }

    /// Three Gauss points per interval.
    fn integrate(&self, f: impl Fn(f64) -> f64) -> f64 {
        let node = libm::sqrt(0.6);
        let mut sum = 0.0;
        for i in 1..self.count {
            let half = 0.5 * (self.at[i] - self.at[i - 1]);
            let middle = 0.5 * (self.at[i] + self.at[i - 1]);
            let outer = f(middle - node * half) + f(middle + node * half);
            sum += half * (5.0 * outer + 8.0 * f(middle)) / 9.0;
        }
        sum
    }
}
