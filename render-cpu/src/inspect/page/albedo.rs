//! One colour for each shape, so that objects are told apart: the mean albedo at some of its triangles.

use super::mesh::FlatMesh;
use glam::Vec3;
use halflight_kernel::math::Ray;
use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::aov;

/// Triangles of a shape that are looked at.
const SAMPLES: u32 = 12;

/// Colour of a shape that shows nowhere.
const UNKNOWN: [f32; 3] = [0.5; 3];

/// Linear colours of all shapes of a scene, of which `mesh` has the triangles.
pub(super) fn of_shapes<T: Traverse>(view: &SceneView<'_, T>, mesh: &FlatMesh) -> Vec<[f32; 3]> {
    let mut sums = vec![(Vec3::ZERO, 0.0); view.tables.shapes.len()];
    let near = 1e-3 * view.tables.info.radius;
    for [shape, first, count] in &mesh.ranges {
        let (sum, weight) = &mut sums[*shape as usize];
        if *weight > 0.0 {
            // Another instance of the same shape.
            continue;
        }
        for i in 0..SAMPLES.min(*count) {
            let triangle =
                first + (u64::from(i) * u64::from(*count) / u64::from(SAMPLES.min(*count))) as u32;
            let corners = mesh.indices[triangle as usize];
            let [a, b, c] = corners.map(|v| Vec3::from_array(mesh.positions[v as usize]));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            if normal == Vec3::ZERO {
                continue;
            }
            // From both sides: a material may scatter on one alone.
            let seen = [1.0, -1.0].map(|side| {
                let origin = (a + b + c) / 3.0 + normal * (side * near);
                let mut sampler = IndependentSampler::new(0, triangle, i);
                let ray = Ray {
                    t_max: 4.0 * near,
                    ..Ray::new(origin, normal * -side)
                };
                aov::features(view, &mut sampler, &ray).albedo
            });
            let albedo = if seen[0].max_element() >= seen[1].max_element() {
                seen[0]
            } else {
                seen[1]
            };
            *sum += albedo.clamp(Vec3::ZERO, Vec3::ONE);
            *weight += 1.0;
        }
    }
    let mean = |(sum, weight): (Vec3, f32)| {
        if weight > 0.0 {
            (sum / weight).to_array()
        } else {
            UNKNOWN
        }
    };
    sums.into_iter().map(mean).collect()
}
