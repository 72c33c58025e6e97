//! Materials: nested BSDF plugins flattened into weighted lobes.
//!
//! A wrapper does not become a record of its own: `blendbsdf` and `mask` multiply the weights of the lobes below them,
//! `twosided` sets on which side they exist, `normalmap` and `bumpmap` give them a perturbed frame. What is left is a
//! list of lobes, which the kernel walks without recursion.

use super::Builder;
use super::texture::MeshAttributes;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::ior;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::bsdf::MAX_LOBES;
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_plastic::{
    TRANSMITTANCE_ENTRIES, fill_rough_transmittance, rough_internal_reflectance,
};
use halflight_kernel::scene::{
    FrameMap, LobeRecord, Material, NONE, RgbParameter, ScalarParameter, WeightFactor,
    distribution, frame_map_kind, lobe_flag, lobe_kind, material_flag,
};
use std::sync::Arc;

/// What the wrappers around a BSDF have decided.
#[derive(Clone)]
struct Context<'a> {
    factors: Vec<WeightFactor>,
    sides: u32,
    frame: u32,
    mesh: Option<&'a MeshAttributes>,
    depth: usize,
}

/// A lobe before its factors have a place in the table.
struct PendingLobe {
    record: LobeRecord,
    factors: Vec<WeightFactor>,
}

/// What dielectrics are made of when nothing is said.
const BK7: &str = "bk7";
/// What plastics are made of when nothing is said.
const POLYPROPYLENE: &str = "polypropylene";

/// Deeper nesting is a mistake or an attack.
const MAX_DEPTH: usize = 32;

