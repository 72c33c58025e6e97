//! Records of a run: the settings in its checkpoints, and the metadata of its image.

use super::options::{RenderOptions, RunState};
use crate::film::Film;
use crate::film::aov::{Aov, AovSet};
use crate::film::checkpoint::Settings;
use crate::image::metadata::{ImageMetadata, SampleRange};
use crate::scene::build::Scene;
use halflight_kernel::sampler::sampler_kind;
use std::path::Path;

/// Name of the settings' entry that tells the shares of an image apart: index of the first sample.
pub const FIRST_SAMPLE: &str = "first sample";
/// The other one.
pub const SEED: &str = "seed";

/// Everything that decides the numbers of an image; a checkpoint of other settings is refused.
pub fn run_settings(path: &Path, scene: &Scene, options: &RenderOptions, aovs: AovSet) -> Settings {
    let camera = &scene.tables.camera;
    let mut settings = Settings::new();
    let mut set = |name: &str, value: String| settings.insert(name.to_string(), value);
    set("version", env!("CARGO_PKG_VERSION").to_string());
    set("scene", path.display().to_string());
    set("tables", format!("{:016x}", scene.tables.fingerprint()));
    set("integrator", format!("{:?}", scene.settings));
    set("sampler", sampler_name(scene.sampler).to_string());
    set(SEED, options.seed.to_string());
    set(FIRST_SAMPLE, options.first_sample.to_string());
    set("adaptive", options.adaptive.to_string());
    set(
        "size",
        format!("{}x{}", camera.film_size[0], camera.film_size[1]),
    );
    set(
        "crop",
        format!(
            "{},{},{},{}",
            camera.crop_offset[0], camera.crop_offset[1], camera.crop_size[0], camera.crop_size[1]
        ),
    );
    set(
        "layers",
        aovs.iter().map(Aov::name).collect::<Vec<_>>().join(","),
    );
    settings
}

/// The metadata of a run's image.
pub fn image_metadata(
    path: &Path,
    scene: &Scene,
    film: &Film,
    options: &RenderOptions,
    state: &RunState,
) -> ImageMetadata {
    let most = film.statistics().iter().map(|p| p.count).max().unwrap_or(0);
    ImageMetadata {
        scene: scene_name(path),
        integrator: scene.integrator.clone(),
        sampler: sampler_name(scene.sampler).to_string(),
        software: concat!("halflight ", env!("CARGO_PKG_VERSION")).to_string(),
        spp: film.total_samples() as f64 / film.statistics().len() as f64,
        sample_ranges: vec![SampleRange {
            seed: options.seed.into(),
            from: options.first_sample,
            to: options.first_sample + most,
        }],
        render_seconds: state.seconds,
    }
}

/// Name of a scene in metadata: that of its file.
pub fn scene_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Name of a sampler in metadata.
pub fn sampler_name(kind: u32) -> &'static str {
    if kind == sampler_kind::SOBOL {
        "sobol"
    } else {
        "independent"
    }
}
