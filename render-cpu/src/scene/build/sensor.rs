//! Sensors and samplers.

use super::film::Film;
use super::options::BuildOptions;
use crate::film::aov::AovSet;
use crate::scene::error::SceneError;
use crate::scene::tables::SceneTables;
use crate::scene::transform;
use crate::scene::xml::{Object, ObjectKind, Value};
use halflight_kernel::math::filter;
use halflight_kernel::sampler::sampler_kind;
use halflight_kernel::scene::camera::{fov_axis, half_extents};
use halflight_kernel::scene::{Camera, NONE, camera_kind};
use std::sync::Arc;

/// The camera record, and the sampler that is part of the sensor.
pub(super) struct Sensor {
    pub camera: Camera,
    pub sampler: u32,
    pub sampler_name: String,
    pub spp: u32,
    pub seed: u32,
    /// Layers that the film asks for.
    pub layers: AovSet,
    /// The object of an irradiance meter, by its index: its shape is not built yet.
    pub meter: Option<usize>,
}

/// All sensors in the order of the file, those of shapes with them, and whether they belong to a shape.
pub fn all(root: &Object) -> Vec<(Arc<Object>, bool)> {
    root.children_of(ObjectKind::Sensor).for_each(drop);
    let mut sensors = Vec::new();
    for child in root.children() {
        if child.object.kind == ObjectKind::Sensor {
            sensors.push((child.object.clone(), false));
        } else if child.object.kind == ObjectKind::Shape {
            // Without a mark: shapes are built later, or not at all.
            let nested = child
                .object
                .properties
                .iter()
                .filter_map(|p| match &p.value {
                    Value::Object(object) if object.kind == ObjectKind::Sensor => {
                        Some(object.clone())
                    }
                    _ => None,
                });
            sensors.extend(nested.map(|object| (object, true)));
        }
    }
    sensors
}

/// Builds the chosen sensor.
pub(super) fn build(root: &Object, options: &BuildOptions) -> Result<Sensor, SceneError> {
    let sensors = all(root);
    if sensors.is_empty() {
        return Err(root.error("the scene has no sensor"));
    }
    let (sensor, is_nested) = sensors.get(options.sensor).ok_or_else(|| {
        SceneError::Request(format!(
            "there is no sensor {}; the scene has {}",
            options.sensor,
            sensors.len()
        ))
    })?;
    let film = Film::read(sensor, &options.film)?;
    let to_world = match (sensor.plugin.as_str(), sensor.opt_vector("origin")?) {
        ("radiancemeter", Some(origin)) => {
            let origin = glam::DVec3::from_array(origin);
            let direction = sensor.opt_vector("direction")?.ok_or_else(|| {
                sensor.property_error("origin", "needs a \"direction\" beside it")
            })?;
            transform::look_at(
                origin,
                origin + glam::DVec3::from_array(direction),
                glam::DVec3::ZERO,
            )
            .map_err(|e| sensor.property_error("direction", e.to_string()))?
        }
        _ => sensor.get_transform("to_world")?,
    };
    let (rows, inverse) = transform::rows_and_inverse(&to_world)
        .map_err(|e| sensor.property_error("to_world", e.to_string()))?;
    let is_irradiance = sensor.plugin == "irradiancemeter";
    if is_irradiance != *is_nested {
        return Err(sensor.error(if is_irradiance {
            "an irradiance meter needs a shape around it"
        } else {
            "only an irradiance meter can be part of a shape"
        }));
    }
    let kind = match sensor.plugin.as_str() {
        "perspective" => camera_kind::PERSPECTIVE,
        "thinlens" => camera_kind::THIN_LENS,
        "orthographic" => camera_kind::ORTHOGRAPHIC,
        // All its rays are one: those of a film without a size.
        "radiancemeter" => camera_kind::ORTHOGRAPHIC,
        "irradiancemeter" => camera_kind::IRRADIANCE_METER,
        // Its name in Mitsuba 0.6 and those of others.
        "spherical" | "equirectangular" | "panoramic" | "environment" => camera_kind::SPHERICAL,
        other => {
            let (kind, instead) = match other {
                // Parallel rays in the middle of the image, or everywhere.
                "distant" | "telecentric" => (camera_kind::ORTHOGRAPHIC, "orthographic"),
                _ => (camera_kind::PERSPECTIVE, "perspective"),
            };
            sensor.warn(format!(
                "sensors of type \"{other}\" are not supported; \"{instead}\" is used instead"
            ))?;
            kind
        }
    };
    if kind == camera_kind::SPHERICAL && !transform::keeps_angles(&to_world) {
        return Err(sensor.property_error("to_world", "must not stretch a panoramic camera"));
    }
    let [width, height] = film.size;
    // All directions, or none.
    let has_view = kind <= camera_kind::ORTHOGRAPHIC && sensor.plugin != "radiancemeter";
    let (tan_half_width, tan_half_height) = if !has_view {
        (0.0, 0.0)
    } else if kind == camera_kind::ORTHOGRAPHIC {
        (1.0, height as f32 / width as f32)
    } else {
        // A new width keeps the horizontal field of view of the file's film; its rounded height would change it a
        // little where the angle is given along another axis.
        let [file_width, file_height] = film.framed_size;
        let (tan_half_width, _) = field_of_view(sensor, file_width, file_height)?;
        (
            tan_half_width,
            tan_half_width * height as f32 / width as f32,
        )
    };
    // Meters and panoramas have no clipping planes.
    let (nearest, farthest) = if has_view {
        (1e-2, 1e4)
    } else {
        (0.0, f64::from(f32::MAX))
    };
    // Nothing moves while the shutter is open.
    for name in ["shutter_open", "shutter_close"] {
        sensor.get(name);
    }
    let near = sensor.get_float("near_clip", nearest)?;
    let far = sensor.get_float("far_clip", farthest)?;
    if near < 0.0 || far <= near {
        return Err(sensor.error("needs 0 <= near_clip < far_clip"));
    }
    let (filter, filter_parameters) = film.filter;
    let camera = Camera {
        kind,
        to_world: rows,
        to_camera: inverse,
        film_size: film.size,
        crop_offset: film.crop.offset,
        crop_size: film.crop.size,
        tan_half_width,
        tan_half_height,
        principal_point_offset: [
            sensor.get_float("principal_point_offset_x", 0.0)? as f32,
            sensor.get_float("principal_point_offset_y", 0.0)? as f32,
        ],
        aperture_radius: aperture(sensor, kind)?,
        focus_distance: sensor.get_float_in("focus_distance", far, 1e-12, f64::from(f32::MAX))?
            as f32,
        clip: [near as f32, far as f32],
        filter,
        filter_parameters,
        filter_table: 0,
        filter_table_size: 0,
        shape: NONE,
        shape_areas: NONE,
    };
    let (sampler, sampler_name, spp, seed) = read_sampler(sensor, options)?;
    Ok(Sensor {
        camera,
        sampler,
        sampler_name,
        spp,
        seed,
        layers: film.layers,
        meter: is_irradiance.then_some(sensor.index),
    })
}

