//! Placement of a mesh in the world or in its group: transformed, with the normals that it has there.

use crate::mesh::{MIN_SHARE, Mesh};
use crate::scene::error::SceneError;
use crate::scene::transform::{self, TransformError};
use crate::scene::xml::Object;
use glam::{DMat3, DMat4, DVec3};
use halflight_kernel::scene::Triangle;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

/// Mean length of the edges of triangles; of no more than some thousand of them, evenly chosen.
pub(super) fn mean_edge(positions: &[[f32; 3]], triangles: &[Triangle]) -> f32 {
    const MOST: usize = 4096;
    let step = triangles.len().div_ceil(MOST).max(1);
    let (mut sum, mut count) = (0.0, 0.0);
    for triangle in triangles.iter().step_by(step) {
        let corners = triangle
            .vertices
            .map(|i| glam::Vec3::from(positions[i as usize]));
        for k in 0..3 {
            sum += f64::from(corners[k].distance(corners[(k + 1) % 3]));
            count += 1.0;
        }
    }
    if count > 0.0 {
        (sum / count) as f32
    } else {
        0.0
    }
}

/// Moves the items of one vector to the end of another; the first ones without a copy.
pub(super) fn append<T>(all: &mut Vec<T>, more: &mut Vec<T>) {
    if all.is_empty() {
        std::mem::swap(all, more);
    } else {
        all.append(more);
    }
}

/// Transforms a mesh into the world (or its group's space) and computes its normals there.
pub(super) fn transform_mesh(
    object: &Object,
    mesh: &mut Mesh,
    to_world: DMat4,
) -> Result<(), SceneError> {
    let normal_to_world = match transform::inverse(&to_world) {
        Ok(inverse) => Some(DMat3::from_mat4(inverse).transpose()),
        // What it flattens still has faces, or some of them.
        Err(TransformError::Singular) => None,
        Err(e) => return Err(object.property_error("to_world", e.to_string())),
    };
    let wide = |v: &[f32; 3]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    let positions = mesh.positions.par_iter_mut().with_min_len(MIN_SHARE);
    let all_finite = positions
        .map(|p| {
            let moved = to_world.transform_point3(wide(p)).as_vec3();
            *p = moved.to_array();
            moved.is_finite()
        })
        .all(|finite| finite);
    if !all_finite {
        return Err(object.error("to_world moves a vertex beyond the range of numbers"));
    }
    if normal_to_world.is_none() {
        mesh.normals.clear();
        mesh.drop_degenerate_triangles();
        for warning in mesh.warnings.drain(..) {
            object.property_warn("to_world", format!("flattens the mesh: {warning}"))?;
        }
        if mesh.triangles.is_empty() {
            return object.warn("has no face with an area once it is placed; it is left out");
        }
    }
    if let Some(angle) = mesh.max_smooth_angle {
        mesh.split_at_creases(angle);
    }
    if mesh.face_normals {
        mesh.normals.clear();
    } else if mesh.normals.is_empty() {
        // Angles are those in the world, so this comes after the transform.
        mesh.compute_vertex_normals();
    } else if let Some(normal_to_world) = normal_to_world {
        let normals = mesh.normals.par_iter_mut().with_min_len(MIN_SHARE);
        normals.for_each(|n| {
            *n = (normal_to_world * wide(n))
                .normalize_or_zero()
                .as_vec3()
                .to_array();
        });
    }
    Ok(())
}
