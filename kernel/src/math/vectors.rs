//! Loops over lanes, compiled for what the processor has.
//!
//! A crate is compiled for the oldest processor that it shall run on. Functions of `over_lanes!` are compiled once more for
//! processors with vectors of sixteen lanes, and take as their first argument which of the two is called. They are not
//! inlined: that their arguments do not overlap is what lets a compiler make vectors of their loops.
//!
//! Hosts only: a shader's lanes are the device's.

/// Which vectors a processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vectors {
    has_avx512: bool,
}

impl Vectors {
    /// Those that the crate is compiled for.
    pub const BASE: Vectors = Vectors { has_avx512: false };

    /// Sixteen lanes.
    ///
    /// # Safety
    /// The processor has the features `avx512f`, `avx512vl`, `avx512bw`, `avx512dq` and `avx512cd`.
    pub unsafe fn avx512() -> Vectors {
        Vectors {
            has_avx512: cfg!(target_arch = "x86_64"),
        }
    }

    /// Whether there are sixteen lanes.
    #[inline(always)]
    pub fn has_avx512(self) -> bool {
        self.has_avx512
    }
}

/// Defines functions `NAME(vectors, ...)` of loops over lanes, see [`self`].
macro_rules! over_lanes {
    ($(
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident$(<$($generic:ident $(: $bound:path)?),*; $(const $constant:ident: $kind:ty),*>)?(
            $($argument:ident: $type:ty),* $(,)?
        ) $body:block
    )*) => {$(
        $(#[$attribute])*
        $visibility fn $name$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?(
            vectors: $crate::math::vectors::Vectors,
            $($argument: $type),*
        ) {
            #[inline(always)]
            #[allow(clippy::too_many_arguments)]
            fn here$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?($($argument: $type),*) $body

            #[cfg(target_arch = "x86_64")]
            if vectors.has_avx512() {
                #[inline(never)]
                #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd")]
                fn avx512$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?($($argument: $type),*) {
                    here$(::<$($generic,)* $($constant),*>)?($($argument),*)
                }
                // SAFETY: `vectors` says that the processor has the features.
                return unsafe { avx512$(::<$($generic,)* $($constant),*>)?($($argument),*) };
            }
            #[inline(never)]
            fn base$(<$($generic $(: $bound)?,)* $(const $constant: $kind),*>)?($($argument: $type),*) {
                here$(::<$($generic,)* $($constant),*>)?($($argument),*)
            }
            let _ = vectors;
            base$(::<$($generic,)* $($constant),*>)?($($argument),*)
        }
    )*};
}
pub(crate) use over_lanes;
