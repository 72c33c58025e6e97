//! Mesh files of shapes.

use crate::mesh::{self, Mesh};
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use std::sync::Arc;

/// The mesh that a shape plugin names, in its own space.
pub(super) fn mesh(object: &Object) -> Result<Mesh, SceneError> {
    let path = object.require_file("filename")?;
    let flip = |default| object.get_bool("flip_tex_coords", default);
    let files = object.kept_files();
    let mesh = match object.plugin.as_str() {
        "obj" => {
            let flip = flip(mesh::obj::DEFAULT_FLIP_TEX_COORDS)?;
            files.get(&path, flip.into(), || mesh::obj::load(&path, flip))
        }
        "ply" => {
            let flip = flip(mesh::ply::DEFAULT_FLIP_TEX_COORDS)?;
            files.get(&path, flip.into(), || mesh::ply::load(&path, flip))
        }
        _ => {
            let index = object.get_int_in("shape_index", 0, 0, i64::from(u32::MAX))? as u32;
            files.get(&path, index.into(), || mesh::serialized::load(&path, index))
        }
    };
    let mesh = mesh.map_err(|e| object.property_error("filename", e.to_string()))?;
    let mut mesh = Arc::unwrap_or_clone(mesh);
    // Mitsuba 0.6: vertices of faces that meet at a larger angle were split apart.
    object.get("max_smooth_angle");
    mesh.face_normals |= object.get_bool("face_normals", false)?;
    Ok(mesh)
}
