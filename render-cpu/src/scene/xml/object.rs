//! Objects, their properties, and the values that these take, other objects among them.
//!
//! An [`Object`] is shared (`Arc`) by everything that refers to it; its `index` identifies it, so that a builder can build
//! each object once. Querying a property marks it as used.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DMat4;

pub use super::kind::ObjectKind;
use super::value::{Color, Spectrum};
use crate::scene::error::{Diagnostics, Location, SceneError, searched};
use crate::scene::file_cache::FileCache;

/// The value of a property.
#[derive(Clone, Debug)]
pub enum Value {
    /// `<boolean>`.
    Bool(bool),
    /// `<integer>`.
    Int(i64),
    /// `<float>`; finite, and in the range of f32.
    Float(f64),
    /// `<string>`.
    String(String),
    /// `<point>`.
    Point([f64; 3]),
    /// `<vector>`.
    Vector([f64; 3]),
    /// `<rgb>` and `<srgb>`.
    Rgb(Color),
    /// `<spectrum>` without a type.
    Spectrum(Spectrum),
    /// `<blackbody>` of 0.6: Planck's law at a temperature in kelvin, times a factor.
    Blackbody {
        /// Kelvin.
        temperature: f64,
        /// Factor on the radiance.
        scale: f64,
    },
    /// `<transform>`, composed.
    Transform(DMat4),
    /// `<animation>` of an edit: times in order, and the transforms then.
    Animation(Arc<[(f64, DMat4)]>),
    /// A nested object, or a reference to one elsewhere.
    Object(Arc<Object>),
}

impl Value {
    /// What the value is, for messages: "a string".
    pub fn describe(&self) -> String {
        match self {
            Value::Bool(_) => "a boolean".into(),
            Value::Int(_) => "an integer".into(),
            Value::Float(_) => "a float".into(),
            Value::String(_) => "a string".into(),
            Value::Point(_) => "a point".into(),
            Value::Vector(_) => "a vector".into(),
            Value::Rgb(_) => "an RGB colour".into(),
            Value::Spectrum(_) => "a spectrum".into(),
            Value::Blackbody { .. } => "a blackbody spectrum".into(),
            Value::Transform(_) => "a transform".into(),
            Value::Animation(_) => "an animation".into(),
            Value::Object(object) => format!("a {} of type \"{}\"", object.kind, object.plugin),
        }
    }
}

/// One property of an object.
#[derive(Debug)]
pub struct Property {
    /// The name in snake case, or empty for a nested object without one.
    pub name: String,
    /// The name as the file has it.
    pub written: String,
    /// The value.
    pub value: Value,
    /// Where its element starts.
    pub location: Location,
    /// The name of its element.
    pub tag: &'static str,
    queried: AtomicBool,
}

impl Property {
    pub(super) fn new(
        (name, written): (String, String),
        value: Value,
        location: Location,
        tag: &'static str,
    ) -> Property {
        Property {
            name,
            written,
            value,
            location,
            tag,
            queried: AtomicBool::new(false),
        }
    }
    /// Whether it was queried.
    pub fn queried(&self) -> bool {
        self.queried.load(Ordering::Relaxed)
    }
    /// Marks it as used.
    pub fn mark(&self) {
        self.queried.store(true, Ordering::Relaxed);
    }
    /// The element as a person would quote it.
    pub fn element(&self) -> String {
        if self.name.is_empty() {
            format!("<{}>", self.tag)
        } else {
            format!("<{} name=\"{}\">", self.tag, self.written)
        }
    }
}

/// The properties of an object, in the order of the file.
#[derive(Debug, Default)]
pub struct Properties {
    entries: Vec<Property>,
    by_name: HashMap<String, usize>,
}

impl Properties {
    /// Adds a property. If there is one of that name, its location is returned, and it is replaced if `replaces`.
    pub(super) fn insert(&mut self, property: Property, replaces: bool) -> Result<(), Location> {
        if !property.name.is_empty() {
            if let Some(&i) = self.by_name.get(&property.name) {
                let first = self.entries[i].location.clone();
                if replaces {
                    self.entries[i] = property;
                }
                return Err(first);
            }
            self.by_name
                .insert(property.name.clone(), self.entries.len());
        }
        self.entries.push(property);
        Ok(())
    }
    /// The property of a name, marked as used.
    pub fn get(&self, name: &str) -> Option<&Property> {
        let property = &self.entries[*self.by_name.get(name)?];
        property.mark();
        Some(property)
    }
    /// Whether there is a property of that name; does not mark it.
    pub fn contains(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }
    /// All properties in the order of the file; does not mark them.
    pub fn iter(&self) -> impl Iterator<Item = &Property> {
        self.entries.iter()
    }
    /// How many there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

/// A nested or referenced object, as a child of another.
#[derive(Clone, Copy, Debug)]
pub struct Child<'a> {
    /// The property that holds it.
    pub property: &'a Property,
    /// The object.
    pub object: &'a Arc<Object>,
}

impl<'a> Child<'a> {
    /// The name that the parent gives to it, or "".
    pub fn name(&self) -> &'a str {
        &self.property.name
    }
}

