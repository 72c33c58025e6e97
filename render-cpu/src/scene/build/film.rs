//! Films and reconstruction filters.

use super::film_format;
use super::options::{Crop, FilmOverride};
use crate::film::aov::AovSet;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::scene::filter_kind;

/// Longest side of an image.
const MAX_SIDE: i64 = 65_536;

/// Size, crop and filter of the film.
pub(super) struct Film {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The size whose proportions decide the field of view.
    pub framed_size: [u32; 2],
    /// The pixels to render.
    pub crop: Crop,
    /// Kind of the reconstruction filter, one of [`filter_kind`], and its parameters.
    pub filter: (u32, [f32; 3]),
    /// Layers that it asks for.
    pub layers: AovSet,
}

impl Film {
    /// The film of a sensor, or the default one, with the changes applied.
    pub fn read(sensor: &Object, change: &FilmOverride) -> Result<Film, SceneError> {
        let object = sensor.single_child_of(ObjectKind::Film)?;
        let mut size = [768, 576];
        let mut crop = None;
        let mut filter = gaussian(0.5);
        let mut layers = AovSet::NONE;
        if let Some(object) = object {
            object.touch();
            let side = |name, default| object.get_int_in(name, default, 1, MAX_SIDE);
            size = [side("width", 768)? as u32, side("height", 576)? as u32];
            if object.has("crop_width")
                || object.has("crop_height")
                || object.has("crop_offset_x")
                || object.has("crop_offset_y")
            {
                let offset = [
                    object.get_int_in("crop_offset_x", 0, 0, i64::from(size[0]) - 1)? as u32,
                    object.get_int_in("crop_offset_y", 0, 0, i64::from(size[1]) - 1)? as u32,
                ];
                crop = Some(Crop {
                    offset,
                    size: [
                        object.get_int_in(
                            "crop_width",
                            (size[0] - offset[0]).into(),
                            1,
                            MAX_SIDE,
                        )? as u32,
                        object.get_int_in(
                            "crop_height",
                            (size[1] - offset[1]).into(),
                            1,
                            MAX_SIDE,
                        )? as u32,
                    ],
                });
            }
            if !matches!(
                object.plugin.as_str(),
                "hdrfilm" | "ldrfilm" | "mfilm" | "tiledhdrfilm"
            ) {
                object.warn(format!(
                    "films of type \"{}\" are not supported; \"hdrfilm\" is used instead",
                    object.plugin
                ))?;
            }
            layers = film_format::layers(object)?;
            if let Some(rfilter) = object.single_child_of(ObjectKind::RFilter)? {
                filter = read_filter(rfilter)?;
            }
        }
        let before = size;
        if let Some(new) = change.size {
            size = new;
        } else if let Some(width) = change.width {
            let height = f64::from(size[1]) * f64::from(width) / f64::from(size[0]);
            size = [width, (height.round() as u32).max(1)];
        }
        if size.iter().any(|&s| s == 0 || i64::from(s) > MAX_SIDE) {
            return Err(SceneError::Request(format!(
                "an image of {} x {} pixels cannot be rendered; sides are 1 to {MAX_SIDE}",
                size[0], size[1]
            )));
        }
        let crop = match (change.crop, crop) {
            (Some(crop), _) => crop,
            (None, Some(crop)) => scale_crop(crop, before, size),
            (None, None) => Crop {
                offset: [0, 0],
                size,
            },
        };
        for axis in 0..2 {
            let end = u64::from(crop.offset[axis]) + u64::from(crop.size[axis]);
            if crop.size[axis] == 0 || end > u64::from(size[axis]) {
                return Err(SceneError::Request(format!(
                    "the crop {},{},{},{} is not inside the image of {} x {} pixels",
                    crop.offset[0], crop.offset[1], crop.size[0], crop.size[1], size[0], size[1]
                )));
            }
        }
        Ok(Film {
            size,
            framed_size: if change.size.is_some() { size } else { before },
            crop,
            filter,
            layers,
        })
    }
}

/// The same part of a film of another size.
fn scale_crop(crop: Crop, from: [u32; 2], to: [u32; 2]) -> Crop {
    let mut scaled = crop;
    for axis in 0..2 {
        let scale = |x: u32| (u64::from(x) * u64::from(to[axis]) / u64::from(from[axis])) as u32;
        scaled.offset[axis] = scale(crop.offset[axis]);
        scaled.size[axis] =
            (scale(crop.offset[axis] + crop.size[axis]) - scaled.offset[axis]).max(1);
    }
    scaled
}

fn gaussian(stddev: f32) -> (u32, [f32; 3]) {
    (filter_kind::GAUSSIAN, [4.0 * stddev, stddev, 0.0])
}

fn read_filter(object: &Object) -> Result<(u32, [f32; 3]), SceneError> {
    let positive = |name: &str, default: f64| -> Result<f32, SceneError> {
        Ok(object.get_float_in(name, default, 1e-3, 64.0)? as f32)
    };
    Ok(match object.plugin.as_str() {
        "box" => (filter_kind::BOX, [positive("radius", 0.5)?, 0.0, 0.0]),
        "tent" => (filter_kind::TENT, [positive("radius", 1.0)?, 0.0, 0.0]),
        "gaussian" => gaussian(positive("stddev", 0.5)?),
        "mitchell" => {
            let third = 1.0 / 3.0;
            let b = if object.has("b") { "b" } else { "B" };
            let c = if object.has("c") { "c" } else { "C" };
            (
                filter_kind::MITCHELL,
                [
                    2.0,
                    object.get_float(b, third)? as f32,
                    object.get_float(c, third)? as f32,
                ],
            )
        }
        "catmullrom" => (filter_kind::CATMULL_ROM, [2.0, 0.0, 0.0]),
        "lanczos" => (
            filter_kind::LANCZOS,
            [object.get_int_in("lobes", 3, 1, 32)? as f32, 0.0, 0.0],
        ),
        other => {
            object.warn(format!(
                "the reconstruction filter \"{other}\" is not supported; \"gaussian\" is used instead"
            ))?;
            gaussian(0.5)
        }
    })
}
