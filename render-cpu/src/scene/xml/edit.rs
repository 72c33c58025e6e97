//! Values of a scene under names of their own, and the scene with some of them changed.
//!
//! A value is named by its object and its property, `glass.int_ior`. Objects are called by their id; those without one by
//! the object that holds them and their name or element there, numbered from the second on: `integrator.max_depth`,
//! `sensor.film.width`, `shape_2.to_world`, `emitter.radiance`. An object that several others refer to is listed once,
//! under the first.
//!
//! The changed scene is a new tree over the same contents of files, and is built like one that was read: what a builder
//! derives from values is derived anew. Invariant (tests): its tables are those of a file in which the values were changed.

use super::ParsedScene;
use super::object::Value;
use super::object::{Object, Properties, Property};
use super::value::Spectrum;
use crate::scene::color::read_samples;
use crate::scene::error::{Diagnostics, SceneError, suggestion};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A value of a scene, with its name.
#[derive(Clone, Debug)]
pub struct NamedValue {
    /// Object and property.
    pub name: String,
    /// The value; never an object.
    pub value: Value,
    /// [`Object::index`] and the name of the property.
    address: (usize, String),
}

impl ParsedScene {
    /// All values that can be changed, in the order of the file.
    pub fn values(&self) -> Vec<NamedValue> {
        let mut list = List::default();
        list.add(&self.root, "");
        list.values
    }

    /// The scene with other values, by the names of [`ParsedScene::values`]. Files that both need are read once. Warnings
    /// of reading are not repeated.
    ///
    /// # Errors
    /// When there is no value of a name, or a file of a spectrum cannot be read.
    pub fn with_values(
        &self,
        changes: &BTreeMap<String, Value>,
    ) -> Result<ParsedScene, SceneError> {
        self.file_cache.keep();
        let known = self.values();
        let mut by_address = HashMap::new();
        for (name, value) in changes {
            let entry = known.iter().find(|entry| entry.name == *name);
            let entry = entry.ok_or_else(|| {
                let hint = suggestion(name, known.iter().map(|entry| entry.name.as_str()))
                    .map_or(String::new(), |near| format!(" (did you mean \"{near}\"?)"));
                SceneError::Request(format!("the scene has no value \"{name}\"{hint}"))
            })?;
            by_address.insert(entry.address.clone(), value);
        }
        let diagnostics = Arc::new(Diagnostics::new(self.diagnostics.strict()));
        let mut copy = Copy {
            changes: by_address,
            diagnostics: diagnostics.clone(),
            done: HashMap::new(),
        };
        Ok(ParsedScene {
            root: copy.object(&self.root)?,
            files: self.files.clone(),
            diagnostics,
            file_cache: self.file_cache.clone(),
            parameters: self.parameters.clone(),
        })
    }
}

/// Values, while the tree is walked.
#[derive(Default)]
struct List {
    values: Vec<NamedValue>,
    /// Indices of the objects that were walked.
    seen: HashSet<usize>,
}

impl List {
    fn add(&mut self, object: &Object, prefix: &str) {
        if !self.seen.insert(object.index) {
            return;
        }
        let join = |name: &str| match prefix {
            "" => name.to_owned(),
            prefix => format!("{prefix}.{name}"),
        };
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for property in object.properties.iter() {
            let Value::Object(child) = &property.value else {
                self.values.push(NamedValue {
                    name: join(&property.name),
                    value: property.value.clone(),
                    address: (object.index, property.name.clone()),
                });
                continue;
            };
            let role = match property.name.as_str() {
                "" => child.kind.element(),
                name => name,
            };
            let count = counts.entry(role).or_insert(0);
            *count += 1;
            let name = match *count {
                1 => join(role),
                n => join(&format!("{role}_{n}")),
            };
            self.add(child, child.id.as_deref().unwrap_or(&name));
        }
    }
}

/// Copies a tree, each object once.
struct Copy<'a> {
    changes: HashMap<(usize, String), &'a Value>,
    diagnostics: Arc<Diagnostics>,
    done: HashMap<usize, Arc<Object>>,
}

