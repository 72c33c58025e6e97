//! The material libraries of OBJ files as BSDFs, for faces to which the scene gives none.

use crate::bytes::read_file;
use crate::mesh::mtl::{self, MtlMaterial};
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind, parse_definitions};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// The longest library.
const MAX_BYTES: u64 = 64 << 20;

/// Objects of the scene file have smaller indices; libraries count from here on, so many each.
const FIRST_INDEX: usize = 1 << 40;
const INDICES: usize = 1 << 20;

/// The BSDFs of the materials `names`, in their order, from the libraries that a mesh names; `count` is the number of libraries that
/// were read before. What is missing is said.
pub(super) fn bsdfs(
    object: &Object,
    libraries: &[String],
    names: &[String],
    count: &mut usize,
) -> Result<Vec<Option<Arc<Object>>>, SceneError> {
    let mut found = vec![None; names.len()];
    let mesh = object.require_file("filename")?;
    let folder = mesh.parent().map(PathBuf::from).unwrap_or_default();
    for path in files(object, libraries, &folder)? {
        let materials = match read_file(&path, MAX_BYTES) {
            Ok(bytes) => mtl::read(&bytes),
            Err(error) => {
                object.property_warn(
                    "filename",
                    format!(
                        "{}: its library {} cannot be read: {error}",
                        mesh.display(),
                        path.display()
                    ),
                )?;
                continue;
            }
        };
        let wanted: Vec<(usize, &MtlMaterial)> = materials
            .iter()
            .filter_map(|m| Some((names.iter().position(|name| *name == m.name)?, m)))
            .filter(|(place, _)| found[*place].is_none())
            .collect();
        let mut text = String::from("<scene version=\"0.6.0\">");
        for (_, material) in &wanted {
            // Writing to a string does not fail.
            let _ = write!(text, "{}", material.bsdf());
        }
        text.push_str("</scene>");
        let root = parse_definitions(&text, &path, FIRST_INDEX + *count * INDICES, object)?;
        *count += 1;
        for ((place, _), child) in wanted.iter().zip(root.children_of(ObjectKind::Bsdf)) {
            found[*place] = Some(child.object.clone());
        }
    }
    Ok(found)
}

/// Where the libraries are: a line names one file, blanks and all, or several.
fn files(
    object: &Object,
    libraries: &[String],
    folder: &std::path::Path,
) -> Result<Vec<PathBuf>, SceneError> {
    let mut files = Vec::new();
    for line in libraries {
        let whole = folder.join(line);
        if whole.is_file() {
            files.push(whole);
            continue;
        }
        for word in line.split_whitespace() {
            let path = folder.join(word);
            if path.is_file() {
                files.push(path);
            } else {
                object.property_warn(
                    "filename",
                    format!("the library {} (mtllib) is not there", path.display()),
                )?;
            }
        }
    }
    Ok(files)
}
