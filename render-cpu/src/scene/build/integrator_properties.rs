//! Which properties belong to which integrators.
//!
//! All are read whatever the integrator, because a scene may be rendered by another one than its own (`--integrator`, or a parameter
//! as its type). Where the file names the integrator, those of others are without an effect, which is said.

use crate::integrators;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;

/// Properties, and the integrators that have them.
const OWNERS: [(&[&str], &[&str]); 6] = [
    (&["emitter_samples", "bsdf_samples"], &["direct"]),
    (&["shading_samples"], &["direct", "ao"]),
    (&["ray_length"], &["ao"]),
    (&["connections"], &["bdpt", "vcm"]),
    (
        &[
            "photon_count",
            "alpha",
            "initial_radius",
            "nearest",
            "min_radius",
            "max_radius",
            "gather_roughness",
        ],
        &["sppm", "mcppm", "appm", "vcm", "vm"],
    ),
    (
        &[
            "p_large",
            "luminance_samples",
            "direct_samples",
            "chains",
            "group_mutations",
            "two_stage",
            "bidirectional_mutation",
            "lens_perturbation",
            "caustic_perturbation",
            "multi_chain_perturbation",
            "manifold_perturbation",
            "half_vector_perturbation",
            "half_vector_step",
            "chain_length",
        ],
        &["pssmlt", "mmlt", "mlt", "memlt", "hslt", "erpt", "meerpt"],
    ),
];

/// Says which properties of an integrator are those of others.
///
/// # Errors
/// The first warning, when the scene is read strictly.
pub(super) fn warn_of_others(object: &Object) -> Result<(), SceneError> {
    let plugin = object.plugin.as_str();
    let Some(integrator) = integrators::find(plugin) else {
        // Another one runs instead.
        return Ok(());
    };
    for (names, owners) in OWNERS {
        if owners.contains(&integrator.name) {
            continue;
        }
        for name in names.iter().filter(|name| object.has(name)) {
            object.property_warn(
                name,
                format!(
                    "\"{plugin}\" does not use this, but {} does; it is ignored",
                    owners.join(", ")
                ),
            )?;
        }
    }
    Ok(())
}
