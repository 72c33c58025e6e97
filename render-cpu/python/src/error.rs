//! Errors of the library as Python exceptions.
//!
//! What is wrong with a scene file becomes `halflight.SceneError`, a `ValueError` with the attributes `file`, `line`,
//! `column` and `element`, each None where it is not known; its text is that of the command, `scene.xml:12:5: ...`.
//! Files that cannot be read or written become `OSError`, everything else that was asked wrongly `ValueError`.

use halflight::scene::error::SceneError as Cause;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::fmt::Display;

pyo3::create_exception!(
    halflight,
    SceneError,
    PyValueError,
    "What is wrong with a scene file: `file`, `line`, `column` (from 1) and `element`, None where not known."
);

/// The exception of a scene's error.
pub(crate) fn scene_error(py: Python<'_>, cause: &Cause) -> PyErr {
    let location = cause.location();
    let error = match (cause, location) {
        (Cause::Request(_), _) | (_, None) => return PyValueError::new_err(cause.to_string()),
        _ => SceneError::new_err(cause.to_string()),
    };
    let known = |n: u32| (n > 0).then_some(n);
    let element = match cause {
        Cause::Element { element, .. } => Some(element.as_str()),
        _ => None,
    };
    let value = error.value(py);
    let set = || -> PyResult<()> {
        value.setattr("file", location.map(|l| l.file.to_path_buf()))?;
        value.setattr("line", location.and_then(|l| known(l.line)))?;
        value.setattr("column", location.and_then(|l| known(l.column)))?;
        value.setattr("element", element)
    };
    match set() {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// A value that was asked for wrongly.
pub(crate) fn value_error(cause: impl Display) -> PyErr {
    PyValueError::new_err(cause.to_string())
}

/// A file that cannot be read or written.
pub(crate) fn file_error(cause: impl Display) -> PyErr {
    PyOSError::new_err(cause.to_string())
}

/// What went wrong while rendering, which is nobody's input.
pub(crate) fn run_error(cause: impl Display) -> PyErr {
    PyRuntimeError::new_err(cause.to_string())
}
