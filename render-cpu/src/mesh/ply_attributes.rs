//! Attributes of vertices and faces in PLY files, by the names of their properties.
//!
//! As in Mitsuba 3, consecutive properties with a common stem are the channels of one attribute, and there must be one
//! or three: `r g b` and `red green blue` make `vertex_color`, `foo_r foo_g foo_b` make `vertex_foo_color`, `foo_0 ...`
//! and `foo_x foo_y foo_z` make `vertex_foo` (`face_` for faces). Properties without a suffix are skipped. Two
//! differences: colours of type `uchar` and `ushort` are scaled to [0, 1], which Mitsuba leaves as they are with a warning,
//! and a fourth colour channel (alpha) is ignored rather than the whole attribute.

use super::Attribute;
use super::colors::{self, Bytes};
use super::ply_header::{Element, Property, Scalar};

/// Where a number of a row is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Target {
    /// Nowhere.
    Skip,
    /// A component of the position.
    Position(usize),
    /// A component of the normal.
    Normal(usize),
    /// A texture coordinate.
    Uv(usize),
    /// The index of an attribute, and a factor; channels follow one another.
    Attribute(usize, f64),
}

/// Groups the properties of an element into attributes; all that are not part of one are skipped.
pub(super) fn attribute_targets(
    element: &Element,
    prefix: &str,
    warnings: &mut Vec<String>,
) -> (Vec<Target>, Vec<Attribute>) {
    let mut targets = vec![Target::Skip; element.properties.len()];
    let mut attributes: Vec<Attribute> = Vec::new();
    let mut start = 0;
    while start < element.properties.len() {
        let stem = attribute_stem(&element.properties[start]);
        let end = (start + 1..element.properties.len())
            .find(|&k| attribute_stem(&element.properties[k]) != stem)
            .unwrap_or(element.properties.len());
        let Some((stem, is_color)) = stem else {
            start = end;
            continue;
        };
        let channels = match end - start {
            4 if is_color => 3,
            count => count,
        };
        let name = format!("{prefix}{stem}");
        if matches!(channels, 1 | 3) && attributes.iter().all(|a| a.name != name) {
            for (target, property) in targets[start..start + channels]
                .iter_mut()
                .zip(&element.properties[start..])
            {
                let factor = match property.scalar {
                    Scalar::U8 if is_color => 1.0 / 255.0,
                    Scalar::U16 if is_color => 1.0 / 65535.0,
                    _ => 1.0,
                };
                *target = Target::Attribute(attributes.len(), factor);
            }
            attributes.push(Attribute {
                name,
                channels: channels as u32,
                values: Vec::new(),
            });
        } else {
            warnings.push(format!(
                "the attribute \"{name}\" has {channels} channels, not 1 or 3, and is left out"
            ));
        }
        start = end;
    }
    (targets, attributes)
}

/// The name that a property shares with the other channels of its attribute, and whether it is a colour.
fn attribute_stem(property: &Property) -> Option<(String, bool)> {
    let name = property.name.as_str();
    if property.list.is_some() || matches!(name, "texture_u" | "texture_v") {
        return None;
    }
    // Programs of some years ago tell colours of surfaces from others.
    if matches!(
        name.strip_prefix("diffuse_").unwrap_or(name),
        "r" | "g" | "b" | "a" | "red" | "green" | "blue" | "alpha"
    ) {
        return Some(("color".into(), true));
    }
    let (stem, suffix) = name.rsplit_once('_')?;
    match suffix {
        _ if stem.is_empty() => None,
        "r" | "g" | "b" | "a" => Some((format!("{stem}_color"), true)),
        "x" | "y" | "z" | "0" | "1" | "2" | "3" => Some((stem.to_owned(), false)),
        _ => None,
    }
}

/// Divides colours of whole numbers that are bytes in a longer type by 255, and says of others that they look like bytes.
pub(super) fn decode_colors(
    element: &Element,
    targets: &[Target],
    attributes: &mut [Attribute],
) -> Vec<String> {
    let mut said = Vec::new();
    for (index, attribute) in attributes.iter_mut().enumerate() {
        let mut channels = targets.iter().zip(&element.properties);
        let is_of = |target: &Target| matches!(*target, Target::Attribute(i, 1.0) if i == index);
        let first = channels.find(|(target, _)| is_of(target));
        let Some((_, property)) = first.filter(|_| attribute.name.ends_with("color")) else {
            continue;
        };
        let bytes = match property.scalar.is_integer() {
            true => Bytes::AreScaled,
            false => Bytes::AreKept,
        };
        said.extend(colors::decode(attribute, bytes));
    }
    said
}

/// Says which properties of vertices are not used, but for those that are measurements.
pub(super) fn unused(element: &Element, targets: &[Target]) -> Option<String> {
    let harmless = [
        "confidence",
        "intensity",
        "quality",
        "flags",
        "alpha",
        "a",
        "diffuse_alpha",
        "texnumber",
    ];
    let names: Vec<&str> = targets
        .iter()
        .zip(&element.properties)
        .filter(|(target, _)| **target == Target::Skip)
        .map(|(_, property)| property.name.as_str())
        // Attributes that have too many channels are named already.
        .filter(|name| !harmless.contains(name) && !name.contains('_'))
        .collect();
    let list = names.join(", ");
    (!list.is_empty()).then(|| format!("the properties {list} of vertices are not used"))
}
