//! Detects instruction sets beyond the one for which the program is compiled.

use halflight_kernel::simd::SimdLevel;

/// The vectors that the processor has. Sixteen lanes are used only along with the features for single words that all
/// processors with such lanes have: `avx2`, `fma`, `popcnt`, `bmi1`, `bmi2` and `lzcnt`.
pub fn simd_level() -> SimdLevel {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512cd")
        && is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("popcnt")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
    {
        // SAFETY: the features are there.
        return unsafe { SimdLevel::avx512() };
    }
    SimdLevel::BASE
}
