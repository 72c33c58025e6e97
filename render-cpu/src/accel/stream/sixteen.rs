//! Sixteen rays, what they have met so far, and the leaves that wait to be tested against them.
//!
//! The walk ([`super::lockstep`]) puts the places of leaves that a ray reaches into a queue, of which sixteen are tested
//! together, whichever rays they are for. Primitives that are neither triangles nor spheres are left to the walk of single
//! rays.

use super::lanes16::*;
use super::root16::Starts;
use super::spheres16::{self, test_spheres};
use super::triangles16::{self, Hits, ShearedRays};
use crate::accel::Group;
use crate::accel::build::packed::Place;
use crate::accel::traverse::{CpuTraverse, Nearest};
use halflight_kernel::math::Ray;
use halflight_kernel::scene::traverse::REACH;
use halflight_kernel::scene::{Hit, HitBatch, RayBatch};
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Entries of the queue: what may be left of it, and all places of sixteen roots and of sixteen other nodes.
const QUEUE: usize = LANES * 49;

/// Sixteen rays.
#[repr(C, align(64))]
pub struct Sixteen {
    pub origin: [Floats; 3],
    pub direction: [Floats; 3],
    pub t_min: Floats,
    /// Where the search ends: a little beyond the hit.
    pub t_max: Floats,
    /// 1 / direction, finite.
    pub inverse: [Floats; 3],
    /// See [`ShearedRays`].
    shear: [Floats; 3],
    /// The longest axis of each direction.
    axis: Words,
    /// Which rays of a batch they are.
    pub ids: Words,
    t: Floats,
    b1: Floats,
    b2: Floats,
    primitive: Words,
    instance: Words,
    /// Places that wait: sixteen times their number, plus the lane.
    queue: [u32; QUEUE],
    queued: usize,
    /// Lanes in which a direction is negative, by axes.
    pub negative: [u16; 3],
}

impl Sixteen {
    /// No rays.
    pub const NONE: Sixteen = Sixteen {
        origin: [Floats::all(0.0); 3],
        direction: [Floats::all(0.0); 3],
        t_min: Floats::all(0.0),
        t_max: Floats::all(0.0),
        inverse: [Floats::all(0.0); 3],
        shear: [Floats::all(0.0); 3],
        axis: Words::all(0),
        ids: Words::all(0),
        t: Floats::all(0.0),
        b1: Floats::all(0.0),
        b2: Floats::all(0.0),
        primitive: Words::all(0),
        instance: Words::all(0),
        queue: [0; QUEUE],
        queued: 0,
        negative: [0; 3],
    };

