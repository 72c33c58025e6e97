//! `ctd`: a conductor that reflects at its microfacets and diffracts at their finer roughness
//! ([`halflight_kernel::bsdf::diffracting_conductor`]).
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `material`, or `eta` and `k` | complex index of refraction, as of `roughconductor` | Cu |
//! | `specular_reflectance` | factor, colour or texture | 1 |
//! | `alpha` | width beta of the facets' slopes, 0.001 to 1 | 0.1 |
//! | `exponent` | p of their exponential power distribution, 0.2 to 5; 1 is Beckmann | 1 |
//! | `sigma` | standard deviation of the finer heights, micrometres | 0.02 |
//! | `correlation_length` | b of the finer heights, micrometres | 2 |
//! | `decay` | exponent c of their spectrum, above 1 to 6 | 2 |
//! | `wavelengths` | of the red, green and blue channel, micrometres | 0.6114, 0.5491, 0.4642 |
//!
//! All but the colours go into a table when the scene is built, so they are constants.

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::bsdf::diffracting_conductor::fill_table;
use halflight_kernel::bsdf::diffraction_table::{FineScale, WORDS};
use halflight_kernel::scene::{LobeRecord, ScalarParameter, distribution};

/// Dominant wavelengths of the linear sRGB primaries.
const WAVELENGTHS: [f64; 3] = [0.6114, 0.5491, 0.4642];

impl Builder {
    /// The facets and the table of a diffracting conductor.
    pub(super) fn diffraction(
        &mut self,
        object: &Object,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        let alpha = object.get_float_in("alpha", 0.1, 1e-3, 1.0)? as f32;
        let exponent = object.get_float_in("exponent", 1.0, 0.2, 5.0)? as f32;
        let wavelengths = object.get_vector("wavelengths", WAVELENGTHS)?;
        if wavelengths.iter().any(|w| !(0.1..=20.0).contains(w)) {
            return Err(object.property_error(
                "wavelengths",
                "must be three lengths in micrometres between 0.1 and 20",
            ));
        }
        let scale = FineScale {
            wavelengths: wavelengths.map(|w| w as f32),
            sigma: object.get_float_in("sigma", 0.02, 0.0, 10.0)? as f32,
            b: object.get_float_in("correlation_length", 2.0, 0.01, 1e3)? as f32,
            c: object.get_float_in("decay", 2.0, 1.01, 6.0)? as f32,
        };
        lobe.distribution = distribution::EXPONENTIAL_POWER;
        lobe.alpha_u = ScalarParameter::constant(alpha);
        lobe.alpha_v = lobe.alpha_u;
        lobe.exponent = ScalarParameter::constant(exponent);
        lobe.table = self.tables.data.len() as u32;
        let mut words = vec![0.0; WORDS];
        fill_table(&scale, alpha, exponent, &mut words);
        self.tables.data.extend_from_slice(&words);
        Ok(())
    }
}