/// Roughness below which a microfacet model counts as the smooth one.
const MIN_ALPHA: f64 = 1e-4;

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
            // Emitters that say nothing of their surface reflect nothing.
            record.reflectance = RgbParameter::constant([if is_emitter { 0.0 } else { 0.5 }; 3]);
            let index = self.push_material(vec![PendingLobe {
                record,
                factors: Vec::new(),
            }]);
            self.default_materials[slot] = Some(index);
            return Ok(index);
        };
        let bound = mesh.is_some_and(|m| !m.vertex.is_empty() || !m.face.is_empty());
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
        if !bound {
            self.materials.insert(object.index, index);
        }
        Ok(index)
    }

    fn push_material(&mut self, lobes: Vec<PendingLobe>) -> u32 {
        let first_lobe = self.tables.lobes.len() as u32;
        let lobe_count = lobes.len() as u32;
        let mut flags = 0;
        for PendingLobe {
            mut record,
            factors,
        } in lobes
        {
            if record.kind == lobe_kind::NULL {
                flags |= material_flag::HAS_NULL;
            }
            record.first_factor = self.tables.factors.len() as u32;
            record.factor_count = factors.len() as u32;
            self.tables.factors.extend(factors);
            self.tables.lobes.push(record);
        }
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
                let transmits = lobes[before..].iter().any(|lobe| {
                    matches!(
                        lobe.record.kind,
                        lobe_kind::DIELECTRIC
                            | lobe_kind::THIN_DIELECTRIC
                            | lobe_kind::ROUGH_DIELECTRIC
                    )
                });
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
                self.push_lobe(empty_lobe(lobe_kind::NULL), null, lobes);
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
                let map = FrameMap {
                    kind: if is_normal {
                        frame_map_kind::NORMAL
                    } else {
                        frame_map_kind::BUMP
                    },
                    texture: self.texture(&texture, context.mesh)?,
                    scale: object.get_float("scale", 1.0)? as f32,
                    parent: context.frame,
                };
                inner.frame = self.tables.frame_maps.len() as u32;
                self.tables.frame_maps.push(map);
                self.flatten(&nested[0], inner, lobes)?;
            }
            _ => {
                let record = self.leaf(object, context.mesh)?;
                self.push_lobe(record, context, lobes);
            }
        }
        Ok(())
    }

    fn push_lobe(
        &self,
        mut record: LobeRecord,
        context: Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) {
        record.flags |= context.sides;
        record.frame = context.frame;
        lobes.push(PendingLobe {
            record,
            factors: context.factors,
        });
    }

    /// A plugin that scatters by itself.
    fn leaf(
        &mut self,
        object: &Arc<Object>,
        mesh: Option<&MeshAttributes>,
    ) -> Result<LobeRecord, SceneError> {
        let mut lobe = empty_lobe(lobe_kind::DIFFUSE);
        let color = |builder: &mut Builder, name: &str, default: f32| {
            builder.rgb_parameter(object, name, ColorUse::Reflectance, [default; 3], mesh)
        };
        match object.plugin.as_str() {
            "diffuse" => {
                let name = if object.has("diffuse_reflectance") {
                    "diffuse_reflectance"
                } else {
                    "reflectance"
                };
                lobe.reflectance = color(self, name, 0.5)?;
            }
            "conductor" | "roughconductor" => {
                lobe.kind = lobe_kind::CONDUCTOR;
                lobe.specular_reflectance = color(self, "specular_reflectance", 1.0)?;
                self.conductor_index(object, mesh, &mut lobe)?;
                if object.plugin == "roughconductor" {
                    lobe.kind = lobe_kind::ROUGH_CONDUCTOR;
                    self.roughness(object, mesh, &mut lobe)?;
                }
            }
            "dielectric" | "thindielectric" | "roughdielectric" => {
                lobe.specular_reflectance = color(self, "specular_reflectance", 1.0)?;
                lobe.specular_transmittance = color(self, "specular_transmittance", 1.0)?;
                let eta = relative_index(object, BK7)?;
                lobe.eta = RgbParameter::constant([eta; 3]);
                lobe.kind = match object.plugin.as_str() {
                    "dielectric" => lobe_kind::DIELECTRIC,
                    "thindielectric" => lobe_kind::THIN_DIELECTRIC,
                    _ => {
                        self.roughness(object, mesh, &mut lobe)?;
                        lobe_kind::ROUGH_DIELECTRIC
                    }
                };
            }
            "plastic" | "roughplastic" => {
                lobe.kind = lobe_kind::PLASTIC;
                lobe.reflectance = color(self, "diffuse_reflectance", 0.5)?;
                lobe.specular_reflectance = color(self, "specular_reflectance", 1.0)?;
                let eta = relative_index(object, POLYPROPYLENE)?;
                lobe.eta = RgbParameter::constant([eta; 3]);
                lobe.internal_reflectance = fresnel_diffuse_reflectance(1.0 / eta);
                if object.get_bool("nonlinear", false)? {
                    lobe.flags |= lobe_flag::NONLINEAR;
                }
                if object.plugin == "roughplastic" {
                    lobe.kind = lobe_kind::ROUGH_PLASTIC;
                    self.roughness(object, mesh, &mut lobe)?;
                    if lobe.alpha_u.texture != NONE {
                        return Err(
                            object.property_error("alpha", "cannot be a texture in roughplastic")
                        );
                    }
                    lobe.table = self.tables.data.len() as u32;
                    let mut table = [0.0; TRANSMITTANCE_ENTRIES];
                    fill_rough_transmittance(
                        lobe.distribution,
                        lobe.alpha_u.value,
                        eta,
                        &mut table,
                    );
                    self.tables.data.extend_from_slice(&table);
                    lobe.internal_reflectance =
                        rough_internal_reflectance(lobe.distribution, lobe.alpha_u.value, eta);
                }
            }
            "null" => lobe.kind = lobe_kind::NULL,
            other => {
                object.warn(format!(
                    "BSDFs of type \"{other}\" are not supported; a diffuse reflectance of 0.5 is used instead"
                ))?;
                lobe.reflectance = RgbParameter::constant([0.5; 3]);
            }
        }
        Ok(lobe)
    }

    /// `material`, or `eta` and `k`, which may be textures.
    fn conductor_index(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        if object.texture("eta").is_some() || object.texture("k").is_some() {
            lobe.eta = self.rgb_parameter(object, "eta", ColorUse::Unbounded, [0.0; 3], mesh)?;
            lobe.k = self.rgb_parameter(object, "k", ColorUse::Unbounded, [1.0; 3], mesh)?;
            return Ok(());
        }
        let conductor = ior::get_conductor(object)?;
        // Mitsuba 0.6 gives the index relative to vacuum and the surroundings apart.
        let outside = ior::get_dielectric(object, "ext_eta", 1.0)? as f32;
        lobe.eta = RgbParameter::constant(conductor.eta.map(|eta| eta / outside));
        lobe.k = RgbParameter::constant(conductor.k.map(|k| k / outside));
        Ok(())
    }

    /// `distribution`, `alpha` or `alpha_u` and `alpha_v`.
    fn roughness(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        lobe.distribution = match object.get_string("distribution", "beckmann")? {
            "beckmann" => distribution::BECKMANN,
            "ggx" => distribution::GGX,
            other => {
                object.warn(format!(
                    "the distribution \"{other}\" is not supported; \"beckmann\" is used instead"
                ))?;
                distribution::BECKMANN
            }
        };
        if !object.get_bool("sample_visible", true)? {
            lobe.flags |= lobe_flag::SAMPLE_ALL_NORMALS;
        }
        let alpha = self.scalar_parameter(object, "alpha", 0.1, mesh)?;
        lobe.alpha_u = if object.has("alpha_u") {
            self.scalar_parameter(object, "alpha_u", 0.1, mesh)?
        } else {
            alpha
        };
        lobe.alpha_v = if object.has("alpha_v") {
            self.scalar_parameter(object, "alpha_v", 0.1, mesh)?
        } else {
            alpha
        };
        for (name, parameter) in [
            ("alpha_u", &mut lobe.alpha_u),
            ("alpha_v", &mut lobe.alpha_v),
        ] {
            let named = if object.has(name) { name } else { "alpha" };
            check_alpha(object, named, parameter)?;
        }
        Ok(())
    }
}

