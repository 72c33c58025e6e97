//! From the object tree of a scene file to the kernel's tables.
//!
//! One pass over the tree: each plugin of each kind has one function here that reads its properties, fills records, and
//! reports unsupported input by an error or a warning. Objects that several others refer to are built once.

mod bitmap;
mod builder;
mod capabilities;
mod chain_settings;
mod daylight;
mod edits;
mod emitter;
mod film;
mod film_format;
mod integrator;
mod integrator_properties;
mod material;
mod options;
mod reading;
pub mod regularization;
mod selection;
mod sensor;
mod shape;
mod texture;
mod value_range;

use crate::expression::{PartsError, PartsRequest, PathParts, SceneNames};
use crate::film::aov::AovSet;
use crate::integrators::divides_paths;
use crate::scene::edits::SceneEdits;
use crate::scene::error::{SceneError, Warning};
use crate::scene::tables::SceneTables;
use crate::scene::xml::unused::warn_unused;
use crate::scene::xml::{Object, ObjectKind, ParsedScene};
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};
use std::sync::Arc;

use builder::Builder;
pub use options::{BuildOptions, Crop, FilmOverride};
pub use sensor::all as all_sensors;

/// A scene that is ready to be rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// All records.
    pub tables: SceneTables,
    /// What its records are called.
    pub names: SceneNames,
    /// The parts into which path expressions divide its image.
    pub parts: PathParts,
    /// Edits of its light transport.
    pub edits: SceneEdits,
    /// Which algorithm, with its parameters.
    pub settings: IntegratorSettings,
    /// Its plugin name.
    pub integrator: String,
    /// Additional layers of the image, as set in the scene.
    pub layers: AovSet,
    /// One of [`halflight_kernel::sampler::sampler_kind`].
    pub sampler: u32,
    /// The name of the requested sampler; `sampler` is the one that replaces it if it is not supported.
    pub sampler_name: String,
    /// Samples per pixel, as set in the scene.
    pub spp: u32,
    /// Seed, as set in the scene.
    pub seed: u32,
    /// Warnings about input that could not be used as written.
    pub warnings: Vec<Warning>,
    /// Plugins by kind and name, with how often each occurs.
    pub plugins: Vec<(String, usize)>,
}

impl Scene {
    /// Divides the image by path expressions.
    ///
    /// # Errors
    /// A mistake in an expression, or an algorithm that does not know the paths of what it adds.
    pub fn divide(&mut self, request: &PartsRequest) -> Result<(), PartsError> {
        if !request.is_empty() && !divides_paths(self.settings.kind) {
            return Err(PartsError::Algorithm(self.integrator.clone()));
        }
        if !request.is_empty() && self.settings.regularization.is_some() {
            return Err(PartsError::Regularized);
        }
        let is_merged = [
            integrator_kind::VERTEX_MERGING,
            integrator_kind::PROGRESSIVE_PHOTONS,
        ]
        .contains(&self.settings.kind);
        if !request.is_empty() && is_merged && !self.edits.is_empty() {
            return Err(PartsError::EditedPhotons(self.integrator.clone()));
        }
        self.parts = PathParts::new(request, &self.tables.view(), &self.names)?;
        Ok(())
    }
}

/// Builds the tables of a parsed scene.
///
/// # Errors
/// The first thing that makes the scene unusable: a missing file, a wrong type, a degenerate transform, no sensor. When
/// the scene was parsed strictly, also the first thing that would otherwise be a warning.
pub fn build_scene(parsed: &ParsedScene, options: &BuildOptions) -> Result<Scene, SceneError> {
    let root = &parsed.root;
    root.touch();
    let sensor = sensor::build(root, options)?;
    let integrator = integrator::build(root, options)?;
    let mut builder = Builder::new(sensor.camera);
    builder.meter = sensor.meter;
    sensor::fill_filter_table(&mut builder.tables);
    builder.add_shapes(root)?;
    builder.add_emitters(root)?;
    builder.check_sensor(root)?;
    builder.check_algorithm(root, &integrator)?;
    builder.finish(root, integrator.settings.kind)?;
    if let Some((what, most)) = builder.tables.view().oversized() {
        return Err(root.error(format!("the scene has more than {most} {what}")));
    }
    let edits = edits::EditReader {
        options,
        integrator: &integrator,
        tables: &builder.tables.view(),
        names: &builder.names,
    };
    let edits = edits.build(root)?;
    warn_unused(root)?;
    let settings = integrator.settings_in(builder.tables.info.radius);
    Ok(Scene {
        edits,
        tables: builder.tables,
        names: builder.names,
        parts: PathParts::default(),
        settings,
        integrator: integrator.name,
        layers: integrator.layers.union(sensor.layers),
        sampler: sensor.sampler,
        sampler_name: sensor.sampler_name,
        spp: sensor.spp,
        seed: sensor.seed,
        warnings: parsed.warnings(),
        plugins: count_plugins(root),
    })
}

/// Settings and name of the integrator that a scene of a radius would be built with.
///
/// # Errors
/// When it has a parameter of a wrong form, or `options` name one that is not known.
pub fn integrator_settings(
    parsed: &ParsedScene,
    options: &BuildOptions,
    radius: f32,
) -> Result<(IntegratorSettings, String), SceneError> {
    let integrator = integrator::build(&parsed.root, options)?;
    Ok((integrator.settings_in(radius), integrator.name))
}

/// Plugins below `root` in alphabetical order; an object that is referred to several times counts once.
fn count_plugins(root: &Object) -> Vec<(String, usize)> {
    let mut seen = std::collections::HashSet::new();
    let mut counts = std::collections::BTreeMap::new();
    let mut stack: Vec<Arc<Object>> = root.children().map(|c| c.object.clone()).collect();
    while let Some(object) = stack.pop() {
        if !seen.insert(object.index) {
            continue;
        }
        if object.kind != ObjectKind::Spectrum {
            *counts
                .entry(format!("{} {}", object.kind, object.plugin))
                .or_insert(0) += 1;
        }
        stack.extend(object.children().map(|c| c.object.clone()));
    }
    counts.into_iter().collect()
}
