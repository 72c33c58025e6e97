//! Rectangles, cubes, spheres, disks and cylinders.
//!
//! Flat faces become triangles, whose differential geometry is exact. Curved ones stay analytic: the record holds the
//! affine map of a canonical surface.

use crate::mesh::Mesh;
use crate::scene::error::SceneError;
use crate::scene::transform::{self, TransformError};
use crate::scene::xml::Object;
use glam::{DMat4, DVec3};
use halflight_kernel::scene::quadric_kind;

/// The square [-1, 1]^2 in z = 0 with normal +z and uv from (0, 0) at (-1, -1).
pub(super) fn rectangle(to_world: DMat4) -> Mesh {
    let mut mesh = Mesh {
        positions: vec![
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
        ],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        face_normals: true,
        ..Mesh::default()
    };
    keep_orientation(&mut mesh, to_world);
    mesh
}

/// The cube [-1, 1]^3 with outward normals; every face has the whole unit square of uv.
pub(super) fn cube(to_world: DMat4) -> Mesh {
    // Per face: corner of uv (0, 0), then the steps along v and along u; normal = (step u) x (step v).
    const FACES: [([f32; 3], [f32; 3], [f32; 3]); 6] = [
        ([-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([1.0, 1.0, 1.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]),
        ([1.0, -1.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
        ([-1.0, -1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([-1.0, -1.0, -1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ([-1.0, 1.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]),
    ];
    let mut mesh = Mesh {
        face_normals: true,
        ..Mesh::default()
    };
    for (corner, v_step, u_step) in FACES {
        let first = mesh.positions.len() as u32;
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let mut p = [0.0; 3];
            for axis in 0..3 {
                p[axis] = corner[axis] + 2.0 * (u * u_step[axis] + v * v_step[axis]);
            }
            mesh.positions.push(p);
            mesh.uvs.push([u, v]);
        }
        // v is left of u seen from outside, as in Mitsuba.
        mesh.triangles.push([first, first + 2, first + 1]);
        mesh.triangles.push([first, first + 3, first + 2]);
    }
    keep_orientation(&mut mesh, to_world);
    mesh
}

/// Reverses the winding under a mirroring transform, so that normals keep pointing where the map of the normal points.
fn keep_orientation(mesh: &mut Mesh, to_world: DMat4) {
    if transform::flips_orientation(&to_world) {
        for t in &mut mesh.triangles {
            t.swap(1, 2);
        }
    }
}

/// Kind and map of a sphere, disk or cylinder; nothing, with a warning, where it has no area.
pub(super) fn quadric(object: &Object) -> Result<Option<(u32, DMat4)>, SceneError> {
    let to_world = object.get_transform("to_world")?;
    let radius = |default| -> Result<f64, SceneError> {
        let radius = object.get_float("radius", default)?;
        if radius < 0.0 {
            return Err(object.property_error("radius", "cannot be negative"));
        }
        Ok(radius)
    };
    let (kind, map) = match object.plugin.as_str() {
        "sphere" => {
            let center = DVec3::from_array(object.get_vector("center", [0.0; 3])?);
            (
                quadric_kind::SPHERE,
                to_world
                    * DMat4::from_translation(center)
                    * DMat4::from_scale(DVec3::splat(radius(1.0)?)),
            )
        }
        "cylinder" => {
            let p0 = DVec3::from_array(object.get_vector("p0", [0.0; 3])?);
            let p1 = DVec3::from_array(object.get_vector("p1", [0.0, 0.0, 1.0])?);
            let axis = p1 - p0;
            let (x, y) = tangents(axis.normalize_or(DVec3::Z));
            let r = radius(1.0)?;
            (
                quadric_kind::CYLINDER,
                to_world
                    * DMat4::from_cols(
                        (x * r).extend(0.0),
                        (y * r).extend(0.0),
                        axis.extend(0.0),
                        p0.extend(1.0),
                    ),
            )
        }
        _ => (quadric_kind::DISK, to_world),
    };
    if transform::inverse(&map) == Err(TransformError::Singular) {
        object.warn("has no size, or its transform flattens it; the shape is left out")?;
        return Ok(None);
    }
    Ok(Some((kind, map)))
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al. 2017), in f64.
fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        DVec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn normals(mesh: &Mesh, to_world: DMat4) -> Vec<(Vec3, Vec3)> {
        mesh.triangles
            .iter()
            .map(|t| {
                let p = t.map(|i| {
                    let p = mesh.positions[i as usize];
                    to_world
                        .transform_point3(DVec3::new(p[0].into(), p[1].into(), p[2].into()))
                        .as_vec3()
                });
                (
                    (p[1] - p[0]).cross(p[2] - p[0]).normalize(),
                    (p[0] + p[1] + p[2]) / 3.0,
                )
            })
            .collect()
    }

    #[test]
    fn a_cube_looks_outwards_even_when_mirrored() {
        for scale in [DVec3::ONE, DVec3::new(-1.0, 2.0, 0.5)] {
            let m = DMat4::from_scale(scale);
            for (normal, center) in normals(&cube(m), m) {
                assert!(normal.dot(center) > 0.0, "{normal} at {center}");
            }
        }
    }

    #[test]
    fn a_rectangle_faces_along_the_mapped_z() {
        for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0)] {
            let m = DMat4::from_scale(scale);
            for (normal, _) in normals(&rectangle(m), m) {
                assert!(normal.z > 0.99);
            }
        }
    }
}
