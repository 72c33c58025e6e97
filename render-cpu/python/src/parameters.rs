//! Values of a scene as objects of Python, and back.
//!
//! | in the file | in Python |
//! |---|---|
//! | boolean, integer, float, string | bool, int, float, str |
//! | point, vector | tuple of three floats |
//! | rgb, spectrum | tuple of three floats, linear sRGB; one float stands for three; uniform spectra are a float |
//! | transform | array of the shape (4, 4), row by row, applied to column vectors |
//!
//! A value keeps its kind when it is changed, but for spectra, which become colours. What no kind holds (infinities, a
//! string for a number) is refused here; what a plugin does not take is refused when the scene is built.

use glam::DMat4;
use halflight::scene::error::suggestion;
use halflight::scene::xml::{Color, Spectrum, Value};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;

/// A value for Python.
pub(crate) fn to_python(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    let three = |v: [f64; 3]| (v[0], v[1], v[2]).into_pyobject(py).map(|o| o.into_any());
    Ok(match value {
        Value::Bool(x) => x.into_pyobject(py)?.to_owned().into_any(),
        Value::Int(x) => x.into_pyobject(py)?.into_any(),
        Value::Float(x) => x.into_pyobject(py)?.into_any(),
        Value::String(x) => x.into_pyobject(py)?.into_any(),
        Value::Point(v) | Value::Vector(v) => three(*v)?,
        Value::Rgb(color) => three(color.rgb.map(f64::from))?,
        Value::Spectrum(Spectrum::Uniform(x)) => x.into_pyobject(py)?.into_any(),
        Value::Spectrum(Spectrum::Samples(samples)) => {
            let rows: Vec<f64> = samples.iter().flat_map(|&(w, v)| [w, v]).collect();
            rows.into_pyarray(py)
                .reshape([samples.len(), 2])?
                .into_any()
        }
        Value::Spectrum(Spectrum::File(path)) => path.into_pyobject(py)?.into_any(),
        Value::Blackbody { temperature, scale } => {
            (*temperature, *scale).into_pyobject(py)?.into_any()
        }
        Value::Transform(m) => {
            let rows = m.transpose().to_cols_array().to_vec();
            rows.into_pyarray(py).reshape([4, 4])?.into_any()
        }
        // Times and the rows of their transforms.
        Value::Animation(keys) => {
            let rows = keys
                .iter()
                .map(|(time, m)| (*time, m.transpose().to_cols_array().to_vec()));
            rows.collect::<Vec<_>>().into_pyobject(py)?.into_any()
        }
        // Objects are no values, and not listed.
        Value::Object(_) => py.None().into_bound(py),
    }
    .unbind())
}

/// A finite number that the kernel can hold.
fn number(x: f64) -> Result<f64, &'static str> {
    if x.is_finite() && x.abs() <= f64::from(f32::MAX) {
        Ok(x)
    } else {
        Err("a finite number in the range of float32")
    }
}

fn float(value: &Bound<'_, PyAny>) -> Result<f64, &'static str> {
    number(value.extract().map_err(|_| "a number")?)
}

fn three(value: &Bound<'_, PyAny>) -> Result<[f64; 3], &'static str> {
    let v: [f64; 3] = value.extract().map_err(|_| "three numbers")?;
    for x in v {
        number(x)?;
    }
    Ok(v)
}

fn color(value: &Bound<'_, PyAny>) -> Result<Value, &'static str> {
    let rgb = match float(value) {
        Ok(x) => [x; 3],
        Err(_) => three(value).map_err(|_| "three finite numbers, linear sRGB, or one")?,
    };
    Ok(Value::Rgb(Color {
        rgb: rgb.map(|x| x as f32),
        was_encoded: false,
    }))
}

fn transform(value: &Bound<'_, PyAny>) -> Result<Value, &'static str> {
    const FORM: &str = "a finite array of the shape (4, 4)";
    let rows: [[f64; 4]; 4] = value.extract().map_err(|_| FORM)?;
    let m = DMat4::from_cols_array_2d(&rows).transpose();
    if m.is_finite() {
        Ok(Value::Transform(m))
    } else {
        Err(FORM)
    }
}

/// A new value of the parameter `name`, of the kind of its old one.
pub(crate) fn from_python(name: &str, old: &Value, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let new = match old {
        Value::Bool(_) => value.extract().map(Value::Bool).map_err(|_| "a bool"),
        Value::Int(_) => value.extract().map(Value::Int).map_err(|_| "an int"),
        Value::Float(_) => float(value).map(Value::Float),
        Value::String(_) => value.extract().map(Value::String).map_err(|_| "a str"),
        Value::Point(_) => three(value).map(Value::Point),
        Value::Vector(_) => three(value).map(Value::Vector),
        Value::Spectrum(Spectrum::Uniform(_)) => match float(value) {
            Ok(x) => Ok(Value::Spectrum(Spectrum::Uniform(x))),
            Err(_) => color(value),
        },
        Value::Rgb(_) | Value::Spectrum(_) | Value::Blackbody { .. } => color(value),
        Value::Transform(_) => transform(value),
        Value::Animation(_) => Err("keyframes of the scene file alone"),
        Value::Object(_) => Err("no object"),
    };
    new.map_err(|expected| {
        let found = value
            .repr()
            .map_or_else(|_| "this".into(), |r| r.to_string());
        PyTypeError::new_err(format!("\"{name}\" takes {expected}, not {found}"))
    })
}

/// There is no such parameter.
pub(crate) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a String>) -> PyErr {
    let hint = suggestion(name, known.map(String::as_str))
        .map_or(String::new(), |near| format!("; did you mean \"{near}\"?"));
    PyKeyError::new_err(format!("the scene has no parameter \"{name}\"{hint}"))
}
