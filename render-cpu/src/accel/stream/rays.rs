//! Sixteen rays in lanes, and the nearest hit of each so far.

use super::root::{PreparedRays, Row};
use crate::accel::simd::avx512::{F16, FloatRow, LANES, W16, WordRow, with_avx512};
use crate::accel::simd::triangles::{Hits, ShearedRays};
use crate::accel::simd::{SimdFloat, SimdWord};
use crate::accel::single::walk::Nearest;
use halflight_kernel::math::Ray;
use halflight_kernel::scene::traverse::REACH;
use halflight_kernel::scene::{Hit, HitBatch, RayBatch};
use std::arch::x86_64::*;

/// Sixteen rays.
#[repr(C, align(64))]
pub struct RayLanes {
    pub origin: [FloatRow; 3],
    pub direction: [FloatRow; 3],
    pub t_min: FloatRow,
    /// Where the search ends: a little beyond the hit.
    pub t_max: FloatRow,
    /// 1 / direction, finite.
    pub inverse: [FloatRow; 3],
    /// See [`ShearedRays`].
    shear: [FloatRow; 3],
    /// The longest axis of each direction.
    axis: WordRow,
    /// Which rays of the stream they are.
    ids: WordRow,
    t: FloatRow,
    b1: FloatRow,
    b2: FloatRow,
    primitive: WordRow,
    instance: WordRow,
    /// Lanes in which a direction is negative, by axes.
    pub negative: [u16; 3],
}

impl RayLanes {
    /// No rays.
    pub const NONE: RayLanes = RayLanes {
        origin: [FloatRow::all(0.0); 3],
        direction: [FloatRow::all(0.0); 3],
        t_min: FloatRow::all(0.0),
        t_max: FloatRow::all(0.0),
        inverse: [FloatRow::all(0.0); 3],
        shear: [FloatRow::all(0.0); 3],
        axis: WordRow::all(0),
        ids: WordRow::all(0),
        t: FloatRow::all(0.0),
        b1: FloatRow::all(0.0),
        b2: FloatRow::all(0.0),
        primitive: WordRow::all(0),
        instance: WordRow::all(0),
        negative: [0; 3],
    };

