//! Typed access to the properties of an object.
//!
//! `get_*` takes a default, `opt_*` returns whether the property is there, `require_*` insists on it. A property that is
//! there with a value of another type is an error that names its line. Integers pass for floats.

use std::sync::Arc;

use glam::DMat4;

use super::object::Value;
use super::object::{Object, ObjectKind, Property};
use crate::scene::color::{self, ColorUse};
use crate::scene::error::SceneError;

/// A colour, or the texture that gives it.
#[derive(Clone, Debug)]
pub enum ColorSource {
    /// Linear sRGB.
    Constant([f32; 3]),
    /// An object of kind [`ObjectKind::Texture`].
    Texture(Arc<Object>),
}

/// A number, or the texture that gives it.
#[derive(Clone, Debug)]
pub enum FloatSource {
    /// The number.
    Constant(f64),
    /// An object of kind [`ObjectKind::Texture`].
    Texture(Arc<Object>),
}

impl Object {
    /// The property of a name, marked as used.
    pub fn get(&self, name: &str) -> Option<&Property> {
        self.touch();
        self.properties.get(name)
    }
    /// Whether there is a property of that name; does not mark it.
    pub fn has(&self, name: &str) -> bool {
        self.properties.contains(name)
    }

    fn wrong_type(&self, property: &Property, wanted: &str) -> SceneError {
        let message = format!(
            "{} needs {wanted} for \"{}\", found {}",
            self.element(),
            property.written,
            property.value.describe()
        );
        SceneError::element(&property.location, property.element(), message)
    }
    fn missing(&self, name: &str, wanted: &str) -> SceneError {
        self.error(format!("\"{name}\" is missing; {wanted} is needed"))
    }
    fn typed<'a, T>(
        &'a self,
        name: &str,
        wanted: &str,
        convert: impl FnOnce(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, SceneError> {
        match self.get(name) {
            None => Ok(None),
            Some(property) => convert(&property.value)
                .map(Some)
                .ok_or_else(|| self.wrong_type(property, wanted)),
        }
    }

    /// A float, if there.
    ///
    /// # Errors
    /// When it is not a number.
    pub fn opt_float(&self, name: &str) -> Result<Option<f64>, SceneError> {
        self.typed(name, "a float", |value| match value {
            Value::Float(x) => Some(*x),
            Value::Int(x) => Some(*x as f64),
            _ => None,
        })
    }
    /// A float, or the default.
    ///
    /// # Errors
    /// When it is not a number.
    pub fn get_float(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        Ok(self.opt_float(name)?.unwrap_or(default))
    }
    /// A float.
    ///
    /// # Errors
    /// When it is not there or not a number.
    pub fn require_float(&self, name: &str) -> Result<f64, SceneError> {
        self.opt_float(name)?
            .ok_or_else(|| self.missing(name, "a float"))
    }
    /// A float within bounds, or the default.
    ///
    /// # Errors
    /// When it is not a number, or outside of the bounds.
    pub fn get_float_in(
        &self,
        name: &str,
        default: f64,
        min: f64,
        max: f64,
    ) -> Result<f64, SceneError> {
        let value = self.get_float(name, default)?;
        if value < min || value > max {
            return Err(self.property_error(name, outside(value, min, max)));
        }
        Ok(value)
    }

    /// An integer, if there.
    ///
    /// # Errors
    /// When it is not an integer.
    pub fn opt_int(&self, name: &str) -> Result<Option<i64>, SceneError> {
        self.typed(name, "an integer", |value| match value {
            Value::Int(x) => Some(*x),
            _ => None,
        })
    }
    /// An integer, or the default.
    ///
    /// # Errors
    /// When it is not an integer.
    pub fn get_int(&self, name: &str, default: i64) -> Result<i64, SceneError> {
        Ok(self.opt_int(name)?.unwrap_or(default))
    }
    /// An integer within bounds, or the default.
    ///
    /// # Errors
    /// When it is not an integer, or outside of the bounds.
    pub fn get_int_in(
        &self,
        name: &str,
        default: i64,
        min: i64,
        max: i64,
    ) -> Result<i64, SceneError> {
        let value = self.get_int(name, default)?;
        if value < min || value > max {
            return Err(self.property_error(name, format!("{value} is outside of [{min}, {max}]")));
        }
        Ok(value)
    }

    /// A boolean, if there.
    ///
    /// # Errors
    /// When it is not a boolean.
    pub fn opt_bool(&self, name: &str) -> Result<Option<bool>, SceneError> {
        self.typed(name, "a boolean", |value| match value {
            Value::Bool(x) => Some(*x),
            _ => None,
        })
    }
    /// A boolean, or the default.
    ///
    /// # Errors
    /// When it is not a boolean.
    pub fn get_bool(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        Ok(self.opt_bool(name)?.unwrap_or(default))
    }

    /// A string, if there.
    ///
    /// # Errors
    /// When it is not a string.
    pub fn opt_string(&self, name: &str) -> Result<Option<&str>, SceneError> {
        self.typed(name, "a string", |value| match value {
            Value::String(x) => Some(x.as_str()),
            _ => None,
        })
    }
    /// A string, or the default.
    ///
    /// # Errors
    /// When it is not a string.
    pub fn get_string<'a>(&'a self, name: &str, default: &'a str) -> Result<&'a str, SceneError> {
        Ok(self.opt_string(name)?.unwrap_or(default))
    }
    /// A string.
    ///
    /// # Errors
    /// When it is not there or not a string.
    pub fn require_string(&self, name: &str) -> Result<&str, SceneError> {
        self.opt_string(name)?
            .ok_or_else(|| self.missing(name, "a string"))
    }

    /// A point or a vector, if there.
    ///
    /// # Errors
    /// When it is neither.
    pub fn opt_vector(&self, name: &str) -> Result<Option<[f64; 3]>, SceneError> {
        self.typed(name, "a point or a vector", |value| match value {
            Value::Point(x) | Value::Vector(x) => Some(*x),
            _ => None,
        })
    }
    /// A point or a vector, or the default.
    ///
    /// # Errors
    /// When it is neither.
    pub fn get_vector(&self, name: &str, default: [f64; 3]) -> Result<[f64; 3], SceneError> {
        Ok(self.opt_vector(name)?.unwrap_or(default))
    }

    /// A transform, if there.
    ///
    /// # Errors
    /// When it is not a transform.
    pub fn opt_transform(&self, name: &str) -> Result<Option<DMat4>, SceneError> {
        self.typed(name, "a transform", |value| match value {
            Value::Transform(x) => Some(*x),
            _ => None,
        })
    }
    /// A transform, or the identity.
    ///
    /// # Errors
    /// When it is not a transform.
    pub fn get_transform(&self, name: &str) -> Result<DMat4, SceneError> {
        Ok(self.opt_transform(name)?.unwrap_or(DMat4::IDENTITY))
    }

    /// A nested or referenced object of a name, if there.
    ///
    /// # Errors
    /// When it is a plain value.
    pub fn opt_object(&self, name: &str) -> Result<Option<&Arc<Object>>, SceneError> {
        self.typed(name, "an object", |value| match value {
            Value::Object(object) => Some(object),
            _ => None,
        })
    }

    /// A colour in linear sRGB, if there. Plain numbers, triplets and every form of spectrum pass, textures do not.
    ///
    /// # Errors
    /// When it is something else, or cannot be converted.
    pub fn opt_rgb(&self, name: &str, usage: ColorUse) -> Result<Option<[f32; 3]>, SceneError> {
        let Some(property) = self.get(name) else {
            return Ok(None);
        };
        match color::from_property(property, usage)? {
            Some(converted) => {
                if let Some(warning) = converted.warning {
                    self.diagnostics
                        .warn(&property.location, property.element(), warning)?;
                }
                Ok(Some(converted.rgb))
            }
            None => Err(self.wrong_type(property, "a colour")),
        }
    }
    /// A colour in linear sRGB, or the default.
    ///
    /// # Errors
    /// As [`Object::opt_rgb`].
    pub fn get_rgb(
        &self,
        name: &str,
        usage: ColorUse,
        default: [f32; 3],
    ) -> Result<[f32; 3], SceneError> {
        Ok(self.opt_rgb(name, usage)?.unwrap_or(default))
    }
    /// A colour or a texture, or the default.
    ///
    /// # Errors
    /// As [`Object::opt_rgb`], but textures pass.
    pub fn get_rgb_or_texture(
        &self,
        name: &str,
        usage: ColorUse,
        default: [f32; 3],
    ) -> Result<ColorSource, SceneError> {
        if let Some(texture) = self.texture(name) {
            return Ok(ColorSource::Texture(texture.clone()));
        }
        Ok(ColorSource::Constant(self.get_rgb(name, usage, default)?))
    }
    /// A number or a texture, or the default. Colours and spectra count by their luminance, as textures do.
    ///
    /// # Errors
    /// When it is none of these, or cannot be converted.
    pub fn get_float_or_texture(
        &self,
        name: &str,
        default: f64,
    ) -> Result<FloatSource, SceneError> {
        if let Some(texture) = self.texture(name) {
            return Ok(FloatSource::Texture(texture.clone()));
        }
        let is_colour = self.get(name).is_some_and(|property| {
            matches!(
                property.value,
                Value::Rgb(_) | Value::Spectrum(_) | Value::Blackbody { .. } | Value::Object(_)
            )
        });
        if is_colour && let Some(rgb) = self.opt_rgb(name, ColorUse::Unbounded)? {
            let luminance = halflight_kernel::math::luminance(rgb.into());
            return Ok(FloatSource::Constant(luminance.into()));
        }
        Ok(FloatSource::Constant(self.get_float(name, default)?))
    }
    /// The texture of a name; nothing when the property is absent or something else.
    pub fn texture(&self, name: &str) -> Option<&Arc<Object>> {
        match &self.get(name)?.value {
            // A constant colour may be dressed as a texture; `opt_rgb` takes it.
            Value::Object(object)
                if object.kind == ObjectKind::Texture && !color::is_constant(&object.plugin) =>
            {
                Some(object)
            }
            _ => None,
        }
    }
}

/// That a number is outside of its bounds, of which those that only keep numbers finite are not worth a word.
fn outside(value: f64, min: f64, max: f64) -> String {
    const ANY: f64 = 1e30;
    let show = |x: f64| match x.abs() {
        0.0 => "0".to_owned(),
        1e-4..1e7 => x.to_string(),
        _ => format!("{x:e}"),
    };
    match (min > -ANY, max < ANY) {
        (true, false) if value < min => format!("{} is below {}", show(value), show(min)),
        (false, true) if value > max => format!("{} is above {}", show(value), show(max)),
        _ => format!(
            "{} is outside of [{}, {}]",
            show(value),
            show(min),
            show(max)
        ),
    }
}
