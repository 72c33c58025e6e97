//! Layers of the images that are merged: what must be there, and which values samples can have.

use super::ExrImage;
use super::merge_error::MergeError;
use super::metadata::ImageMetadata;
use super::window::Window;

/// The layer of sample counts.
pub(super) const SAMPLES: &str = "samples";

/// How the names of layers of variances begin.
pub(super) const VARIANCE: &str = "variance.";

/// The pixels of an image.
pub(super) fn window(image: &ExrImage) -> Window {
    Window {
        origin: image.origin,
        width: image.width,
        height: image.height,
    }
}

/// Name of the channel with the variance of a channel.
pub(super) fn variance_of(channel: &str) -> String {
    format!("{VARIANCE}{channel}")
}

/// What an image says about its making.
pub(super) fn metadata(name: &str, image: &ExrImage) -> Result<ImageMetadata, MergeError> {
    let find = |attribute: &str| image.attribute(attribute).map(str::to_owned);
    ImageMetadata::from_attributes(find).map_err(|source| MergeError::Metadata {
        name: name.to_owned(),
        source,
    })
}

/// Samples of every pixel.
pub(super) fn sample_counts(name: &str, image: &ExrImage) -> Result<Vec<f64>, MergeError> {
    let missing = |layer: &str| MergeError::MissingLayer {
        name: name.to_owned(),
        layer: layer.to_owned(),
    };
    for layer in ["R", "G", "B"] {
        if image.channel(layer).is_none() {
            return Err(missing(layer));
        }
    }
    let counts = image.sample_counts().ok_or_else(|| missing(SAMPLES))?;
    let counts = to_f64(name, &counts, image.width as usize)?;
    match counts.iter().position(|n| *n < 0.0 || n.fract() != 0.0) {
        Some(i) => Err(invalid(
            name,
            "a number of samples that is not whole",
            i,
            image.width as usize,
        )),
        None => Ok(counts),
    }
}

/// Sums of squared deviations from variances of means.
pub(super) fn deviations(
    name: &str,
    variance: &[f32],
    counts: &[f64],
    width: usize,
) -> Result<Vec<f64>, MergeError> {
    let mut m2 = to_f64(name, variance, width)?;
    if let Some(i) = m2.iter().position(|v| *v < 0.0) {
        return Err(invalid(name, "a negative variance", i, width));
    }
    for (v, n) in m2.iter_mut().zip(counts) {
        *v *= n * (n - 1.0).max(0.0);
    }
    Ok(m2)
}

/// Finite values.
pub(super) fn to_f64(name: &str, values: &[f32], width: usize) -> Result<Vec<f64>, MergeError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(invalid(name, "a value that is not finite", i, width)),
        None => Ok(values.iter().map(|&v| f64::from(v)).collect()),
    }
}

fn invalid(name: &str, what: &str, i: usize, width: usize) -> MergeError {
    MergeError::InvalidPixel {
        name: name.to_owned(),
        what: what.to_owned(),
        x: i % width,
        y: i / width,
    }
}
