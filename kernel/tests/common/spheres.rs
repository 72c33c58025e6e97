//! A scene of two spheres: enough for a walk.

#[allow(clippy::duplicate_mod)] // Tests take this file with or without the others that need it.
#[path = "brute_force.rs"]
mod brute_force;
#[allow(clippy::duplicate_mod)] // Tests take this file with or without the others that need it.
#[path = "empty_tables.rs"]
mod empty_tables;

use glam::Vec3;
use halflight_kernel::math::Ray;
use halflight_kernel::scene::{Hit, NONE, Quadric, Shape, Tables, Traverse, quadric_kind};

/// Two spheres, each with its material.
pub struct Spheres {
    quadrics: [Quadric; 2],
    shapes: [Shape; 2],
}

impl Spheres {
    /// Centre, radius and material of each.
    pub fn new(spheres: [(Vec3, f32, u32); 2]) -> Spheres {
        let quadric = |shape: usize| {
            let (c, r, _) = spheres[shape];
            let s = 1.0 / r;
            let (x, y, z) = (-c.x * s, -c.y * s, -c.z * s);
            Quadric {
                to_world: [r, 0.0, 0.0, c.x, 0.0, r, 0.0, c.y, 0.0, 0.0, r, c.z],
                to_object: [s, 0.0, 0.0, x, 0.0, s, 0.0, y, 0.0, 0.0, s, z],
                kind: quadric_kind::SPHERE,
                shape: shape as u32,
            }
        };
        Spheres {
            quadrics: [quadric(0), quadric(1)],
            shapes: spheres.map(|(_, _, material)| Shape {
                material,
                emitter: NONE,
                flags: 0,
                normal_offset: NONE,
                uv_offset: NONE,
                first_vertex: 0,
                first_primitive: 0,
                primitive_count: 1,
            }),
        }
    }

    /// The borrowed tables.
    pub fn tables(&self) -> Tables<'_> {
        Tables {
            quadrics: &self.quadrics,
            shapes: &self.shapes,
            ..empty_tables::empty_tables()
        }
    }
}

impl Traverse for Spheres {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        brute_force::closest_hit(&self.tables(), ray)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.closest_hit(ray).is_hit()
    }
}
