//! From the flat list to the tree: references become shared objects.
//!
//! Each object is made once, however often it is referred to, so that nested references cannot grow exponentially.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::document::{Document, RawObject, RawValue};
use super::limits;
use super::object::Value;
use super::object::{Object, Properties, Property};
use crate::scene::error::{Diagnostics, SceneError, suggestion};
use crate::scene::file_cache::FileCache;

enum State {
    Waiting(RawObject),
    /// Its properties are being resolved; meeting it again is a cycle.
    Open,
    Done(Arc<Object>),
}

struct Resolver<'a> {
    first_index: usize,
    states: Vec<State>,
    by_id: std::collections::HashMap<String, usize>,
    diagnostics: &'a Arc<Diagnostics>,
    file_cache: &'a Arc<FileCache>,
}

/// The root of the tree.
pub fn resolve(
    document: Document,
    diagnostics: &Arc<Diagnostics>,
    file_cache: &Arc<FileCache>,
) -> Result<Arc<Object>, SceneError> {
    resolve_from(document, 0, diagnostics, file_cache)
}

/// [`resolve`] with indices that begin at `first_index`.
pub fn resolve_from(
    document: Document,
    first_index: usize,
    diagnostics: &Arc<Diagnostics>,
    file_cache: &Arc<FileCache>,
) -> Result<Arc<Object>, SceneError> {
    let mut resolver = Resolver {
        first_index,
        states: document.objects.into_iter().map(State::Waiting).collect(),
        by_id: document.by_id,
        diagnostics,
        file_cache,
    };
    resolver
        .object(0, 0)?
        .ok_or_else(|| SceneError::Request("the scene refers to itself".into()))
}

impl Resolver<'_> {
    /// The object at an index, or `None` when it is a part of itself.
    fn object(&mut self, index: usize, depth: usize) -> Result<Option<Arc<Object>>, SceneError> {
        let raw = match std::mem::replace(&mut self.states[index], State::Open) {
            State::Open => return Ok(None),
            State::Done(object) => {
                self.states[index] = State::Done(object.clone());
                return Ok(Some(object));
            }
            State::Waiting(raw) => raw,
        };
        let element = format!("<{} type=\"{}\">", raw.kind, raw.plugin);
        let mut properties = Properties::default();
        for property in raw.properties {
            let fail = |message: String| {
                let element = match &property.value {
                    RawValue::Reference(id) => format!("<ref id=\"{id}\">"),
                    _ if property.name.is_empty() => format!("<{}>", property.tag),
                    _ => format!("<{} name=\"{}\">", property.tag, property.written),
                };
                SceneError::element(&property.location, element, message)
            };
            let target = match &property.value {
                RawValue::Value(_) => None,
                RawValue::Nested(target) => Some(*target),
                RawValue::Reference(id) => Some(self.target(id).map_err(fail)?),
            };
            let value = match target {
                Some(_) if depth >= limits::MAX_DEPTH => {
                    let limit = limits::MAX_DEPTH;
                    return Err(fail(format!(
                        "objects refer to each other in a chain of more than {limit}"
                    )));
                }
                Some(target) => match self.object(target, depth + 1)? {
                    Some(object) => Value::Object(object),
                    None => return Err(fail("the reference is circular".into())),
                },
                None => match property.value {
                    RawValue::Value(value) => value,
                    // Every other value has a target.
                    RawValue::Nested(_) | RawValue::Reference(_) => continue,
                },
            };
            let names = (property.name, property.written);
            let property = Property::new(names, value, property.location, property.tag);
            let (location, quoted) = (property.location.clone(), property.element());
            if let Err(first) = properties.insert(property, raw.is_legacy) {
                if raw.is_legacy {
                    // As Mitsuba 0.6 has it.
                    let message = format!(
                        "{element} has this property already, at {first}; the last one counts"
                    );
                    self.diagnostics.warn(&location, quoted, message)?;
                    continue;
                }
                let message = format!("{element} has this property already, at {first}");
                return Err(SceneError::element(&location, quoted, message));
            }
        }
        let object = Arc::new(Object {
            kind: raw.kind,
            plugin: raw.plugin,
            id: raw.id,
            index: self.first_index + index,
            properties,
            location: raw.location,
            is_legacy: raw.is_legacy,
            is_literal: raw.is_literal,
            search_paths: raw.search_paths,
            diagnostics: self.diagnostics.clone(),
            file_cache: self.file_cache.clone(),
            touched: AtomicBool::new(false),
        });
        self.states[index] = State::Done(object.clone());
        Ok(Some(object))
    }

    fn target(&self, id: &str) -> Result<usize, String> {
        self.by_id.get(id).copied().ok_or_else(|| {
            let mut known: Vec<&str> = self.by_id.keys().map(String::as_str).collect();
            known.sort_unstable();
            let hint = suggestion(id, known)
                .map_or(String::new(), |near| format!(" (did you mean \"{near}\"?)"));
            format!("no object has this id{hint}")
        })
    }
}
