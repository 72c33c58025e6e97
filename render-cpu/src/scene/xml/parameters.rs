//! Parameters: `-D name=value` and `<default name value>`, substituted for `$name` in any attribute.
//!
//! After a `$`, the longest known name that matches is taken, so that `$res` and `$resx` can coexist and `$folder/mesh.obj`
//! needs no braces. A substituted value is not expanded again.

use std::borrow::Cow;
use std::collections::HashMap;

use super::limits;
use super::numbers::shortened;
use crate::scene::error::{SceneError, suggestion};

struct Parameter {
    value: String,
    used: bool,
}

/// A `<default>` of a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeclaredParameter {
    /// Its name.
    pub name: String,
    /// Its default value.
    pub default: String,
}

/// The parameters known so far.
pub struct Parameters {
    by_name: HashMap<String, Parameter>,
    /// Lengths of the names, longest first.
    lengths: Vec<usize>,
    /// Names of `-D` that nothing has used yet are reported in this order.
    defined: Vec<String>,
    /// Those that the scene has a default for, in its order.
    declared: Vec<DeclaredParameter>,
    substituted: usize,
}

impl Parameters {
    /// Those of the command line; a later one of the same name wins.
    pub fn new(defines: &[(String, String)]) -> Result<Parameters, SceneError> {
        let mut parameters = Parameters {
            by_name: HashMap::new(),
            lengths: Vec::new(),
            defined: Vec::new(),
            declared: Vec::new(),
            substituted: 0,
        };
        for (name, value) in defines {
            if name.is_empty() {
                return Err(SceneError::Request(format!(
                    "the parameter with the value \"{}\" has no name",
                    shortened(value)
                )));
            }
            parameters.insert(name, value, false);
            if !parameters.defined.contains(name) {
                parameters.defined.push(name.clone());
            }
        }
        Ok(parameters)
    }

    fn insert(&mut self, name: &str, value: &str, used: bool) {
        let value = value.to_owned();
        self.by_name
            .insert(name.to_owned(), Parameter { value, used });
        if let Err(at) = self
            .lengths
            .binary_search_by(|length| name.len().cmp(length))
        {
            self.lengths.insert(at, name.len());
        }
    }

    /// A `<default>`: has no effect when the name is known.
    pub fn set_default(&mut self, name: &str, value: &str) {
        if !self.declared.iter().any(|known| known.name == name) {
            self.declared.push(DeclaredParameter {
                name: name.to_owned(),
                default: value.to_owned(),
            });
        }
        if !self.by_name.contains_key(name) {
            // Scenes may leave their own defaults unused.
            self.insert(name, value, true);
        }
    }

    /// Puts the values in.
    pub fn substitute<'a>(&mut self, text: &'a str) -> Result<Cow<'a, str>, String> {
        if !text.contains('$') {
            return Ok(Cow::Borrowed(text));
        }
        let mut result = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            result.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            let length = self
                .lengths
                .iter()
                .copied()
                .find(|&length| {
                    rest.get(..length)
                        .is_some_and(|name| self.by_name.contains_key(name))
                })
                .ok_or_else(|| self.undefined(rest))?;
            if let Some(parameter) = self.by_name.get_mut(&rest[..length]) {
                parameter.used = true;
                result.push_str(&parameter.value);
            }
            rest = &rest[length..];
            if result.len() > limits::MAX_SUBSTITUTED {
                return Err("the value is too long once its parameters are put in".into());
            }
        }
        result.push_str(rest);
        self.substituted += result.len();
        if self.substituted > limits::MAX_SUBSTITUTED_TOTAL {
            return Err("the scene is too large once its parameters are put in".into());
        }
        Ok(Cow::Owned(result))
    }

    fn undefined(&self, rest: &str) -> String {
        let end = rest
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        let name = shortened(&rest[..end]);
        let hint = self.hint(&name);
        format!("the parameter \"${name}\" is not defined{hint}; give it with -D {name}=...")
    }

    fn hint(&self, name: &str) -> String {
        let mut known: Vec<&str> = self
            .by_name
            .keys()
            .map(String::as_str)
            .filter(|known| *known != name)
            .collect();
        known.sort_unstable();
        suggestion(name, known).map_or(String::new(), |near| format!(" (did you mean \"{near}\"?)"))
    }

    /// The defaults of the scene.
    pub fn declared(&self) -> &[DeclaredParameter] {
        &self.declared
    }

    /// That every parameter of the command line is one of the scene's: an error for those that it does not know, and the names
    /// of those that it knows and uses nowhere.
    pub fn unused(&self) -> Result<Vec<&str>, SceneError> {
        let mut unused = Vec::new();
        for name in &self.defined {
            let is_used = self.by_name.get(name).is_some_and(|known| known.used);
            if is_used {
                continue;
            }
            if self.declared.iter().any(|known| known.name == *name) {
                unused.push(name.as_str());
            } else {
                return Err(SceneError::Request(format!(
                    "the scene has no parameter \"{name}\"{}",
                    self.hint(name)
                )));
            }
        }
        Ok(unused)
    }
}
