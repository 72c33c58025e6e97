//! Scenes that nobody here wrote, against other renderers' images: the z-test of `halflight compare` for every algorithm.
//!
//! - [`ordinary`]: `HALFLIGHT_CORPUS` names a folder with `manifest.json`, a list of scenes, film widths, parameters, and
//!   reference images with the variance of their mean;
//! - [`hard`]: `HALFLIGHT_HARD` names a folder with a folder `NAME/scene.xml` per scene and the references `reference/NAME.exr`
//!   and `reference/mitsuba3/NAME.exr`, scenes whose light path tracing loses.
//!
//! `HALFLIGHT_CORPUS_SPP` and `HALFLIGHT_HARD_SPP` set the samples per pixel, `HALFLIGHT_CORPUS_SEEDS` the number of seeds with
//! which algorithms but path tracing render each scene, `HALFLIGHT_CORPUS_STEP` the share of the scenes that they take (one in
//! so many), `HALFLIGHT_CORPUS_ONLY` a part of the names. Without a folder the tests are skipped; with
//! `HALFLIGHT_REQUIRE_CORPUS` set that is a failure.

#[path = "../common/skip.rs"]
mod skip;

mod hard;
mod ordinary;

use halflight::compare::metrics::RgbImage;
use halflight::compare::metrics::ztest::{Estimate, Outcome, Settings, ztest};
use halflight::film::aov::AovSet;
use halflight::image::read_exr;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, FilmOverride, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use std::path::PathBuf;

/// A scene and its reference.
struct Entry {
    name: String,
    scene: PathBuf,
    defines: Vec<(String, String)>,
    /// Width of the film, if not the scene's own.
    width: Option<u32>,
    reference: PathBuf,
    /// Samples per pixel of the reference, where they are independent.
    reference_spp: Option<f64>,
    /// Independent runs from which its variance comes.
    reference_runs: f64,
}

/// An image and what is known of its error.
struct Image {
    mean: RgbImage,
    variance: RgbImage,
    degrees_of_freedom: f64,
    samples: Option<f64>,
}

/// The scenes that a folder's variable names, or `None` where there is none.
fn folder(variable: &str) -> Option<PathBuf> {
    let folder = std::env::var_os(variable);
    let folder = folder.ok_or(format!("{variable} does not name a folder of scenes"));
    skip::available(folder, "HALFLIGHT_REQUIRE_CORPUS").map(PathBuf::from)
}

/// A number from the environment.
fn number(variable: &str, default: u32) -> u32 {
    std::env::var(variable).map_or(default, |text| text.parse().expect("a number"))
}

/// Whether the scene of the name is asked for.
fn is_asked_for(name: &str) -> bool {
    name.contains(&std::env::var("HALFLIGHT_CORPUS_ONLY").unwrap_or_default())
}

/// The scene of an entry, rendered by its own integrator or another.
fn load(entry: &Entry, integrator: Option<&str>) -> Result<Scene, String> {
    let parsed = parse_scene(&entry.scene, &entry.defines, false).map_err(|e| e.to_string())?;
    let options = BuildOptions {
        film: FilmOverride {
            width: entry.width,
            ..FilmOverride::default()
        },
        integrator: integrator.map(Into::into),
        // Samples that know of each other have less variance than the film can tell.
        sampler: Some("independent".into()),
        ..BuildOptions::default()
    };
    build_scene(&parsed, &options).map_err(|e| e.to_string())
}

/// An image of `spp` samples per pixel.
fn render(scene: &Scene, spp: u32, seed: u32) -> Image {
    let options = RenderOptions {
        goal: Goal::Samples(spp),
        seed,
        first_sample: 0,
        adaptive: false,
    };
    let film = render_film(scene, &options, AovSet::NONE).expect("a film");
    let size = (film.width() as usize, film.height() as usize);
    let image = |pixels| RgbImage::new(size.0, size.1, pixels);
    Image {
        mean: image(film.mean()),
        variance: image(film.variance_of_mean()),
        degrees_of_freedom: f64::from(spp) - 1.0,
        samples: Some(f64::from(spp)),
    }
}

/// The z-test of two images of one size.
fn compare(image: &Image, reference: &Image) -> Outcome {
    let size = |image: &Image| (image.mean.width, image.mean.height);
    assert_eq!(size(image), size(reference), "width and height");
    ztest(image.estimate(), reference.estimate(), Settings::default())
}

impl Image {
    fn estimate(&self) -> Estimate<'_> {
        Estimate {
            mean: &self.mean,
            variance: &self.variance,
            degrees_of_freedom: self.degrees_of_freedom,
            samples: self.samples,
        }
    }
}

/// The reference of an entry, which holds mean and variance of the mean.
fn read_reference(entry: &Entry) -> Result<Image, String> {
    let path = &entry.reference;
    let reference = read_exr(path).map_err(|e| e.to_string())?;
    let size = (reference.width as usize, reference.height as usize);
    let channels = |names: [&str; 3]| -> Result<RgbImage, String> {
        let planes = names.map(|name| reference.channel(name));
        let [Some(r), Some(g), Some(b)] = planes else {
            return Err(format!("{} lacks {names:?}", path.display()));
        };
        let pixels = (0..r.len())
            .map(|i| [r[i], g[i], b[i]].map(f64::from))
            .collect();
        Ok(RgbImage::new(size.0, size.1, pixels))
    };
    Ok(Image {
        mean: channels(["R", "G", "B"])?,
        variance: channels(["variance.R", "variance.G", "variance.B"])?,
        degrees_of_freedom: entry.reference_runs - 1.0,
        samples: entry.reference_spp,
    })
}

/// Prints a comparison; whether it passes.
fn report(what: &str, outcome: &Outcome) -> bool {
    let verdict = if outcome.passes() { "pass" } else { "FAIL" };
    let levels = outcome
        .levels
        .map(|level| format!("{:.2}", level.severity()));
    println!(
        "{verdict} {what:48} severity of pixels, 8 x 8, 32 x 32, image: {}; mean z {:+.3}",
        levels.join(" "),
        outcome.mean_z
    );
    outcome.passes()
}
