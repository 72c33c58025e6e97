//! Halflight as a Python module: the compiled half of the package `halflight`.
//!
//! Python code beside this crate (`halflight/`) holds what people call: names, broadcasting, documentation. Here is what
//! they cannot do in Python: scenes and renders (`scene`, `run`, `image`), comparisons (`compare`), materials
//! (`bsdf`), and the kernel's functions over flat arrays (`half_vector`, `regularize`, `chain`).
//!
//! Conventions: arrays of directions have the shape (n, 3), of numbers (n,), all of them `float32` and contiguous, which
//! the Python side sees to. Whatever takes longer than a call releases the interpreter's lock and uses all threads.
//! Nothing here computes: formulas are the kernel's, files and images the library's.

mod arrays;
mod bsdf;
mod chain;
mod compare;
mod error;
mod half_vector;
mod image;
mod layers;
mod parameters;
mod regularize;
mod run;
mod scene;

use pyo3::prelude::*;

/// The compiled half of the package `halflight`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // First of all: a later instruction may be one that the processor lacks.
    if let Some(message) = halflight::commands::processor::insufficiency() {
        return Err(pyo3::exceptions::PyImportError::new_err(message));
    }
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", module.py().get_type::<error::SceneError>())?;
    module.add_class::<scene::PyScene>()?;
    module.add_class::<image::PyImage>()?;
    module.add_class::<compare::PyComparison>()?;
    module.add_class::<bsdf::PyBsdf>()?;
    module.add_function(wrap_pyfunction!(scene::load, module)?)?;
    module.add_function(wrap_pyfunction!(image::read, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    half_vector::register(module)?;
    regularize::register(module)?;
    Ok(())
}
