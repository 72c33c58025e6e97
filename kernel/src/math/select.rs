//! Choices without a branch.

/// `a` if `condition`, else `b`, where both are computed already: for conditions that are nearly random, half of which a
/// processor would mispredict, at some fifteen cycles each.
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
