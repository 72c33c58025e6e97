//! Roots, rounding to integers and small helpers: the switch between std, libm and the instructions of a shader.

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
    /// Smallest integer not below `x`.
    ceil => ceilf;
    /// Absolute value.
    abs => fabsf;
}

/// Largest integer not above `x`.
#[inline]
pub fn floor(x: f32) -> f32 {
    // Processors of the first x86-64 level have no instruction for it, and a call costs more than this.
    #[cfg(all(target_arch = "x86_64", not(target_feature = "sse4.1")))]
    {
        // From 2^23 on every float is whole.
        let is_whole = !(abs(x) < 8_388_608.0);
        let inside = if is_whole { 0.0 } else { x };
        // SAFETY: `inside` is not a NaN and within the range of the integer.
        let whole = unsafe { inside.to_int_unchecked::<i32>() } as f32;
        let below = if whole > x { whole - 1.0 } else { whole };
        if is_whole { x } else { below }
    }
    #[cfg(not(all(target_arch = "x86_64", not(target_feature = "sse4.1"))))]
    {
        #[cfg(feature = "std")]
        {
            x.floor()
        }
        #[cfg(not(feature = "std"))]
        {
            libm::floorf(x)
        }
    }
}

/// The whole part of `x` from 0 to 2^31 - 128; nearer ends for numbers beyond, 0 for a NaN.
///
/// As the compiler's own conversion within that range, but without what that one does beyond, which vectors lack.
#[inline]
pub fn to_index(x: f32) -> u32 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 2_147_483_520.0 {
        x
    } else {
        2_147_483_520.0
    };
    #[cfg(target_arch = "spirv")]
    {
        x as u32
    }
    #[cfg(not(target_arch = "spirv"))]
    {
        // SAFETY: `x` is not a NaN and has been brought into the range of the integer.
        unsafe { x.to_int_unchecked::<i32>() as u32 }
    }
}

/// The whole number `x` within 2^30 from zero, nearer ends for numbers beyond, the lower one for a NaN. See [`to_index`].
#[inline]
pub fn to_integer(x: f32) -> i32 {
    const END: f32 = 1_073_741_824.0;
    let x = if x > -END { x } else { -END };
    let x = if x < END { x } else { END };
    #[cfg(target_arch = "spirv")]
    {
        x as i32
    }
    #[cfg(not(target_arch = "spirv"))]
    {
        // SAFETY: `x` is not a NaN and has been brought into the range of the integer.
        unsafe { x.to_int_unchecked::<i32>() }
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
