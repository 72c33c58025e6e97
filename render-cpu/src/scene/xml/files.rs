//! Files of a scene: reading one, including others, and the search paths of further files.

use std::path::{Path, PathBuf};

use roxmltree::{Document as Xml, Node, ParsingOptions};

use super::document::RawValue;
use super::element::Element;
use super::limits;
use super::loader::{FileContext, Loader};
use super::object::ObjectKind;
use super::source::{self, Source};
use crate::scene::error::{Location, SceneError, searched};

impl Loader<'_> {
    /// Reads one file; `parent` is the object that includes it, and the name that it gives to an included object.
    pub(super) fn file(
        &mut self,
        source: &Source,
        search_paths: &[PathBuf],
        parent: Option<(usize, &str)>,
    ) -> Result<(), SceneError> {
        let options = ParsingOptions {
            allow_dtd: false,
            // Text, comments and attributes' name spaces count as nodes too.
            nodes_limit: (4 * limits::MAX_ELEMENTS) as u32,
            ..ParsingOptions::default()
        };
        let xml = Xml::parse_with_options(&source.text, options).map_err(|error| {
            let mut location = Location::of_file(source.path.clone());
            location.line = error.pos().row;
            location.column = error.pos().col;
            SceneError::File {
                location,
                message: format!("malformed XML: {}", message_without_location(&error)),
            }
        })?;
        for (line, what) in &source.notes {
            let location = Location {
                file: source.path.clone(),
                line: *line,
                column: 0,
            };
            self.diagnostics.warn(&location, "XML", what)?;
        }
        self.document.files.push(source.path.to_path_buf());
        self.open_files.push(identity(&source.path));
        let folder = match source.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let mut context = FileContext {
            source,
            search_paths: source::prepended(search_paths, folder),
            is_legacy: false,
        };
        let root = xml.root_element();
        let version = root.attribute("version").and_then(major_version);
        context.is_legacy = version.is_some_and(|major| major < 2);
        let element = self.element(root, &context)?;
        let Some(kind) = ObjectKind::from_element(element.tag) else {
            return Err(element.error("the outermost element must be <scene>"));
        };
        if element.attribute("version").is_none() {
            element.warn("the attribute \"version\" is missing; 3.0.0 is assumed")?;
        } else if version.is_none() {
            element.warn("the attribute \"version\" is none; 3.0.0 is assumed")?;
        } else if version > Some(NEWEST_VERSION) {
            element.warn("the version is newer than what is known; 3.0.0 is assumed")?;
        }
        match parent {
            None if kind != ObjectKind::Scene => {
                return Err(element.error("the outermost element must be <scene>"));
            }
            Some((parent, _)) if kind == ObjectKind::Scene => {
                self.children(root, parent, &mut context)?
            }
            Some((parent, name)) => {
                let index = self.object(root, &element, kind, &mut context)?;
                let name = match name {
                    "" => element.attribute("name").unwrap_or(""),
                    name => name,
                };
                self.document.add(
                    parent,
                    name,
                    RawValue::Nested(index),
                    &element,
                    kind.element(),
                )?;
            }
            None => {
                self.object(root, &element, kind, &mut context)?;
            }
        }
        self.open_files.pop();
        Ok(())
    }

    pub(super) fn path(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        context: &mut FileContext<'_>,
    ) -> Result<(), SceneError> {
        element.check_attributes(&["value"])?;
        let depth_in_file = node.ancestors().filter(Node::is_element).count();
        if depth_in_file != 2 {
            return Err(element.error("belongs directly inside of the outermost element"));
        }
        let value = element.require("value")?;
        let folder = source::find(&context.search_paths, value)
            .filter(|folder| folder.is_dir())
            .ok_or_else(|| {
                element.error(format!(
                    "no folder \"{value}\"; searched {}",
                    searched(&context.search_paths)
                ))
            })?;
        context.search_paths = source::prepended(&context.search_paths, folder);
        Ok(())
    }

    pub(super) fn include(
        &mut self,
        element: &Element<'_>,
        parent: usize,
        context: &FileContext<'_>,
    ) -> Result<(), SceneError> {
        element.check_attributes(&["filename", "name"])?;
        let file = element.require("filename")?;
        let path = source::find(&context.search_paths, file).ok_or_else(|| {
            element.error(format!(
                "no file \"{file}\"; searched {}",
                searched(&context.search_paths)
            ))
        })?;
        if self.open_files.contains(&identity(&path)) {
            return Err(element.error("the file includes itself, directly or through others"));
        }
        if self.open_files.len() >= limits::MAX_INCLUDE_DEPTH {
            let message = format!(
                "files are included more than {} deep",
                limits::MAX_INCLUDE_DEPTH
            );
            return Err(element.error(message));
        }
        if self.document.files.len() >= limits::MAX_FILES {
            return Err(element.error(format!(
                "more than {} files are included",
                limits::MAX_FILES
            )));
        }
        let source = Source::read(&path, &mut self.budget)?;
        let name = element.attribute("name").unwrap_or("");
        self.file(&source, &context.search_paths, Some((parent, name)))
    }
}

/// Files of Mitsuba 3 are of this version.
const NEWEST_VERSION: u32 = 3;

/// The first number of a version of up to three.
fn major_version(version: &str) -> Option<u32> {
    let mut numbers = version.trim().split('.').map(str::parse::<u32>);
    let major = numbers.next()?.ok()?;
    let rest: Result<Vec<u32>, _> = numbers.collect();
    rest.is_ok_and(|rest| rest.len() <= 2).then_some(major)
}

/// What makes two paths the same file.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// The message of the XML reader without its location, which is printed in our own form.
fn message_without_location(error: &roxmltree::Error) -> String {
    if matches!(error, roxmltree::Error::NoRootNode) {
        return "there is no element in it; is it a scene file?".to_owned();
    }
    let message = error.to_string();
    let location = format!(" at {}", error.pos());
    message
        .strip_suffix(&location)
        .unwrap_or(&message)
        .to_owned()
}
