//! The float functions of the kernel: the only module that knows of std, libm and SPIR-V.
//!
//! - [`basic`]: what is rounded exactly everywhere (roots, rounding to integers) comes from std on hosts that enable it and
//!   from libm elsewhere, whose names rust-gpu replaces by the shader's own instructions (a root of a device may be off by
//!   2.5 ulp);
//! - [`elementary`]: exponential, logarithm, power and trigonometric functions of our own, the same to the bit on hosts and in
//!   shaders;
//! - [`special`]: `exp_m1`, `ln_1p`, the error function, the Gamma distribution.
//!
//! No function panics; each returns a finite value for finite input inside its domain.

pub mod basic;
pub mod elementary;
pub mod special;

pub use basic::{
    abs, ceil, floor, is_finite, lerp, safe_sqrt, sqr, sqrt, to_index, to_integer, with_sign_of,
};
pub use elementary::{
    atan, atan2, cos, exp, ln, pow, sin, sin_cos, sin_cos_2pi, sin_cos_octant, tan,
};
pub use special::{erf, erf_inv, erfc_scaled, exp_m1, gamma_1p, inverse_gamma_distribution, ln_1p};
