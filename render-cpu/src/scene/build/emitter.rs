//! Emitter plugins to records, with their sampling tables.

use super::builder::{Builder, name_last};
use super::reading::Reading;
use super::sensor::field_of_view;
use super::texture::{MeshAttributes, expect_constant};
use super::value_range::ValueRange;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::transform;
use crate::scene::xml::{Object, ObjectKind};
use glam::{DMat4, DVec3};
use halflight_kernel::scene::emitter;
use halflight_kernel::scene::{
    Emitter, NONE, RgbParameter, Texture, emitter_kind, filter_mode, texel_format, texture_kind,
    wrap_mode,
};
use std::sync::Arc;

/// Rows of the identity.
const IDENTITY: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

impl Builder {
    /// Emitters that are not part of a shape.
    pub(super) fn add_emitters(&mut self, root: &Object) -> Result<(), SceneError> {
        for child in root.children_of(ObjectKind::Emitter) {
            let object = child.object;
            object.touch();
            let weight = object.get_float("sampling_weight", 1.0)?;
            let is_found_by_sampling_alone = matches!(
                object.plugin.as_str(),
                "point" | "spot" | "projector" | "directional" | "collimated"
            );
            // Other weights change the noise, and light that rays can hit is found all the same.
            if weight == 0.0 && is_found_by_sampling_alone {
                object.ignore();
                continue;
            }
            match object.plugin.as_str() {
                "point" => self.add_point(object)?,
                "spot" => self.add_spot(object)?,
                "projector" => self.add_projector(object)?,
                "directional" => self.add_directional(object)?,
                "collimated" => self.add_collimated(object)?,
                "constant" => self.add_constant(object)?,
                "envmap" => self.add_environment(object)?,
                "sky" | "sun" | "sunsky" => self.add_daylight(object)?,
                // A definition for shapes to refer to.
                "area" if object.id.is_some() => {}
                "area" => object.warn("an area emitter needs a shape around it; it is left out")?,
                other => object.warn(format!(
                    "emitters of type \"{other}\" are not supported; it is left out"
                ))?,
            }
            if self.names.emitters.len() < self.tables.emitters.len() {
                let name = object.id.as_deref().unwrap_or(&object.plugin);
                name_last(&mut self.names.emitters, self.tables.emitters.len(), name);
            }
        }
        Ok(())
    }

    /// The emission of the shape `shape`, which is in the table already.
    pub(super) fn add_area_emitter(
        &mut self,
        object: &Arc<Object>,
        shape: u32,
        mesh: Option<&MeshAttributes>,
    ) -> Result<(), SceneError> {
        object.touch();
        object.get("sampling_weight");
        let mut record = empty(emitter_kind::AREA);
        record.radiance =
            self.rgb_parameter(object, "radiance", ColorUse::Emission, [1.0; 3], mesh)?;
        record.shape = shape;
        let count = self.tables.shapes[shape as usize].primitive_count as usize;
        let mut areas = vec![0.0; count];
        record.distribution = self.tables.data.len() as u32;
        record.area = emitter::fill_shape_areas(&self.tables.view(), shape, &mut areas);
        if !(record.area > 0.0) {
            object.warn("the emitting shape has no area; it gives no light")?;
        }
        self.tables.data.extend_from_slice(&areas);
        self.tables.emitters.push(record);
        let of_shape = self.names.shapes.get(shape as usize).cloned();
        let name = object.id.clone().or(of_shape).unwrap_or_default();
        name_last(&mut self.names.emitters, self.tables.emitters.len(), &name);
        Ok(())
    }

