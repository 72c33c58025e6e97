//! Textures and the parameters that take them.

use super::bitmap::{filter, wrap};
use super::builder::Builder;
use super::reading::Reading;
use super::value_range::ValueRange;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::{ColorSource, FloatSource, Object, ObjectKind};
use glam::DMat4;
use halflight_kernel::scene::{NONE, RgbParameter, ScalarParameter, Texture, texture_kind};
use std::sync::Arc;

/// The attributes of the mesh that a material is built for.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshAttributes {
    /// Name, first word in `data`, channels.
    pub vertex: Vec<(String, u32, u32)>,
    /// Name, first word in `data`, channels.
    pub face: Vec<(String, u32, u32)>,
    pub first_vertex: u32,
    pub first_triangle: u32,
    /// Mean length of the edges of its triangles.
    pub mean_edge: f32,
}

const IDENTITY_UV: [f32; 6] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

impl Builder {
    /// A colour property that may be a texture.
    pub(super) fn rgb_parameter(
        &mut self,
        object: &Object,
        name: &str,
        usage: ColorUse,
        default: [f32; 3],
        mesh: Option<&MeshAttributes>,
    ) -> Result<RgbParameter, SceneError> {
        match object.get_rgb_or_texture(name, usage, default)? {
            ColorSource::Constant(value) => {
                let mut value = value;
                if usage == ColorUse::Reflectance {
                    if value.iter().any(|&v| v > 1.0) && name != "eta" && name != "k" {
                        object.warn(format!(
                            "\"{name}\" is above 1, which creates energy; it is clamped to 1"
                        ))?;
                        value = value.map(|v| v.min(1.0));
                    }
                    if value.iter().any(|&v| v < 0.0) {
                        object.warn(format!("\"{name}\" is negative; it is clamped to 0"))?;
                        value = value.map(|v| v.max(0.0));
                    }
                }
                Ok(RgbParameter::constant(value))
            }
            ColorSource::Texture(texture) => {
                let range = match usage {
                    ColorUse::Reflectance => ValueRange::UnitInterval,
                    ColorUse::Emission | ColorUse::Unbounded => ValueRange::Unbounded,
                };
                let index = self.texture(&texture, range, mesh)?;
                self.check_range(&texture, index, range)?;
                Ok(RgbParameter::textured(index))
            }
        }
    }

    /// A number property that may be a texture.
    pub(super) fn scalar_parameter(
        &mut self,
        object: &Object,
        name: &str,
        default: f64,
        mesh: Option<&MeshAttributes>,
    ) -> Result<ScalarParameter, SceneError> {
        match object.get_float_or_texture(name, default)? {
            FloatSource::Constant(value) => Ok(ScalarParameter::constant(value as f32)),
            FloatSource::Texture(texture) => Ok(ScalarParameter {
                value: 1.0,
                texture: self.texture(&texture, ValueRange::UnitInterval, mesh)?,
            }),
        }
    }

    /// The index of a texture, built at its first use. Mesh attributes are looked up anew for every mesh.
    pub(super) fn texture(
        &mut self,
        object: &Arc<Object>,
        range: ValueRange,
        mesh: Option<&MeshAttributes>,
    ) -> Result<u32, SceneError> {
        let key = (object.index, range);
        if let Some(&index) = self.textures.get(&key) {
            return Ok(index);
        }
        let (texture, shared) = self.build_texture(object, range, mesh)?;
        let index = self.tables.textures.len() as u32;
        self.tables.textures.push(texture);
        if shared {
            self.textures.insert(key, index);
        }
        Ok(index)
    }

