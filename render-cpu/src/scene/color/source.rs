//! The colour that a property of a scene means.
//!
//! Triplets and plain numbers are taken as they are, spectra are integrated. What is out of range is clamped with a
//! warning.

use std::path::Path;

use super::{Illuminant, blackbody_to_srgb, check_samples, samples_to_srgb, xyz_to_srgb};
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind, Property, Spectrum, Value, numbers, read_text};

/// What a colour is for, which decides its range and how a spectrum becomes a triplet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorUse {
    /// A reflectance or transmittance: within [0, 1].
    Reflectance,
    /// Radiance, intensity or irradiance: not negative; a flat spectrum has the colour of equal energy.
    Emission,
    /// An index of refraction or a factor: not negative; a flat spectrum is the same in every channel.
    Unbounded,
}

impl ColorUse {
    /// Under which light a spectrum of this use is turned into a colour.
    fn illuminant(self) -> Illuminant {
        match self {
            ColorUse::Emission => Illuminant::EqualEnergy,
            ColorUse::Reflectance | ColorUse::Unbounded => Illuminant::D65,
        }
    }
}

/// A colour, and what had to be changed to get it.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted {
    /// Linear sRGB.
    pub rgb: [f32; 3],
    /// Why the colour differs from the given one.
    pub warning: Option<String>,
}

/// A colour that saturated spectra leave by this much is clamped without a warning: the colours of measured surfaces
/// do so by the width of the sRGB gamut, and nothing can be done about it.
const GAMUT_SLACK: f64 = 0.05;

/// The colour of a property, or `None` when it is none, a texture for instance.
///
/// # Errors
/// When a file of a spectrum cannot be read, or the colour is too large for f32.
pub fn from_property(
    property: &Property,
    usage: ColorUse,
) -> Result<Option<Converted>, SceneError> {
    let fail =
        |message: String| SceneError::element(&property.location, property.element(), message);
    let (rgb, slack) = match &property.value {
        Value::Float(x) => ([*x; 3], 0.0),
        Value::Int(x) => ([*x as f64; 3], 0.0),
        Value::Rgb(color) => (color.rgb.map(f64::from), 0.0),
        Value::Spectrum(Spectrum::Uniform(x)) => (uniform(*x, usage), 0.0),
        Value::Spectrum(Spectrum::Samples(samples)) => {
            (samples_to_srgb(usage.illuminant(), samples), GAMUT_SLACK)
        }
        Value::Spectrum(Spectrum::File(path)) => (
            samples_to_srgb(usage.illuminant(), &read_samples(path)?),
            GAMUT_SLACK,
        ),
        Value::Blackbody { temperature, scale } => {
            let rgb = blackbody_to_srgb(*temperature).map(|x| x * scale);
            let peak = rgb[0].max(rgb[1]).max(rgb[2]);
            (rgb, peak * GAMUT_SLACK)
        }
        Value::Object(object) => match plugin(object, usage)? {
            Some(rgb) => (rgb, GAMUT_SLACK),
            None => return Ok(None),
        },
        _ => return Ok(None),
    };
    let (min, max) = match usage {
        ColorUse::Reflectance => (0.0, 1.0),
        ColorUse::Emission | ColorUse::Unbounded => (0.0, f64::INFINITY),
    };
    if !rgb
        .iter()
        .all(|x| x.is_finite() && x.abs() <= f64::from(f32::MAX))
    {
        return Err(fail("the colour is too large for 32-bit floats".into()));
    }
    let outside = rgb.iter().any(|x| *x < min - slack || *x > max + slack);
    let warning = outside.then(|| {
        let range = if max == 1.0 {
            "[0, 1]"
        } else {
            "the positive numbers"
        };
        let [r, g, b] = rgb.map(|x| x as f32);
        format!("the colour ({r}, {g}, {b}) is clamped to {range}")
    });
    let rgb = rgb.map(|x| x.clamp(min, max) as f32);
    Ok(Some(Converted { rgb, warning }))
}

