//! A scene as read, before references are resolved: a flat list of objects.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::element::Element;
use super::object::ObjectKind;
use super::object::Value;
use super::upgrade;
use crate::scene::error::{Location, SceneError};

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
    /// In snake case, or empty; see [`Document::add`].
    pub name: String,
    /// As the file has it.
    pub written: String,
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
    /// Whether its file is of a version before 2.
    pub is_legacy: bool,
    /// Whether the file names the plugin itself, not by a parameter.
    pub is_literal: bool,
    /// In the order of the file.
    pub properties: Vec<RawProperty>,
}

/// Everything that was read; the root is object 0.
#[derive(Default)]
pub struct Document {
    /// Nested objects come after those that hold them.
    pub objects: Vec<RawObject>,
    /// Object of each name and alias.
    pub by_id: HashMap<String, usize>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

impl Document {
    /// Adds a property to an object, under the name of today. What a shape calls an object within it is kept as it is: that may
    /// be the name of a material of its file.
    pub fn add(
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
        let object = &mut self.objects[parent];
        let written = name.to_owned();
        let is_part_of_shape =
            object.kind == ObjectKind::Shape && !matches!(value, RawValue::Value(_));
        let name = match is_part_of_shape {
            true => written.clone(),
            false => {
                let name = upgrade::snake_case(name);
                upgrade::property_name(object.kind, &object.plugin, name)
            }
        };
        object.properties.push(RawProperty {
            name,
            written,
            value,
            location: element.location().clone(),
            tag,
        });
        Ok(())
    }

    /// Offsets and scales of 0.6 become the transform that replaced them, unless there is one.
    pub fn upgrade_uv(&mut self, index: usize) {
        let is_legacy = self.objects[index].is_legacy;
        let properties = &mut self.objects[index].properties;
        if properties.iter().any(|property| property.name == "to_uv") {
            return;
        }
        let mut values = [None; 5];
        let mut first: Option<RawProperty> = None;
        let mut kept = Vec::with_capacity(properties.len());
        for property in properties.drain(..) {
            let slot = upgrade::UV_NAMES
                .iter()
                .position(|name| *name == property.name);
            match (slot, &property.value) {
                (Some(slot), RawValue::Value(Value::Float(x))) => values[slot] = Some(*x),
                (Some(slot), RawValue::Value(Value::Int(x))) => values[slot] = Some(*x as f64),
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
                value: RawValue::Value(Value::Transform(upgrade::to_uv(values, is_legacy))),
                ..property
            });
        }
        *properties = kept;
    }
}
