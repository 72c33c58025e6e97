//! Which scattering model the surface of a shape has, or each part of it.

use super::library;
use crate::mesh::{MaterialNames, Mesh};
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use std::sync::Arc;

/// The BSDF of a shape that takes but one.
pub(super) fn only(object: &Object) -> Result<Option<Arc<Object>>, SceneError> {
    Ok(object.single_child_of(ObjectKind::Bsdf)?.cloned())
}

/// A part of a mesh and its BSDF.
pub(super) type Part = (Mesh, Option<Arc<Object>>);

/// The parts of a mesh with their BSDFs.
///
/// In Mitsuba 0.6 the name of a BSDF within an OBJ shape is that of a material in the file (`usemtl`); one without a name
/// is for all others. A single BSDF is for the whole mesh unless it names a material of a file before version 2.
///
/// Materials to which the scene gives no BSDF take that of the file's libraries (`mtllib`), unless `load_materials` forbids;
/// `libraries_read` counts them.
pub(super) fn parts(
    object: &Object,
    mesh: Mesh,
    libraries_read: &mut usize,
) -> Result<Vec<Part>, SceneError> {
    let children: Vec<_> = object.children_of(ObjectKind::Bsdf).collect();
    let material_of = |name: &str| mesh.materials.names.iter().position(|known| known == name);
    let is_general = |name: &str| name.is_empty() || name == "bsdf";
    let is_whole = match &children[..] {
        [] => true,
        [child] => !object.is_legacy || material_of(child.name()).is_none(),
        _ => object.plugin != "obj",
    };
    let wants_materials =
        object.plugin == "obj" && object.get_bool("load_materials", object.is_legacy)?;
    let wants_materials = wants_materials && !mesh.materials.names.is_empty();
    let loads_materials = wants_materials && !mesh.materials.libraries.is_empty();
    if wants_materials && !loads_materials && children.is_empty() {
        object.warn(
            "the faces have materials (usemtl), but the file names no library of them (mtllib); the shape is diffuse with a reflectance of 0.5",
        )?;
    }
    let mut of_library = vec![None; mesh.materials.names.len().max(1)];
    if loads_materials && (children.is_empty() || !is_whole) {
        let MaterialNames {
            names, libraries, ..
        } = &mesh.materials;
        of_library = library::bsdfs(object, libraries, names, libraries_read)?;
    }
    if is_whole && !(loads_materials && children.is_empty()) {
        if let [child] = &children[..]
            && object.is_legacy
            && object.plugin == "obj"
            && !is_general(child.name())
        {
            object.property_warn(
                child.name(),
                format!(
                    "no face of the file has this material (usemtl){}; the BSDF is for the whole shape",
                    there_are(&mesh.materials.names)
                ),
            )?;
        }
        return Ok(vec![(mesh, only(object)?)]);
    }
    let mut of_rest = None;
    let mut of_material = vec![None; mesh.materials.names.len().max(1)];
    for child in &children {
        let slot = if is_general(child.name()) {
            &mut of_rest
        } else if let Some(material) = material_of(child.name()) {
            &mut of_material[material]
        } else {
            object.property_warn(
                child.name(),
                format!(
                    "no face of the file has this material (usemtl), and the BSDF is left out{}",
                    there_are(&mesh.materials.names)
                ),
            )?;
            continue;
        };
        if slot.is_some() {
            return Err(SceneError::element(
                &child.property.location,
                child.property.element(),
                format!("{} has a BSDF for this already", object.element()),
            ));
        }
        *slot = Some(child.object.clone());
    }
    let mut parts = Vec::new();
    for (index, bsdf) in of_material.into_iter().enumerate() {
        let part = mesh.part(index as u32);
        if part.triangles.is_empty() {
            continue;
        }
        let bsdf = bsdf.or_else(|| of_rest.clone());
        let bsdf = bsdf.or_else(|| of_library.get(index).cloned().flatten());
        if bsdf.is_none() {
            let faces = match mesh.materials.names.get(index).map_or("", String::as_str) {
                "" => "without a material".to_owned(),
                name => format!("of the material \"{name}\""),
            };
            object.warn(format!(
                "there is no BSDF for the faces {faces} (usemtl); they get a diffuse reflectance of 0.5"
            ))?;
        }
        parts.push((part, bsdf));
    }
    Ok(parts)
}

/// The materials of a file, for a message.
fn there_are(names: &[String]) -> String {
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let known = known.join(", ");
    match known.trim_start_matches(", ") {
        "" => String::new(),
        known => format!("; there are: {known}"),
    }
}

/// Whether the surface is only the boundary of a medium: before version 2, that of a shape with a medium and without a BSDF.
///
/// Media themselves are not supported: what they would scatter and absorb is left out with a warning.
pub(super) fn is_index_matched(
    object: &Object,
    bsdf: Option<&Arc<Object>>,
) -> Result<bool, SceneError> {
    let mut has_medium = false;
    for child in object.children_of(ObjectKind::Medium) {
        has_medium = true;
        // Said once for each medium, however many shapes it has.
        if !child.object.touched() {
            child.object.ignore();
            child
                .object
                .warn("media are not supported: light neither scatters in it nor is absorbed")?;
        }
    }
    Ok(has_medium && bsdf.is_none() && object.is_legacy)
}
