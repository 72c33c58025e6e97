//! Channels of an image as arrays of numpy.
//!
//! A layer is the channels whose names begin alike, as in an EXR file: `albedo.R`, `albedo.G`, `albedo.B` are the layer
//! `albedo` of the shape (height, width, 3); one channel alone, as `samples` or `depth.Z`, is (height, width). The channels
//! `R`, `G`, `B` are the layer `radiance`.

use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// Name of the layer of the channels without a prefix.
pub(crate) const RADIANCE: &str = "radiance";

/// Order of the channels of a layer; others follow in the order of their names.
const SUFFIXES: [&str; 9] = ["R", "G", "B", "A", "X", "Y", "Z", "U", "V"];

/// Numbers of a layer.
pub(crate) enum Data {
    Float(Py<PyArrayDyn<f32>>),
    Count(Py<PyArrayDyn<u32>>),
}

/// A layer of an image.
pub(crate) struct Layer {
    pub name: String,
    /// Names of its channels in the file, in the order of the last axis.
    pub channels: Vec<String>,
    pub data: Data,
}

/// A plane of an image: its channel's name and its values.
pub(crate) enum Plane {
    Float(Vec<f32>),
    Count(Vec<u32>),
}

/// Layer and suffix of a channel.
fn split_name(channel: &str) -> (&str, &str) {
    match channel.rsplit_once('.') {
        Some((layer, suffix)) => (layer, suffix),
        None if SUFFIXES.contains(&channel) => (RADIANCE, channel),
        None => (channel, ""),
    }
}

/// Where a channel stands in its layer.
fn rank(channel: &str) -> usize {
    let (_, suffix) = split_name(channel);
    let known = SUFFIXES.iter().position(|s| *s == suffix);
    known.unwrap_or(SUFFIXES.len())
}

/// The planes of the layers, in the order of their first channels.
pub(crate) fn layers(
    py: Python<'_>,
    planes: Vec<(String, Plane)>,
    width: usize,
    height: usize,
) -> PyResult<Vec<Layer>> {
    let mut groups: Vec<(String, Vec<(String, Plane)>)> = Vec::new();
    for (channel, plane) in planes {
        let name = split_name(&channel).0.to_owned();
        match groups.iter_mut().find(|(n, _)| *n == name) {
            Some((_, group)) => group.push((channel, plane)),
            None => groups.push((name, vec![(channel, plane)])),
        }
    }
    // Radiance first, whatever the order of the file.
    groups.sort_by_key(|(name, _)| name != RADIANCE);
    let mut made = Vec::with_capacity(groups.len());
    for (name, mut group) in groups {
        group.sort_by_key(|(channel, _)| rank(channel));
        let (channels, planes): (Vec<_>, Vec<_>) = group.into_iter().unzip();
        let data = if let [Plane::Count(counts)] = &planes[..] {
            let array = counts.clone().into_pyarray(py).reshape([height, width])?;
            Data::Count(array.to_dyn().clone().unbind())
        } else {
            let planes: Vec<Vec<f32>> = planes.into_iter().map(into_floats).collect();
            let depth = planes.len();
            let array = interleaved(planes).into_pyarray(py);
            let array = if depth == 1 {
                array.reshape([height, width])?.to_dyn().clone()
            } else {
                array.reshape([height, width, depth])?.to_dyn().clone()
            };
            Data::Float(array.unbind())
        };
        made.push(Layer {
            name,
            channels,
            data,
        });
    }
    Ok(made)
}

fn into_floats(plane: Plane) -> Vec<f32> {
    match plane {
        Plane::Float(values) => values,
        Plane::Count(values) => values.into_iter().map(|n| n as f32).collect(),
    }
}

/// Planes side by side per pixel; a single one stays where it is.
fn interleaved(mut planes: Vec<Vec<f32>>) -> Vec<f32> {
    if planes.len() == 1 {
        return planes.remove(0);
    }
    let pixels = planes.first().map_or(0, Vec::len);
    let mut values = Vec::with_capacity(pixels * planes.len());
    for i in 0..pixels {
        values.extend(planes.iter().map(|plane| plane[i]));
    }
    values
}
