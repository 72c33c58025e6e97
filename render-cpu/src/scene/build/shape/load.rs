//! Mesh files of shapes.

use crate::mesh::obj::Shape;
use crate::mesh::{self, Mesh};
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use std::sync::Arc;

/// The mesh that a shape plugin names, in its own space.
pub(super) fn mesh(object: &Object) -> Result<Mesh, SceneError> {
    let path = object.require_file("filename")?;
    let flip = |default| object.get_bool("flip_tex_coords", default);
    let files = object.file_cache();
    let mesh = match object.plugin.as_str() {
        "obj" => {
            // The groups of a file are always one shape, as with `collapse` of Mitsuba 0.6; the image is the same.
            object.get("collapse");
            let flip = flip(mesh::obj::DEFAULT_FLIP_TEX_COORDS)?;
            let index = object.get_int_in("shape_index", -1, -1, i64::from(u32::MAX))?;
            let shape = match u32::try_from(index) {
                Ok(index) if !object.get_bool("collapse", false)? => Shape::Numbered(index),
                _ => Shape::All,
            };
            let variant = u64::from(flip) | ((index + 1) as u64) << 1;
            files.get(&path, variant, || mesh::obj::load_shape(&path, flip, shape))
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
    for warning in mesh.warnings.drain(..) {
        object.property_warn("filename", format!("{}: {warning}", path.display()))?;
    }
    if !mesh.texture_files.is_empty() && object.single_child_of(ObjectKind::Bsdf)?.is_none() {
        object.property_warn(
            "filename",
            format!(
                "{}: its texture is not read; a BSDF with a bitmap of {} shows it",
                path.display(),
                mesh.texture_files.join(", ")
            ),
        )?;
    }
    // Mitsuba 0.6 takes the colours of PLY files as encoded unless told otherwise.
    if object.plugin == "ply" && object.is_legacy && object.get_bool("srgb", true)? {
        for attribute in &mut mesh.vertex_attributes {
            if attribute.name == "vertex_color" {
                let linear = |v: f32| crate::scene::color::srgb_to_linear(v.into()) as f32;
                attribute.values.iter_mut().for_each(|v| *v = linear(*v));
            }
        }
    }
    let asks_for_faces = object.get_bool("face_normals", false)?;
    mesh.face_normals |= asks_for_faces;
    if let Some(angle) = object.opt_float("max_smooth_angle")? {
        if asks_for_faces {
            return Err(object.property_error(
                "max_smooth_angle",
                "cannot be given together with face normals",
            ));
        }
        if !(0.0..=180.0).contains(&angle) {
            return Err(
                object.property_error("max_smooth_angle", "is no angle of 0 to 180 degrees")
            );
        }
        // The file's own wish for face normals is older than this one.
        mesh.face_normals = false;
        mesh.max_smooth_angle = Some(angle.to_radians() as f32);
    }
    if mesh.triangles.is_empty() {
        object.property_warn(
            "filename",
            format!(
                "{}: has no face with an area; the shape is left out",
                path.display()
            ),
        )?;
    }
    Ok(mesh)
}
