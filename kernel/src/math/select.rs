//! Choices without a branch.

/// `a` if `condition`, else `b`, both being at hand: for conditions that are as good as random, of which a processor
/// would guess every other one wrong at the cost of some fifteen cycles.
#[inline]
pub fn select<T>(condition: bool, a: T, b: T) -> T {
    #[cfg(not(target_arch = "spirv"))]
    {
        core::hint::select_unpredictable(condition, a, b)
    }
    #[cfg(target_arch = "spirv")]
    {
        if condition { a } else { b }
    }
}
