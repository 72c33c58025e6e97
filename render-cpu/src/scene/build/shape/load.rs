//! Mesh files of shapes.

use crate::mesh::{self, Mesh, MeshError};
use crate::scene::error::SceneError;
use crate::scene::xml::Object;

/// The mesh that a shape plugin names, in its own space.
pub(super) fn mesh(object: &Object) -> Result<Mesh, SceneError> {
    let path = object.require_file("filename")?;
    let fail = |e: MeshError| object.property_error("filename", e.to_string());
    let flip = |default| object.get_bool("flip_tex_coords", default);
    let mut mesh = match object.plugin.as_str() {
        "obj" => mesh::obj::load(&path, flip(mesh::obj::DEFAULT_FLIP_TEX_COORDS)?).map_err(fail)?,
        "ply" => mesh::ply::load(&path, flip(mesh::ply::DEFAULT_FLIP_TEX_COORDS)?).map_err(fail)?,
        _ => {
            let index = object.get_int_in("shape_index", 0, 0, i64::from(u32::MAX))? as u32;
            mesh::serialized::load(&path, index).map_err(fail)?
        }
    };
    // Mitsuba 0.6: vertices of faces that meet at a larger angle were split apart.
    object.get("max_smooth_angle");
    mesh.face_normals |= object.get_bool("face_normals", false)?;
    Ok(mesh)
}
