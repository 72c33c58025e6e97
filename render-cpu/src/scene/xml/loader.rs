//! From XML to a flat list of objects whose references are not resolved yet.
//!
//! Included files are read where they are named: their objects become children of the element that includes them, as
//! if written there, except that file names and versions count from their own file.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DMat4;
use roxmltree::{Document as Xml, Node, ParsingOptions};

use super::numbers::shortened;
use super::object::ObjectKind;
use super::parameters::Parameters;
use super::source::{self, Source};
use super::value::Value;
use super::{elements, limits, transforms, upgrade};
use crate::scene::error::{Diagnostics, Location, SceneError, searched, suggestion};

/// Where a scene comes from.
pub enum Origin<'a> {
    /// A file.
    File(&'a Path),
    /// A text, and the name of the file that it stands for.
    Text(&'a str, &'a Path),
}

/// A value, or a link to an object.
pub enum RawValue {
    /// A value.
    Value(Value),
    /// The object at an index of the document.
    Nested(usize),
    /// The object of a name.
    Reference(String),
}

/// A property before references are resolved.
pub struct RawProperty {
    /// In snake case, or empty.
    pub name: String,
    /// The value.
    pub value: RawValue,
    /// Where.
    pub location: Location,
    /// The element.
    pub tag: &'static str,
}

/// An object before references are resolved.
pub struct RawObject {
    /// What it is.
    pub kind: ObjectKind,
    /// Its plugin.
    pub plugin: String,
    /// Its name.
    pub id: Option<String>,
    /// Where.
    pub location: Location,
    /// For file names in its properties.
    pub search_paths: Arc<[PathBuf]>,
    /// In the order of the file.
    pub properties: Vec<RawProperty>,
}

/// Everything that was read; the root is object 0.
pub struct Document {
    /// Nested objects come after those that hold them.
    pub objects: Vec<RawObject>,
    /// Object of each name and alias.
    pub by_id: HashMap<String, usize>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// Reads a scene and everything that it includes.
pub fn load(
    origin: Origin<'_>,
    parameters: &mut Parameters,
    diagnostics: &Arc<Diagnostics>,
) -> Result<Document, SceneError> {
    let mut budget = limits::MAX_BYTES;
    let source = match origin {
        Origin::File(path) => Source::read(path, &mut budget)?,
        Origin::Text(text, name) => Source::new(name, text.to_owned()),
    };
    let mut loader = Loader {
        document: Document {
            objects: Vec::new(),
            by_id: HashMap::new(),
            files: Vec::new(),
        },
        parameters,
        diagnostics,
        budget,
        elements: 0,
        depth: 0,
        open_files: Vec::new(),
    };
    loader.file(&source, &[], None)?;
    Ok(loader.document)
}

/// An element with its parameters put in.
pub struct Element<'a> {
    /// Its name.
    pub tag: &'a str,
    /// Where file names are sought.
    pub search_paths: Arc<[PathBuf]>,
    location: Location,
    attributes: Vec<(&'a str, Cow<'a, str>)>,
    diagnostics: Arc<Diagnostics>,
}

impl Element<'_> {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(known, _)| *known == name);
        found.map(|(_, value)| value.as_ref())
    }
    /// The value of an attribute that must be there.
    pub fn require(&self, name: &str) -> Result<&str, SceneError> {
        self.attribute(name)
            .ok_or_else(|| self.error(format!("the attribute \"{name}\" is missing")))
    }
    /// The value of an attribute that must be there, converted.
    pub fn parse<T>(
        &self,
        name: &str,
        convert: impl FnOnce(&str) -> Result<T, String>,
    ) -> Result<T, SceneError> {
        convert(self.require(name)?).map_err(|message| self.error(message))
    }
    /// An error here.
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        SceneError::element(&self.location, self.quoted(), message)
    }
    /// A warning here.
    pub fn warn(&self, message: impl Into<String>) -> Result<(), SceneError> {
        self.diagnostics
            .warn(&self.location, self.quoted(), message)
    }
    /// A warning about every attribute that is not among the known.
    pub fn check_attributes(&self, known: &[&str]) -> Result<(), SceneError> {
        for (name, _) in &self.attributes {
            if !known.contains(name) {
                let message = format!(
                    "the attribute \"{}\" is not known here and is ignored",
                    shortened(name)
                );
                self.warn(message)?;
            }
        }
        Ok(())
    }
    /// The element as a person would quote it.
    fn quoted(&self) -> String {
        let tag = shortened(self.tag);
        let shown = ["name", "id", "filename", "type"]
            .into_iter()
            .find_map(|key| Some((key, self.attribute(key)?)));
        match shown {
            Some((key, value)) => format!("<{tag} {key}=\"{}\">", shortened(value)),
            None => format!("<{tag}>"),
        }
    }
}

