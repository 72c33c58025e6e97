//! Exponential power distribution of slopes: `D(m) = exp(-t^p) / (pi ax ay Gamma(1 + 1/p) z^4)`, `t` the squared slope in
//! units of alpha, `t = (x^2/ax^2 + y^2/ay^2) / z^2`.
//!
//! Holzschuch and Pacanowski 2015, "A Physically Accurate Reflectance Model Combining Reflection and Diffraction"
//! (Inria RR-8807), whose beta is the alpha and whose p the exponent here; anisotropic by stretching. `p = 1` is
//! Beckmann, below 1 the peak is sharp and the tail long, above 1 the slopes fill a disk. `p` is in [0.2, 5], clamped.
//!
//! Smith's projected area needs the one-dimensional marginal `P2` of the slopes, which has no closed form:
//! `A(w) = spread (a + g(a))`, `a = cot(theta) / alpha`, `g(a)` the integral of `(r - a) P2(r)` over `r > a`. With
//! `g(0) = Gamma(1.5 / p) / (pi Gamma(1 / p))`, the ratio `g(a) / g(0)` is a function of `a / g(0)` and of `p` that falls
//! from 1 to 0; it is held as a product of Chebyshev polynomials. Error of the area: see [`AREA_ERROR`].
//!
//! `t^p` has a Gamma distribution of shape `1/p`, so slopes are sampled by inverting the incomplete Gamma function.

use crate::math::entry;
use crate::math::float::{
    exp, gamma_1p, inverse_gamma_distribution, ln, pow, safe_sqrt, sin_cos_2pi, sqr,
};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// Smallest exponent.
pub const EXPONENT_MIN: f32 = 0.2;
/// Largest exponent.
pub const EXPONENT_MAX: f32 = 5.0;

/// The exponent within the domain.
#[inline]
pub fn clamp_exponent(p: f32) -> f32 {
    p.max(EXPONENT_MIN).min(EXPONENT_MAX)
}

/// `D(m)` for `m.z > 0`.
#[inline]
pub fn distribution(alpha: Vec2, exponent: f32, m: Vec3) -> f32 {
    let p = clamp_exponent(exponent);
    let z2 = m.z * m.z;
    let slope2 = sqr(m.x / alpha.x) + sqr(m.y / alpha.y);
    // Beyond 80 the exponential is zero next to any other normal: slope2 / z2 at most 80^(1 / p) < 4e9.
    if slope2 >= 4e9 * z2 {
        return 0.0;
    }
    let e = pow(slope2 / z2, p);
    if e >= 80.0 {
        return 0.0;
    }
    exp(-e) / (PI * alpha.x * alpha.y * gamma_1p(1.0 / p) * z2 * z2)
}

/// The slope, in units of alpha, at the quantile `u`.
#[inline]
pub fn sample_radius(exponent: f32, u: f32) -> f32 {
    let shape = 1.0 / clamp_exponent(exponent);
    safe_sqrt(inverse_gamma_distribution(shape, u))
}

/// A slope in units of alpha with density `exp(-s^(2 p)) / (pi Gamma(1 + 1/p))`.
#[inline]
pub fn sample_slope(exponent: f32, u: Vec2) -> Vec2 {
    let (sin_phi, cos_phi) = sin_cos_2pi(u.x);
    let r = sample_radius(exponent, u.y);
    Vec2::new(r * cos_phi, r * sin_phi)
}

/// `-2 t / (d ln P / dt)`: `beta^(2 p) t^(2 - 2 p) / p` (`inverse` is `1 / beta^2` along the azimuth, `t2` the squared
/// slope). At `t = 0` it vanishes for `p < 1` and has a pole for `p > 1`; both are cut off at a slope of `beta / 1000`. At
/// least 1e-28, which keeps derivatives finite up to slopes of 1e9.
#[inline]
pub fn local_alpha_squared(inverse: f32, t2: f32, exponent: f32) -> f32 {
    let p = clamp_exponent(exponent);
    let s2 = (t2 * inverse).max(1e-6);
    (pow(s2, 1.0 - p) / (p * inverse)).max(1e-28)
}

/// Largest relative error of [`projected_area`] (against quadrature in f64).
pub const AREA_ERROR: f32 = 2.5e-4;

/// Projected area for a cosine and `spread = alpha sin(theta)`.
#[inline]
pub fn projected_area(cos: f32, spread: f32, exponent: f32) -> f32 {
    let p = clamp_exponent(exponent);
    // E|slope| / 2 = Gamma(1.5 / p) / (pi Gamma(1 / p)), Gamma(x) = Gamma(1 + x) / x.
    let at_zero = gamma_1p(1.5 / p) / (1.5 * PI * gamma_1p(1.0 / p));
    let grazing = spread * at_zero;
    // Nothing is masked this far from the horizon; also keeps the ratio finite.
    if cos >= 400.0 * grazing {
        return cos;
    }
    cos + grazing * masked_share(cos / grazing, p).max(0.0).min(1.0)
}

