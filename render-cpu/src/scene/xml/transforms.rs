//! The elements of a `<transform>`.
//!
//! Each is applied after those before it: the matrix of a later element is multiplied from the left.

use glam::{DMat4, DVec3};

use super::element::Element;
use super::numbers;
use crate::scene::error::SceneError;
use crate::scene::transform;

/// Whether an element is a part of a transform.
pub fn is_transform_element(tag: &str) -> bool {
    matches!(
        tag,
        "translate" | "rotate" | "scale" | "lookat" | "lookAt" | "matrix"
    )
}

/// The matrix of one element.
pub fn matrix(element: &Element<'_>) -> Result<DMat4, SceneError> {
    match element.tag {
        "translate" => {
            element.check_attributes(&["x", "y", "z", "value"])?;
            Ok(DMat4::from_translation(xyz(element, 0.0)?))
        }
        "scale" => {
            element.check_attributes(&["x", "y", "z", "value"])?;
            Ok(DMat4::from_scale(xyz(element, 1.0)?))
        }
        "rotate" => {
            element.check_attributes(&["x", "y", "z", "value", "angle"])?;
            let axis = xyz(element, 0.0)?;
            let angle = element.parse("angle", numbers::float)?;
            transform::rotation(axis, angle).map_err(|error| element.error(error.to_string()))
        }
        "lookat" | "lookAt" => {
            element.check_attributes(&["origin", "target", "up"])?;
            let origin = element.parse("origin", numbers::vector)?;
            let target = element.parse("target", numbers::vector)?;
            let up = match element.attribute("up") {
                Some(_) => element.parse("up", numbers::vector)?,
                None => [0.0; 3],
            };
            transform::look_at(origin.into(), target.into(), up.into())
                .map_err(|error| element.error(error.to_string()))
        }
        "matrix" => {
            element.check_attributes(&["value"])?;
            let values = element.parse("value", numbers::floats)?;
            transform::from_rows(&values).ok_or_else(|| {
                element.error(format!("expected 9 or 16 numbers, found {}", values.len()))
            })
        }
        _ => Err(element.error("is not a part of a transform")),
    }
}

/// `value="a"`, `value="a, b, c"` or any of x, y, z.
pub fn xyz(element: &Element<'_>, absent: f64) -> Result<DVec3, SceneError> {
    let mut result = DVec3::splat(absent);
    if element.attribute("value").is_some() {
        if ["x", "y", "z"]
            .iter()
            .any(|axis| element.attribute(axis).is_some())
        {
            return Err(element.error("takes either \"value\" or \"x\", \"y\", \"z\""));
        }
        return Ok(element.parse("value", numbers::triplet)?.into());
    }
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        if element.attribute(axis).is_some() {
            result[i] = element.parse(axis, numbers::float)?;
        }
    }
    Ok(result)
}
