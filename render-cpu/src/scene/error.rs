//! Errors and warnings that name file, line and element.
//!
//! One [`SceneError`] ends the reading of a scene; [`Warning`]s are collected in [`Diagnostics`], which turns each into
//! an error when the scene is read strictly. Both print on one line, in the form that editors and terminals link:
//! `scene.xml:12:5: <float name="alpha">: expected a number, found "rough"`.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A location in a file. Lines and columns count from 1, columns in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file.
    pub file: Arc<Path>,
    /// The line, or 0 for the file as a whole.
    pub line: u32,
    /// The column, or 0 for the line as a whole.
    pub column: u32,
}

impl Location {
    /// The file as a whole.
    pub fn of_file(file: impl Into<Arc<Path>>) -> Location {
        Location {
            file: file.into(),
            line: 0,
            column: 0,
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
            if self.column > 0 {
                write!(f, ":{}", self.column)?;
            }
        }
        Ok(())
    }
}

/// Why a scene could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// Something is wrong with an element of a scene file.
    #[error("{location}: {element}: {message}")]
    Element {
        /// Where the element starts.
        location: Location,
        /// The element as a person would quote it, `<float name="alpha">`.
        element: String,
        /// What is wrong, in one sentence.
        message: String,
    },
    /// An error in a file, at a location in it or as a whole.
    #[error("{location}: {message}")]
    File {
        /// The file, and the line and column if known.
        location: Location,
        /// What is wrong, in one sentence.
        message: String,
    },
    /// An error in the options of the command line.
    #[error("{0}")]
    Request(String),
}

impl SceneError {
    /// An error at an element.
    pub fn element(
        location: &Location,
        element: impl Into<String>,
        message: impl Into<String>,
    ) -> SceneError {
        SceneError::Element {
            location: location.clone(),
            element: element.into(),
            message: message.into(),
        }
    }
    /// An error about a file as a whole.
    pub fn file(path: &Path, message: impl Into<String>) -> SceneError {
        SceneError::File {
            location: Location::of_file(path),
            message: message.into(),
        }
    }
    /// Where the error is, if it is in a file.
    pub fn location(&self) -> Option<&Location> {
        match self {
            SceneError::Element { location, .. } | SceneError::File { location, .. } => {
                Some(location)
            }
            SceneError::Request(_) => None,
        }
    }
}

/// Something that was read but not used as its author may have meant it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Where the element starts.
    pub location: Location,
    /// The element as a person would quote it.
    pub element: String,
    /// What is odd, and what was done instead.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.location, self.element, self.message)
    }
}

/// Beyond this many, warnings are counted but not kept.
const MAX_WARNINGS: usize = 10_000;

/// Collects warnings; shared by everything that reads one scene.
#[derive(Debug, Default)]
pub struct Diagnostics {
    strict: bool,
    warnings: Mutex<Vec<Warning>>,
}

impl Diagnostics {
    /// An empty collection; when `strict`, every warning is an error.
    pub fn new(strict: bool) -> Diagnostics {
        Diagnostics {
            strict,
            warnings: Mutex::default(),
        }
    }
    /// Whether warnings are errors.
    pub fn strict(&self) -> bool {
        self.strict
    }
    /// Adds a warning.
    ///
    /// # Errors
    /// The warning itself, when the scene is read strictly.
    pub fn warn(
        &self,
        location: &Location,
        element: impl Into<String>,
        message: impl Into<String>,
    ) -> Result<(), SceneError> {
        if self.strict {
            return Err(SceneError::element(location, element, message));
        }
        let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        if warnings.len() < MAX_WARNINGS {
            warnings.push(Warning {
                location: location.clone(),
                element: element.into(),
                message: message.into(),
            });
        }
        Ok(())
    }
    /// The warnings so far, in the order of their discovery.
    pub fn warnings(&self) -> Vec<Warning> {
        self.warnings
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// The name among `candidates` that a misspelt `name` probably meant: the nearest in edit distance, if it is near.
///
/// The distance counts insertions, deletions and substitutions (Levenshtein), ignoring case; near is at most a third
/// of the name's length, but at least 1.
pub fn suggestion<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    // Longer names are not misspellings of anything known, and would make the table large.
    if name.is_empty() || name.len() > 64 {
        return None;
    }
    let limit = (name.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|candidate| (edit_distance(name, candidate), candidate))
        .filter(|(distance, _)| *distance <= limit)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

/// The paths that were searched, for a message about a missing file.
pub(crate) fn searched(paths: &[PathBuf]) -> String {
    let list: Vec<String> = paths
        .iter()
        .map(|p| format!("\"{}\"", p.display()))
        .collect();
    list.join(", ")
}
