//! Materials: nested BSDF plugins flattened into weighted lobes.
//!
//! A wrapper does not become a record of its own: `blendbsdf` and `mask` multiply the weights of the lobes below them,
//! `twosided` sets on which side they exist, `coating` and `roughcoating` put coats above them, `normalmap` and
//! `bumpmap` give them a perturbed frame. The result is a flat list of lobes, which the kernel evaluates without recursion.

mod context;
mod diffraction;
mod glossy;
mod layered;
mod leaf;
mod parameters;
mod principled;
mod principled_thin;
mod scattering_layer;

use super::builder::{Builder, name_last};
use super::texture::MeshAttributes;
use super::value_range::ValueRange;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind, Value};
use context::{Coats, Context, PendingLobe, nested_bsdfs};
use halflight_kernel::scene::{
    FrameMap, LobeRecord, MAX_LOBES, Material, NONE, RgbParameter, ScalarParameter, WeightFactor,
    frame_map_kind, lobe_flag, lobe_kind,
};
use halflight_kernel::transport::wavefront::bsdf_variant;
use parameters::empty_lobe;
use std::sync::Arc;

/// Deeper nesting is a mistake or an attack.
const MAX_DEPTH: usize = 32;

impl Builder {
    /// The material of a shape: its BSDF, or Mitsuba's default for shapes without one.
    pub(super) fn material(
        &mut self,
        bsdf: Option<&Arc<Object>>,
        is_emitter: bool,
        mesh: Option<&MeshAttributes>,
    ) -> Result<u32, SceneError> {
        let Some(object) = bsdf else {
            let slot = usize::from(is_emitter);
            if let Some(index) = self.default_materials[slot] {
                return Ok(index);
            }
            let mut record = empty_lobe(lobe_kind::DIFFUSE);
            record.flags = lobe_flag::FRONT | lobe_flag::BACK;
            // Emitters without a BSDF are black.
            record.reflectance = RgbParameter::constant([if is_emitter { 0.0 } else { 0.5 }; 3]);
            let index = self.push_material(vec![PendingLobe {
                record,
                factors: Vec::new(),
            }]);
            self.default_materials[slot] = Some(index);
            return Ok(index);
        };
        // Whether it depends on the mesh: on its attributes, or on the length of its edges.
        let bound = mesh
            .is_some_and(|m| !m.vertex.is_empty() || !m.face.is_empty() || uses_wireframe(object));
        if !bound && let Some(&index) = self.materials.get(&object.index) {
            return Ok(index);
        }
        let mut lobes = Vec::new();
        self.flatten(
            object,
            Context {
                factors: Vec::new(),
                sides: lobe_flag::FRONT | lobe_flag::BACK,
                frame: NONE,
                coats: Coats::default(),
                mesh,
                depth: 0,
            },
            &mut lobes,
        )?;
        if lobes.len() > MAX_LOBES {
            return Err(object.error(format!(
                "the material has {} lobes after its nested BSDFs are flattened; at most {MAX_LOBES} are supported",
                lobes.len()
            )));
        }
        let index = self.push_material(lobes);
        let name = object.id.as_deref().unwrap_or_default();
        name_last(&mut self.names.materials, self.tables.materials.len(), name);
        if !bound {
            self.materials.insert(object.index, index);
        }
        Ok(index)
    }

    /// A material of null scattering only: an invisible surface.
    pub(super) fn null_material(&mut self) -> u32 {
        if let Some(index) = self.default_materials[2] {
            return index;
        }
        let mut record = empty_lobe(lobe_kind::NULL);
        record.flags = lobe_flag::FRONT | lobe_flag::BACK;
        let index = self.push_material(vec![PendingLobe {
            record,
            factors: Vec::new(),
        }]);
        self.default_materials[2] = Some(index);
        index
    }

