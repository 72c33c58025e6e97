//! A sampler whose kind is chosen at run time.

use super::hash::to_unit_interval;
use super::{IndependentSampler, Sampler, SobolSampler};
use bytemuck::{Pod, Zeroable};
use glam::Vec2;

/// Kinds of [`AnySampler`].
pub mod sampler_kind {
    /// [`crate::sampler::IndependentSampler`].
    pub const INDEPENDENT: u32 = 0;
    /// [`crate::sampler::SobolSampler`].
    pub const SOBOL: u32 = 1;
}

/// Either sampler, chosen at run time; plain numbers, so that a buffer can hold it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct AnySampler {
    kind: u32,
    /// The counter; an independent sampler is the same but for its keys and the unused index.
    state: SobolSampler,
}

impl AnySampler {
    /// A sampler of one of [`sampler_kind`]; unknown kinds are independent.
    #[inline]
    pub fn new(kind: u32, seed: u32, pixel: u32, sample: u32) -> AnySampler {
        let state = if kind == sampler_kind::SOBOL {
            SobolSampler::new(seed, pixel, sample)
        } else {
            let s = IndependentSampler::new(seed, pixel, sample);
            SobolSampler {
                key0: s.key0,
                key1: s.key1,
                index: 0,
                dimension: s.dimension,
            }
        };
        AnySampler { kind, state }
    }

    #[inline]
    fn next_independent(&mut self) -> f32 {
        to_unit_interval(self.state.advance())
    }
}

impl Sampler for AnySampler {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        if self.kind == sampler_kind::SOBOL {
            self.state.next_1d()
        } else {
            self.next_independent()
        }
    }

    #[inline]
    fn next_2d(&mut self) -> Vec2 {
        if self.kind == sampler_kind::SOBOL {
            self.state.next_2d()
        } else {
            let x = self.next_independent();
            let y = self.next_independent();
            Vec2::new(x, y)
        }
    }
}
