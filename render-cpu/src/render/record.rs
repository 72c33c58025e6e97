//! Records of a run: the settings in its checkpoints, and the metadata of its image.

use super::chains::MutationsPerPixel;
use super::options::{RenderOptions, RunState};
use crate::film::Film;
use crate::film::aov::{Aov, AovSet};
use crate::film::checkpoint::Settings;
use crate::image::metadata::{ImageMetadata, SampleRange};
use crate::scene::build::Scene;
use flate2::Crc;
use halflight_kernel::sampler::sampler_kind;
use halflight_kernel::scene::NONE;
use halflight_kernel::transport::integrator_kind;
use std::path::Path;

/// Name of the settings' entry that distinguishes the shares of an image: index of the first sample.
pub const FIRST_SAMPLE: &str = "first sample";
/// The other one.
pub const SEED: &str = "seed";

/// Name of the setting that says what samples are brought down to.
pub const CLAMP: &str = "clamp";

/// Everything that decides the numbers of an image; a checkpoint of other settings is refused.
pub fn run_settings(path: &Path, scene: &Scene, options: &RenderOptions, aovs: AovSet) -> Settings {
    let camera = &scene.tables.camera;
    let mut settings = Settings::new();
    let mut set = |name: &str, value: String| settings.insert(name.to_string(), value);
    set("version", env!("CARGO_PKG_VERSION").to_string());
    set("scene", path.display().to_string());
    set(
        SCENE_CONTENT,
        format!("{:016x}", scene.tables.fingerprint()),
    );
    for (name, value) in integrator_words(scene) {
        set(name, value);
    }
    for (name, value) in scene.parts.settings() {
        set(&name, value);
    }
    for (name, value) in scene.edits.settings() {
        set(&name, value);
    }
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

/// Name of the entry with a digest of the scene's tables.
const SCENE_CONTENT: &str = "content of the scene (digest)";

/// The algorithm and its parameters by the names that scene files and command lines have for them. What has no name there is
/// in a digest of all of them.
fn integrator_words(scene: &Scene) -> Vec<(&'static str, String)> {
    let settings = &scene.settings;
    let depth = |n: u32| match n {
        u32::MAX => "-1".to_string(),
        n => n.to_string(),
    };
    let flag = |n: u32| (n != 0).to_string();
    let mut words = vec![
        ("integrator", scene.integrator.clone()),
        ("max_depth", depth(settings.rules.max_depth)),
        ("rr_depth", depth(settings.rules.rr_depth)),
        ("hide_emitters", flag(settings.rules.hide_emitters)),
        ("strict_normals", flag(settings.rules.strict_normals)),
    ];
    match settings.kind {
        integrator_kind::DIRECT => words.extend([
            (
                "emitter_samples",
                settings.direct.emitter_samples.to_string(),
            ),
            ("bsdf_samples", settings.direct.bsdf_samples.to_string()),
        ]),
        integrator_kind::AMBIENT_OCCLUSION => words.extend([
            ("shading_samples", settings.occlusion.samples.to_string()),
            (
                "ray_length",
                (settings.occlusion.distance * scene.tables.info.radius).to_string(),
            ),
        ]),
        integrator_kind::BIDIRECTIONAL
        | integrator_kind::LIGHT_TRACING
        | integrator_kind::MANIFOLD_BIDIRECTIONAL => {
            let bidirectional = &settings.bidirectional;
            let any = |n: u32| match n {
                NONE => "*".to_string(),
                n => n.to_string(),
            };
            let strategies = format!(
                "{},{}",
                any(bidirectional.only_s),
                any(bidirectional.only_t)
            );
            words.extend([
                ("light_image", flag(bidirectional.light_image)),
                ("sample_direct", flag(bidirectional.sample_direct)),
                ("--connections", bidirectional.connections.to_string()),
                ("--heuristic power", flag(bidirectional.power_heuristic)),
                ("--strategies", strategies),
                ("--unweighted", flag(bidirectional.unweighted)),
            ]);
        }
        _ => {}
    }
    let mut digest = Crc::new();
    digest.update(bytemuck::bytes_of(settings));
    words.push((
        "parameters of the integrator (digest)",
        format!("{:08x}", digest.sum()),
    ));
    words
}

/// Of the settings of a run, what tells images of one scene by one algorithm from others, whatever samples and pixels they
/// hold: a digest of the scene, and the rest by name.
pub fn identity(settings: &Settings) -> (String, Settings) {
    let of_the_run = [
        SCENE_CONTENT,
        "version",
        "scene",
        SEED,
        FIRST_SAMPLE,
        "adaptive",
        "size",
        "crop",
        "layers",
    ];
    let rest = settings
        .iter()
        .filter(|(name, _)| !of_the_run.contains(&name.as_str()));
    let digest = settings.get(SCENE_CONTENT).cloned();
    (
        digest.unwrap_or_default(),
        rest.map(|(name, value)| (name.clone(), value.clone()))
            .collect(),
    )
}

/// The metadata of a run's image.
pub fn image_metadata(
    path: &Path,
    scene: &Scene,
    film: &Film,
    options: &RenderOptions,
    state: &RunState,
) -> ImageMetadata {
    let (scene_digest, settings) = identity(&run_settings(path, scene, options, film.aovs()));
    let most = film.statistics().iter().map(|p| p.count).max().unwrap_or(0);
    ImageMetadata {
        scene: scene_name(path),
        integrator: scene.integrator.clone(),
        sampler: sampler_name(scene.sampler).to_string(),
        software: concat!("halflight ", env!("CARGO_PKG_VERSION")).to_string(),
        spp: film.total_samples() as f64 / film.statistics().len() as f64
            * f64::from(MutationsPerPixel::of(scene).0),
        sample_ranges: vec![SampleRange {
            seed: options.seed.into(),
            from: options.first_sample,
            to: options.first_sample + most,
        }],
        render_seconds: state.seconds,
        scene_digest,
        settings,
        mutations: film
            .chain_counts()
            .json()
            .map_or_else(String::new, |json| json.to_string()),
        ..ImageMetadata::default()
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