    fn push_material(&mut self, lobes: Vec<PendingLobe>) -> u32 {
        let first_lobe = self.tables.lobes.len() as u32;
        let lobe_count = lobes.len() as u32;
        for PendingLobe {
            mut record,
            factors,
        } in lobes
        {
            record.first_factor = self.tables.factors.len() as u32;
            record.factor_count = factors.len() as u32;
            self.tables.factors.extend(factors);
            self.tables.lobes.push(record);
        }
        let lobes = &self.tables.lobes[first_lobe as usize..];
        let flags = Material::flags_of(lobes) | bsdf_variant::material_flags(lobes);
        self.tables.materials.push(Material {
            first_lobe,
            lobe_count,
            flags,
        });
        self.tables.materials.len() as u32 - 1
    }

    fn flatten(
        &mut self,
        object: &Arc<Object>,
        context: Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) -> Result<(), SceneError> {
        object.touch();
        if context.depth > MAX_DEPTH {
            return Err(object.error(format!("BSDFs are nested more than {MAX_DEPTH} deep")));
        }
        let mut inner = context.clone();
        inner.depth += 1;
        match object.plugin.as_str() {
            "twosided" => {
                let nested = nested_bsdfs(object, 1, 2)?;
                let before = lobes.len();
                if nested.len() == 1 {
                    inner.sides = lobe_flag::FRONT | lobe_flag::BACK | lobe_flag::FLIP_BACK;
                    self.flatten(&nested[0], inner, lobes)?;
                } else {
                    let mut back = inner.clone();
                    inner.sides = lobe_flag::FRONT;
                    back.sides = lobe_flag::BACK | lobe_flag::FLIP_BACK;
                    self.flatten(&nested[0], inner, lobes)?;
                    self.flatten(&nested[1], back, lobes)?;
                }
                let transmits = lobes[before..]
                    .iter()
                    .any(|lobe| lobe.record.kind != lobe_kind::NULL && lobe.transmits());
                if transmits {
                    return Err(object.error("a BSDF that transmits light cannot be two-sided"));
                }
            }
            "mask" => {
                let nested = nested_bsdfs(object, 1, 1)?;
                let opacity = self.scalar_parameter(object, "opacity", 0.5, context.mesh)?;
                inner.factors.push(WeightFactor {
                    parameter: opacity,
                    complement: 0,
                });
                self.flatten(&nested[0], inner, lobes)?;
                let mut null = context;
                null.factors.push(WeightFactor {
                    parameter: opacity,
                    complement: 1,
                });
                // Light passes on both sides whatever surrounds the mask.
                null.sides = lobe_flag::FRONT | lobe_flag::BACK;
                self.push_lobe(object, empty_lobe(lobe_kind::NULL), null, lobes)?;
            }
            "blendbsdf" => {
                let nested = nested_bsdfs(object, 2, 2)?;
                let weight = self.scalar_parameter(object, "weight", 0.5, context.mesh)?;
                let mut second = inner.clone();
                inner.factors.push(WeightFactor {
                    parameter: weight,
                    complement: 1,
                });
                second.factors.push(WeightFactor {
                    parameter: weight,
                    complement: 0,
                });
                self.flatten(&nested[0], inner, lobes)?;
                self.flatten(&nested[1], second, lobes)?;
            }
            "mixturebsdf" => {
                let nested = nested_bsdfs(object, 1, usize::MAX)?;
                for (child, weight) in nested.iter().zip(mixture_weights(object, nested.len())?) {
                    let mut part = inner.clone();
                    part.factors.push(WeightFactor {
                        parameter: ScalarParameter::constant(weight),
                        complement: 0,
                    });
                    self.flatten(child, part, lobes)?;
                }
            }
            "phong" | "ward" => self.glossy(object, &context, lobes)?,
            "principled" => {
                pass_over_sampling_rates(object);
                self.principled(object, &context, lobes)?;
            }
            "principledthin" => {
                pass_over_sampling_rates(object);
                self.principled_thin(object, &context, lobes)?;
            }
            "coating" | "roughcoating" => self.coating(object, &context, inner, lobes)?,
            "normalmap" | "bumpmap" => {
                let nested = nested_bsdfs(object, 1, 1)?;
                let is_normal = object.plugin == "normalmap";
                let texture = match object.texture("normalmap") {
                    Some(texture) if is_normal => texture.clone(),
                    _ => object
                        .single_child_of(ObjectKind::Texture)?
                        .cloned()
                        .ok_or_else(|| object.error("needs a nested texture"))?,
                };
                let (texture, factor) = match is_normal {
                    true => (texture, 1.0),
                    false => without_scales(texture)?,
                };
                let scale = factor * object.get_float("scale", 1.0)?;
                let map = FrameMap {
                    kind: if is_normal {
                        frame_map_kind::NORMAL
                    } else {
                        frame_map_kind::BUMP
                    },
                    texture: self.texture(&texture, ValueRange::UnitInterval, context.mesh)?,
                    scale: scale as f32,
                    parent: context.frame,
                };
                inner.frame = self.tables.frame_maps.len() as u32;
                self.tables.frame_maps.push(map);
                self.flatten(&nested[0], inner, lobes)?;
            }
            _ => {
                let record = self.leaf(object, context.mesh)?;
                self.push_lobe(object, record, context, lobes)?;
            }
        }
        Ok(())
    }

