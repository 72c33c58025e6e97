//! Rays against leaf entries: sixteen entries of a queue with a ray each, or one entry with all rays of a packet.
//!
//! Triangles and spheres are tested in lanes ([`crate::accel::simd`]), other primitives of a mixed tree by the walk of single
//! rays ([`crate::accel::single`]).

use super::leaf_queue::LeafQueue;
use super::rays::RayLanes;
use crate::accel::build::leaf_entry::LeafEntry;
use crate::accel::simd::avx512::{F16, LANES, W16, WordRow, columns, transposed, with_avx512};
use crate::accel::simd::spheres::hit_spheres;
use crate::accel::simd::triangles::{ShearedRays, hit_pairs};
use crate::accel::simd::{SimdFloat, SimdWord};
use crate::accel::single::walk::World;
use crate::accel::trees::Group;
use halflight_kernel::scene::{Quadric, Tables, quadric_kind};
use std::arch::x86_64::*;
use std::mem::offset_of;

/// Tests of leaf entries, one per lane of a mask.
struct QueuedTests {
    /// The entry of each lane.
    indices: WordRow,
    /// The lane of the ray that each lane tests.
    owners: W16,
    /// The mask.
    lanes: u16,
}

with_avx512! {
    /// Tests up to sixteen of the entries that wait; the lanes that have met something.
    #[inline(never)]
    pub fn test_queued(
        world: &World<'_>,
        group: &Group,
        rays: &mut RayLanes,
        queue: &mut LeafQueue,
        any: bool,
    ) -> u16 {
        let (mask, items, from) = queue.pop();
        let owners = items & W16::splat(LANES as u32 - 1);
        let entries = group.entries.as_ptr();
        macro_rules! vertex {
            ($vertex:literal) => {
                columns!(|lane| {
                    // Read once more, which is less work than to take a vector apart.
                    // SAFETY: sixteen items follow, and each that has ever been written is an entry of the group, as is zero.
                    let entry: &LeafEntry = unsafe { &*entries.add((*from.add(lane) >> 4) as usize) };
                    // SAFETY: a row is four aligned floats.
                    unsafe { _mm_load_si128(entry.row($vertex).as_ptr().cast()) }
                })
            };
        }
        let [x0, y0, z0, primitive] = vertex!(0);
        let [x1, y1, z1, partner] = vertex!(1);
        let [x2, y2, z2, rotations] = vertex!(2);
        let [x3, y3, z3, _] = vertex!(3);
        let sheared = rays.sheared_of(owners);
        let vertices = [
            [x0.as_floats(), y0.as_floats(), z0.as_floats()],
            [x1.as_floats(), y1.as_floats(), z1.as_floats()],
            [x2.as_floats(), y2.as_floats(), z2.as_floats()],
            [x3.as_floats(), y3.as_floats(), z3.as_floats()],
        ];
        let (found, names) = hit_pairs(&sheared, &vertices, primitive, partner, rotations, mask);
        let mut met = rays.commit_for(owners, &found, names);
        if group.is_mixed {
            let triangles = W16::splat(world.tables.triangles.len() as u32);
            let others = primitive.ge(triangles, mask);
            if others != 0 {
                let mut indices = WordRow::all(0);
                items.shr::<4>().store(&mut indices);
                let spheres = are_spheres(&world.tables, primitive, others);
                met |= test_spheres(rays, &world.tables, &sheared, owners, primitive, spheres);
                let tests = QueuedTests { indices, owners, lanes: others & !spheres };
                met |= test_others(world, group, rays, &tests, any);
            }
        }
        met
    }

    /// Tests an entry for the lanes of a mask; those that have met something.
    #[inline]
    pub fn test_entry(
        world: &World<'_>,
        group: &Group,
        rays: &mut RayLanes,
        index: usize,
        lanes: u16,
        any: bool,
    ) -> u16 {
        let entry = &group.entries[index];
        let sheared = rays.sheared();
        let primitive = W16::splat(entry.primitive());
        if group.is_mixed && entry.primitive() >= world.tables.triangles.len() as u32 {
            let owners = W16::lane_numbers();
            let spheres = are_spheres(&world.tables, primitive, lanes);
            let met = test_spheres(rays, &world.tables, &sheared, owners, primitive, spheres);
            let indices = WordRow::all(index as u32);
            let tests = QueuedTests { indices, owners, lanes: lanes & !spheres };
            return met | test_others(world, group, rays, &tests, any);
        }
        let vertex = |k: usize| {
            let [x, y, z, _] = *entry.row(k);
            [F16::splat(x), F16::splat(y), F16::splat(z)]
        };
        let vertices = [vertex(0), vertex(1), vertex(2), vertex(3)];
        let partner = W16::splat(entry.partner());
        let rotations = W16::splat(entry.rotations());
        let (found, names) = hit_pairs(&sheared, &vertices, primitive, partner, rotations, lanes);
        if found.mask == 0 {
            return 0;
        }
        rays.commit(found.mask, [found.t, found.b1, found.b2], names)
    }

    /// Tests entries that are neither triangles nor spheres, by the walk of single rays; the rays' lanes that have hit something.
    #[inline(never)]
    fn test_others(
        world: &World<'_>,
        group: &Group,
        rays: &mut RayLanes,
        tests: &QueuedTests,
        any: bool,
    ) -> u16 {
        let mut lanes = WordRow::all(0);
        tests.owners.store(&mut lanes);
        let mut met = 0;
        let mut left = tests.lanes;
        while left != 0 {
            let k = left.trailing_zeros() as usize & (LANES - 1);
            left &= left - 1;
            let lane = lanes.0[k] as usize & (LANES - 1);
            let mut nearest = rays.nearest(lane);
            let index = tests.indices.0[k] as usize;
            let ray = rays.ray(lane);
            if any {
                world.test_other_avx2::<true>(group, index, &ray, &mut nearest);
            } else {
                world.test_other_avx2::<false>(group, index, &ray, &mut nearest);
            }
            rays.set_nearest(lane, &nearest);
            met |= u16::from(nearest.hit.is_hit()) << lane;
        }
        met
    }

    /// Which of the primitives of a mask, all behind the triangles, are spheres.
    #[inline]
    fn are_spheres(tables: &Tables<'_>, primitives: W16, mask: u16) -> u16 {
        let index = quadric_indices(tables, primitives);
        let mask = index.lt(W16::splat(tables.quadrics.len() as u32), mask);
        let stride = (size_of::<Quadric>() / size_of::<u32>()) as i32;
        let at = _mm512_mullo_epi32(index.0, _mm512_set1_epi32(stride));
        let kinds = tables.quadrics.as_ptr().cast::<u8>().wrapping_add(offset_of!(Quadric, kind));
        // SAFETY: the lanes of the mask read the kind of a quadric each.
        let kind = W16(unsafe {
            _mm512_mask_i32gather_epi32::<4>(W16::splat(u32::MAX).0, mask, at, kinds.cast())
        });
        kind.eq(W16::splat(quadric_kind::SPHERE), mask)
    }

    /// Indices into the quadrics of primitives behind the triangles.
    #[inline]
    fn quadric_indices(tables: &Tables<'_>, primitives: W16) -> W16 {
        primitives - W16::splat(tables.triangles.len() as u32)
    }

    /// Tests the spheres of a mask among primitives, by the rays of the lanes `owners`, of which `sheared` has what the test
    /// needs; the rays' lanes that have met one.
    #[inline]
    fn test_spheres(
        rays: &mut RayLanes,
        tables: &Tables<'_>,
        sheared: &ShearedRays<F16>,
        owners: W16,
        primitives: W16,
        spheres: u16,
    ) -> u16 {
        if spheres == 0 {
            return 0;
        }
        let mut indices = WordRow::all(0);
        quadric_indices(tables, primitives).masked(spheres).store(&mut indices);
        macro_rules! row {
            ($row:literal) => {{
                let [x, y, z, w] = columns!(|lane| {
                    let quadric = &tables.quadrics[indices.0[lane] as usize];
                    // SAFETY: a row is four floats.
                    unsafe { _mm_loadu_si128(quadric.to_object[4 * $row..].as_ptr().cast()) }
                });
                [x.as_floats(), y.as_floats(), z.as_floats(), w.as_floats()]
            }};
        }
        let to_object = [row!(0), row!(1), row!(2)];
        let range = [sheared.t_min, sheared.t_max];
        let found = hit_spheres(sheared.origin, sheared.direction, to_object, range, spheres);
        rays.commit_for(owners, &found, primitives)
    }
}
