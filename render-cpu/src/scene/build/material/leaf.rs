//! Plugins that scatter by themselves: each becomes one lobe.

use super::parameters::{empty_lobe, relative_index};
use crate::bytes::read_file;
use crate::measured::merl::{self, Merl};
use crate::measured::rgl::{self, Rgl};
use crate::scene::build::builder::Builder;
use crate::scene::build::texture::MeshAttributes;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::scene::{LobeRecord, RgbParameter, lobe_kind};
use std::sync::Arc;

/// The default material of dielectrics.
const BK7: &str = "bk7";
/// The default material of plastics.
const POLYPROPYLENE: &str = "polypropylene";

impl Builder {
    /// A plugin that scatters by itself.
    pub(super) fn leaf(
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
            "roughdiffuse" => {
                lobe.kind = lobe_kind::ROUGH_DIFFUSE;
                lobe.reflectance = color(self, "reflectance", 0.5)?;
                lobe.alpha_u = self.scalar_parameter(object, "alpha", 0.2, mesh)?;
                // The model is the full fit; the flag asks for a cheaper one.
                object.get_bool("use_fast_approx", false)?;
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
            "ctd" => {
                lobe.kind = lobe_kind::DIFFRACTING_CONDUCTOR;
                lobe.specular_reflectance = color(self, "specular_reflectance", 1.0)?;
                self.conductor_index(object, mesh, &mut lobe)?;
                self.diffraction(object, &mut lobe)?;
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
                if object.plugin == "roughplastic" {
                    lobe.kind = lobe_kind::ROUGH_PLASTIC;
                }
                self.plastic_layer(object, mesh, eta, &mut lobe)?;
            }
            "merl" => {
                lobe.kind = lobe_kind::MERL;
                lobe.table = self.measured(object)?;
            }
            "measured" => {
                lobe.kind = lobe_kind::MEASURED;
                lobe.table = self.measured_adaptively(object)?;
            }
            "difftrans" => {
                lobe.kind = lobe_kind::DIFFUSE_TRANSMISSION;
                lobe.specular_transmittance = color(self, "transmittance", 0.5)?;
            }
            "hk" => lobe = self.scattering_layer(object, mesh)?,
            "null" => lobe.kind = lobe_kind::NULL,
            other => {
                object.warn(format!(
                    "BSDFs of type \"{other}\" are not supported; a diffuse reflectance of 0.5 is used instead"
                ))?;
                object.ignore();
                lobe.reflectance = RgbParameter::constant([0.5; 3]);
            }
        }
        Ok(lobe)
    }

    /// Loads the material of the RGL database in the file `filename`; returns its offset in the data table.
    fn measured_adaptively(&mut self, object: &Object) -> Result<u32, SceneError> {
        let path = object.require_file("filename")?;
        let wrong =
            |what: String| object.property_error("filename", format!("{}: {what}", path.display()));
        let measured = object.file_cache().get(&path, 1, || {
            let bytes = read_file(&path, rgl::MAX_BYTES).map_err(|e| wrong(e.to_string()))?;
            Rgl::read(&bytes).map_err(|e| wrong(e.to_string()))
        })?;
        let first = self.tables.data.len() as u32;
        self.tables.data.extend_from_slice(&measured.table());
        Ok(first)
    }

    /// Loads the measured reflectance in the file `filename`; returns its offset in the data table.
    fn measured(&mut self, object: &Object) -> Result<u32, SceneError> {
        let path = object.require_file("filename")?;
        let wrong =
            |what: String| object.property_error("filename", format!("{}: {what}", path.display()));
        let measured = object.file_cache().get(&path, 0, || {
            let bytes = read_file(&path, merl::MAX_BYTES).map_err(|e| wrong(e.to_string()))?;
            Merl::read(&bytes).map_err(|e| wrong(e.to_string()))
        })?;
        if measured.cells != merl::DATABASE_CELLS {
            let [h, d, p] = measured.cells;
            object.warn(format!(
                "{h} x {d} x {p} cells, where files of the MERL database have 90 x 90 x 180"
            ))?;
        }
        let first = self.tables.data.len() as u32;
        self.tables.data.extend_from_slice(&measured.table());
        Ok(first)
    }
}
