//! What commands that let algorithms race on one scene load first.

use super::scene_args::SceneArgs;
use crate::experiment::convergence::errors::Reference;
use crate::experiment::convergence::find;
use crate::image::read_exr;
use crate::say::note;
use crate::scene::build::Scene;
use halflight_kernel::transport::IntegratorSettings;
use std::error::Error;
use std::path::Path;

/// The name and the settings of an algorithm.
pub type Competitor = (String, IntegratorSettings);

/// The scene as the first of some algorithms has it, and the name and settings of each. What the scene warns of is said.
///
/// # Errors
/// If an algorithm is unknown, the scene cannot be loaded for it, or there is none.
pub fn load_for_each(
    args: &SceneArgs,
    integrators: &[String],
) -> Result<(Scene, Vec<Competitor>), Box<dyn Error + Send + Sync>> {
    let mut settings = Vec::new();
    let mut scene = None;
    for name in integrators {
        let integrator = find(name)?;
        let mut with = args.clone();
        with.integrator = Some(integrator.name.to_owned());
        let loaded = with.load()?;
        settings.push((integrator.name.to_owned(), loaded.settings));
        scene.get_or_insert(loaded);
    }
    let scene = scene.ok_or("--integrators names no algorithm")?;
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    Ok((scene, settings))
}

/// The image to measure by, if one is given, for a film of `size`.
///
/// # Errors
/// If it cannot be read or has another size.
pub fn read_reference(
    path: Option<&Path>,
    size: [u32; 2],
) -> Result<Option<Reference>, Box<dyn Error + Send + Sync>> {
    let Some(path) = path else {
        return Ok(None);
    };
    let name = path.display().to_string();
    Ok(Some(Reference::new(&name, &read_exr(path)?, size)?))
}

/// Says how much of the race is over.
pub fn show_share(quiet: bool, share: f64) {
    if !quiet {
        note(format_args!("{:5.1} % done", 100.0 * share));
    }
}
