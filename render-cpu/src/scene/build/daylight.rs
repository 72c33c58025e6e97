//! `sky`, `sun` and `sunsky`: the light of a clear day as an image around the scene.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `turbidity` | haze, 1 to 10 | 3 |
//! | `albedo` | reflectance of the ground | 0.2 before version 2, then 0.3 |
//! | `sun_direction` | to the sun; else `latitude`, `longitude`, `timezone`, `year`, `month`, `day`, `hour`, `minute`, `second` | Tokyo, 2010-07-10, 15:00 |
//! | `scale`, `sky_scale`, `sun_scale` | factors | 1 |
//! | `sun_radius_scale`, or `sun_aperture` (degrees) | size of the disk; 0 makes the sun a directional light | 1, 0.5358 |
//! | `stretch` | above 1 the sky reaches below the horizon | 1 |
//! | `extend` | the sky continues below the horizon and darkens towards the nadir | false |
//! | `resolution` | width of the image | 512 |
//!
//! Up is +y before version 2 and +z from then on. The sun of every version is that of 0.6; Mitsuba 3 has another.

use super::builder::Builder;
use super::emitter::empty;
use super::emitter::light_scale;
use crate::image::{Bitmap, Texels};
use crate::scene::color::ColorUse;
use crate::scene::daylight::sun_position::LocationAndTime;
use crate::scene::daylight::{Daylight, sun};
use crate::scene::error::SceneError;
use crate::scene::transform;
use crate::scene::xml::Object;
use glam::{DMat4, DVec3};
use halflight_kernel::scene::{RgbParameter, emitter_kind};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

impl Builder {
    /// The light of `sky`, `sun` or `sunsky`.
    pub(super) fn add_daylight(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let has_sky = object.plugin != "sun";
        let has_sun = object.plugin != "sky";
        let scale = light_scale(object, "scale")?;
        let albedo = if object.is_legacy { 0.2 } else { 0.3 };
        let aperture = object.get_float_in("sun_aperture", 0.5358, 0.0, 90.0)?;
        let radius_scale = object.get_float_in("sun_radius_scale", 1.0, 0.0, 100.0)?;
        let up_is_z = !object.is_legacy;
        let mut to_world = object.get_transform("to_world")?;
        if up_is_z {
            to_world *= DMat4::from_rotation_x(FRAC_PI_2);
        }
        let day = Daylight {
            turbidity: object.get_float_in("turbidity", 3.0, 1.0, 10.0)?,
            albedo: object.get_rgb("albedo", ColorUse::Reflectance, [albedo; 3])?,
            to_sun: to_sun(object, &to_world, up_is_z)?,
            extend: object.get_bool("extend", false)?,
            stretch: object.get_float_in("stretch", 1.0, 1.0, 2.0)?,
            sky_scale: match has_sky {
                true => Some(scale * light_scale(object, "sky_scale")?),
                false => None,
            },
            sun_scale: match has_sun {
                true => Some(scale * light_scale(object, "sun_scale")?),
                false => None,
            },
            sun_radius: radius_scale * (0.5 * aperture).to_radians(),
        };
        if has_sun && day.to_sun.y <= 0.0 {
            object.warn("the sun is below the horizon and gives no light")?;
        }
        let is_directional = has_sun && day.sun_radius == 0.0;
        if is_directional {
            self.add_directional_sun(object, &day, to_world)?;
            if !has_sky {
                return Ok(());
            }
        }
        let width = object.get_int_in("resolution", 512, 8, 8192)? as u32;
        let height = (width / 2).max(4);
        let day = Daylight {
            sun_scale: day.sun_scale.filter(|_| !is_directional),
            ..day
        };
        let image = day
            .image(width, height)
            .map_err(|what| object.error(what))?;
        let bitmap = Bitmap {
            width,
            height,
            texels: Texels::Rgb32F(image),
            warnings: Vec::new(),
        };
        let texels = self.push_bitmap(object, &bitmap)?;
        self.add_environment_image(object, texels, 1.0, to_world)
    }

    /// The sun as a light of one direction.
    fn add_directional_sun(
        &mut self,
        object: &Object,
        day: &Daylight,
        to_world: DMat4,
    ) -> Result<(), SceneError> {
        if day.to_sun.y <= 0.0 {
            return Ok(());
        }
        let mut record = empty(emitter_kind::DIRECTIONAL);
        let solid_angle = TAU * (1.0 - sun::RADIUS.cos()) * day.sun_scale.unwrap_or(1.0);
        let radiance = sun::radiance(day.to_sun.y.clamp(-1.0, 1.0).acos(), day.turbidity);
        record.radiance = RgbParameter::constant(radiance.map(|v| (v * solid_angle) as f32));
        let along = to_world.transform_vector3(-day.shown_sun()).normalize();
        let (x, y) = along.any_orthonormal_pair();
        let frame = DMat4::from_cols(
            x.extend(0.0),
            y.extend(0.0),
            along.extend(0.0),
            glam::DVec4::W,
        );
        self.set_transform(object, &mut record, frame)?;
        self.tables.emitters.push(record);
        Ok(())
    }
}

/// Unit vector to the sun in the space of the image, +y up. A direction that is given is one of the world.
fn to_sun(object: &Object, to_world: &DMat4, up_is_z: bool) -> Result<DVec3, SceneError> {
    if let Some(direction) = object.opt_vector("sun_direction")? {
        let to_local = transform::inverse(to_world)
            .map_err(|e| object.property_error("to_world", e.to_string()))?;
        return to_local
            .transform_vector3(DVec3::from_array(direction))
            .try_normalize()
            .ok_or_else(|| object.property_error("sun_direction", "has no length"));
    }
    let default = LocationAndTime::default();
    let [year, month, day] = default.date;
    let [hour, minute, second] = default.time;
    let observer = LocationAndTime {
        latitude: object.get_float_in("latitude", default.latitude, -90.0, 90.0)?,
        longitude: object.get_float_in("longitude", default.longitude, -180.0, 180.0)?,
        timezone: object.get_float_in("timezone", default.timezone, -14.0, 14.0)?,
        date: [
            object.get_int_in("year", year, 1, 9999)?,
            object.get_int_in("month", month, 1, 12)?,
            object.get_int_in("day", day, 1, 31)?,
        ],
        time: [
            object.get_float_in("hour", hour, 0.0, 24.0)?,
            object.get_float_in("minute", minute, 0.0, 60.0)?,
            object.get_float_in("second", second, 0.0, 60.0)?,
        ],
    };
    let to_sun = observer.to_sun();
    // Mitsuba 3 has the south along +x and the west along +y, 0.6 the east along +x and the north along -z.
    Ok(match up_is_z {
        true => DVec3::new(to_sun.z, to_sun.y, to_sun.x),
        false => to_sun,
    })
}
