//! How weights are checked, and the counts of those that were.

use halflight_kernel::path::Contribution;

/// How weights are to be checked.
#[derive(Clone, Copy)]
pub struct Weighting {
    pub is_power: bool,
    /// Radius and number of light walks of merging, zero for none.
    pub radius: f32,
    pub emitted: u32,
}

/// Weights that were checked, by the kind of their strategy.
#[derive(Clone, Copy, Debug, Default)]
pub struct Checked {
    pub inner: u32,
    pub to_lens: u32,
    pub lit: u32,
    pub emitted: u32,
    pub lens_hit: u32,
    pub merged: u32,
}

impl Checked {
    pub fn all(&self) -> u32 {
        self.inner + self.to_lens + self.lit + self.emitted + self.lens_hit + self.merged
    }
}

/// The share of a strategy by the power or balance heuristic.
pub fn reference(densities: &[f64], s: usize, is_power: bool) -> f64 {
    let h = |x: f64| if is_power { x * x } else { x };
    1.0 / densities.iter().map(|p| h(p / densities[s])).sum::<f64>()
}

/// The weight that a contribution was made with.
pub fn weight(make: impl Fn(bool) -> Contribution) -> Option<f64> {
    let (weighted, plain) = (make(false), make(true));
    let value = f64::from(plain.value.max_element());
    (value > 0.0).then(|| f64::from(weighted.value.max_element()) / value)
}
