//! What path expressions make of an image: layers, and a restriction to the paths of one.

use super::compile::{CompiledExpressions, compile};
use super::error::ExpressionError;
use super::names::SceneNames;
use crate::film::aov::Aov;
use crate::integrators::{INTEGRATORS, divides_paths, names};
use halflight_kernel::path::PathExpressions;
use halflight_kernel::scene::Tables;
use serde::{Deserialize, Serialize};

/// What is asked for, as text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartsRequest {
    /// Names of layers and their expressions.
    pub layers: Vec<(String, String)>,
    /// The expression of the only paths that count.
    pub only: Option<String>,
}

impl PartsRequest {
    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        self.layers.is_empty() && self.only.is_none()
    }

    /// Reads `NAME=EXPRESSION`.
    ///
    /// # Errors
    /// If there is no name, or one that a layer cannot have.
    pub fn parse_layer(text: &str) -> Result<(String, String), String> {
        let (name, expression) = text
            .split_once('=')
            .ok_or("expected NAME=EXPRESSION, as in caustics='L S+ D E'")?;
        let is_plain = |c: char| c.is_alphanumeric() || "_-".contains(c);
        if name.is_empty() || !name.chars().all(is_plain) {
            return Err(format!(
                "\"{name}\" is no name of a layer: letters, digits, _ and -"
            ));
        }
        let taken = Aov::ALL.iter().map(|aov| aov.name());
        if taken.chain(["R", "G", "B", "A"]).any(|n| n == name) {
            return Err(format!("\"{name}\" is the name of another layer"));
        }
        Ok((name.to_owned(), expression.to_owned()))
    }
}

/// The parts of a scene's image.
#[derive(Clone, Debug, Default)]
pub struct PathParts {
    request: PartsRequest,
    compiled: Option<CompiledExpressions>,
}

impl PathParts {
    /// Compiles what is asked for.
    ///
    /// # Errors
    /// The first mistake in an expression, or a name that stands for two layers.
    pub fn new(
        request: &PartsRequest,
        tables: &Tables<'_>,
        names: &SceneNames,
    ) -> Result<PathParts, PartsError> {
        if request.is_empty() {
            return Ok(PathParts::default());
        }
        for (i, (name, _)) in request.layers.iter().enumerate() {
            if request.layers[..i].iter().any(|(other, _)| other == name) {
                return Err(PartsError::Twice(name.clone()));
            }
        }
        let only = request.only.as_deref().into_iter();
        let texts: Vec<&str> = only
            .chain(request.layers.iter().map(|(_, text)| text.as_str()))
            .collect();
        let compiled = compile(&texts, request.only.is_some(), tables, names)?;
        Ok(PathParts {
            request: request.clone(),
            compiled: Some(compiled),
        })
    }

    /// What was asked for.
    pub fn request(&self) -> &PartsRequest {
        &self.request
    }

    /// The expressions for the kernel; none if nothing is asked for.
    pub fn view(&self) -> Option<PathExpressions<'_>> {
        self.compiled.as_ref().map(CompiledExpressions::view)
    }

    /// Names of the layers.
    pub fn layer_names(&self) -> Vec<String> {
        let layers = self.request.layers.iter();
        layers.map(|(name, _)| name.clone()).collect()
    }

    /// The expression that is the first layer: behind that of the only paths that count.
    pub fn first_layer(&self) -> usize {
        usize::from(self.request.only.is_some())
    }

    /// What decides the numbers of the image, by the names of the command line.
    pub fn settings(&self) -> impl Iterator<Item = (String, String)> + '_ {
        let layers = self.request.layers.iter();
        let layers = layers.map(|(name, text)| (format!("--lpe {name}"), text.clone()));
        let only = self.request.only.iter();
        layers.chain(only.map(|text| ("--only".to_owned(), text.clone())))
    }
}

/// Why an image cannot be divided.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PartsError {
    /// In an expression.
    #[error(transparent)]
    Expression(#[from] ExpressionError),
    /// Two layers of one name.
    #[error("--lpe: there are two layers named \"{0}\"")]
    Twice(String),
    /// The algorithm does not know the paths of what it adds.
    #[error(
        "--lpe and --only are not for {0}: use one of {list}",
        list = names(INTEGRATORS.iter().filter(|i| divides_paths(i.kind)))
    )]
    Algorithm(String),
    /// Photons among edits know which edits apply to them, and nothing else of their paths.
    #[error("--lpe and --only do not divide what {0} merges among edits: use bdpt")]
    EditedPhotons(String),
    /// Events that regularisation has spread are of no kind.
    #[error("--lpe and --only divide paths as they are, not those that regularisation has spread")]
    Regularized,
}
