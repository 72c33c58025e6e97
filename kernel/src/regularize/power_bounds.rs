//! Bounds of reflection and refraction at microfacets of the exponential power distribution, for every exponent.
//!
//! With `x = tan^2(theta)` of the half vector, isotropic roughness alpha and exponent p,
//!
//! ```text
//! D / D(n) = (1 + x)^2 exp(-(x / alpha^2)^p).
//! ```
//!
//! For p = 1 this is Beckmann's distribution, whose peak leaves the normal above alpha = 1/sqrt(2); for p > 1 it always does,
//! and for p < 1 a second peak grows in the tail. Two grazing directions of nearly opposite azimuth have any half vector between
//! the normal and the horizon, so the bound of reflection is the largest D times that of masking, `1 / (4 A^2)` with the
//! projected area A at grazing angles, which is proportional to alpha. In units `y = x / alpha^2`:
//!
//! ```text
//! rho(alpha) = U max_y (1 / alpha^2 + y)^2 exp(-y^p),   U = D(n) / (4 A^2) at alpha = 1,
//! ```
//!
//! which falls in alpha and is inverted in closed form but for a minimum over one variable:
//!
//! ```text
//! rho(alpha) <= tau   if and only if   1 / alpha^2 <= min_y ( sqrt(tau / U) exp(y^p / 2) - y ).
//! ```
//!
//! The paper has no bound for this distribution (Jendersie and Grosch 2019, section 3.2). Anisotropic lobes take the larger
//! roughness for the peak and the smaller one for masking. Invariant (tests): an adversarial search over directions stays
//! below, and comes close, for all exponents.

use super::bounds::ALPHA_MAX;
use crate::bsdf::microfacet::exponential_power::clamp_exponent;
use crate::math::float::{exp, pow, sqrt};

/// Points of the coarse search, spaced evenly in the logarithm of y.
const POINTS: u32 = 48;

/// Steps of the refinement around the best of them.
const STEPS: u32 = 24;

/// Beyond this y^p nothing is left of the exponential.
const FAR: f32 = 80.0;

/// The least value of `f` over y > 0.
#[inline]
fn least(exponent: f32, f: impl Fn(f32) -> f32) -> f32 {
    // y = e^u.
    let (first, last) = (-9.0, 4.382_027 / exponent);
    let at = |u: f32| f(exp(u));
    let step = (last - first) / POINTS as f32;
    let mut best = first;
    let mut value = at(first);
    for i in 1..=POINTS {
        let u = first + step * i as f32;
        let next = at(u);
        if next < value {
            value = next;
            best = u;
        }
    }
    let (mut low, mut high) = (best - step, best + step);
    for _ in 0..STEPS {
        let third = (high - low) / 3.0;
        let (a, b) = (low + third, high - third);
        if at(a) < at(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let refined = at(0.5 * (low + high));
    if refined < value { refined } else { value }
}

/// The largest D over that at the normal.
pub fn peak_excess(alpha: f32, exponent: f32) -> f32 {
    let p = clamp_exponent(exponent);
    let a2 = alpha * alpha;
    let negative = |y: f32| {
        let e = pow(y, p);
        if e >= FAR {
            return 0.0;
        }
        let t = 1.0 + a2 * y;
        -t * t * exp(-e)
    };
    (-least(p, negative)).max(1.0)
}

/// The roughness at which `unit` of the module's U keeps the bound at `tau`, at most [`ALPHA_MAX`], where no roughness will do.
pub fn alpha_hat(unit: f32, exponent: f32, tau: f32) -> f32 {
    let p = clamp_exponent(exponent);
    let s = sqrt((tau.max(1e-12) / unit.max(1e-30)).min(1e36));
    let inverse = least(p, |y| {
        let e = 0.5 * pow(y, p);
        if 2.0 * e >= FAR {
            f32::MAX
        } else {
            s * exp(e) - y
        }
    });
    // The difference of large numbers has lost some digits, on the safe side.
    let inverse = inverse.min(s) * 0.999;
    if inverse > 1.0 {
        1.0 / sqrt(inverse)
    } else {
        ALPHA_MAX
    }
}
