//! Chains of several settings on one scene against one image of another algorithm, and the scenes that all of them take.

use crate::agreement::{Batches, compare, settings_of};
use crate::brightness::{BALL, DIFFUSE, POINT, SKY, VEIL, camera};
use crate::scenes::{LAMP, PINHOLE, room};
use halflight::scene::build::Scene;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};

/// A sheet of metal, so that light has far to go between diffuse surfaces.
pub const MIRROR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.6"/>
    <rotate y="1" angle="-40"/><translate x="1" y="0.7" z="-0.3"/></transform>
    <bsdf type="twosided"><bsdf type="conductor"/></bsdf></shape>"#;

/// Chains of full paths without light apart, by nothing but mutations of these weights: bidirectional, lens, caustic, multi-chain.
pub fn of_mutations([bidirectional, lens, caustic, multi_chain]: [f32; 4]) -> ChainSettings {
    ChainSettings {
        direct_samples: 0,
        bidirectional_weight: bidirectional,
        lens_weight: lens,
        caustic_weight: caustic,
        multi_chain_weight: multi_chain,
        ..ChainSettings::DEFAULT
    }
}

/// Samples of the other algorithm and of the chains.
#[derive(Clone, Copy)]
pub struct Samples {
    pub truth: u32,
    pub chains: u32,
}

/// Of chains of full paths.
pub const OF_WHOLE_PATHS: Samples = Samples {
    truth: 384,
    chains: 6,
};

/// Compares chains of `chain_kind` with the algorithm of `kind`.
pub fn agree_with(
    what: &str,
    scene: &mut Scene,
    [kind, chain_kind]: [u32; 2],
    samples: Samples,
    variants: &[(&str, ChainSettings)],
) -> Vec<Result<(), String>> {
    let settings = settings_of(scene, kind);
    let truth = Batches::render(what, scene, settings, samples.truth);
    variants
        .iter()
        .map(|(name, chains)| {
            let what = format!("{what}, {name}");
            let settings = IntegratorSettings {
                chains: *chains,
                ..settings_of(scene, chain_kind)
            };
            let found = Batches::render(&what, scene, settings, samples.chains);
            let error = truth.relative_error().hypot(found.relative_error());
            if error > 0.03 {
                return Err(format!("{what}: noise of {error:.3} hides everything"));
            }
            compare(&what, &truth, &found)
        })
        .collect()
}

/// Scenes with every kind of light and camera and with masks, each with the algorithm that finds all of its light; they
/// want the file sky.exr.
pub fn lights_cameras_and_masks() -> [(&'static str, String, u32); 5] {
    let thin = camera(
        "thinlens",
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="3"/>"#,
    );
    let parallel = PINHOLE
        .replace("perspective", "orthographic")
        .replace(r#"<float name="fov" value="60"/>"#, "");
    let coated = r#"<bsdf type="plastic"/>"#;
    [
        (
            "point light through glass",
            [PINHOLE, &room(DIFFUSE), POINT, BALL].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
        (
            "sky through glass",
            [PINHOLE, &room(DIFFUSE), SKY, BALL].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
        (
            "veil",
            [PINHOLE, &room(DIFFUSE), LAMP, VEIL].concat(),
            integrator_kind::PATH,
        ),
        (
            "coats through a thin lens",
            [&thin, &room(coated), LAMP].concat(),
            integrator_kind::PATH,
        ),
        (
            "parallel rays",
            [&parallel, &room(coated), LAMP, MIRROR].concat(),
            integrator_kind::BIDIRECTIONAL,
        ),
    ]
}