    /// The ray of a lane.
    fn ray(&self, lane: usize) -> Ray {
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

    fn set_nearest(&mut self, lane: usize, nearest: &Nearest) {
        let hit = &nearest.hit;
        self.t.0[lane] = hit.t;
        self.b1.0[lane] = hit.b1;
        self.b2.0[lane] = hit.b2;
        self.primitive.0[lane] = hit.primitive;
        self.instance.0[lane] = hit.instance;
        self.t_max.0[lane] = nearest.t_max;
    }

    /// How many places wait.
    pub fn queued(&self) -> usize {
        self.queued
    }
}

avx512! {
    /// Takes the next rays of a batch, from `first` on, into the lanes of a mask.
    pub fn take<const N: usize>(
        sixteen: &mut Sixteen,
        lanes: u16,
        rays: &RayBatch<N>,
        starts: &Starts<N>,
        first: usize,
    ) {
        debug_assert!(first + lanes.count_ones() as usize <= N);
        let expand = |row: &mut Floats, from: *const f32| {
            // SAFETY: as many floats are read as bits are set, which the batch has; those of `starts` have been written.
            let v = unsafe { _mm512_mask_expandloadu_ps(load(row), lanes, from.add(first)) };
            store(row, v);
        };
        expand(&mut sixteen.origin[0], rays.origin.x.as_ptr());
        expand(&mut sixteen.origin[1], rays.origin.y.as_ptr());
        expand(&mut sixteen.origin[2], rays.origin.z.as_ptr());
        expand(&mut sixteen.direction[0], rays.direction.x.as_ptr());
        expand(&mut sixteen.direction[1], rays.direction.y.as_ptr());
        expand(&mut sixteen.direction[2], rays.direction.z.as_ptr());
        expand(&mut sixteen.t_min, rays.t_min.as_ptr());
        expand(&mut sixteen.t_max, rays.t_max.as_ptr());
        for k in 0..3 {
            expand(&mut sixteen.inverse[k], starts.inverse[k].as_ptr().cast());
            expand(&mut sixteen.shear[k], starts.shear[k].as_ptr().cast());
            let inverse = _mm512_castps_si512(load(&sixteen.inverse[k]));
            sixteen.negative[k] = _mm512_movepi32_mask(inverse);
        }
        let axis = expand_words(load_words(&sixteen.axis), lanes, &starts.axis, first);
        store_words(&mut sixteen.axis, axis);
        let numbers = _mm512_add_epi32(word(first as i32), lane_numbers());
        let ids = _mm512_mask_expand_epi32(load_words(&sixteen.ids), lanes, numbers);
        store_words(&mut sixteen.ids, ids);
        store_some(&mut sixteen.t, lanes, splat(f32::MAX));
        store_some(&mut sixteen.b1, lanes, splat(0.0));
        store_some(&mut sixteen.b2, lanes, splat(0.0));
        store_some_words(&mut sixteen.primitive, lanes, word(-1));
        store_some_words(&mut sixteen.instance, lanes, word(0));
    }

    /// The numbers of rays that have begun, from `first` on, in the lanes of a mask; those of `other` elsewhere.
    pub fn expand_words<const N: usize>(
        other: __m512i,
        lanes: u16,
        row: &[MaybeUninit<u32>; N],
        first: usize,
    ) -> __m512i {
        // SAFETY: as many words are read as bits are set; they have been written.
        unsafe { _mm512_mask_expandloadu_epi32(other, lanes, row.as_ptr().add(first).cast()) }
    }

    /// Appends a place of each of the lanes of a mask to the queue, which must have room for sixteen.
    pub fn enqueue(sixteen: &mut Sixteen, lanes: u16, places: __m512i) {
        let entries = _mm512_or_si512(_mm512_slli_epi32::<4>(places), lane_numbers());
        debug_assert!(sixteen.queued + LANES <= QUEUE);
        // SAFETY: there is room.
        unsafe {
            let to = sixteen.queue.as_mut_ptr().add(sixteen.queued);
            _mm512_storeu_si512(to.cast(), _mm512_maskz_compress_epi32(lanes, entries));
        }
        sixteen.queued += lanes.count_ones() as usize;
    }

    /// The lanes of the places that wait, of which there are fewer than sixteen.
    pub fn waiting(sixteen: &Sixteen) -> u16 {
        let mask = ((1u32 << sixteen.queued.min(LANES - 1)) - 1) as u16;
        // SAFETY: the entries have been written.
        let entries = unsafe { _mm512_maskz_loadu_epi32(mask, sixteen.queue.as_ptr().cast()) };
        let lanes = _mm512_and_si512(entries, word(LANES as i32 - 1));
        _mm512_mask_reduce_or_epi32(mask, _mm512_sllv_epi32(word(1), lanes)) as u16
    }

    /// What triangles need of the rays.
    pub fn sheared(sixteen: &Sixteen) -> ShearedRays {
        let three = |rows: &[Floats; 3]| [load(&rows[0]), load(&rows[1]), load(&rows[2])];
        let axis = load_words(&sixteen.axis);
        ShearedRays {
            origin: three(&sixteen.origin),
            direction: three(&sixteen.direction),
            shear: three(&sixteen.shear),
            is_x: _mm512_testn_epi32_mask(axis, axis),
            is_y: _mm512_cmpeq_epi32_mask(axis, word(1)),
            t_min: load(&sixteen.t_min),
            t_max: load(&sixteen.t_max),
        }
    }

    /// Keeps hits (t, b1, b2) of the lanes of a mask with primitives of the world where they come first; the lanes where they do.
    pub fn keep_first(
        sixteen: &mut Sixteen,
        mask: u16,
        [t, b1, b2]: [__m512; 3],
        primitive: __m512i,
    ) -> u16 {
        let (before, other) = (load(&sixteen.t), load_words(&sixteen.primitive));
        let is_nearer = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(mask, t, before);
        let is_tie = _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(mask, t, before)
            & _mm512_cmp_ps_mask::<_CMP_LT_OQ>(before, splat(f32::MAX));
        let instance = load_words(&sixteen.instance);
        let is_lower = _mm512_cmplt_epu32_mask(primitive, other)
            | (_mm512_cmpeq_epu32_mask(primitive, other)
                & _mm512_test_epi32_mask(instance, instance));
        let is_first = is_nearer | (is_tie & is_lower);
        store_some(&mut sixteen.t, is_first, t);
        store_some(&mut sixteen.t_max, is_first, _mm512_mul_ps(t, splat(REACH)));
        store_some(&mut sixteen.b1, is_first, b1);
        store_some(&mut sixteen.b2, is_first, b2);
        store_some_words(&mut sixteen.primitive, is_first, primitive);
        store_some_words(&mut sixteen.instance, is_first, word(0));
        is_first
    }

    /// Keeps the hits of some lanes' rays, `owners`, with primitives of the world, where they come first; the rays' lanes.
    pub fn keep(sixteen: &mut Sixteen, owners: __m512i, hits: &Hits, primitives: __m512i) -> u16 {
        let mut kept = 0;
        let mut left = hits.mask;
        while left != 0 {
            // One hit of every ray in turn: the last.
            let mut turn = Words::all(u32::MAX);
            // SAFETY: lanes of a vector.
            unsafe {
                let to = turn.0.as_mut_ptr().cast();
                _mm512_mask_i32scatter_epi32::<4>(to, left, owners, lane_numbers());
            }
            let turn = load_words(&turn);
            let is_in_turn = _mm512_permutexvar_epi32(owners, turn);
            left &= _mm512_cmpneq_epi32_mask(is_in_turn, lane_numbers());
            let has_hit = _mm512_cmplt_epu32_mask(turn, word(LANES as i32));
            let t = _mm512_permutexvar_ps(turn, hits.t);
            let primitive = _mm512_permutexvar_epi32(turn, primitives);
            let b1 = _mm512_permutexvar_ps(turn, hits.b1);
            let b2 = _mm512_permutexvar_ps(turn, hits.b2);
            kept |= keep_first(sixteen, has_hit, [t, b1, b2], primitive);
        }
        kept
    }

    /// Hands over the hits of the lanes of a mask, with `ANY` whether there are any.
    pub fn hand_over<const ANY: bool, const N: usize>(
        sixteen: &Sixteen,
        lanes: u16,
        hits: &mut HitBatch<N>,
    ) {
        let mut left = lanes;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & (LANES - 1);
            left &= left - 1;
            let id = (sixteen.ids.0[lane] as usize).min(N - 1);
            if ANY {
                hits.t[id] = sixteen.t.0[lane];
            } else {
                hits.set(id, &sixteen.nearest(lane).hit);
            }
        }
    }
}

