//! What films ask of the file that holds their image.
//!
//! Images are RGB in floats of 32 bits, in the format of the name that they are written to, with a PNG in sRGB beside them. What a
//! film asks for beyond that, or against it, is said; an alpha channel is written.

use crate::film::aov::{Aov, AovSet};
use crate::scene::error::SceneError;
use crate::scene::xml::Object;

/// Layers that a film asks for by its format.
pub(super) fn layers(film: &Object) -> Result<AovSet, SceneError> {
    let is_for_screens = film.plugin == "ldrfilm";
    // Of these the image does not depend.
    for name in [
        "banner",
        "attach_log",
        "sample_border",
        "compensate",
        "high_quality_edges",
        "metadata",
    ] {
        film.get(name);
    }
    precision(film)?;
    let file_format = word(film, "file_format")?;
    match (file_format.as_str(), is_for_screens) {
        ("" | "openexr" | "exr", _) | ("png", true) => {}
        _ => film.property_warn(
            "file_format",
            "the name of the output says its format (-o NAME.exr, .hdr, .pfm, .png, .jpg)",
        )?,
    }
    if is_for_screens {
        curve(film)?;
    }
    pixels(film)
}

/// A string in small letters without separators, so that both versions' spellings are one.
fn word(film: &Object, name: &str) -> Result<String, SceneError> {
    let text = film.get_string(name, "")?.to_ascii_lowercase();
    Ok(text.replace(['_', ' '], ""))
}

/// Floats of 32 bits hold everything that floats of 16 bits do.
fn precision(film: &Object) -> Result<(), SceneError> {
    match word(film, "component_format")?.as_str() {
        "" | "float16" | "float32" => Ok(()),
        _ => film.property_warn(
            "component_format",
            "images are written in floats of 32 bits (or 16, with --half)",
        ),
    }
}

/// How the PNG shows radiance.
fn curve(film: &Object) -> Result<(), SceneError> {
    let gamma = film.get_float("gamma", -1.0)?;
    // sRGB's own curve is nearest to this power.
    if gamma != -1.0 && gamma != 2.2 {
        film.property_warn("gamma", "the PNG is written in sRGB, whatever the gamma")?;
    }
    let exposure = film.get_float("exposure", 0.0)?;
    if exposure != 0.0 {
        film.property_warn(
            "exposure",
            format!("the exposure of the PNG is an option (--exposure {exposure})"),
        )?;
    }
    match word(film, "tonemap_method")?.as_str() {
        "" | "gamma" => Ok(()),
        _ => film.property_warn(
            "tonemap_method",
            "the PNG has a tone curve of its own (`halflight image convert` has others)",
        ),
    }
}

/// The channels of a pixel. Around several integrators there is a list; what the others hold becomes layers of their own.
fn pixels(film: &Object) -> Result<AovSet, SceneError> {
    let text = word(film, "pixel_format")?;
    let first = text.split(',').next().unwrap_or_default();
    let alpha = AovSet::NONE.with(Aov::Alpha);
    let (is_rgb, layers) = match first {
        "" | "rgb" => (true, AovSet::NONE),
        "rgba" => (true, alpha),
        "luminancealpha" | "xyza" | "spectrumalpha" => (false, alpha),
        _ => (false, AovSet::NONE),
    };
    if !is_rgb {
        film.property_warn("pixel_format", "images are written in RGB")?;
    }
    Ok(layers)
}