    fn push_lobe(
        &self,
        object: &Object,
        mut record: LobeRecord,
        context: Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) -> Result<(), SceneError> {
        record.flags |= context.sides;
        record.frame = context.frame;
        context.coats.apply(object, &mut record)?;
        lobes.push(PendingLobe {
            record,
            factors: context.factors,
        });
        Ok(())
    }
}

/// Mitsuba 3 is told how often to choose each part of its model, which changes the noise alone.
fn pass_over_sampling_rates(object: &Object) {
    let properties = object.properties.iter();
    let rates = properties.filter(|property| property.name.ends_with("_sampling_rate"));
    rates.for_each(|property| property.mark());
}

/// Whether a `wireframe` texture is somewhere below an object.
fn uses_wireframe(object: &Object) -> bool {
    let mut pending: Vec<&Object> = vec![object];
    let mut seen = std::collections::HashSet::new();
    while let Some(object) = pending.pop() {
        if object.kind == ObjectKind::Texture && object.plugin == "wireframe" {
            return true;
        }
        if seen.insert(object.index) {
            pending.extend(object.properties.iter().filter_map(|p| match &p.value {
                Value::Object(child) => Some(child.as_ref()),
                _ => None,
            }));
        }
    }
    false
}

/// The weights of a `mixturebsdf`, one for each of its `count` parts, scaled down when they sum to more than one.
fn mixture_weights(object: &Object, count: usize) -> Result<Vec<f32>, SceneError> {
    let text = object.require_string("weights")?;
    let mut weights = Vec::new();
    for word in text
        .split([',', ' ', '\t', '\n', '\r', ';'])
        .filter(|w| !w.is_empty())
    {
        match word.parse::<f32>() {
            Ok(weight) if weight.is_finite() && weight >= 0.0 => weights.push(weight),
            _ => {
                return Err(object.property_error(
                    "weights",
                    format!("\"{word}\" is not a number of at least 0"),
                ));
            }
        }
    }
    if weights.len() != count {
        return Err(object.property_error(
            "weights",
            format!("{} weights for {count} nested BSDFs", weights.len()),
        ));
    }
    let sum: f32 = weights.iter().sum();
    if sum > 1.0 + 1e-5 {
        object.warn(format!(
            "the weights sum to {sum}, which creates energy; they are divided by that"
        ))?;
        weights.iter_mut().for_each(|weight| *weight /= sum);
    }
    Ok(weights)
}

/// A texture of heights, and the number that textures around it multiply it by. It may be negative, which textures of colours are not.
fn without_scales(mut texture: Arc<Object>) -> Result<(Arc<Object>, f64), SceneError> {
    let mut factor = 1.0;
    while texture.plugin == "scale"
        && texture
            .get("scale")
            .is_some_and(|scale| matches!(scale.value, Value::Float(_) | Value::Int(_)))
        && let Some(nested) = texture.single_child_of(ObjectKind::Texture)?.cloned()
    {
        factor *= texture.get_float("scale", 1.0)?;
        texture = nested;
    }
    Ok((texture, factor))
}