/// Puts the filter's cumulative table into `data`.
pub(super) fn fill_filter_table(tables: &mut SceneTables) {
    let first = tables.data.len();
    let size = filter::TABLE_SIZE;
    tables
        .data
        .resize(first + filter::table_words(size) as usize, 0.0);
    filter::fill_table(
        tables.camera.filter,
        tables.camera.filter_parameters,
        &mut tables.data[first..],
    );
    tables.camera.filter_table = first as u32;
    tables.camera.filter_table_size = size;
}

fn aperture(sensor: &Object, kind: u32) -> Result<f32, SceneError> {
    if kind != camera_kind::THIN_LENS {
        return Ok(0.0);
    }
    let radius = sensor.get_float("aperture_radius", 0.0)?;
    if radius < 0.0 {
        return Err(sensor.property_error("aperture_radius", "cannot be negative"));
    }
    Ok(radius as f32)
}

/// Tangents of half the field of view of a camera or a projector from `fov` and `fov_axis`, or from the focal length on 35 mm film.
pub(super) fn field_of_view(
    sensor: &Object,
    width: u32,
    height: u32,
) -> Result<(f32, f32), SceneError> {
    if let Some(fov) = sensor.opt_float("fov")? {
        if !(fov > 0.0 && fov < 180.0) {
            return Err(sensor.property_error("fov", "must be between 0 and 180 degrees"));
        }
        let axis = match sensor.get_string("fov_axis", "x")? {
            "x" => fov_axis::X,
            "y" => fov_axis::Y,
            "diagonal" => fov_axis::DIAGONAL,
            "smaller" => fov_axis::SMALLER,
            "larger" => fov_axis::LARGER,
            other => {
                return Err(sensor.property_error(
                    "fov_axis",
                    format!("\"{other}\" is none of x, y, diagonal, smaller, larger"),
                ));
            }
        };
        return Ok(half_extents(fov as f32, axis, width, height));
    }
    // Diagonal of a 36 x 24 mm frame.
    const DIAGONAL_MM: f64 = 43.266_615_305_567_87;
    let text = sensor.get_string("focal_length", "50mm")?;
    let millimetres: f64 = text
        .trim()
        .trim_end_matches("mm")
        .trim()
        .parse()
        .ok()
        .filter(|f: &f64| f.is_finite() && *f > 0.0)
        .ok_or_else(|| {
            sensor.property_error("focal_length", format!("\"{text}\" is no length in mm"))
        })?;
    let fov = 2.0 * (0.5 * DIAGONAL_MM / millimetres).atan().to_degrees();
    Ok(half_extents(fov as f32, fov_axis::DIAGONAL, width, height))
}

/// Kind and name of the sampler, samples per pixel and seed.
fn read_sampler(
    sensor: &Object,
    options: &BuildOptions,
) -> Result<(u32, String, u32, u32), SceneError> {
    let object = sensor.single_child_of(ObjectKind::Sampler)?;
    let (mut spp, mut seed, mut plugin) = (4, 0, "independent".to_string());
    if let Some(object) = object {
        object.touch();
        spp = object.get_int_in("sample_count", 4, 1, i64::from(u32::MAX))? as u32;
        seed = object.get_int_in("seed", 0, 0, i64::from(u32::MAX))? as u32;
        plugin = object.plugin.clone();
        // Parameters of Mitsuba's samplers that ours do not need.
        for name in ["jitter", "dimension", "scramble"] {
            object.get(name);
        }
    }
    if let Some(name) = &options.sampler {
        plugin.clone_from(name);
    }
    let kind = match plugin.as_str() {
        "independent" => sampler_kind::INDEPENDENT,
        // Every stratified or low-discrepancy sampler is served by the best that we have.
        "sobol" | "ldsampler" | "multijitter" | "stratified" | "orthogonal" | "halton"
        | "hammersley" => sampler_kind::SOBOL,
        other if options.sampler.is_some() => {
            return Err(SceneError::Request(format!(
                "there is no sampler \"{other}\"; known are independent and sobol"
            )));
        }
        other => {
            if let Some(object) = object {
                object.warn(format!(
                    "the sampler \"{other}\" is not supported; \"sobol\" is used instead"
                ))?;
            }
            sampler_kind::SOBOL
        }
    };
    Ok((kind, plugin, spp, seed))
}
