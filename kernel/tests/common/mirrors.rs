//! Scenes of mirrors and glass for the walk, with a brute-force ray tracer, and chains through them.

// Each test file uses its part.
#![allow(dead_code)]

#[allow(clippy::duplicate_mod)] // Tests take this file with or without the others that need it.
#[path = "brute_force.rs"]
mod brute_force;

use super::primitives::{Primitives, rows};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use halflight_kernel::manifold::{ChainVertex, MAX_CHAIN};
use halflight_kernel::math::Ray;
use halflight_kernel::scene::*;

/// A chain of any length.
pub type Vertices = [ChainVertex; MAX_CHAIN];

/// Geometry with materials.
#[derive(Clone, Debug, Default)]
pub struct Mirrors {
    pub geometry: Primitives,
}

impl Mirrors {
    fn shape(&mut self, material: u32, normal_offset: u32) -> u32 {
        let world = Instance {
            to_world: rows(DAffine3::IDENTITY),
            to_object: rows(DAffine3::IDENTITY),
            root: 0,
            group: 0,
        };
        self.geometry.instances = vec![world];
        self.geometry.shapes.push(Shape {
            material,
            emitter: NONE,
            flags: 0,
            normal_offset,
            uv_offset: NONE,
            first_vertex: 0,
            first_primitive: 0,
            primitive_count: 0,
        });
        self.geometry.shapes.len() as u32 - 1
    }

    /// An ellipsoid: the unit sphere under a map.
    pub fn quadric(mut self, kind: u32, map: DAffine3, material: u32) -> Mirrors {
        let shape = self.shape(material, NONE);
        self.geometry.quadrics.push(Quadric {
            to_world: rows(map),
            to_object: rows(map.inverse()),
            kind,
            shape,
        });
        self
    }

    pub fn sphere(self, center: Vec3, radius: f64, material: u32) -> Mirrors {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(radius),
            DQuat::IDENTITY,
            center.as_dvec3(),
        );
        self.quadric(quadric_kind::SPHERE, map, material)
    }

    /// A parallelogram around `center` with half edges `u`, `v`.
    pub fn quad(self, center: Vec3, u: Vec3, v: Vec3, material: u32) -> Mirrors {
        self.patch(1, material, |a, b| {
            (center + u * a + v * b, u.cross(v).normalize())
        })
    }

    /// A mesh of `n` by `n` cells over [-1, 1]^2 with vertex normals.
    pub fn patch(
        mut self,
        n: u32,
        material: u32,
        surface: impl Fn(f32, f32) -> (Vec3, Vec3),
    ) -> Mirrors {
        let first = self.geometry.positions.len() as u32;
        let offset = (self.geometry.normals.len() as u32).wrapping_sub(first);
        let shape = self.shape(material, offset);
        for i in 0..=n {
            for j in 0..=n {
                let at = |k: u32| 2.0 * k as f32 / n as f32 - 1.0;
                let (p, normal) = surface(at(j), at(i));
                self.geometry.positions.push(p.to_array());
                self.geometry.normals.push(normal.to_array());
            }
        }
        for i in 0..n {
            for j in 0..n {
                let a = first + i * (n + 1) + j;
                let c = a + n + 1;
                for vertices in [[a, a + 1, c + 1], [a, c + 1, c]] {
                    self.geometry.triangles.push(Triangle { vertices, shape });
                }
            }
        }
        self
    }

    /// What a ray meets.
    pub fn hit(&self, ray: &Ray) -> Option<SurfacePoint> {
        let hit = self.closest_hit(ray);
        hit.is_hit()
            .then(|| surface_at(&self.geometry.tables(), ray, &hit))
    }

    /// The chain from `start` through the surfaces met on the way to each of `guesses`, to `end`. Each vertex is made
    /// by `vertex`, which is told its place.
    pub fn chain(
        &self,
        start: ChainVertex,
        guesses: &[Vec3],
        end: ChainVertex,
        vertex: impl Fn(usize, ChainVertex) -> ChainVertex,
    ) -> Option<(Vertices, usize)> {
        let mut vertices = [ChainVertex::NONE; MAX_CHAIN];
        vertices[0] = start;
        for (i, guess) in guesses.iter().enumerate() {
            let from = vertices[i];
            let d = (*guess - from.position).normalize();
            let side = from.geometric_normal.dot(d).signum();
            let origin = from.position + from.geometric_normal * side * from.position_error;
            let point = self.hit(&Ray::new(origin, d))?;
            vertices[i + 1] = vertex(i + 1, ChainVertex::from_surface(&point));
        }
        vertices[guesses.len() + 1] = end;
        Some((vertices, guesses.len() + 2))
    }
}

impl Traverse for Mirrors {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        brute_force::closest_hit(&self.geometry.tables(), ray)
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.closest_hit(ray).is_hit()
    }
}

/// A specular vertex of reflection.
pub fn mirror(_: usize, x: ChainVertex) -> ChainVertex {
    x.scattering(false, 1.0, Vec2::ZERO)
}
