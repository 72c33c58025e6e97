//! Loops over lanes, compiled once per instruction set.
//!
//! A crate is compiled for the oldest processor that it supports. `multiversioned!` defines each function a second time for
//! processors with AVX-512; the first argument, a [`SimdLevel`], selects the version at run time. Neither version is inlined:
//! function boundaries are what tells the compiler that the arguments do not alias, and so that a loop may be vectorised.

/// The widest vector instructions that a processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimdLevel {
    has_avx512: bool,
}

impl SimdLevel {
    /// Those that the crate is compiled for.
    pub const BASE: SimdLevel = SimdLevel { has_avx512: false };

    /// AVX-512: sixteen lanes of 32 bits.
    ///
    /// # Safety
    /// The processor has the features `avx512f`, `avx512vl`, `avx512bw`, `avx512dq` and `avx512cd`.
    pub unsafe fn avx512() -> SimdLevel {
        SimdLevel {
            has_avx512: cfg!(target_arch = "x86_64"),
        }
    }

    /// Whether AVX-512 may be used.
    #[inline(always)]
    pub fn has_avx512(self) -> bool {
        self.has_avx512
    }
}

/// Defines functions `NAME(simd, ...)` in a version per instruction set, see [`self`].
macro_rules! multiversioned {
    ($(
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident$(<$($generic:ident $(: $bound:path)?),*; $(const $constant:ident: $kind:ty),*>)?(
            $($argument:ident: $type:ty),* $(,)?
        ) $body:block
    )*) => {$(
        $(#[$attribute])*
        $visibility fn $name$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?(
            simd: $crate::simd::SimdLevel,
            $($argument: $type),*
        ) {
            #[inline(always)]
            #[allow(clippy::too_many_arguments)]
            fn body$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?($($argument: $type),*) $body

            #[cfg(target_arch = "x86_64")]
            if simd.has_avx512() {
                #[inline(never)]
                #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd")]
                fn avx512$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?($($argument: $type),*) {
                    body$(::<$($generic,)* $($constant),*>)?($($argument),*)
                }
                // SAFETY: `simd` states that the processor has the features.
                return unsafe { avx512$(::<$($generic,)* $($constant),*>)?($($argument),*) };
            }
            #[inline(never)]
            fn base$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?($($argument: $type),*) {
                body$(::<$($generic,)* $($constant),*>)?($($argument),*)
            }
            let _ = simd;
            base$(::<$($generic,)* $($constant),*>)?($($argument),*)
        }
    )*};
}
pub(crate) use multiversioned;
