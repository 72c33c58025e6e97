//! Names of version 0.6 to those of today.
//!
//! Mitsuba 2 renamed all properties from camel case to snake case, `diffuseReflectance` of `diffuse` to `reflectance`,
//! and replaced offsets and scales of textures by the transform `to_uv`. Camel case is accepted in files of any version.

use glam::{DMat4, DVec3};

use super::object::ObjectKind;

/// `toWorld` to `to_world`, `intIOR` to `int_ior`: an underscore where a capital follows a small letter, then small
/// letters for the run of capitals.
pub fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut previous_is_lower = false;
    let mut in_capitals = false;
    for c in name.chars() {
        let starts = previous_is_lower && c.is_ascii_uppercase();
        if starts {
            result.push('_');
        }
        in_capitals = starts || (in_capitals && c.is_ascii_uppercase());
        result.push(if in_capitals {
            c.to_ascii_lowercase()
        } else {
            c
        });
        previous_is_lower = c.is_ascii_lowercase();
    }
    result
}

/// The name of today for a property, already in snake case, of an object.
pub fn property_name(kind: ObjectKind, plugin: &str, name: String) -> String {
    match (kind, plugin, name.as_str()) {
        (ObjectKind::Bsdf, "diffuse" | "roughdiffuse", "diffuse_reflectance") => {
            "reflectance".into()
        }
        (ObjectKind::Bsdf, "difftrans", "diffuse_transmittance") => "transmittance".into(),
        _ => name,
    }
}

/// The properties of 0.6 that [`to_uv`] replaces; the last gives both scales where they are not given themselves.
pub const UV_NAMES: [&str; 5] = ["uoffset", "voffset", "uscale", "vscale", "uvscale"];

/// The transform for offsets and scales, in the order of [`UV_NAMES`]: uv' = scale uv + offset as 0.6 has it, and
/// uv' = scale (uv + offset) in files of later versions, as Mitsuba 3 reads them.
pub fn to_uv(values: [Option<f64>; 5], is_legacy: bool) -> DMat4 {
    let [u_offset, v_offset, u_scale, v_scale, both] = values;
    let scale = |axis: Option<f64>| axis.or(both).unwrap_or(1.0);
    let scaling = DMat4::from_scale(DVec3::new(scale(u_scale), scale(v_scale), 1.0));
    let offset = DVec3::new(u_offset.unwrap_or(0.0), v_offset.unwrap_or(0.0), 0.0);
    let translation = DMat4::from_translation(offset);
    if is_legacy {
        translation * scaling
    } else {
        scaling * translation
    }
}
