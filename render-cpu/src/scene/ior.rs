//! Indices of refraction by the name of the material.
//!
//! Dielectrics have one number, for yellow light (the sodium D line) at room temperature; conductors have a complex
//! index per channel, averaged from published measurements, in `data/conductors.csv`.

use std::sync::OnceLock;

use super::color::ColorUse;
use super::error::{SceneError, suggestion};
use super::xml::{Object, Value};

/// Dielectrics, from gases to diamond.
const DIELECTRICS: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// The index of a dielectric; the case of the name does not matter.
pub fn dielectric(name: &str) -> Option<f64> {
    let found = DIELECTRICS
        .iter()
        .find(|(known, _)| known.eq_ignore_ascii_case(name));
    found.map(|(_, index)| *index)
}

/// The index that a property gives as a number or a name.
///
/// # Errors
/// When the name is not known, or the index is not positive.
pub fn get_dielectric(object: &Object, property: &str, default: f64) -> Result<f64, SceneError> {
    let index = match object.get(property).map(|found| &found.value) {
        Some(Value::String(name)) => dielectric(name).ok_or_else(|| {
            let known = DIELECTRICS.iter().map(|(known, _)| *known);
            object.property_error(property, unknown("dielectric", name, known))
        })?,
        _ => object.get_float(property, default)?,
    };
    if index <= 0.0 {
        return Err(object.property_error(
            property,
            format!("the index must be positive, found {index}"),
        ));
    }
    Ok(index)
}

/// A conductor's complex index of refraction, eta + i k, per channel of linear sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// The real part.
    pub eta: [f32; 3],
    /// The imaginary part, the extinction.
    pub k: [f32; 3],
}

impl Conductor {
    /// Reflects everything: the Fresnel reflectance of eta = 0, k = 1 is 1 at every angle.
    pub const PERFECT_MIRROR: Conductor = Conductor {
        eta: [0.0; 3],
        k: [1.0; 3],
    };
}

/// The index of a conductor, "none" being the perfect mirror. `Na` finds `Na_palik` where only that was measured.
pub fn conductor(name: &str) -> Option<Conductor> {
    if name.eq_ignore_ascii_case("none") {
        return Some(Conductor::PERFECT_MIRROR);
    }
    let find = |name: &str| conductors().iter().find(|(known, _)| *known == name);
    find(name)
        .or_else(|| find(&format!("{name}_palik")))
        .map(|(_, conductor)| *conductor)
}

/// The names of the conductors.
pub fn conductor_names() -> impl Iterator<Item = &'static str> {
    conductors().iter().map(|(name, _)| *name)
}

/// The index that an object gives by `material`, or by `eta` and `k`; when it gives none of these, a perfect mirror, and
/// copper before version 2.
///
/// # Errors
/// When the name is not known, or only one of `eta` and `k` is given.
pub fn get_conductor(object: &Object) -> Result<Conductor, SceneError> {
    let name = object.opt_string("material")?;
    match (name, object.has("eta"), object.has("k")) {
        (None, false, false) if object.is_legacy => {
            Ok(conductor("Cu").unwrap_or(Conductor::PERFECT_MIRROR))
        }
        (None, false, false) => Ok(Conductor::PERFECT_MIRROR),
        (Some(name), false, false) => conductor(name).ok_or_else(|| {
            object.property_error("material", unknown("conductor", name, conductor_names()))
        }),
        (None, true, true) => Ok(Conductor {
            eta: object.get_rgb("eta", ColorUse::Unbounded, [0.0; 3])?,
            k: object.get_rgb("k", ColorUse::Unbounded, [1.0; 3])?,
        }),
        (None, _, _) => Err(object.error("needs both \"eta\" and \"k\"")),
        (Some(_), _, _) => Err(object.error("takes either \"material\" or \"eta\" and \"k\"")),
    }
}

fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    match suggestion(name, known) {
        Some(near) => format!("no {what} is called \"{name}\"; did you mean \"{near}\"?"),
        None => format!("no {what} is called \"{name}\""),
    }
}

fn conductors() -> &'static [(&'static str, Conductor)] {
    static TABLE: OnceLock<Vec<(&str, Conductor)>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let rows = include_str!("data/conductors.csv").lines();
        rows.filter(|line| !line.starts_with('#'))
            .skip(1)
            .filter_map(row)
            .collect()
    })
}

/// `name,eta_r,eta_g,eta_b,k_r,k_g,k_b`.
fn row(line: &str) -> Option<(&str, Conductor)> {
    let (name, numbers) = line.split_once(',')?;
    let mut values = numbers.split(',').map(|number| number.parse::<f32>().ok());
    let mut triplet = || Some([values.next()??, values.next()??, values.next()??]);
    let (eta, k) = (triplet()?, triplet()?);
    Some((name, Conductor { eta, k }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_conductors_are_all_read() {
        let lines = include_str!("data/conductors.csv").lines().count();
        assert_eq!(conductors().len(), lines - 2);
        assert_eq!(
            conductor("Cu").unwrap().eta,
            [0.2010055, 0.9237495, 1.102215]
        );
        assert_eq!(conductor("Na"), conductor("Na_palik"));
        assert_eq!(conductor("none"), Some(Conductor::PERFECT_MIRROR));
        assert_eq!(conductor("Unobtainium"), None);
    }

    #[test]
    fn near_misses_are_suggested() {
        let known = || DIELECTRICS.iter().map(|(known, _)| *known);
        assert_eq!(suggestion("wter", known()), Some("water"));
        assert_eq!(suggestion("Diamnd", known()), Some("diamond"));
        assert_eq!(suggestion("unobtainium", known()), None);
        assert_eq!(suggestion("", known()), None);
    }
}
