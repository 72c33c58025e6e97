//! Random numbers and adversarial search for the experiments.

/// A small generator (SplitMix64, Steele, Lea and Flood 2014), one per run.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1) with 53 bits.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [-1, 1).
    pub fn symmetric(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }
}

/// The largest value of `f` over the unit cube: random search, then steps around the best point that shrink when
/// they fail. `effort` is the number of evaluations.
pub fn maximize<const N: usize>(effort: u32, seed: u64, f: impl Fn(&[f64; N]) -> f64) -> f64 {
    let mut random = Random(seed);
    let mut best = 0.0_f64;
    for _ in 0..4 {
        let mut here = (0.0, [0.5; N]);
        for _ in 0..effort / 8 {
            let x = [0; N].map(|_| random.uniform());
            let value = f(&x);
            if value > here.0 {
                here = (value, x);
            }
        }
        let mut step = 0.2;
        for _ in 0..effort / 8 {
            let x = here
                .1
                .map(|v| (v + step * random.symmetric()).clamp(0.0, 1.0));
            let value = f(&x);
            if value > here.0 {
                here = (value, x);
            } else {
                step = (step * 0.99_f64).max(1e-9);
            }
        }
        best = best.max(here.0);
    }
    best
}
