//! Dielectric layers: the coats above other BSDFs, the absorption in a layer, and tables of rough transmittance.

use super::context::{Context, PendingLobe, nested_bsdfs};
use super::parameters::{empty_lobe, relative_index};
use crate::scene::build::builder::{Builder, TransmittanceTable};
use crate::scene::build::texture::MeshAttributes;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_transmittance::{ENTRIES, ROW, ROWS, fill, fill_row};
use halflight_kernel::scene::MAX_COATS;
use halflight_kernel::scene::{
    CoatRecord, LobeRecord, NONE, RgbParameter, distribution, lobe_flag, lobe_kind,
};
use std::sync::Arc;

/// The default material of coats.
const BK7: &str = "bk7";

impl Builder {
    /// `coating` and `roughcoating`: the coat's own reflection, and the nested BSDF below the coat.
    pub(super) fn coating(
        &mut self,
        object: &Arc<Object>,
        outer: &Context<'_>,
        mut inner: Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) -> Result<(), SceneError> {
        let nested = nested_bsdfs(object, 1, 1)?;
        if inner.coats.records.len() == MAX_COATS {
            return Err(object.error(format!(
                "at most {MAX_COATS} coatings above each other are supported"
            )));
        }
        let is_rough = object.plugin == "roughcoating";
        let eta = relative_index(object, BK7)?;
        let mut surface = empty_lobe(if is_rough {
            lobe_kind::ROUGH_COAT
        } else {
            lobe_kind::COAT
        });
        surface.eta = RgbParameter::constant([eta; 3]);
        surface.specular_reflectance = self.rgb_parameter(
            object,
            "specular_reflectance",
            ColorUse::Reflectance,
            [1.0; 3],
            inner.mesh,
        )?;
        let mut coat = CoatRecord {
            eta,
            optical_depth: self.optical_depth(object, inner.mesh)?,
            ..CoatRecord::NONE
        };
        if is_rough {
            self.roughness(object, inner.mesh, &mut surface)?;
            if let Some(table) = self.rough_transmittance(object, &surface, eta)? {
                (coat.table, coat.table_rows) = (table.first, table.rows);
                coat.alpha = surface.alpha_u;
            }
        }
        // Indices that match reflect nothing.
        if eta != 1.0 {
            self.push_lobe(object, surface, outer.clone(), lobes)?;
        }
        if inner.coats.records.is_empty() {
            inner.coats.frame = inner.frame;
        } else if inner.coats.frame != inner.frame {
            return Err(object.error("a normal or bump map between two coatings is not supported"));
        }
        inner.coats.records.push(coat);
        let before = lobes.len();
        self.flatten(&nested[0], inner, lobes)?;
        if lobes[before..].iter().any(PendingLobe::transmits) {
            return Err(object.error(
                "a BSDF that transmits light cannot be coated; put a mask around the coating",
            ));
        }
        Ok(())
    }

    /// `thickness` times `sigma_a`.
    pub(super) fn optical_depth(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
    ) -> Result<RgbParameter, SceneError> {
        let thickness = object.get_float_in("thickness", 1.0, 0.0, f64::MAX)? as f32;
        let mut depth =
            self.rgb_parameter(object, "sigma_a", ColorUse::Unbounded, [0.0; 3], mesh)?;
        depth.value = depth.value.map(|v| v * thickness);
        Ok(depth)
    }

    /// The table of rough transmittance for the distribution and roughness of `lobe`; `None` when the plugin's
    /// `transmittance` is that of a smooth boundary.
    pub(super) fn rough_transmittance(
        &mut self,
        object: &Object,
        lobe: &LobeRecord,
        eta: f32,
    ) -> Result<Option<TransmittanceTable>, SceneError> {
        match object.get_string("transmittance", "rough")? {
            "rough" => {}
            "smooth" => return Ok(None),
            other => {
                return Err(object.property_error(
                    "transmittance",
                    format!("\"{other}\" is neither \"rough\" nor \"smooth\""),
                ));
            }
        }
        if lobe.distribution == distribution::EXPONENTIAL_POWER {
            return Err(object.property_error("distribution", "a coat cannot be \"epd\""));
        }
        let textured = lobe.alpha_u.texture != NONE;
        let alpha = if textured { 0.0 } else { lobe.alpha_u.value };
        let key = (lobe.distribution, textured, alpha.to_bits(), eta.to_bits());
        if let Some(&table) = self.transmittance_tables.get(&key) {
            return Ok(Some(table));
        }
        let first = self.tables.data.len() as u32;
        let rows = if textured { ROWS } else { 1 };
        let mut words = vec![0.0; rows * ROW];
        if textured {
            fill(lobe.distribution, eta, &mut words);
        } else {
            fill_row(lobe.distribution, alpha, eta, &mut words);
        }
        self.tables.data.extend_from_slice(&words);
        let table = TransmittanceTable {
            first,
            rows: rows as u32,
            internal_reflectance: words[ENTRIES],
        };
        self.transmittance_tables.insert(key, table);
        Ok(Some(table))
    }

    /// The layer of `plastic` and `roughplastic` above its diffuse base.
    pub(super) fn plastic_layer(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
        eta: f32,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        lobe.eta = RgbParameter::constant([eta; 3]);
        lobe.internal_reflectance = fresnel_diffuse_reflectance(1.0 / eta);
        lobe.optical_depth = self.optical_depth(object, mesh)?;
        if object.get_bool("nonlinear", false)? {
            lobe.flags |= lobe_flag::NONLINEAR;
        }
        if lobe.kind == lobe_kind::ROUGH_PLASTIC {
            self.roughness(object, mesh, lobe)?;
            if let Some(table) = self.rough_transmittance(object, lobe, eta)? {
                (lobe.table, lobe.table_rows) = (table.first, table.rows);
                lobe.internal_reflectance = table.internal_reflectance;
            }
        }
        Ok(())
    }
}
