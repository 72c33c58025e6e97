//! Comparison of algorithms on a scene: images of equal processor time against a reference, and the error over time.
//!
//! The chosen algorithms render the same scene in turn, slice by slice, so that other load on the machine
//! affects all of them ([`mod@race`]). After 1/128, 1/64 ... 1 of the time their images are measured ([`errors`]); the numbers
//! become a table, a diagram and JSON ([`report`]), the last images a contact sheet with insets ([`sheet`]).
//!
//! Without a reference each algorithm renders two images with different random numbers, each for the whole time, and is measured
//! by their difference, which does not show light that both miss.

pub mod errors;
pub mod race;
pub mod report;
pub mod sheet;

use errors::{ErrorReference, Errors, Reference, ShownErrors};
use race::{Budget, Runner, race};

use crate::accel::Accel;
use crate::compare::metrics::RgbImage;
use crate::film::Film;
use crate::integrators::{self, INTEGRATORS, Integrator};
use crate::render::PassError;
use crate::scene::build::Scene;
use halflight_kernel::transport::IntegratorSettings;

/// The algorithms that can be compared: all that estimate the whole light of a scene.
pub fn comparable() -> impl Iterator<Item = &'static Integrator> {
    INTEGRATORS.iter().filter(|i| i.is_complete)
}

/// The algorithm of a name.
///
/// # Errors
/// If there is none that can be compared; the message names all.
pub fn find(name: &str) -> Result<&'static Integrator, String> {
    comparable().find(|i| i.name == name).ok_or_else(|| {
        format!(
            "there is no integrator \"{name}\" to compare; known are {}",
            integrators::names(comparable())
        )
    })
}

/// What is measured of an image after some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Processor time in seconds.
    pub seconds: f64,
    /// Samples per pixel, mutations where there are chains.
    pub samples: u32,
    /// The errors.
    pub errors: Errors,
}

/// How an algorithm did.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Its name.
    pub name: String,
    /// What was measured, in the order of time.
    pub curve: Vec<Point>,
    /// Perceptual metrics of the last image.
    pub shown: ShownErrors,
    /// The last image.
    pub image: RgbImage,
    /// Relative squared error per pixel of the last image.
    pub error_map: Vec<f64>,
}

/// The mean of a film.
fn image(film: &Film) -> RgbImage {
    RgbImage::new(film.width() as usize, film.height() as usize, film.mean())
}

/// What is compared.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// The algorithms, by the names that they have in the results, with their settings.
    pub integrators: &'a [(String, IntegratorSettings)],
    /// What each may spend.
    pub budget: Budget,
    /// Seed of the first images; second ones, without a reference, have the next.
    pub seed: u32,
    /// The image to measure against.
    pub reference: Option<&'a Reference>,
}

/// Renders and measures; `done` is called after each share of the budget.
///
/// # Errors
/// If a film cannot be made or a pass fails.
pub fn run(
    scene: &mut Scene,
    accel: &Accel,
    setup: &Setup<'_>,
    mut done: impl FnMut(f64),
) -> Result<Vec<Outcome>, PassError> {
    let (integrators, reference) = (setup.integrators, setup.reference);
    // Pairs stand side by side.
    let runs = if reference.is_some() { 1 } else { 2 };
    let mut runners = Vec::new();
    for (name, settings) in integrators {
        for twin in 0..runs {
            let seed = setup.seed.wrapping_add(twin);
            runners.push(Runner::new(name, scene, *settings, seed)?);
        }
    }
    let mut curves: Vec<Vec<Point>> = vec![Vec::new(); integrators.len()];
    race(
        &mut runners,
        scene,
        accel,
        setup.budget,
        |runners, share| {
            for (runs, curve) in runners.chunks(runs as usize).zip(&mut curves) {
                let first = &runs[0];
                let is_new = curve.last().is_none_or(|p| p.samples < first.samples());
                if is_new {
                    curve.push(Point {
                        seconds: first.seconds,
                        samples: first.samples(),
                        errors: with_error_reference(runs, reference, |image, reference| {
                            Errors::new(image, &first.film.variance_of_mean(), reference)
                        }),
                    });
                }
            }
            done(share);
        },
    )?;
    let finished = runners.chunks(runs as usize).zip(curves);
    Ok(finished
        .map(|(runs, curve)| {
            let (shown, error_map) = with_error_reference(runs, reference, |image, reference| {
                let map = errors::relative_squares(image, reference);
                (ShownErrors::new(image, reference), map)
            });
            Outcome {
                name: runs[0].name.clone(),
                curve,
                shown,
                image: image(&runs[0].film),
                error_map,
            }
        })
        .collect())
}

/// Calls a function with the image of the first run and the image that it is measured against.
fn with_error_reference<R>(
    runs: &[Runner],
    reference: Option<&Reference>,
    measure: impl FnOnce(&RgbImage, ErrorReference<'_>) -> R,
) -> R {
    let first = image(&runs[0].film);
    match (reference, runs.get(1)) {
        (Some(reference), _) => measure(&first, ErrorReference::Reference(reference)),
        (None, Some(twin)) => measure(&first, ErrorReference::Twin(&image(&twin.film))),
        (None, None) => measure(&first, ErrorReference::Twin(&first)),
    }
}
