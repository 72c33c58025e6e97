//! The random numbers of a bounce, in lanes.

use super::paths::{PathLanes, QueuedPaths};
use crate::sampler::LaneSampler;
use crate::simd::lanes::gather;
use crate::simd::multiversioned;
use bytemuck::Zeroable;
use glam::Vec2;

/// The numbers of up to `N` paths, in the order in which a single path draws them.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct NumberLanes<const N: usize> {
    /// Chooses an emitter.
    pub emitter: [f32; N],
    emitter_point: [[f32; N]; 2],
    /// Chooses a lobe, or between reflection and refraction.
    pub event: [f32; N],
    direction: [[f32; N]; 2],
}

impl<const N: usize> NumberLanes<N> {
    /// What chooses the point of an emitter or the direction towards it, at slot `k < N`.
    #[inline(always)]
    pub fn emitter_point(&self, k: usize) -> Vec2 {
        Vec2::new(self.emitter_point[0][k], self.emitter_point[1][k])
    }

    /// What chooses a scattered direction, at slot `k < N`.
    #[inline(always)]
    pub fn direction(&self, k: usize) -> Vec2 {
        Vec2::new(self.direction[0][k], self.direction[1][k])
    }
}

multiversioned! {
    /// Draws the numbers of the queued paths, those of an emitter sample if `SAMPLES_EMITTERS`, and moves their samplers and
    /// indices to the slots of `next`.
    pub(super) fn draw<S: LaneSampler; const SAMPLES_EMITTERS: bool, const N: usize>(
        queued: &QueuedPaths<'_, N>,
        next: &mut PathLanes<N>,
        numbers: &mut NumberLanes<N>,
    ) {
        for k in queued.segment.padded::<N>() {
            let mut sampler = queued.paths.sampler::<S>(queued.entries[k]);
            if SAMPLES_EMITTERS {
                draw_emitter(&mut sampler, numbers, k);
            }
            draw_scattering(sampler, queued, next, numbers, k);
        }
    }

    /// [`draw`] where only the slots in `is_lit` sample an emitter.
    pub(super) fn draw_where_lit<S: LaneSampler; const N: usize>(
        queued: &QueuedPaths<'_, N>,
        is_lit: &[u32; N],
        next: &mut PathLanes<N>,
        numbers: &mut NumberLanes<N>,
    ) {
        for k in queued.segment.padded::<N>() {
            let unlit = queued.paths.sampler::<S>(queued.entries[k]);
            let mut lit = unlit;
            draw_emitter(&mut lit, numbers, k);
            let sampler = if is_lit[k] != 0 { lit } else { unlit };
            draw_scattering(sampler, queued, next, numbers, k);
        }
    }
}

/// The numbers of an emitter sample, in slot `k < N`.
#[inline(always)]
fn draw_emitter<S: LaneSampler, const N: usize>(
    sampler: &mut S,
    numbers: &mut NumberLanes<N>,
    k: usize,
) {
    numbers.emitter[k] = sampler.next_1d();
    let u = sampler.next_2d();
    numbers.emitter_point[0][k] = u.x;
    numbers.emitter_point[1][k] = u.y;
}

/// The numbers of a scattered direction, the last of the bounce, in slot `k < N`.
#[inline(always)]
fn draw_scattering<S: LaneSampler, const N: usize>(
    mut sampler: S,
    queued: &QueuedPaths<'_, N>,
    next: &mut PathLanes<N>,
    numbers: &mut NumberLanes<N>,
    k: usize,
) {
    numbers.event[k] = sampler.next_1d();
    let u = sampler.next_2d();
    numbers.direction[0][k] = u.x;
    numbers.direction[1][k] = u.y;
    next.set_sampler(k, sampler);
    next.index[k] = gather(&queued.paths.index, queued.entries[k]);
}