    /// The record, and whether other meshes may share it.
    fn build_texture(
        &mut self,
        object: &Arc<Object>,
        range: ValueRange,
        mesh: Option<&MeshAttributes>,
    ) -> Result<(Texture, bool), SceneError> {
        let mut texture = Texture {
            kind: texture_kind::CHECKERBOARD,
            data: [0; 6],
            to_uv: uv_transform(object)?,
            color0: RgbParameter::constant([0.4; 3]),
            color1: RgbParameter::constant([0.2; 3]),
        };
        let mut shared = true;
        let usage = range.color_use();
        match object.plugin.as_str() {
            "bitmap" => {
                let path = object.require_file("filename")?;
                let reading = Reading::of(object)?;
                let [first, width, height, format] = self.bitmap(object, &path, reading)?;
                texture.kind = texture_kind::BITMAP;
                texture.data = [first, width, height, format, filter(object)?, wrap(object)?];
                texture.color0 = RgbParameter::constant([1.0; 3]);
            }
            "checkerboard" => {
                texture.color0 = self.rgb_parameter(object, "color0", usage, [0.4; 3], mesh)?;
                texture.color1 = self.rgb_parameter(object, "color1", usage, [0.2; 3], mesh)?;
            }
            "gridtexture" => {
                texture.kind = texture_kind::GRID;
                let width = object.get_float_in("line_width", 0.01, 0.0, 0.5)? as f32;
                texture.data[0] = width.to_bits();
                texture.color0 = RgbParameter::constant(object.get_rgb("color0", usage, [0.2; 3])?);
                texture.color1 = RgbParameter::constant(object.get_rgb("color1", usage, [0.4; 3])?);
            }
            "wireframe" => {
                texture.kind = texture_kind::WIREFRAME;
                texture.to_uv = IDENTITY_UV;
                texture.color0 =
                    RgbParameter::constant(object.get_rgb("interior_color", usage, [0.5; 3])?);
                texture.color1 =
                    RgbParameter::constant(object.get_rgb("edge_color", usage, [0.1; 3])?);
                let width = match object.opt_float("line_width")? {
                    Some(width) if width > 0.0 => width as f32,
                    _ => {
                        // A tenth of the mean edge, of each mesh.
                        shared = false;
                        0.1 * mesh.map_or(1.0, |mesh| mesh.mean_edge)
                    }
                };
                let step = object.get_float_in("step_width", 0.5, 0.0, 1.0)? as f32;
                texture.data[0] = (width * (1.0 - step)).to_bits();
                texture.data[1] = width.to_bits();
            }
            "mesh_attribute" | "vertexcolors" => {
                // The texture of 0.6 has the colours of the vertices only.
                let name = match object.plugin.as_str() {
                    "vertexcolors" => "vertex_color",
                    _ => object.require_string("name")?,
                };
                let scale = object.get_float("scale", 1.0)? as f32;
                texture.color0 = RgbParameter::constant([1.0; 3]);
                texture.to_uv = IDENTITY_UV;
                shared = false;
                let found = mesh.and_then(|mesh| {
                    let find = |list: &[(String, u32, u32)]| {
                        list.iter().find(|entry| entry.0 == name).cloned()
                    };
                    find(&mesh.vertex)
                        .map(|(_, word, channels)| {
                            (
                                texture_kind::VERTEX_ATTRIBUTE,
                                word,
                                channels,
                                mesh.first_vertex,
                            )
                        })
                        .or_else(|| {
                            find(&mesh.face).map(|(_, word, channels)| {
                                (
                                    texture_kind::FACE_ATTRIBUTE,
                                    word,
                                    channels,
                                    mesh.first_triangle,
                                )
                            })
                        })
                });
                match found {
                    Some((kind, word, channels, first)) => {
                        texture.kind = kind;
                        texture.data = [word, channels, first, 0, 0, 0];
                        if scale != 1.0 {
                            let attribute = self.tables.textures.len() as u32;
                            self.tables.textures.push(texture);
                            texture.kind = texture_kind::SCALE;
                            texture.data = [0; 6];
                            texture.color0 = RgbParameter {
                                value: [scale; 3],
                                texture: attribute,
                            };
                        }
                    }
                    None => {
                        object.warn(format!(
                            "the shape has no attribute \"{name}\"; zero is used instead"
                        ))?;
                        return Ok((constant_texture([0.0; 3]), false));
                    }
                }
            }
            "scale" => {
                let factor =
                    self.rgb_parameter(object, "scale", ColorUse::Emission, [1.0; 3], mesh)?;
                let nested = object
                    .single_child_of(ObjectKind::Texture)?
                    .ok_or_else(|| object.error("\"scale\" needs a nested texture"))?;
                texture.kind = texture_kind::SCALE;
                texture.to_uv = IDENTITY_UV;
                texture.color0 = RgbParameter {
                    value: factor.value,
                    texture: self.texture(nested, range, mesh)?,
                };
            }
            other => {
                object.warn(format!(
                    "textures of type \"{other}\" are not supported; a reflectance of 0.5 is used instead"
                ))?;
                object.ignore();
                texture = constant_texture([0.5; 3]);
            }
        }
        Ok((texture, shared))
    }
}

/// A texture of one colour: both fields of a checkerboard.
fn constant_texture(value: [f32; 3]) -> Texture {
    Texture {
        kind: texture_kind::CHECKERBOARD,
        data: [0; 6],
        to_uv: IDENTITY_UV,
        color0: RgbParameter::constant(value),
        color1: RgbParameter::constant(value),
    }
}

/// The affine map of texture coordinates: `to_uv`, or the scales and offsets of Mitsuba 0.6.
fn uv_transform(object: &Object) -> Result<[f32; 6], SceneError> {
    let m: DMat4 = object.get_transform("to_uv")?;
    let column = |c: usize| m.col(c);
    let mut to_uv = [
        column(0).x,
        column(1).x,
        column(3).x,
        column(0).y,
        column(1).y,
        column(3).y,
    ];
    let both = object.get_float("uvscale", 1.0)?;
    let scale = [
        object.get_float("uscale", both)?,
        object.get_float("vscale", both)?,
    ];
    let offset = [
        object.get_float("uoffset", 0.0)?,
        object.get_float("voffset", 0.0)?,
    ];
    for row in 0..2 {
        for i in 0..3 {
            to_uv[3 * row + i] *= scale[row];
        }
        to_uv[3 * row + 2] += offset[row];
    }
    Ok(to_uv.map(|x| x as f32))
}

/// A parameter without a texture; used where the kernel takes only constants.
pub(super) fn expect_constant(
    object: &Object,
    name: &str,
    parameter: RgbParameter,
) -> Result<[f32; 3], SceneError> {
    if parameter.texture == NONE {
        Ok(parameter.value)
    } else {
        Err(object.property_error(name, "cannot be a texture here"))
    }
}
