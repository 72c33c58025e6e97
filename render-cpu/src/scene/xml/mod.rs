//! Mitsuba scene files, versions 0.6, 2 and 3, as a tree of objects.
//!
//! [`parse_scene`] reads a file with everything that it includes, substitutes parameters, replaces names of version 0.6 by
//! current ones, resolves references and returns the root [`Object`]. Nothing is built yet: an object is a kind, a plugin name
//! and typed properties, with its location in the file. It records which of its properties were queried, so that [`unused`]
//! can report those that were not understood.
//!
//! The resources that hostile files can consume are bounded: see [`limits`].

mod document;
mod edit;
mod element;
mod elements;
mod files;
mod getters;
mod kind;
mod lenient;
pub mod limits;
mod loader;
pub(crate) mod numbers;
mod object;
mod parameters;
mod resolve;
mod source;
mod transforms;
pub mod unused;
mod upgrade;
mod value;

pub(crate) use source::{decode, find, read_repaired, read_text, refuse_image};

pub use edit::NamedValue;
pub use getters::{ColorSource, FloatSource};
pub use object::{Child, Object, ObjectKind, Properties, Property, Value};
pub use parameters::DeclaredParameter;
pub use value::{Color, Spectrum};

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::{Diagnostics, Location, SceneError, Warning};
use super::file_cache::FileCache;

/// A scene that was read, and what was noticed meanwhile.
#[derive(Debug)]
pub struct ParsedScene {
    /// The `<scene>` element.
    pub root: Arc<Object>,
    /// Every scene file that was read, the first one first.
    pub files: Vec<PathBuf>,
    /// Where warnings go; shared with every object, see [`Object::warn`].
    pub diagnostics: Arc<Diagnostics>,
    /// What was read from other files; shared with every object.
    pub file_cache: Arc<FileCache>,
    /// The parameters that the scene has defaults for.
    pub parameters: Arc<[DeclaredParameter]>,
}

impl ParsedScene {
    /// The warnings so far: those of reading, and those that were added through [`Object::warn`] since.
    pub fn warnings(&self) -> Vec<Warning> {
        self.diagnostics.warnings()
    }
}

/// Reads a scene file.
///
/// `defines` are the parameters `-D name=value`, later ones win. When `strict`, warnings are errors.
///
/// # Errors
/// The first reason that makes the scene unreadable: a missing file, malformed XML, an element that is not allowed where it
/// occurs, a malformed value, a broken or circular reference, an unused parameter.
pub fn parse_scene(
    path: &Path,
    defines: &[(String, String)],
    strict: bool,
) -> Result<ParsedScene, SceneError> {
    let diagnostics = Arc::new(Diagnostics::new(strict));
    let mut parameters = parameters::Parameters::new(defines)?;
    let document = loader::load(loader::Origin::File(path), &mut parameters, &diagnostics)?;
    finish(document, parameters, diagnostics)
}

/// Reads a scene from memory; `name` serves as the file name in messages, and relative files are searched beside it.
///
/// # Errors
/// As [`parse_scene`].
pub fn parse_scene_from_str(
    text: &str,
    name: &Path,
    defines: &[(String, String)],
    strict: bool,
) -> Result<ParsedScene, SceneError> {
    let diagnostics = Arc::new(Diagnostics::new(strict));
    let mut parameters = parameters::Parameters::new(defines)?;
    let document = loader::load(
        loader::Origin::Text(text, name),
        &mut parameters,
        &diagnostics,
    )?;
    finish(document, parameters, diagnostics)
}

/// Reads definitions that belong to an object of another scene: warnings go where its own go, and the objects' indices begin at
/// `first_index`, so that they are not taken for those of that scene. Relative files are searched beside `name`.
///
/// # Errors
/// As [`parse_scene`].
pub(crate) fn parse_definitions(
    text: &str,
    name: &Path,
    first_index: usize,
    of: &Object,
) -> Result<Arc<Object>, SceneError> {
    let mut parameters = parameters::Parameters::new(&[])?;
    // A dollar sign in a file's name is one.
    parameters.set_default("", "$");
    let origin = loader::Origin::Text(text, name);
    let document = loader::load(origin, &mut parameters, &of.diagnostics)?;
    resolve::resolve_from(document, first_index, &of.diagnostics, &of.file_cache)
}

fn finish(
    document: document::Document,
    parameters: parameters::Parameters,
    diagnostics: Arc<Diagnostics>,
) -> Result<ParsedScene, SceneError> {
    let files = document.files.clone();
    for name in parameters.unused()? {
        let file = files.first().map(PathBuf::as_path).unwrap_or(Path::new(""));
        diagnostics.warn(
            &Location::of_file(file),
            format!("-D {name}"),
            "the scene has a default for this parameter and uses it nowhere",
        )?;
    }
    let file_cache = Arc::new(FileCache::default());
    let root = resolve::resolve(document, &diagnostics, &file_cache)?;
    Ok(ParsedScene {
        root,
        files,
        diagnostics,
        file_cache,
        parameters: parameters.declared().into(),
    })
}