    /// The ray of a lane.
    pub fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: self.origin.map(|row| row.0[lane]).into(),
            direction: self.direction.map(|row| row.0[lane]).into(),
            t_min: self.t_min.0[lane],
            t_max: self.t_max.0[lane],
        }
    }

    /// The nearest hit of a lane so far.
    pub fn nearest(&self, lane: usize) -> Nearest {
        Nearest {
            hit: Hit {
                t: self.t.0[lane],
                b1: self.b1.0[lane],
                b2: self.b2.0[lane],
                primitive: self.primitive.0[lane],
                instance: self.instance.0[lane],
            },
            t_max: self.t_max.0[lane],
        }
    }

    /// Replaces the nearest hit of a lane.
    pub fn set_nearest(&mut self, lane: usize, nearest: &Nearest) {
        let hit = &nearest.hit;
        self.t.0[lane] = hit.t;
        self.b1.0[lane] = hit.b1;
        self.b2.0[lane] = hit.b2;
        self.primitive.0[lane] = hit.primitive;
        self.instance.0[lane] = hit.instance;
        self.t_max.0[lane] = nearest.t_max;
    }

    /// Stores the hits of sixteen rays that follow one another in the stream from `first` on.
    pub fn store_row<const N: usize>(&self, first: usize, hits: &mut HitBatch<N>) {
        let row = first..first + LANES;
        hits.t[row.clone()].copy_from_slice(&self.t.0);
        hits.b1[row.clone()].copy_from_slice(&self.b1.0);
        hits.b2[row.clone()].copy_from_slice(&self.b2.0);
        hits.primitive[row.clone()].copy_from_slice(&self.primitive.0);
        hits.instance[row].copy_from_slice(&self.instance.0);
    }

    with_avx512! {
        /// Takes the next rays of a stream, from `first` on, into the lanes of a mask.
        #[inline]
        pub fn load<const N: usize>(
            &mut self,
            lanes: u16,
            rays: &RayBatch<N>,
            prepared: &PreparedRays<N>,
            first: usize,
        ) {
            debug_assert!(first + lanes.count_ones() as usize <= N);
            let expand = |row: &mut FloatRow, from: *const f32| {
                // SAFETY: as many floats are read as bits are set, which the stream has; those that were prepared have
                // been written.
                let v = unsafe { _mm512_mask_expandloadu_ps(F16::load(row).0, lanes, from.add(first)) };
                F16(v).store(row);
            };
            expand(&mut self.origin[0], rays.origin.x.as_ptr());
            expand(&mut self.origin[1], rays.origin.y.as_ptr());
            expand(&mut self.origin[2], rays.origin.z.as_ptr());
            expand(&mut self.direction[0], rays.direction.x.as_ptr());
            expand(&mut self.direction[1], rays.direction.y.as_ptr());
            expand(&mut self.direction[2], rays.direction.z.as_ptr());
            expand(&mut self.t_min, rays.t_min.as_ptr());
            expand(&mut self.t_max, rays.t_max.as_ptr());
            for k in 0..3 {
                expand(&mut self.inverse[k], prepared.inverse[k].as_ptr().cast());
                expand(&mut self.shear[k], prepared.shear[k].as_ptr().cast());
                self.negative[k] = F16::load(&self.inverse[k]).signs();
            }
            let axis = expand_words(W16::load(&self.axis), lanes, &prepared.axis, first);
            axis.store(&mut self.axis);
            let numbers = W16::splat(first as u32) + W16::lane_numbers();
            let ids = W16(_mm512_mask_expand_epi32(W16::load(&self.ids).0, lanes, numbers.0));
            ids.store(&mut self.ids);
            F16::splat(f32::MAX).store_masked(&mut self.t, lanes);
            F16::splat(0.0).store_masked(&mut self.b1, lanes);
            F16::splat(0.0).store_masked(&mut self.b2, lanes);
            W16::splat(u32::MAX).store_masked(&mut self.primitive, lanes);
            W16::splat(0).store_masked(&mut self.instance, lanes);
        }

        /// What triangles need of the rays.
        #[inline]
        pub fn sheared(&self) -> ShearedRays<F16> {
            let axis = W16::load(&self.axis);
            ShearedRays {
                origin: F16::load3(&self.origin),
                direction: F16::load3(&self.direction),
                shear: F16::load3(&self.shear),
                is_x: axis.eq(W16::splat(0), u16::MAX),
                is_y: axis.eq(W16::splat(1), u16::MAX),
                t_min: F16::load(&self.t_min),
                t_max: F16::load(&self.t_max),
            }
        }

        /// What triangles need of the rays, in each lane those of the lane that `owners` names there.
        #[inline]
        pub fn sheared_of(&self, owners: W16) -> ShearedRays<F16> {
            let of = |row: &FloatRow| F16::load(row).permuted(owners);
            let of_three = |rows: &[FloatRow; 3]| [of(&rows[0]), of(&rows[1]), of(&rows[2])];
            let axis = W16::load(&self.axis).permuted(owners);
            ShearedRays {
                origin: of_three(&self.origin),
                direction: of_three(&self.direction),
                shear: of_three(&self.shear),
                is_x: axis.eq(W16::splat(0), u16::MAX),
                is_y: axis.eq(W16::splat(1), u16::MAX),
                t_min: of(&self.t_min),
                t_max: of(&self.t_max),
            }
        }

        /// Keeps hits (t, b1, b2) of the lanes of a mask with primitives of the world where they come first; the lanes where
        /// they do.
        #[inline]
        pub fn commit(&mut self, mask: u16, [t, b1, b2]: [F16; 3], primitive: W16) -> u16 {
            let (before, other) = (F16::load(&self.t), W16::load(&self.primitive));
            let is_nearer = t.lt(before, mask);
            let is_tie = t.eq(before, mask) & before.lt(F16::splat(f32::MAX), u16::MAX);
            let instance = W16::load(&self.instance);
            let is_lower = primitive.lt(other, u16::MAX)
                | (primitive.eq(other, u16::MAX) & instance.test(instance, u16::MAX));
            let is_first = is_nearer | (is_tie & is_lower);
            t.store_masked(&mut self.t, is_first);
            (t * F16::splat(REACH)).store_masked(&mut self.t_max, is_first);
            b1.store_masked(&mut self.b1, is_first);
            b2.store_masked(&mut self.b2, is_first);
            primitive.store_masked(&mut self.primitive, is_first);
            W16::splat(0).store_masked(&mut self.instance, is_first);
            is_first
        }

        /// Keeps hits of the rays of the lanes `owners` with primitives of the world, where they come first; the rays' lanes.
        /// Several hits may have the same owner.
        #[inline]
        pub fn commit_for(&mut self, owners: W16, hits: &Hits<F16>, primitives: W16) -> u16 {
            let mut kept = 0;
            let mut left = hits.mask;
            while left != 0 {
                // One hit of every ray at a time: the last one written for it.
                let mut chosen = WordRow::all(u32::MAX);
                // SAFETY: owners are lanes of a row.
                unsafe {
                    let to = chosen.0.as_mut_ptr().cast();
                    _mm512_mask_i32scatter_epi32::<4>(to, left, owners.0, W16::lane_numbers().0);
                }
                let chosen = W16::load(&chosen);
                left &= chosen.permuted(owners).ne(W16::lane_numbers(), u16::MAX);
                let has_hit = chosen.lt(W16::splat(LANES as u32), u16::MAX);
                let t = hits.t.permuted(chosen);
                let primitive = primitives.permuted(chosen);
                let b1 = hits.b1.permuted(chosen);
                let b2 = hits.b2.permuted(chosen);
                kept |= self.commit(has_hit, [t, b1, b2], primitive);
            }
            kept
        }
    }

    /// Stores the hits of the lanes of a mask where their rays are in the stream, with `ANY` whether there are any.
    #[inline]
    pub fn store<const ANY: bool, const N: usize>(&self, lanes: u16, hits: &mut HitBatch<N>) {
        let mut left = lanes;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & (LANES - 1);
            left &= left - 1;
            let id = (self.ids.0[lane] as usize).min(N - 1);
            if ANY {
                hits.t[id] = self.t.0[lane];
            } else {
                hits.set(id, &self.nearest(lane).hit);
            }
        }
    }
}

with_avx512! {
    /// The numbers of rays that have begun, from `first` on, in the lanes of a mask; those of `other` elsewhere.
    #[inline]
    pub fn expand_words<const N: usize>(
        other: W16,
        lanes: u16,
        row: &Row<u32, N>,
        first: usize,
    ) -> W16 {
        // SAFETY: as many words are read as bits are set; they have been written.
        W16(unsafe { _mm512_mask_expandloadu_epi32(other.0, lanes, row.as_ptr().add(first).cast()) })
    }
}
