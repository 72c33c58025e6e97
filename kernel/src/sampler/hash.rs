//! Hashes of words, and the stream of words of a sample.

/// Mixes the bits of a word: a bijection in which each input bit flips each output bit with a probability of nearly
/// one half (constants with the lowest known bias of this form: Wellons, "Hash Prospector").
#[inline]
pub fn mix(x: u32) -> u32 {
    let mut x = x;
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// A word as a float in [0, 1): its upper 24 bits, which a float holds exactly.
#[inline]
pub fn to_unit_interval(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// 2^32 over the golden ratio, rounded to odd: counts through dimensions far apart in bits.
pub(super) const GOLDEN: u32 = 0x9e37_79b9;

/// Two words from three: 64 bits, so that the 10^9 samples of an image hardly ever share a stream.
#[inline]
pub(super) fn keys(seed: u32, pixel: u32, sample: u32) -> (u32, u32) {
    let a = mix(pixel.wrapping_add(mix(seed.wrapping_add(0x6a09_e667))));
    let b = mix(pixel.wrapping_add(mix(seed.wrapping_add(0xbb67_ae85))));
    (mix(sample.wrapping_add(a)), mix(sample.wrapping_add(b)))
}

/// Number `dimension` of the stream with these keys.
#[inline]
pub(super) fn hashed(key0: u32, key1: u32, dimension: u32) -> u32 {
    mix(key0 ^ mix(key1.wrapping_add(dimension.wrapping_mul(GOLDEN))))
}
