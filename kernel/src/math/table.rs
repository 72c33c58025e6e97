//! Elements of tables by indices that may lie beyond their ends.
//!
//! A shader reads without a check. On hosts an index beyond the end reads zeros, because a loop over lanes is vectorised only
//! if nothing in it can panic. A gather takes half the instructions if the compiler can prove that its offsets fit one word
//! instead of two; tables therefore have at most [`most_elements`] elements, and larger scenes are refused when they are built
//! ([`crate::scene::Tables::oversized`]).

/// Element `i` of a constant table, the last one beyond its end.
///
/// An index that may panic would make a shader compiler copy the function to all its callers.
#[inline]
pub fn entry<const N: usize>(table: [f32; N], i: usize) -> f32 {
    let i = if i < N { i } else { N - 1 };
    #[cfg(target_arch = "spirv")]
    // SAFETY: the index was brought into the table.
    unsafe {
        *table.get_unchecked(i)
    }
    #[cfg(not(target_arch = "spirv"))]
    table[i]
}

/// Most elements of a table: a power of two whose offsets, counted in words of 32 bits, stay below 2^31.
pub const fn most_elements<T>() -> usize {
    let words = size_of::<T>() / size_of::<u32>();
    1 << ((1usize << 31) / words).ilog2()
}

/// Element `i` of a table of whole words, if there is one.
///
/// Where a table has more than [`most_elements`], it is that of the index without its highest bits.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
pub fn within<T>(table: &[T], i: u32) -> Option<&T> {
    const { assert!(size_of::<T>().is_multiple_of(4) && align_of::<T>() == 4) };
    let words = const { size_of::<T>() / size_of::<u32>() } as u32;
    let mask = const { most_elements::<T>() - 1 } as u32;
    // Elements beyond the range of indices are never read.
    if i < table.len() as u32 {
        let offset = (i & mask).wrapping_mul(words) as usize;
        // SAFETY: that of an element that is no later than i, which lies in the table.
        Some(unsafe { &*table.as_ptr().cast::<u32>().add(offset).cast::<T>() })
    } else {
        None
    }
}

/// Element `i` of a table, on hosts zeros beyond its end: loops over lanes are vectorised only where nothing can panic.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn element<T: Copy + bytemuck::Zeroable>(table: &[T], i: u32) -> T {
    #[cfg(target_arch = "spirv")]
    {
        table[i as usize]
    }
    #[cfg(not(target_arch = "spirv"))]
    match within(table, i) {
        Some(value) => *value,
        None => T::zeroed(),
    }
}

/// A field of element `i` of a table, as [`element`]: for lanes, where whole records would be read in pieces of two words.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn field<T, U: bytemuck::Zeroable>(table: &[T], i: u32, of: impl FnOnce(&T) -> U) -> U {
    #[cfg(target_arch = "spirv")]
    {
        of(&table[i as usize])
    }
    #[cfg(not(target_arch = "spirv"))]
    match within(table, i) {
        Some(value) => of(value),
        None => U::zeroed(),
    }
}
