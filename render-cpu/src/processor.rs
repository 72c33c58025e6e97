//! Detects instruction sets beyond the one for which the program is compiled, and sets the number of threads.

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

/// Threads for each processor that are still taken for meant.
const MAX_THREADS_PER_PROCESSOR: usize = 16;

/// Threads that are taken for meant on any machine.
const MAX_THREADS: usize = 256;

/// Chooses the number of threads that work from now on; none or zero: one for each processor.
///
/// # Errors
/// If there are more than any machine of this size can use, or threads are at work already.
pub fn set_threads(threads: Option<usize>) -> Result<(), String> {
    let Some(threads) = threads else {
        return Ok(());
    };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    if threads > MAX_THREADS.max(MAX_THREADS_PER_PROCESSOR * processors) {
        return Err(format!(
            "{threads} threads are more than this machine, which runs {processors} at a time, can use"
        ));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|error| format!("{threads} threads cannot be started: {error}"))
}
