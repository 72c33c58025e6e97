//! Elements that are values: `<float>`, `<rgb>`, `<spectrum>` and the like.

use super::element::Element;
use super::numbers::{self, shortened};
use super::object::Value;
use super::source;
use super::transforms;
use super::value::{Color, Spectrum};
use crate::scene::color;
use crate::scene::error::{SceneError, searched};

/// The elements that are values.
const TAGS: [&str; 10] = [
    "float",
    "integer",
    "boolean",
    "string",
    "point",
    "vector",
    "rgb",
    "srgb",
    "spectrum",
    "blackbody",
];

/// The value of an element and the element's name, or `None` when the element is no value.
pub fn value(element: &Element<'_>) -> Result<Option<(&'static str, Value)>, SceneError> {
    const PLAIN: &[&str] = &["name", "value"];
    let Some(tag) = TAGS.iter().copied().find(|tag| *tag == element.tag) else {
        return Ok(None);
    };
    let value = match tag {
        "float" => {
            element.check_attributes(PLAIN)?;
            Value::Float(element.parse("value", numbers::float)?)
        }
        "integer" => {
            element.check_attributes(PLAIN)?;
            Value::Int(element.parse("value", numbers::integer)?)
        }
        "boolean" => {
            element.check_attributes(PLAIN)?;
            Value::Bool(element.parse("value", numbers::boolean)?)
        }
        "string" => {
            element.check_attributes(PLAIN)?;
            Value::String(element.require("value")?.to_owned())
        }
        "point" => Value::Point(coordinates(element)?),
        "vector" => Value::Vector(coordinates(element)?),
        "rgb" | "srgb" => {
            // In version 0.6 `intent` chooses reflectance or illumination; in RGB they are the same.
            element.check_attributes(&["name", "value", "intent"])?;
            Value::Rgb(element.parse("value", |text| triplet_color(element.tag, text))?)
        }
        "spectrum" => {
            element.check_attributes(&["name", "value", "filename", "intent"])?;
            spectrum(element)?
        }
        "blackbody" => {
            element.check_attributes(&["name", "temperature", "scale"])?;
            blackbody(element)?
        }
        _ => return Ok(None),
    };
    Ok(Some((tag, value)))
}

fn coordinates(element: &Element<'_>) -> Result<[f64; 3], SceneError> {
    element.check_attributes(&["name", "value", "x", "y", "z"])?;
    if ["value", "x", "y", "z"]
        .iter()
        .all(|name| element.attribute(name).is_none())
    {
        return Err(element.error("needs \"x\", \"y\" and \"z\""));
    }
    Ok(transforms::xyz(element, 0.0)?.into())
}

/// One or three numbers, or `#rrggbb`; linear in `<rgb>`, encoded in `<srgb>`.
fn triplet_color(tag: &str, text: &str) -> Result<Color, String> {
    let values = match text.trim().strip_prefix('#') {
        Some(digits) => hexadecimal(digits).ok_or_else(|| {
            format!(
                "expected a colour of the form #rrggbb, found \"{}\"",
                shortened(text)
            )
        })?,
        None => numbers::triplet(text)?,
    };
    let was_encoded = tag == "srgb";
    let rgb = values.map(|x| if was_encoded { color::srgb_to_linear(x) } else { x } as f32);
    if !rgb.iter().all(|x| x.is_finite()) {
        return Err("the colour is too large".into());
    }
    Ok(Color { rgb, was_encoded })
}

fn hexadecimal(digits: &str) -> Option<[f64; 3]> {
    if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let number = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| f64::from(number >> shift & 0xff) / 255.0))
}

fn spectrum(element: &Element<'_>) -> Result<Value, SceneError> {
    let value = match (element.attribute("value"), element.attribute("filename")) {
        (Some(_), Some(_)) => return Err(element.error("takes either \"value\" or \"filename\"")),
        (None, None) => return Err(element.error("needs \"value\" or \"filename\"")),
        (None, Some(file)) => {
            let path = source::find(&element.search_paths, file)
                .filter(|path| path.is_file())
                .ok_or_else(|| {
                    element.error(format!(
                        "no file \"{file}\"; searched {}",
                        searched(&element.search_paths)
                    ))
                })?;
            Value::Spectrum(Spectrum::File(path))
        }
        (Some(_), None) => match element.parse("value", spectrum_value)? {
            // Rendering in RGB, 0.6 takes one number for all channels, of lights as well.
            Value::Spectrum(Spectrum::Uniform(x)) if element.is_legacy => Value::Rgb(Color {
                rgb: [x as f32; 3],
                was_encoded: false,
            }),
            value => value,
        },
    };
    Ok(value)
}

/// One number, `wavelength:value` pairs, or, as 0.6 has it in RGB, three numbers.
fn spectrum_value(text: &str) -> Result<Value, String> {
    if text.contains(':') {
        // White space around the colon does not separate.
        let joined = text.split(':').map(str::trim).collect::<Vec<_>>().join(":");
        let samples = numbers::items(&joined)
            .map(|item| {
                let (wavelength, value) = item.split_once(':').ok_or_else(|| {
                    format!("expected wavelength:value, found \"{}\"", shortened(item))
                })?;
                Ok((numbers::float(wavelength)?, numbers::float(value)?))
            })
            .collect::<Result<Vec<_>, String>>()?;
        color::check_samples(&samples)?;
        return Ok(Value::Spectrum(Spectrum::Samples(samples.into())));
    }
    match *numbers::floats(text)? {
        [x] => Ok(Value::Spectrum(Spectrum::Uniform(x))),
        [r, g, b] => Ok(Value::Rgb(Color {
            rgb: [r as f32, g as f32, b as f32],
            was_encoded: false,
        })),
        ref other => Err(format!(
            "expected one number or a list of wavelength:value, found {} numbers",
            other.len()
        )),
    }
}

fn blackbody(element: &Element<'_>) -> Result<Value, SceneError> {
    let temperature = element.parse("temperature", |text| {
        // 0.6 writes the unit: 5000K.
        numbers::float(text.trim().trim_end_matches(['k', 'K']))
    })?;
    let scale = match element.attribute("scale") {
        Some(_) => element.parse("scale", numbers::float)?,
        None => 1.0,
    };
    if temperature <= 0.0 {
        return Err(element.error(format!(
            "the temperature must be positive, found {temperature} K"
        )));
    }
    Ok(Value::Blackbody { temperature, scale })
}