/// Hands over the hits of sixteen rays in a row.
pub fn hand_over_row<const N: usize>(sixteen: &Sixteen, first: usize, hits: &mut HitBatch<N>) {
    let row = first..first + LANES;
    hits.t[row.clone()].copy_from_slice(&sixteen.t.0);
    hits.b1[row.clone()].copy_from_slice(&sixteen.b1.0);
    hits.b2[row.clone()].copy_from_slice(&sixteen.b2.0);
    hits.primitive[row.clone()].copy_from_slice(&sixteen.primitive.0);
    hits.instance[row].copy_from_slice(&sixteen.instance.0);
}

impl CpuTraverse<'_> {
    /// Tests up to sixteen of the places that wait; the lanes that have met something.
    #[inline(never)]
    #[target_feature(
        enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
    )]
    pub(in crate::accel) fn test_places(
        &self,
        sixteen: &mut Sixteen,
        group: &Group,
        any: bool,
    ) -> u16 {
        // The last ones, which moves none.
        let count = sixteen.queued.min(LANES);
        sixteen.queued -= count;
        let mask = ((1u32 << count) - 1) as u16;
        let queue = sixteen.queue[sixteen.queued..].as_ptr();
        // SAFETY: `count` entries from here on have been written.
        let entries = unsafe { _mm512_maskz_loadu_epi32(mask, queue.cast()) };
        let lanes = _mm512_and_si512(entries, word(LANES as i32 - 1));
        let places = group.places.as_ptr();
        macro_rules! vertex {
            ($vertex:literal) => {
                columns!(|lane| {
                    // Read once more, which is less work than to take a vector apart.
                    // SAFETY: sixteen entries follow, and each that has ever been written is a place of the group, as is zero.
                    let place: &Place = unsafe { &*places.add((*queue.add(lane) >> 4) as usize) };
                    // SAFETY: a row is four aligned floats.
                    unsafe { _mm_load_si128(place.row($vertex).as_ptr().cast()) }
                })
            };
        }
        let [x0, y0, z0, name] = vertex!(0);
        let [x1, y1, z1, partner] = vertex!(1);
        let [x2, y2, z2, turns] = vertex!(2);
        let [x3, y3, z3, _] = vertex!(3);
        let of = |row: &Floats| _mm512_permutexvar_ps(lanes, load(row));
        let of_three = |rows: &[Floats; 3]| [of(&rows[0]), of(&rows[1]), of(&rows[2])];
        let axis = _mm512_permutexvar_epi32(lanes, load_words(&sixteen.axis));
        let rays = ShearedRays {
            origin: of_three(&sixteen.origin),
            direction: of_three(&sixteen.direction),
            shear: of_three(&sixteen.shear),
            is_x: _mm512_testn_epi32_mask(axis, axis),
            is_y: _mm512_cmpeq_epi32_mask(axis, word(1)),
            t_min: of(&sixteen.t_min),
            t_max: of(&sixteen.t_max),
        };
        let float = |v: __m512i| _mm512_castsi512_ps(v);
        let vertices = [
            [float(x0), float(y0), float(z0)],
            [float(x1), float(y1), float(z1)],
            [float(x2), float(y2), float(z2)],
            [float(x3), float(y3), float(z3)],
        ];
        let (found, names) =
            triangles16::nearest::<false>(&rays, &vertices, name, partner, turns, mask);
        let mut met = keep(sixteen, lanes, &found, names);
        if group.is_mixed {
            let triangles = word(self.tables.triangles.len() as i32);
            let others = _mm512_mask_cmpge_epu32_mask(mask, name, triangles);
            if others != 0 {
                let mut at = Words::all(0);
                store_words(&mut at, _mm512_srli_epi32::<4>(entries));
                let spheres = spheres16::are_spheres(&self.tables, name, others);
                met |= test_spheres(sixteen, &self.tables, &rays, lanes, name, spheres);
                met |= self.test_others(sixteen, group, &at, lanes, others & !spheres, any);
            }
        }
        met
    }

    /// What lies in places without a triangle, by the walk of single rays; the lanes that have met something.
    #[inline(never)]
    #[target_feature(
        enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
    )]
    pub(in crate::accel) fn test_others(
        &self,
        sixteen: &mut Sixteen,
        group: &Group,
        places: &Words,
        lanes: __m512i,
        others: u16,
        any: bool,
    ) -> u16 {
        let mut owners = Words::all(0);
        store_words(&mut owners, lanes);
        let mut met = 0;
        let mut left = others;
        while left != 0 {
            let k = left.trailing_zeros() as usize & (LANES - 1);
            left &= left - 1;
            let lane = owners.0[k] as usize & (LANES - 1);
            let mut nearest = sixteen.nearest(lane);
            let place = places.0[k] as usize;
            let ray = sixteen.ray(lane);
            if any {
                self.test_other::<true>(group, place, &ray, &mut nearest);
            } else {
                self.test_other::<false>(group, place, &ray, &mut nearest);
            }
            sixteen.set_nearest(lane, &nearest);
            met |= u16::from(nearest.hit.is_hit()) << lane;
        }
        met
    }
}