impl Copy<'_> {
    fn object(&mut self, object: &Arc<Object>) -> Result<Arc<Object>, SceneError> {
        if let Some(done) = self.done.get(&object.index) {
            return Ok(done.clone());
        }
        let mut properties = Properties::default();
        for property in object.properties.iter() {
            let address = (object.index, property.name.clone());
            let value = match (self.changes.get(&address), &property.value) {
                (Some(&value), _) => value.clone(),
                (None, Value::Object(child)) => Value::Object(self.object(child)?),
                // The builder would read the file each time.
                (None, Value::Spectrum(Spectrum::File(path))) => {
                    Value::Spectrum(Spectrum::Samples(read_samples(path)?.into()))
                }
                (None, other) => other.clone(),
            };
            let copy = Property::new(
                (property.name.clone(), property.written.clone()),
                value,
                property.location.clone(),
                property.tag,
            );
            // The original has each name once.
            let _ = properties.insert(copy, false);
        }
        let copy = Arc::new(Object {
            kind: object.kind,
            plugin: object.plugin.clone(),
            id: object.id.clone(),
            index: object.index,
            properties,
            location: object.location.clone(),
            search_paths: object.search_paths.clone(),
            is_legacy: object.is_legacy,
            is_literal: object.is_literal,
            diagnostics: self.diagnostics.clone(),
            file_cache: object.file_cache.clone(),
            touched: AtomicBool::new(false),
        });
        self.done.insert(object.index, copy.clone());
        Ok(copy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::build::{BuildOptions, build_scene};
    use crate::scene::xml::parse_scene_from_str;

    fn scene(radius: f64, reflectance: f64) -> ParsedScene {
        let text = format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/></sensor>\
             <emitter type=\"constant\"/>\
             <bsdf type=\"twosided\" id=\"red\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" \
             value=\"{reflectance}, 0.1, 0.1\"/></bsdf></bsdf>\
             <shape type=\"sphere\"><float name=\"radius\" value=\"{radius}\"/><ref id=\"red\"/></shape>\
             <shape type=\"sphere\"><float name=\"radius\" value=\"0.5\"/><ref id=\"red\"/></shape></scene>"
        );
        let parsed = parse_scene_from_str(&text, "test.xml".as_ref(), &[], true);
        parsed.unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn values_are_named_by_object_and_property() {
        let names: Vec<_> = scene(1.0, 0.5)
            .values()
            .into_iter()
            .map(|v| v.name)
            .collect();
        let expected = [
            "sensor.fov",
            "red.bsdf.reflectance",
            "shape.radius",
            "shape_2.radius",
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn a_changed_scene_is_that_of_a_changed_file() {
        let changes = BTreeMap::from([
            ("shape.radius".to_owned(), Value::Float(2.0)),
            (
                "red.bsdf.reflectance".to_owned(),
                Value::Rgb(super::super::Color {
                    rgb: [0.75, 0.1, 0.1],
                    was_encoded: false,
                }),
            ),
        ]);
        let build = |parsed: &ParsedScene| {
            let scene = build_scene(parsed, &BuildOptions::default());
            scene.unwrap_or_else(|e| panic!("{e}")).tables.fingerprint()
        };
        let original = scene(1.0, 0.5);
        let changed = original
            .with_values(&changes)
            .unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(build(&changed), build(&scene(2.0, 0.75)));
        assert_ne!(build(&original), build(&changed));
    }

    #[test]
    fn a_name_that_is_not_there_is_an_error_with_the_one_that_is_near() {
        let changes = BTreeMap::from([("shape.radios".to_owned(), Value::Float(2.0))]);
        let error = scene(1.0, 0.5).with_values(&changes).map(drop);
        let message = error.map_or_else(|e| e.to_string(), |()| String::new());
        assert_eq!(
            message,
            "the scene has no value \"shape.radios\" (did you mean \"shape.radius\"?)"
        );
    }
}
