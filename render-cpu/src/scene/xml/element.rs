//! An element of a scene file, its parameters put in.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

use roxmltree::Node;

use super::numbers::shortened;
use super::parameters::Parameters;
use super::source::Source;
use crate::scene::error::{Diagnostics, Location, SceneError};

/// An element with its parameters put in.
pub struct Element<'a> {
    /// Its name.
    pub tag: &'a str,
    /// Where file names are sought.
    pub search_paths: Arc<[PathBuf]>,
    /// Whether its file is of a version before 2.
    pub is_legacy: bool,
    location: Location,
    attributes: Vec<(&'a str, Cow<'a, str>)>,
    diagnostics: Arc<Diagnostics>,
}

impl<'a> Element<'a> {
    /// Reads the attributes of a node.
    pub fn new(
        node: Node<'a, 'a>,
        source: &Source,
        search_paths: &Arc<[PathBuf]>,
        is_legacy: bool,
        parameters: &mut Parameters,
        diagnostics: &Arc<Diagnostics>,
    ) -> Result<Element<'a>, SceneError> {
        let mut element = Element {
            tag: node.tag_name().name(),
            search_paths: search_paths.clone(),
            is_legacy,
            location: source.location(node.range().start),
            attributes: Vec::new(),
            diagnostics: diagnostics.clone(),
        };
        for attribute in node.attributes() {
            let value = parameters
                .substitute(attribute.value())
                .map_err(|message| element.error(message))?;
            element.attributes.push((attribute.name(), value));
        }
        Ok(element)
    }
    /// Where it starts.
    pub fn location(&self) -> &Location {
        &self.location
    }
    /// That there are no elements inside of it.
    pub fn check_childless(&self, node: Node<'_, '_>) -> Result<(), SceneError> {
        match node.children().find(Node::is_element) {
            Some(child) => {
                let tag = shortened(child.tag_name().name());
                Err(self.error(format!("cannot hold other elements, but holds <{tag}>")))
            }
            None => Ok(()),
        }
    }
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