/// Keeps a constant roughness in the models' domain.
fn check_alpha(
    object: &Object,
    name: &str,
    parameter: &mut ScalarParameter,
) -> Result<(), SceneError> {
    if parameter.texture != NONE {
        return Ok(());
    }
    if parameter.value < 0.0 {
        return Err(object.property_error(name, "a roughness cannot be negative"));
    }
    parameter.value = parameter.value.max(MIN_ALPHA as f32);
    Ok(())
}

/// Interior over exterior index of refraction.
fn relative_index(object: &Object, interior: &str) -> Result<f32, SceneError> {
    if let Some(eta) = object.opt_float("eta")? {
        if eta <= 0.0 {
            return Err(object.property_error("eta", "an index of refraction must be positive"));
        }
        return Ok(eta as f32);
    }
    let named = |name: &str| ior::dielectric(name).unwrap_or(1.0);
    let inside = ior::get_dielectric(object, "int_ior", named(interior))?;
    let outside = ior::get_dielectric(object, "ext_ior", named("air"))?;
    Ok((inside / outside) as f32)
}

/// The nested BSDFs of a wrapper, between `least` and `most` of them.
fn nested_bsdfs(
    object: &Object,
    least: usize,
    most: usize,
) -> Result<Vec<Arc<Object>>, SceneError> {
    let nested: Vec<_> = object
        .children_of(ObjectKind::Bsdf)
        .map(|child| child.object.clone())
        .collect();
    if nested.len() < least || nested.len() > most {
        let wanted = if least == most {
            format!("{least}")
        } else {
            format!("{least} or {most}")
        };
        return Err(object.error(format!(
            "needs {wanted} nested BSDF(s), found {}",
            nested.len()
        )));
    }
    Ok(nested)
}

/// A lobe with neutral parameters.
fn empty_lobe(kind: u32) -> LobeRecord {
    LobeRecord {
        kind,
        distribution: distribution::BECKMANN,
        flags: 0,
        first_factor: 0,
        factor_count: 0,
        frame: NONE,
        reflectance: RgbParameter::constant([0.0; 3]),
        specular_reflectance: RgbParameter::constant([1.0; 3]),
        specular_transmittance: RgbParameter::constant([1.0; 3]),
        eta: RgbParameter::constant([1.0; 3]),
        k: RgbParameter::constant([0.0; 3]),
        alpha_u: ScalarParameter::constant(0.1),
        alpha_v: ScalarParameter::constant(0.1),
        table: NONE,
        internal_reflectance: 0.0,
    }
}
