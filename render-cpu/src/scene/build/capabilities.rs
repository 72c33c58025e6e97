//! What an algorithm cannot see or cannot be seen through, said before it renders.

use super::builder::Builder;
use super::integrator::Integrator;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::scene::{NONE, camera_kind, emitter_kind};
use halflight_kernel::transport::integrator_kind;

impl Builder {
    /// That the sensor found its shape.
    pub(super) fn check_sensor(&self, root: &Object) -> Result<(), SceneError> {
        let camera = &self.tables.camera;
        if camera.kind == camera_kind::IRRADIANCE_METER && camera.shape == NONE {
            return Err(root.error("the shape of the irradiance meter is not part of the scene"));
        }
        Ok(())
    }

    /// That the algorithm serves the sensor and finds the light of all emitters.
    pub(super) fn check_algorithm(
        &self,
        root: &Object,
        integrator: &Integrator,
    ) -> Result<(), SceneError> {
        let kind = integrator.settings.kind;
        let name = &integrator.name;
        let is_meter = self.tables.camera.kind == camera_kind::IRRADIANCE_METER;
        if is_meter && kind == integrator_kind::VEACH_MLT {
            return Err(root.error(format!(
                "{name} mutates paths through an image, which an irradiance meter does not have; use another algorithm"
            )));
        }
        let has_beam = self
            .tables
            .emitters
            .iter()
            .any(|emitter| emitter.kind == emitter_kind::COLLIMATED);
        let finds_beams = !matches!(
            kind,
            integrator_kind::PATH
                | integrator_kind::MANIFOLD_PATH
                | integrator_kind::DIRECT
                | integrator_kind::AMBIENT_OCCLUSION
                | integrator_kind::VEACH_MLT
        );
        if has_beam && !finds_beams {
            root.warn(format!(
                "{name} does not find the light of collimated emitters; ptracer, bdpt and photon mapping do"
            ))?;
        }
        Ok(())
    }
}