/// What stays the same within one file.
struct FileContext<'a> {
    source: &'a Source,
    search_paths: Arc<[PathBuf]>,
}

struct Loader<'a> {
    document: Document,
    parameters: &'a mut Parameters,
    diagnostics: &'a Arc<Diagnostics>,
    budget: u64,
    elements: usize,
    depth: usize,
    /// The including files, outermost first, for cycles.
    open_files: Vec<PathBuf>,
}

impl Loader<'_> {
    /// Reads one file; `parent` is the object that includes it, and the name that it gives to an included object.
    fn file(
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
                message: format!("malformed XML: {}", message_without_place(&error)),
            }
        })?;
        self.document.files.push(source.path.to_path_buf());
        self.open_files.push(identity(&source.path));
        let folder = match source.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let mut context = FileContext {
            source,
            search_paths: source::prepended(search_paths, folder),
        };
        let root = xml.root_element();
        let element = self.element(root, &context)?;
        let Some(kind) = ObjectKind::from_element(element.tag) else {
            return Err(element.error("the outermost element must be <scene>"));
        };
        if element.attribute("version").is_none() {
            element.warn("the attribute \"version\" is missing; 3.0.0 is assumed")?;
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
                self.add(
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

    /// The element with its parameters put in.
    fn element<'a>(
        &mut self,
        node: Node<'a, 'a>,
        context: &FileContext<'_>,
    ) -> Result<Element<'a>, SceneError> {
        self.elements += 1;
        let mut element = Element {
            tag: node.tag_name().name(),
            search_paths: context.search_paths.clone(),
            location: context.source.location(node.range().start),
            attributes: Vec::new(),
            diagnostics: self.diagnostics.clone(),
        };
        if self.elements > limits::MAX_ELEMENTS {
            let message = format!("the scene has more than {} elements", limits::MAX_ELEMENTS);
            return Err(element.error(message));
        }
        for attribute in node.attributes() {
            let value = self
                .parameters
                .substitute(attribute.value())
                .map_err(|message| element.error(message))?;
            element.attributes.push((attribute.name(), value));
        }
        Ok(element)
    }

    /// The elements inside of an object.
    fn children(
        &mut self,
        node: Node<'_, '_>,
        parent: usize,
        context: &mut FileContext<'_>,
    ) -> Result<(), SceneError> {
        self.depth += 1;
        for child in node.children().filter(Node::is_element) {
            let element = self.element(child, context)?;
            if self.depth > limits::MAX_DEPTH {
                let message = format!("elements are nested more than {} deep", limits::MAX_DEPTH);
                return Err(element.error(message));
            }
            self.child(child, &element, parent, context)?;
        }
        self.depth -= 1;
        Ok(())
    }

    fn child(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        parent: usize,
        context: &mut FileContext<'_>,
    ) -> Result<(), SceneError> {
        match element.tag {
            "default" => {
                element.check_attributes(&["name", "value"])?;
                let name = element.require("name")?;
                if name.is_empty() {
                    return Err(element.error("the name is empty"));
                }
                self.parameters.set_default(name, element.require("value")?);
                return childless(node, element);
            }
            "path" => {
                self.path(node, element, context)?;
                return childless(node, element);
            }
            "include" => {
                self.include(element, parent, context)?;
                return childless(node, element);
            }
            "alias" => {
                self.alias(element)?;
                return childless(node, element);
            }
            "ref" => {
                element.check_attributes(&["id", "name"])?;
                let id = element.require("id")?.to_owned();
                let name = element.attribute("name").unwrap_or("");
                self.add(parent, name, RawValue::Reference(id), element, "ref")?;
                return childless(node, element);
            }
            "transform" => {
                element.check_attributes(&["name"])?;
                let matrix = self.transform(node, element, context)?;
                let name = element.require("name")?;
                return self.add(
                    parent,
                    name,
                    RawValue::Value(Value::Transform(matrix)),
                    element,
                    "transform",
                );
            }
            "animation" => return self.animation(node, element, parent, context),
            _ => {}
        }
        if transforms::is_transform_element(element.tag) {
            return Err(element.error("belongs inside of a <transform>"));
        }
        let is_value = element.tag == "spectrum" && element.attribute("type").is_none();
        if let Some(kind) = ObjectKind::from_element(element.tag).filter(|_| !is_value) {
            if kind == ObjectKind::Scene {
                return Err(element.error("a scene cannot stand inside of another; use <include>"));
            }
            let index = self.object(node, element, kind, context)?;
            let name = element.attribute("name").unwrap_or("");
            return self.add(
                parent,
                name,
                RawValue::Nested(index),
                element,
                kind.element(),
            );
        }
        match elements::value(element)? {
            Some((tag, value)) => {
                self.add(
                    parent,
                    element.require("name")?,
                    RawValue::Value(value),
                    element,
                    tag,
                )?;
                childless(node, element)
            }
            None => {
                let hint = suggestion(element.tag, KNOWN.iter().copied())
                    .map_or(String::new(), |near| format!(" (did you mean <{near}>?)"));
                element.warn(format!("the element is not known and is ignored{hint}"))
            }
        }
    }

    /// An object and everything inside of it; returns its index.
    fn object(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        kind: ObjectKind,
        context: &mut FileContext<'_>,
    ) -> Result<usize, SceneError> {
        let plugin = if kind == ObjectKind::Scene {
            element.check_attributes(&["version", "type", "id", "name"])?;
            "scene"
        } else {
            element.check_attributes(&["version", "type", "id", "name"])?;
            element.require("type")?
        };
        let index = self.document.objects.len();
        let id = element.attribute("id").filter(|id| !id.is_empty());
        if let Some(id) = id {
            if let Some(&other) = self.document.by_id.get(id) {
                let message = format!(
                    "the id is taken by {}",
                    self.document.objects[other].location
                );
                return Err(element.error(message));
            }
            self.document.by_id.insert(id.to_owned(), index);
        }
        self.document.objects.push(RawObject {
            kind,
            plugin: plugin.to_owned(),
            id: id.map(str::to_owned),
            location: element.location.clone(),
            search_paths: element.search_paths.clone(),
            properties: Vec::new(),
        });
        self.children(node, index, context)?;
        if kind == ObjectKind::Texture {
            self.upgrade_uv(index);
        }
        Ok(index)
    }

    fn add(
        &mut self,
        parent: usize,
        name: &str,
        value: RawValue,
        element: &Element<'_>,
        tag: &'static str,
    ) -> Result<(), SceneError> {
        if name.is_empty() && matches!(value, RawValue::Value(_)) {
            return Err(element.error("the name is empty"));
        }
        let object = &mut self.document.objects[parent];
        let name = upgrade::property_name(object.kind, &object.plugin, upgrade::snake_case(name));
        object.properties.push(RawProperty {
            name,
            value,
            location: element.location.clone(),
            tag,
        });
        Ok(())
    }

    fn transform(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        context: &FileContext<'_>,
    ) -> Result<DMat4, SceneError> {
        let mut result = DMat4::IDENTITY;
        for child in node.children().filter(Node::is_element) {
            let part = self.element(child, context)?;
            result = transforms::matrix(&part)? * result;
            childless(child, &part)?;
        }
        if !result.is_finite() {
            return Err(element.error("the transform overflows"));
        }
        Ok(result)
    }

    /// Moving objects stand still at their first key.
    fn animation(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        parent: usize,
        context: &FileContext<'_>,
    ) -> Result<(), SceneError> {
        element.warn("animation is not supported; the first transform is used")?;
        let name = element.require("name")?;
        let Some(first) = node.children().find(Node::is_element) else {
            return Err(element.error("is empty"));
        };
        let key = self.element(first, context)?;
        if key.tag != "transform" {
            return Err(key.error("belongs inside of a <transform>"));
        }
        let matrix = self.transform(first, &key, context)?;
        self.add(
            parent,
            name,
            RawValue::Value(Value::Transform(matrix)),
            element,
            "animation",
        )
    }

    fn path(
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

    fn alias(&mut self, element: &Element<'_>) -> Result<(), SceneError> {
        element.check_attributes(&["id", "as"])?;
        let (id, alias) = (element.require("id")?, element.require("as")?);
        let Some(&object) = self.document.by_id.get(id) else {
            return Err(element.error(format!("no object with the id \"{id}\" stands before this")));
        };
        if self.document.by_id.contains_key(alias) {
            return Err(element.error(format!("the id \"{alias}\" is taken")));
        }
        self.document.by_id.insert(alias.to_owned(), object);
        Ok(())
    }

    fn include(
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

    /// Offsets and scales of 0.6 become the transform that replaced them, unless there is one.
    fn upgrade_uv(&mut self, index: usize) {
        let properties = &mut self.document.objects[index].properties;
        if properties.iter().any(|property| property.name == "to_uv") {
            return;
        }
        let mut values = [0.0, 0.0, 1.0, 1.0];
        let mut first: Option<RawProperty> = None;
        let mut kept = Vec::with_capacity(properties.len());
        for property in properties.drain(..) {
            let slot = upgrade::UV_NAMES
                .iter()
                .position(|name| *name == property.name);
            match (slot, &property.value) {
                (Some(slot), RawValue::Value(Value::Float(x))) => values[slot] = *x,
                (Some(slot), RawValue::Value(Value::Int(x))) => values[slot] = *x as f64,
                _ => {
                    kept.push(property);
                    continue;
                }
            }
            first.get_or_insert(property);
        }
        if let Some(property) = first {
            kept.push(RawProperty {
                name: "to_uv".into(),
                value: RawValue::Value(Value::Transform(upgrade::to_uv(values))),
                ..property
            });
        }
        *properties = kept;
    }
}

/// Elements, for suggestions.
const KNOWN: &[&str] = &[
    "alias",
    "animation",
    "blackbody",
    "boolean",
    "bsdf",
    "default",
    "emitter",
    "film",
    "float",
    "include",
    "integer",
    "integrator",
    "medium",
    "path",
    "phase",
    "point",
    "ref",
    "rfilter",
    "rgb",
    "sampler",
    "sensor",
    "shape",
    "spectrum",
    "srgb",
    "string",
    "texture",
    "transform",
    "vector",
    "volume",
];

fn childless(node: Node<'_, '_>, element: &Element<'_>) -> Result<(), SceneError> {
    match node.children().find(Node::is_element) {
        Some(child) => {
            let tag = shortened(child.tag_name().name());
            Err(element.error(format!("cannot hold other elements, but holds <{tag}>")))
        }
        None => Ok(()),
    }
}

/// What makes two paths the same file.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// The message of the XML reader, whose place we print ourselves.
fn message_without_place(error: &roxmltree::Error) -> String {
    let message = error.to_string();
    let place = format!(" at {}", error.pos());
    message.strip_suffix(&place).unwrap_or(&message).to_owned()
}