/// `g(a) / g(0)` at `y = a / g(0)`: a product of Chebyshev polynomials in `z = y / (y + 4)` and `ln p`, both mapped to
/// [-1, 1], interpolating values by quadrature.
#[cfg_attr(not(target_arch = "spirv"), inline)]
fn masked_share(y: f32, p: f32) -> f32 {
    const IN_Y: usize = 20;
    const IN_P: usize = 8;
    const C: [f32; IN_Y * IN_P] = [
        0.3265960, -0.0287866, 0.0112496, -0.0027542, 0.0004737, -0.0000677, 0.0000070, 0.0000009,
        -0.4968299, 0.0083309, -0.0021279, -0.0001655, 0.0002838, -0.0000984, 0.0000217,
        -0.0000036, 0.1952915, 0.0440898, -0.0165686, 0.0036640, -0.0004541, 0.0000032, 0.0000183,
        -0.0000076, -0.0060026, -0.0147458, 0.0028478, 0.0008946, -0.0006429, 0.0001563,
        -0.0000150, -0.0000026, -0.0268239, -0.0206145, 0.0065216, -0.0006964, -0.0002687,
        0.0001582, -0.0000422, 0.0000057, 0.0041672, 0.0086646, -0.0001395, -0.0013809, 0.0004607,
        0.0000047, -0.0000422, 0.0000145, 0.0065737, 0.0073713, -0.0013290, -0.0005362, 0.0004070,
        -0.0001106, -0.0000019, 0.0000123, -0.0018961, -0.0031422, -0.0010122, 0.0008401,
        0.0000045, -0.0001435, 0.0000460, -0.0000020, -0.0023425, -0.0029627, 0.0000129, 0.0005269,
        -0.0001856, -0.0000228, 0.0000440, -0.0000167, 0.0007787, 0.0012974, 0.0006561, -0.0001928,
        -0.0001991, 0.0000984, 0.0000104, -0.0000185, 0.0010410, 0.0013792, 0.0002188, -0.0002860,
        -0.0000069, 0.0000750, -0.0000275, -0.0000019, -0.0003017, -0.0005753, -0.0003473,
        -0.0000222, 0.0001307, -0.0000023, -0.0000383, 0.0000144, -0.0005104, -0.0007423,
        -0.0001884, 0.0001140, 0.0000675, -0.0000449, -0.0000096, 0.0000152, 0.0001119, 0.0002318,
        0.0001873, 0.0000547, -0.0000468, -0.0000300, 0.0000198, 0.0000038, 0.0002692, 0.0004129,
        0.0001421, -0.0000437, -0.0000547, 0.0000085, 0.0000207, -0.0000084, -0.0000285,
        -0.0000748, -0.0000925, -0.0000522, 0.0000059, 0.0000226, 0.0000015, -0.0000102,
        -0.0001415, -0.0002228, -0.0000929, 0.0000138, 0.0000343, 0.0000041, -0.0000123,
        -0.0000026, -0.0000089, 0.0000047, 0.0000398, 0.0000433, 0.0000121, -0.0000116, -0.0000083,
        0.0000042, 0.0000611, 0.0000991, 0.0000447, -0.0000024, -0.0000163, -0.0000045, 0.0000046,
        0.0000046, 0.0000226, 0.0000237, -0.0000178, -0.0000362, -0.0000191, 0.0000053, 0.0000090,
        0.0000019,
    ];
    let u = 2.0 * y / (y + 4.0) - 1.0;
    // ln 5 = 1.609438.
    let v = ln(p) * (1.0 / 1.609_438);
    // Clenshaw's recurrence, inside in p and outside in y.
    let (mut b1, mut b2) = (0.0, 0.0);
    let mut row = IN_Y;
    while row > 0 {
        row -= 1;
        let (mut a1, mut a2) = (0.0, 0.0);
        let mut column = IN_P;
        while column > 1 {
            column -= 1;
            let a0 = entry(C, row * IN_P + column) + 2.0 * v * a1 - a2;
            a2 = a1;
            a1 = a0;
        }
        let coefficient = entry(C, row * IN_P) + v * a1 - a2;
        if row > 0 {
            let b0 = coefficient + 2.0 * u * b1 - b2;
            b2 = b1;
            b1 = b0;
        } else {
            b1 = coefficient + u * b1 - b2;
        }
    }
    b1
}
