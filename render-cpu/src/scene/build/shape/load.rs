//! Mesh files of shapes.

use crate::mesh::{self, Mesh};
use crate::scene::error::SceneError;
use crate::scene::xml::Object;

/// The mesh that a shape plugin names; nothing, after a warning, when it has no triangle.
pub(super) fn mesh(object: &Object) -> Result<Option<Mesh>, SceneError> {
    let path = object.require_file("filename")?;
    let options = mesh::LoadOptions {
        face_normals: object.get_bool("face_normals", false)?,
        flip_tex_coords: object.opt_bool("flip_tex_coords")?,
        shape_index: object.get_int_in("shape_index", 0, 0, i64::from(u32::MAX))? as u32,
    };
    let fail = |e: mesh::MeshError| object.property_error("filename", e.to_string());
    let loaded = match object.plugin.as_str() {
        "obj" => mesh::obj::load(&path, &options).map_err(fail)?,
        "ply" => mesh::ply::load(&path, &options).map_err(fail)?,
        _ => mesh::serialized::load(&path, &options).map_err(fail)?,
    };
    for warning in &loaded.warnings {
        object.warn(warning.clone())?;
    }
    if loaded.mesh.triangles.is_empty() {
        object.warn("the mesh has no triangle; it is left out")?;
        return Ok(None);
    }
    Ok(Some(loaded.mesh))
}
