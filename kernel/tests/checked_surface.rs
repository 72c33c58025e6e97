//! The checked look-up of a surface: the same as the plain one inside the tables, a refusal outside.

#[path = "common/primitives.rs"]
mod primitives;

use glam::{DAffine3, Vec3};
use halflight_kernel::math::Ray;
use halflight_kernel::scene::surface::checked::checked_surface_at;
use halflight_kernel::scene::{
    Hit, NONE, Quadric, Shape, Tables, Triangle, quadric_kind, shape_flag, surface_at,
};
use primitives::{Primitives, runner};
use proptest::prelude::*;
use std::cell::Cell;

/// Two triangles and two quadrics in two instances.
fn scene() -> Primitives {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let map = DAffine3::from_scale(glam::DVec3::new(1.0, 2.0, 3.0));
    let mut scene = Primitives::triangle(
        corners,
        Some([Vec3::Z, Vec3::new(0.1, 0.0, 1.0), Vec3::new(0.0, 0.2, 1.0)]),
        Some([[0.0, 0.0], [1.0, 0.2], [0.1, 2.0]]),
        0,
        map,
    );
    let quadric = Primitives::quadric(quadric_kind::SPHERE, 0, map, map);
    scene.triangles.push(Triangle {
        vertices: [2, 0, 1],
        shape: 1,
    });
    scene.shapes.extend(quadric.shapes);
    scene.quadrics = vec![
        Quadric {
            shape: 1,
            ..quadric.quadrics[0]
        },
        Quadric {
            shape: 0,
            kind: quadric_kind::DISK,
            ..quadric.quadrics[0]
        },
    ];
    scene
}

/// Whether the tables hold all that belongs to a hit.
fn holds(tables: &Tables<'_>, hit: &Hit) -> bool {
    let at = |offset: u32, v: u32| v.wrapping_add(offset) as usize;
    let has_vertex = |shape: &Shape, v: u32| {
        let is_smooth = shape.normal_offset != NONE && shape.flags & shape_flag::FACE_NORMALS == 0;
        (v as usize) < tables.positions.len()
            && (shape.uv_offset == NONE || at(shape.uv_offset, v) < tables.uvs.len())
            && (!is_smooth || at(shape.normal_offset, v) < tables.normals.len())
    };
    let has_primitive = match tables.triangles.get(hit.primitive as usize) {
        Some(triangle) => tables
            .shapes
            .get(triangle.shape as usize)
            .is_some_and(|shape| triangle.vertices.iter().all(|&v| has_vertex(shape, v))),
        None => tables
            .quadrics
            .get(hit.primitive as usize - tables.triangles.len())
            .is_some_and(|quadric| (quadric.shape as usize) < tables.shapes.len()),
    };
    let is_placed = hit.instance == 0 || (hit.instance as usize) < tables.instances.len();
    hit.is_hit() && has_primitive && is_placed
}

/// Every index of a hit and of the records it leads to, inside and outside.
#[test]
fn hits_outside_the_tables_are_refused() {
    let index = || prop_oneof![6 => 0u32..3, 1 => Just(NONE), 1 => any::<u32>()];
    let counts = Cell::new([0; 2]);
    let strategy = (
        (0u32..6, 0u32..3, any::<bool>()),
        prop::array::uniform8(index()),
        0usize..16,
        prop::array::uniform5(0usize..2),
    );
    runner(8000)
        .run(
            &strategy,
            |((primitive, instance, is_hit), indices, changed, cut)| {
                let mut scene = scene();
                // Some records lead elsewhere, and some tables are shorter.
                let targets: [&mut u32; 8] = {
                    let [t, _] = &mut scene.triangles[..] else {
                        unreachable!()
                    };
                    let [s, other] = &mut scene.shapes[..] else {
                        unreachable!()
                    };
                    let [v0, v1, v2] = &mut t.vertices;
                    [
                        v0,
                        v1,
                        v2,
                        &mut t.shape,
                        &mut s.uv_offset,
                        &mut s.normal_offset,
                        &mut other.uv_offset,
                        &mut scene.quadrics[0].shape,
                    ]
                };
                for (i, target) in targets.into_iter().enumerate() {
                    if i == changed {
                        *target = indices[i];
                    }
                }
                if changed > 12 {
                    scene.positions.truncate(3 - cut[0]);
                    scene.normals.truncate(3 - cut[1]);
                    scene.uvs.truncate(3 - cut[2]);
                    scene.instances.truncate(2 - cut[3]);
                    scene.shapes.truncate(2 - cut[4]);
                }
                let tables = scene.tables();
                let hit = Hit {
                    t: if is_hit { 1.5 } else { f32::MAX },
                    b1: 0.3,
                    b2: 0.2,
                    primitive,
                    instance,
                };
                let ray = Ray::new(Vec3::new(0.1, 0.2, 2.0), -Vec3::Z);
                let found = checked_surface_at(&tables, &ray, &hit);
                let mut n = counts.get();
                n[usize::from(found.valid)] += 1;
                counts.set(n);
                prop_assert_eq!(found.valid, holds(&tables, &hit));
                if found.valid {
                    let plain = surface_at(&tables, &ray, &hit);
                    prop_assert_eq!(format!("{plain:?}"), format!("{:?}", found.point));
                }
                Ok(())
            },
        )
        .unwrap();
    let counts = counts.get();
    assert!(counts[0] > 1000 && counts[1] > 1000, "{counts:?}");
}
