//! The values that properties take.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DMat4;

use super::object::Object;

/// A colour given by a triplet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    /// Linear sRGB.
    pub rgb: [f32; 3],
    /// It was given in `<srgb>`, or as a hexadecimal number there, and was linearised.
    pub was_encoded: bool,
}

/// A colour given over the wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Uniform(f64),
    /// Pairs of a wavelength in nanometres, strictly increasing, and a value; linear in between, zero outside.
    Samples(Arc<[(f64, f64)]>),
    /// A file of such pairs, one per line; already found, not yet read.
    File(PathBuf),
}

/// The value of a property.
#[derive(Clone, Debug)]
pub enum Value {
    /// `<boolean>`.
    Bool(bool),
    /// `<integer>`.
    Int(i64),
    /// `<float>`; finite, and in the range of f32.
    Float(f64),
    /// `<string>`.
    String(String),
    /// `<point>`.
    Point([f64; 3]),
    /// `<vector>`.
    Vector([f64; 3]),
    /// `<rgb>` and `<srgb>`.
    Rgb(Color),
    /// `<spectrum>` without a type.
    Spectrum(Spectrum),
    /// `<blackbody>` of 0.6: Planck's law at a temperature in kelvin, times a factor.
    Blackbody {
        /// Kelvin.
        temperature: f64,
        /// Factor on the radiance.
        scale: f64,
    },
    /// `<transform>`, composed.
    Transform(DMat4),
    /// A nested object, or a reference to one elsewhere.
    Object(Arc<Object>),
}

impl Value {
    /// What the value is, for messages: "a string".
    pub fn describe(&self) -> String {
        match self {
            Value::Bool(_) => "a boolean".into(),
            Value::Int(_) => "an integer".into(),
            Value::Float(_) => "a float".into(),
            Value::String(_) => "a string".into(),
            Value::Point(_) => "a point".into(),
            Value::Vector(_) => "a vector".into(),
            Value::Rgb(_) => "an RGB colour".into(),
            Value::Spectrum(_) => "a spectrum".into(),
            Value::Blackbody { .. } => "a blackbody spectrum".into(),
            Value::Transform(_) => "a transform".into(),
            Value::Object(object) => format!("a {} of type \"{}\"", object.kind, object.plugin),
        }
    }
}
