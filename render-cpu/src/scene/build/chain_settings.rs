//! Parameters of Metropolis chains, by their names in Mitsuba 0.6.

use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::transport::markov::primary_space::technique;
use halflight_kernel::transport::settings::{ChainSettings, half_vector_flag};

/// Reads what the plugin says of chains.
///
/// # Errors
/// If a value is out of its range.
pub(super) fn read_chains(object: &Object, chains: &mut ChainSettings) -> Result<(), SceneError> {
    let is_bidirectional = object.get_bool("bidirectional", true)?;
    chains.technique = if is_bidirectional {
        technique::BIDIRECTIONAL
    } else {
        technique::PATH
    };
    chains.p_large = object.get_float("p_large", 0.3)? as f32;
    if !(0.0..=1.0).contains(&chains.p_large) {
        return Err(object.error("p_large is a probability"));
    }
    chains.candidates = object.get_int_in("luminance_samples", 0, 0, 1 << 30)? as u32;
    // Mitsuba 0.6: -1 leaves direct illumination to the chains.
    chains.direct_samples = if object.has("direct_samples") {
        object.get_int_in("direct_samples", 0, -1, 1 << 20)?.max(0) as u32
    } else {
        ChainSettings::SOME
    };
    chains.chains = object.get_int_in("chains", 128, 1, 1 << 16)? as u32;
    chains.mutations = object.get_int_in("group_mutations", 0, 0, 1 << 20)? as u32;
    for (name, weight) in [
        ("bidirectional_mutation", &mut chains.bidirectional_weight),
        ("lens_perturbation", &mut chains.lens_weight),
        ("caustic_perturbation", &mut chains.caustic_weight),
        ("multi_chain_perturbation", &mut chains.multi_chain_weight),
    ] {
        *weight = switch_or_weight(object, name, true)?;
    }
    for (name, weight) in [
        ("manifold_perturbation", &mut chains.manifold_weight),
        ("half_vector_perturbation", &mut chains.half_vector_weight),
    ] {
        *weight = switch_or_weight(object, name, false)?;
    }
    chains.two_stage = object.get_bool("two_stage", false)?.into();
    chains.lambda = object.get_float_in("lambda", chains.lambda.into(), 1.0, 1e4)? as f32;
    let step = chains.half_vector_step.into();
    chains.half_vector_step = object.get_float_in("half_vector_step", step, 1e-3, 10.0)? as f32;
    let flags = &mut chains.half_vector_flags;
    for (name, flag) in [
        ("original", half_vector_flag::ORIGINAL),
        ("global_roughness", half_vector_flag::GLOBAL_ROUGHNESS),
        ("projected_half_vectors", half_vector_flag::PROJECTED),
        ("equal_steps", half_vector_flag::EQUAL_STEPS),
        ("unstratified", half_vector_flag::UNSTRATIFIED),
    ] {
        if object.get_bool(name, false)? {
            *flags |= flag;
        }
    }
    Ok(())
}

/// No perturbation but manifold exploration: `memlt`, `meerpt`.
pub(super) fn with_manifold(chains: &mut ChainSettings) {
    without_perturbations(chains);
    chains.half_vector_weight = 0.0;
    chains.manifold_weight = weight_or_one(chains.manifold_weight);
}

/// No perturbation but the half-vector mutation: `hslt`.
pub(super) fn with_half_vectors(chains: &mut ChainSettings) {
    without_perturbations(chains);
    chains.manifold_weight = 0.0;
    chains.half_vector_weight = weight_or_one(chains.half_vector_weight);
}

fn without_perturbations(chains: &mut ChainSettings) {
    chains.lens_weight = 0.0;
    chains.caustic_weight = 0.0;
    chains.multi_chain_weight = 0.0;
}

fn weight_or_one(weight: f32) -> f32 {
    if weight > 0.0 { weight } else { 1.0 }
}

/// A mutation of `mlt`: on or off as in Mitsuba 0.6, or its weight in the choice.
fn switch_or_weight(object: &Object, name: &str, default: bool) -> Result<f32, SceneError> {
    let weight_name = format!("{name}_weight");
    let is_on = object.get_bool(name, default)?;
    let weight = object.get_float_in(&weight_name, 1.0, 0.0, 1e6)?;
    Ok(if is_on { weight as f32 } else { 0.0 })
}

/// Energy redistribution: chains are short and many, and start wherever there is light instead of going there.
///
/// # Errors
/// If a value is out of its range.
pub(super) fn redistribute(
    object: Option<&Object>,
    chains: &mut ChainSettings,
) -> Result<(), SceneError> {
    chains.bidirectional_weight = 0.0;
    chains.chain_length = match object {
        Some(object) => object.get_int_in("chain_length", 100, 1, 1 << 20)? as u32,
        None => 100,
    };
    Ok(())
}
