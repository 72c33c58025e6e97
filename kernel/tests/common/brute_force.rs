//! Ray tracing by trying every primitive of the tables; no instances.

use glam::Vec3;
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::scene::intersect::{ShearedRay, intersect_quadric, intersect_triangle};
use halflight_kernel::scene::{Hit, Tables};

/// The nearest hit.
pub fn closest_hit(tables: &Tables<'_>, ray: &Ray) -> Hit {
    let mut hit = Hit::MISS;
    let sheared = ShearedRay::new(ray.origin, ray.direction);
    for (i, t) in tables.triangles.iter().enumerate() {
        let [p, q, r] = t
            .vertices
            .map(|v| Vec3::from_array(tables.positions[v as usize]));
        let h = intersect_triangle(&sheared, p, q, r, ray.t_min, ray.t_max.min(hit.t));
        if h.t < hit.t {
            hit = Hit {
                t: h.t,
                b1: h.b1,
                b2: h.b2,
                primitive: i as u32,
                instance: 0,
            };
        }
    }
    for (i, q) in tables.quadrics.iter().enumerate() {
        let origin = transform_point(&q.to_object, ray.origin);
        let direction = transform_vector(&q.to_object, ray.direction);
        let t = intersect_quadric(q.kind, origin, direction, ray.t_min, ray.t_max.min(hit.t));
        if t < hit.t {
            hit = Hit {
                t,
                primitive: (tables.triangles.len() + i) as u32,
                instance: 0,
                ..Hit::MISS
            };
        }
    }
    hit
}