    fn add_point(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::POINT);
        let intensity =
            self.rgb_parameter(object, "intensity", ColorUse::Emission, [1.0; 3], None)?;
        record.radiance = RgbParameter::constant(expect_constant(object, "intensity", intensity)?);
        let to_world = match object.opt_vector("position")? {
            Some(position) => DMat4::from_translation(DVec3::from_array(position)),
            None => object.get_transform("to_world")?,
        };
        self.set_transform(object, &mut record, to_world)?;
        self.tables.emitters.push(record);
        Ok(())
    }

    fn add_spot(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::SPOT);
        record.radiance =
            self.rgb_parameter(object, "intensity", ColorUse::Emission, [1.0; 3], None)?;
        let cutoff = object.get_float_in("cutoff_angle", 20.0, 1e-3, 180.0)?;
        let beam = object.get_float_in("beam_width", cutoff * 0.75, 0.0, cutoff)?;
        if let Some(texture) = object.texture("texture").cloned() {
            record.radiance.texture = self.texture(&texture, ValueRange::Unbounded, None)?;
        }
        record.parameters = [
            beam.to_radians() as f32,
            cutoff.to_radians() as f32,
            0.0,
            0.0,
        ];
        let to_world = object.get_transform("to_world")?;
        self.set_transform(object, &mut record, to_world)?;
        self.tables.emitters.push(record);
        Ok(())
    }

    fn add_projector(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::PROJECTOR);
        record.radiance =
            self.rgb_parameter(object, "irradiance", ColorUse::Emission, [1.0; 3], None)?;
        let scale = light_scale(object, "scale")? as f32;
        record.radiance.value = record.radiance.value.map(|v| v * scale);
        let [width, height] = match record.radiance.texture {
            NONE => [1, 1],
            index => {
                let texture = &self.tables.textures[index as usize];
                if texture.kind == texture_kind::BITMAP {
                    [texture.data[1], texture.data[2]]
                } else {
                    [1, 1]
                }
            }
        };
        let (x, y) = field_of_view(object, width, height)?;
        record.parameters = [x, y, 0.0, 0.0];
        let to_world = object.get_transform("to_world")?;
        self.set_transform(object, &mut record, to_world)?;
        self.tables.emitters.push(record);
        Ok(())
    }

    fn add_directional(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::DIRECTIONAL);
        let irradiance =
            self.rgb_parameter(object, "irradiance", ColorUse::Emission, [1.0; 3], None)?;
        record.radiance =
            RgbParameter::constant(expect_constant(object, "irradiance", irradiance)?);
        let to_world = match object.opt_vector("direction")? {
            Some(direction) => {
                let z = DVec3::from_array(direction)
                    .try_normalize()
                    .ok_or_else(|| object.property_error("direction", "has no length"))?;
                let (x, y) = z.any_orthonormal_pair();
                DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), glam::DVec4::W)
            }
            None => object.get_transform("to_world")?,
        };
        self.set_transform(object, &mut record, to_world)?;
        self.tables.emitters.push(record);
        Ok(())
    }

    fn add_collimated(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::COLLIMATED);
        let power = self.rgb_parameter(object, "power", ColorUse::Emission, [1.0; 3], None)?;
        record.radiance = RgbParameter::constant(expect_constant(object, "power", power)?);
        let to_world = object.get_transform("to_world")?;
        self.set_transform(object, &mut record, to_world)?;
        self.tables.emitters.push(record);
        Ok(())
    }

    fn add_constant(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::CONSTANT);
        let radiance =
            self.rgb_parameter(object, "radiance", ColorUse::Emission, [1.0; 3], None)?;
        record.radiance = RgbParameter::constant(expect_constant(object, "radiance", radiance)?);
        self.set_environment(object, record)
    }

    fn add_environment(&mut self, object: &Arc<Object>) -> Result<(), SceneError> {
        let scale = light_scale(object, "scale")? as f32;
        // Which directions are sampled how often; the image has the same mean.
        object.get("mis_compensation");
        let path = object.require_file("filename")?;
        // What it asks for of 0.6 is understood as by a bitmap.
        let bitmap = self.bitmap(object, &path, Reading::of(object)?)?;
        self.say_if_negative(object, bitmap)?;
        let to_world = object.get_transform("to_world")?;
        self.add_environment_image(object, bitmap, scale, to_world)
    }

    /// Light from infinity by an image: first word, width, height and format of its texels.
    pub(super) fn add_environment_image(
        &mut self,
        object: &Object,
        [first, width, height, format]: [u32; 4],
        scale: f32,
        to_world: DMat4,
    ) -> Result<(), SceneError> {
        let mut record = empty(emitter_kind::ENVIRONMENT);
        record.radiance = RgbParameter {
            value: [scale; 3],
            texture: self.tables.textures.len() as u32,
        };
        self.tables.textures.push(Texture {
            kind: texture_kind::BITMAP,
            data: [
                first,
                width,
                height,
                format,
                filter_mode::BILINEAR,
                wrap_mode::REPEAT,
            ],
            to_uv: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            color0: RgbParameter::constant([1.0; 3]),
            color1: RgbParameter::constant([1.0; 3]),
        });
        debug_assert!(format <= texel_format::RGB32F);
        record.distribution = self.tables.data.len() as u32;
        let (table_width, table_height) = emitter::environment_table_size(width, height);
        record.width = table_width;
        record.height = table_height;
        self.set_transform(object, &mut record, to_world)?;
        let words = emitter::environment_table_words(table_width, table_height);
        let mut table = vec![0.0; words as usize];
        emitter::fill_environment_distribution(&self.tables.view(), &record, &mut table);
        self.tables.data.extend_from_slice(&table);
        self.set_environment(object, record)
    }

    fn set_environment(&mut self, object: &Object, record: Emitter) -> Result<(), SceneError> {
        if self.tables.info.environment != NONE {
            return Err(object.error("the scene has more than one environment"));
        }
        self.tables.info.environment = self.tables.emitters.len() as u32;
        self.tables.emitters.push(record);
        Ok(())
    }

    /// Sets the transforms of a record.
    pub(super) fn set_transform(
        &self,
        object: &Object,
        record: &mut Emitter,
        to_world: DMat4,
    ) -> Result<(), SceneError> {
        (record.to_world, record.to_local) = transform::rows_and_inverse(&to_world)
            .map_err(|e| object.property_error("to_world", e.to_string()))?;
        Ok(())
    }
}

/// An emitter with neutral parameters.
pub(super) fn empty(kind: u32) -> Emitter {
    Emitter {
        kind,
        radiance: RgbParameter::constant([1.0; 3]),
        to_world: IDENTITY,
        to_local: IDENTITY,
        parameters: [0.0; 4],
        shape: NONE,
        area: 0.0,
        distribution: NONE,
        width: 0,
        height: 0,
        selection_pdf: 0.0,
        selection_cdf: 0.0,
    }
}

/// A factor on a light. There is no negative light.
pub(super) fn light_scale(object: &Object, name: &str) -> Result<f64, SceneError> {
    let scale = object.get_float(name, 1.0)?;
    if scale < 0.0 {
        object.property_warn(name, "light cannot be negative; 0 is used")?;
    }
    Ok(scale.max(0.0))
}
