//! From XML to a flat list of objects whose references are not resolved yet.
//!
//! Included files are read where they are named: their objects become children of the element that includes them, as
//! if written there, except that file names and versions count from their own file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DMat4;
use roxmltree::Node;

use super::document::{Document, RawObject, RawValue};
use super::element::Element;
use super::object::ObjectKind;
use super::object::Value;
use super::parameters::Parameters;
use super::source::Source;
use super::{elements, limits, numbers, transforms};
use crate::scene::error::{Diagnostics, SceneError, suggestion};

/// Where a scene comes from.
pub enum Origin<'a> {
    /// A file.
    File(&'a Path),
    /// A text, and the file name to use for it.
    Text(&'a str, &'a Path),
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
        Origin::Text(text, name) => Source::new(name, text.trim_start_matches('\u{feff}')),
    };
    let mut loader = Loader {
        document: Document::default(),
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

/// What stays the same within one file.
pub(super) struct FileContext<'a> {
    pub(super) source: &'a Source,
    pub(super) search_paths: Arc<[PathBuf]>,
    /// Whether the file is of a version before 2.
    pub(super) is_legacy: bool,
}

/// Reads files into a document.
pub(super) struct Loader<'a> {
    pub(super) document: Document,
    parameters: &'a mut Parameters,
    pub(super) diagnostics: &'a Arc<Diagnostics>,
    pub(super) budget: u64,
    elements: usize,
    depth: usize,
    /// The including files, outermost first, for cycles.
    pub(super) open_files: Vec<PathBuf>,
}

impl Loader<'_> {
    /// An element, counted.
    pub(super) fn element<'a>(
        &mut self,
        node: Node<'a, 'a>,
        context: &FileContext<'_>,
    ) -> Result<Element<'a>, SceneError> {
        self.elements += 1;
        let paths = &context.search_paths;
        let element = Element::new(
            node,
            context.source,
            paths,
            context.is_legacy,
            self.parameters,
            self.diagnostics,
        )?;
        if self.elements > limits::MAX_ELEMENTS {
            let message = format!("the scene has more than {} elements", limits::MAX_ELEMENTS);
            return Err(element.error(message));
        }
        Ok(element)
    }

    /// The elements inside of an object.
    pub(super) fn children(
        &mut self,
        node: Node<'_, '_>,
        parent: usize,
        context: &mut FileContext<'_>,
    ) -> Result<(), SceneError> {
        self.depth += 1;
        for child in node.children() {
            if !child.is_element() {
                self.say_text(child, context)?;
                continue;
            }
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

    /// Says that text between elements is not read.
    fn say_text(&self, node: Node<'_, '_>, context: &FileContext<'_>) -> Result<(), SceneError> {
        /// Longest text that a message shows.
        const MOST: usize = 40;
        let text = node.text().filter(|_| node.is_text()).unwrap_or_default();
        let start = text.len() - text.trim_start().len();
        let shown: String = text.trim().chars().take(MOST).collect();
        if shown.is_empty() {
            return Ok(());
        }
        let location = context.source.location(node.range().start + start);
        let what = format!("it stands between elements and is left out: \"{shown}\"");
        self.diagnostics.warn(&location, "text", what)
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
                return element.check_childless(node);
            }
            "path" => {
                self.path(node, element, context)?;
                return element.check_childless(node);
            }
            "include" => {
                self.include(element, parent, context)?;
                return element.check_childless(node);
            }
            "alias" => {
                self.alias(element)?;
                return element.check_childless(node);
            }
            "ref" => {
                element.check_attributes(&["id", "name"])?;
                let id = element.require("id")?.to_owned();
                let name = element.attribute("name").unwrap_or("");
                self.document
                    .add(parent, name, RawValue::Reference(id), element, "ref")?;
                return element.check_childless(node);
            }
            "transform" => {
                element.check_attributes(&["name"])?;
                let matrix = self.transform(node, element, context)?;
                let name = element.require("name")?;
                return self.document.add(
                    parent,
                    name,
                    RawValue::Value(Value::Transform(matrix)),
                    element,
                    "transform",
                );
            }
            "animation" if self.document.objects[parent].kind == ObjectKind::Edit => {
                return self.keyframes(node, element, parent, context);
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
            return self.document.add(
                parent,
                name,
                RawValue::Nested(index),
                element,
                kind.element(),
            );
        }
        match elements::value(element)? {
            Some((tag, value)) => {
                self.document.add(
                    parent,
                    element.require("name")?,
                    RawValue::Value(value),
                    element,
                    tag,
                )?;
                element.check_childless(node)
            }
            None => {
                let hint = suggestion(element.tag, KNOWN.iter().copied())
                    .map_or(String::new(), |near| format!(" (did you mean <{near}>?)"));
                element.warn(format!("the element is not known and is ignored{hint}"))
            }
        }
    }

    /// An object and everything inside of it; returns its index.
    pub(super) fn object(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        kind: ObjectKind,
        context: &mut FileContext<'_>,
    ) -> Result<usize, SceneError> {
        element.check_attributes(&["version", "type", "id", "name"])?;
        let plugin = match kind {
            ObjectKind::Scene => "scene",
            _ => element.require("type")?,
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
            location: element.location().clone(),
            search_paths: element.search_paths.clone(),
            is_legacy: element.is_legacy,
            is_literal: !node
                .attribute("type")
                .is_some_and(|name| name.contains('$')),
            properties: Vec::new(),
        });
        self.children(node, index, context)?;
        if kind == ObjectKind::Texture {
            self.document.upgrade_uv(index);
        }
        Ok(index)
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
            part.check_childless(child)?;
        }
        if !result.is_finite() {
            return Err(element.error("the transform overflows"));
        }
        Ok(result)
    }

    /// The keyframes of an edit.
    fn keyframes(
        &mut self,
        node: Node<'_, '_>,
        element: &Element<'_>,
        parent: usize,
        context: &FileContext<'_>,
    ) -> Result<(), SceneError> {
        element.check_attributes(&["name"])?;
        let mut keys: Vec<(f64, DMat4)> = Vec::new();
        for child in node.children().filter(Node::is_element) {
            let key = self.element(child, context)?;
            if key.tag != "transform" {
                return Err(key.error("an animation holds <transform>s, each with a time"));
            }
            key.check_attributes(&["time"])?;
            let time = key.parse("time", numbers::float)?;
            if keys.last().is_some_and(|(last, _)| *last >= time) {
                return Err(key.error("the times of an animation grow from one key to the next"));
            }
            keys.push((time, self.transform(child, &key, context)?));
        }
        if keys.is_empty() {
            return Err(element.error("is empty"));
        }
        let name = element.require("name")?;
        let value = RawValue::Value(Value::Animation(keys.into()));
        self.document.add(parent, name, value, element, "animation")
    }

    /// Animated transforms are replaced by their first key.
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
        self.document.add(
            parent,
            name,
            RawValue::Value(Value::Transform(matrix)),
            element,
            "animation",
        )
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
}

/// Elements, for suggestions.
const KNOWN: &[&str] = &[
    "alias",
    "animation",
    "blackbody",
    "boolean",
    "bsdf",
    "default",
    "edit",
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