fn uniform(value: f64, usage: ColorUse) -> [f64; 3] {
    match usage {
        ColorUse::Emission => xyz_to_srgb([value; 3]),
        ColorUse::Reflectance | ColorUse::Unbounded => [value; 3],
    }
}

/// Whether a spectrum or texture plugin is a constant colour.
pub fn is_constant(plugin: &str) -> bool {
    matches!(
        plugin,
        "uniform" | "d65" | "srgb" | "rgb" | "blackbody" | "irregular" | "regular"
    )
}

/// The colour of `<spectrum type="...">`, or of a texture of these types.
fn plugin(object: &Object, usage: ColorUse) -> Result<Option<[f64; 3]>, SceneError> {
    if !matches!(object.kind, ObjectKind::Spectrum | ObjectKind::Texture) {
        return Ok(None);
    }
    let rgb = match object.plugin.as_str() {
        "uniform" => [object.get_float("value", 1.0)?; 3],
        // In RGB, daylight is white.
        "d65" => {
            let scale = object.get_float("scale", 1.0)?;
            let rgb = object.get_rgb("color", ColorUse::Unbounded, [1.0; 3])?;
            rgb.map(|x| f64::from(x) * scale)
        }
        "srgb" | "rgb" => {
            let name = if object.has("value") {
                "value"
            } else {
                "color"
            };
            object
                .get_rgb(name, ColorUse::Unbounded, [1.0; 3])?
                .map(f64::from)
        }
        "blackbody" => {
            let temperature = object.require_float("temperature")?;
            if temperature <= 0.0 {
                return Err(
                    object.property_error("temperature", "the temperature must be positive")
                );
            }
            let scale = object.get_float("scale", 1.0)?;
            blackbody_to_srgb(temperature).map(|x| x * scale)
        }
        "irregular" => {
            let wavelengths = list(object, "wavelengths")?;
            let values = list(object, "values")?;
            if wavelengths.len() != values.len() {
                let counts = format!(
                    "{} wavelengths and {} values",
                    wavelengths.len(),
                    values.len()
                );
                return Err(object.error(format!("found {counts}")));
            }
            sampled(object, usage, wavelengths.into_iter().zip(values).collect())?
        }
        "regular" => {
            let first = object.require_float("wavelength_min")?;
            let last = object.require_float("wavelength_max")?;
            let values = list(object, "values")?;
            let intervals = values.len().saturating_sub(1).max(1) as f64;
            let wavelength = |i: usize| first + (last - first) * i as f64 / intervals;
            let samples = values
                .into_iter()
                .enumerate()
                .map(|(i, value)| (wavelength(i), value));
            sampled(object, usage, samples.collect())?
        }
        _ => return Ok(None),
    };
    Ok(Some(rgb))
}

fn list(object: &Object, name: &str) -> Result<Vec<f64>, SceneError> {
    numbers::floats(object.require_string(name)?)
        .map_err(|message| object.property_error(name, message))
}

fn sampled(
    object: &Object,
    usage: ColorUse,
    samples: Vec<(f64, f64)>,
) -> Result<[f64; 3], SceneError> {
    check_samples(&samples).map_err(|message| object.error(message))?;
    Ok(samples_to_srgb(usage.illuminant(), &samples))
}

/// A file with a wavelength in nanometres and a value on each line; `#` starts a comment.
pub(crate) fn read_samples(path: &Path) -> Result<Vec<(f64, f64)>, SceneError> {
    /// Measured spectra have hundreds of lines.
    const MAX_BYTES: u64 = 16 << 20;
    let text = read_text(path, MAX_BYTES)?;
    let mut samples = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() {
            continue;
        }
        let fail = |message: String| {
            let mut error = SceneError::file(path, message);
            if let SceneError::File { location, .. } = &mut error {
                location.line = (i + 1) as u32;
            }
            error
        };
        match *numbers::floats(line).map_err(fail)? {
            [wavelength, value] => samples.push((wavelength, value)),
            _ => return Err(fail("expected a wavelength and a value".into())),
        }
    }
    check_samples(&samples).map_err(|message| SceneError::file(path, message))?;
    Ok(samples)
}