/// An object of a scene, as written.
#[derive(Debug)]
pub struct Object {
    /// What it is.
    pub kind: ObjectKind,
    /// The name of its plugin, `type` in the file.
    pub plugin: String,
    /// Its name, if it has one.
    pub id: Option<String>,
    /// Distinct for distinct objects of a scene.
    pub index: usize,
    /// What it is made of.
    pub properties: Properties,
    /// Where its element starts.
    pub location: Location,
    /// Whether its file is of a version before 2, in which some defaults are others.
    pub is_legacy: bool,
    /// Whether the file names the plugin itself, not by a parameter.
    pub is_literal: bool,
    pub(super) search_paths: Arc<[PathBuf]>,
    pub(super) diagnostics: Arc<Diagnostics>,
    pub(super) file_cache: Arc<FileCache>,
    pub(super) touched: AtomicBool,
}

impl Object {
    /// The element as a person would quote it.
    pub fn element(&self) -> String {
        format!("<{} type=\"{}\">", self.kind, self.plugin)
    }
    /// An error at this object.
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        SceneError::element(&self.location, self.element(), message)
    }
    /// Adds a warning at this object.
    ///
    /// # Errors
    /// The warning itself, when the scene is read strictly.
    pub fn warn(&self, message: impl Into<String>) -> Result<(), SceneError> {
        self.diagnostics
            .warn(&self.location, self.element(), message)
    }
    /// Adds a warning at a position in another file that the object is made from.
    ///
    /// # Errors
    /// The warning itself, when the scene is read strictly.
    pub fn warn_at(
        &self,
        location: &Location,
        element: String,
        message: impl Into<String>,
    ) -> Result<(), SceneError> {
        self.diagnostics.warn(location, element, message)
    }
    /// Where one of its properties stands, and the element as a person would quote it; of the object when there is none of that name.
    pub fn property_place(&self, name: &str) -> (&Location, String) {
        match self.properties.get(name) {
            Some(property) => (&property.location, property.element()),
            None => (&self.location, self.element()),
        }
    }
    /// An error at one of its properties, or at the object when there is none of that name.
    pub fn property_error(&self, name: &str, message: impl Into<String>) -> SceneError {
        match self.properties.get(name) {
            Some(property) => SceneError::element(&property.location, property.element(), message),
            None => self.error(message),
        }
    }
    /// Adds a warning at one of its properties, or at the object when there is none of that name.
    ///
    /// # Errors
    /// The warning itself, when the scene is read strictly.
    pub fn property_warn(&self, name: &str, message: impl Into<String>) -> Result<(), SceneError> {
        match self.properties.get(name) {
            Some(property) => {
                self.diagnostics
                    .warn(&property.location, property.element(), message)
            }
            None => self.warn(message),
        }
    }
    /// Marks the object as built, so that its unused properties are warned about. Getters do so too.
    pub fn touch(&self) {
        self.touched.store(true, Ordering::Relaxed);
    }
    /// Marks the object as left out with a warning of its own: its properties are not warned about.
    pub fn ignore(&self) {
        self.touch();
        self.properties.iter().for_each(Property::mark);
    }
    /// Whether it was marked as built.
    pub fn touched(&self) -> bool {
        self.touched.load(Ordering::Relaxed)
    }

    /// Nested and referenced objects in the order of the file, named or not; does not mark them.
    pub fn children(&self) -> impl Iterator<Item = Child<'_>> {
        self.touch();
        self.properties
            .iter()
            .filter_map(|property| match &property.value {
                Value::Object(object) => Some(Child { property, object }),
                _ => None,
            })
    }
    /// Nested and referenced objects of one kind, marked as used.
    pub fn children_of(&self, kind: ObjectKind) -> impl Iterator<Item = Child<'_>> {
        self.children()
            .filter(move |child| child.object.kind == kind)
            .inspect(|child| child.property.mark())
    }
    /// The only nested or referenced object of a kind, if there is one.
    ///
    /// # Errors
    /// When there are several.
    pub fn single_child_of(&self, kind: ObjectKind) -> Result<Option<&Arc<Object>>, SceneError> {
        let mut children = self.children_of(kind);
        let first = children.next();
        if let Some(second) = children.next() {
            return Err(SceneError::element(
                &second.property.location,
                second.property.element(),
                format!("{} takes only one {kind}", self.element()),
            ));
        }
        Ok(first.map(|child| child.object))
    }

    /// What was read from other files.
    pub fn file_cache(&self) -> &FileCache {
        &self.file_cache
    }
    /// Where relative file names of this object are sought, in order.
    pub fn search_paths(&self) -> &[PathBuf] {
        &self.search_paths
    }
    /// Finds the file that a string property names.
    ///
    /// # Errors
    /// When the property is absent or no string, or no such file exists.
    pub fn require_file(&self, name: &str) -> Result<PathBuf, SceneError> {
        let file = self.require_string(name)?;
        super::source::find(&self.search_paths, file)
            .filter(|path| path.is_file())
            .ok_or_else(|| {
                let message = format!(
                    "no file \"{file}\"; searched {}",
                    searched(&self.search_paths)
                );
                self.property_error(name, message)
            })
    }
}
