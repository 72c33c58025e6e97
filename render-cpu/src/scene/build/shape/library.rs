//! The material libraries of OBJ files as BSDFs, for faces to which the scene gives none.

use crate::bytes::read_file;
use crate::mesh::mtl::{self, MtlMaterial};
use crate::scene::error::{Location, SceneError};
use crate::scene::xml::{Object, ObjectKind, find, parse_definitions};
use std::path::{Path, PathBuf};
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
        let mut materials = match read_file(&path, MAX_BYTES) {
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
        let wanted: Vec<(usize, &mut MtlMaterial)> = materials
            .iter_mut()
            .filter_map(|m| Some((names.iter().position(|name| *name == m.name)?, m)))
            .filter(|(index, _)| found[*index].is_none())
            .collect();
        let mut text = String::from("<scene version=\"0.6.0\">");
        let mut line = 1;
        let mut places = Vec::new();
        for (index, material) in wanted {
            find_maps(object, &path, &folder, material);
            say_what_is_lost(object, &path, material)?;
            // Each on its own line of the library, so that messages name that.
            while line < material.line {
                text.push('\n');
                line += 1;
            }
            text.push_str(&material.bsdf());
            places.push(index);
        }
        text.push_str("</scene>");
        let root = parse_definitions(&text, &path, FIRST_INDEX + *count * INDICES, object)?;
        *count += 1;
        for (index, child) in places.iter().zip(root.children_of(ObjectKind::Bsdf)) {
            found[*index] = Some(child.object.clone());
        }
    }
    Ok(found)
}

/// Replaces the names of a material's maps by the files that there are, beside the library or the mesh or where the scene's files
/// are sought; paths of other machines by their last part. A map that is nowhere is taken away, and this is said.
fn find_maps(object: &Object, library: &Path, folder: &Path, material: &mut MtlMaterial) {
    let of_library = library.parent().unwrap_or(folder).to_path_buf();
    let mut folders = vec![of_library, folder.to_path_buf()];
    folders.extend_from_slice(object.search_paths());
    let mut missing = Vec::new();
    for slot in material.maps() {
        let Some(map) = slot else {
            continue;
        };
        match locate(&folders, &map.file) {
            Some(path) => {
                // The library is read like a scene file in its own folder.
                let path = path.canonicalize().unwrap_or(path);
                map.file = path.to_string_lossy().into_owned();
            }
            None => {
                missing.push((
                    map.line,
                    format!("there is no map \"{}\"; it is left out", map.file),
                ));
                *slot = None;
            }
        }
    }
    material.warnings.extend(missing);
}

/// Says what of a material is not used as written.
fn say_what_is_lost(
    object: &Object,
    library: &Path,
    material: &MtlMaterial,
) -> Result<(), SceneError> {
    for (line, what) in &material.warnings {
        let location = Location {
            file: library.into(),
            line: u32::try_from(*line).unwrap_or(0),
            column: 0,
        };
        object.warn_at(
            &location,
            format!("the material \"{}\"", material.name),
            what,
        )?;
    }
    Ok(())
}

/// Where the libraries are: a line names one file, blanks and all, or several.
fn files(object: &Object, libraries: &[String], folder: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let mut files = Vec::new();
    let folders = [folder.to_path_buf()];
    for line in libraries {
        // A name with blanks, or several names.
        let line = line.trim_matches('"');
        if let Some(whole) = locate(&folders, line) {
            files.push(whole);
            continue;
        }
        for word in line.split_whitespace() {
            match locate(&folders, word) {
                Some(path) => files.push(path),
                None => object.property_warn(
                    "filename",
                    format!(
                        "the library {} (mtllib) is not there",
                        folder.join(word).display()
                    ),
                )?,
            }
        }
    }
    Ok(files)
}

/// A file as it is named, or of that name without its folders, which are those of another machine, or, as on other systems, with
/// letters of the other case.
fn locate(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    let is_file = |path: &PathBuf| path.is_file();
    let bare = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let in_any_case = || {
        let entries = folders.iter().filter_map(|f| f.read_dir().ok()).flatten();
        let mut same: Vec<PathBuf> = entries
            .flatten()
            .filter(|entry| entry.file_name().eq_ignore_ascii_case(bare))
            .map(|entry| entry.path())
            .filter(is_file)
            .collect();
        same.sort();
        same.into_iter().next()
    };
    let found = find(folders, name).filter(is_file);
    found
        .or_else(|| find(folders, bare).filter(is_file))
        .or_else(in_any_case)
}
