//! The one place where float functions are chosen: std on hosts that enable it, libm elsewhere.
//!
//! rust-gpu replaces libm's names by the shader's own instructions, so the libm branch serves both plain `no_std`
//! targets and shaders. No function here panics; each returns a finite value for finite input inside its domain.

macro_rules! unary {
    ($($(#[$doc:meta])* $name:ident => $libm:ident;)*) => {$(
        $(#[$doc])*
        #[inline]
        pub fn $name(x: f32) -> f32 {
            #[cfg(feature = "std")]
            {
                x.$name()
            }
            #[cfg(not(feature = "std"))]
            {
                libm::$libm(x)
            }
        }
    )*};
}

unary! {
    /// Square root; the caller keeps `x >= 0` (see [`safe_sqrt`]).
    sqrt => sqrtf;
    /// Sine of radians.
    sin => sinf;
    /// Cosine of radians.
    cos => cosf;
    /// Tangent of radians.
    tan => tanf;
    /// Arc tangent.
    atan => atanf;
    /// Exponential.
    exp => expf;
    /// Natural logarithm; the caller keeps `x > 0`.
    ln => logf;
    /// Largest integer not above `x`.
    floor => floorf;
    /// Smallest integer not below `x`.
    ceil => ceilf;
    /// Absolute value.
    abs => fabsf;
}

/// Arc tangent of `y / x` in the right quadrant.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    #[cfg(feature = "std")]
    {
        y.atan2(x)
    }
    #[cfg(not(feature = "std"))]
    {
        libm::atan2f(y, x)
    }
}

/// `x` to the power `y` for `x >= 0`; a negative base is taken as zero, because shaders leave it undefined.
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    #[cfg(feature = "std")]
    {
        x.powf(y)
    }
    #[cfg(not(feature = "std"))]
    {
        libm::powf(x, y)
    }
}

/// Square.
#[inline]
pub fn sqr(x: f32) -> f32 {
    x * x
}

/// Square root of the positive part.
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    sqrt(if x > 0.0 { x } else { 0.0 })
}

/// `sin` and `cos` together.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    (sin(x), cos(x))
}

/// Fused name for `a + t (b - a)`.
#[inline]
pub fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// Magnitude of `x` with the sign of `s`; the sign of zero counts as positive.
#[inline]
pub fn with_sign_of(x: f32, s: f32) -> f32 {
    if s < 0.0 { -abs(x) } else { abs(x) }
}

/// Whether `x` is neither an infinity nor a NaN.
#[inline]
pub fn is_finite(x: f32) -> bool {
    abs(x) <= f32::MAX
}
