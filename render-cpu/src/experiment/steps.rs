//! Figure 8.5 of Kaplanyan 2017: how far half vectors should step.
//!
//! A sphere and a cube of rough glass, of roughness 0.1 and 0.01, on a diffuse ground below a lamp. The half-vector mutation of whole
//! paths with the same step at all materials, over a range of steps, against steps from the roughness, without and with the limit
//! of a few percent of the image: acceptance, and error against bidirectional path tracing. No one step suits both
//! materials.

use super::report::Report;
use crate::film::Film;
use crate::film::aov::AovSet;
use crate::plot::{Mark, Plot, Scale, Series};
use crate::render::{Goal, MutationsPerPixel, RenderOptions, render_film};
use crate::scene::build::{BuildOptions, Scene, build_scene};
use crate::scene::xml::parse_scene_from_str;
use halflight_kernel::transport::settings::{ChainSettings, half_vector_flag, integrator_kind};
use std::fmt::Write;
use std::path::Path;

const SCENE: &str = r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="8"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 1.6, 4" target="0, 0.4, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="$width"/><integer name="height" value="$height"/>
    <rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.6, 0.6"/></bsdf></shape>
<shape type="sphere"><point name="center" value="-0.7, 0.5, 0"/><float name="radius" value="0.45"/>
    <bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf></shape>
<shape type="cube"><transform name="to_world"><scale value="0.4"/><rotate y="1" angle="30"/><translate x="0.7" y="0.45"/></transform>
    <bsdf type="roughdielectric"><float name="alpha" value="0.01"/></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate y="2.5" z="-0.5"/></transform>
    <emitter type="area"><rgb name="radiance" value="12, 12, 12"/></emitter></shape></scene>"#;

/// Mutations per pixel.
const MUTATIONS: u32 = 128;

fn scene([width, height]: [u32; 2]) -> Scene {
    let defines = [("width", width), ("height", height)]
        .map(|(name, value)| (name.to_string(), value.to_string()));
    let parsed = parse_scene_from_str(SCENE, Path::new("steps.xml"), &defines, true);
    let built = parsed.and_then(|parsed| build_scene(&parsed, &BuildOptions::default()));
    match built {
        Ok(scene) => scene,
        Err(error) => unreachable!("the scene of an experiment: {error}"),
    }
}

/// A film of so many samples; nothing if it cannot be made.
pub(super) fn rendered(scene: &Scene, samples: u32) -> Option<Film> {
    let options = RenderOptions {
        goal: Goal::Samples(samples),
        seed: 1,
        first_sample: 0,
        adaptive: false,
    };
    let options = MutationsPerPixel::of(scene).groups(&options).ok()?;
    render_film(scene, &options, AovSet::NONE).ok()
}

/// Mean of (I - R)^2 / (R^2 + 0.01) over pixels and channels, without the worst 0.1 %.
fn error(film: &Film, reference: &Film) -> f64 {
    let (image, reference) = (film.mean(), reference.mean());
    let mut errors: Vec<f64> = image
        .iter()
        .flatten()
        .zip(reference.iter().flatten())
        .map(|(i, r)| (i - r).powi(2) / (r * r + 0.01))
        .collect();
    errors.sort_by(f64::total_cmp);
    errors.truncate(errors.len() - errors.len() / 1000);
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// Share of the half-vector mutations that were accepted.
fn acceptance(film: &Film) -> f64 {
    let counts = film.chain_counts().iter();
    counts
        .filter(|(name, _)| *name == "half-vector")
        .map(|(_, counts)| counts.accepted as f64 / counts.proposed.max(1) as f64)
        .sum()
}

/// Runs the experiment.
pub fn run(quick: bool) -> Report {
    let mut scene = scene(if quick { [24, 16] } else { [96, 64] });
    scene.settings.kind = integrator_kind::BIDIRECTIONAL;
    let mut report = Report {
        text: String::new(),
        plots: vec![],
        figures: vec![],
    };
    let Some(reference) = rendered(&scene, if quick { 512 } else { 2048 }) else {
        return report;
    };
    scene.settings.kind = integrator_kind::VEACH_MLT;
    let usual = ChainSettings {
        lens_weight: 0.0,
        caustic_weight: 0.0,
        multi_chain_weight: 0.0,
        half_vector_weight: 1.0,
        half_vector_flags: half_vector_flag::ORIGINAL,
        mutations: MUTATIONS,
        direct_samples: 0,
        ..ChainSettings::DEFAULT
    };
    let mut measure = |step: f32, flags: u32| {
        scene.settings.chains = ChainSettings {
            half_vector_step: step,
            half_vector_flags: usual.half_vector_flags | flags,
            ..usual
        };
        match rendered(&scene, MUTATIONS) {
            Some(film) => [acceptance(&film), error(&film, &reference)],
            None => [0.0; 2],
        }
    };
    let text = &mut report.text;
    let _ = writeln!(
        text,
        "half-vector mutations of whole paths, {MUTATIONS} per pixel:\n\n  {:<38}{:>10}  {:>10}",
        "mean step", "accepted", "error"
    );
    let mut line = |name: String, [accepted, error]: [f64; 2]| {
        let _ = writeln!(
            text,
            "  {name:<38}{:>8.1} %  {error:>10.4}",
            100.0 * accepted
        );
        report.figures.push((format!("{name}: accepted"), accepted));
        report.figures.push((format!("{name}: error"), error));
    };
    let equal = half_vector_flag::EQUAL_STEPS | half_vector_flag::UNSTRATIFIED;
    let mut fixed = vec![];
    let steps: &[f32] = if quick {
        &[0.001, 0.1]
    } else {
        &[0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3]
    };
    for &step in steps {
        // The mean of |step| of one axis is gamma / sqrt(pi) for a roughness of one.
        let found = measure(step * std::f32::consts::PI.sqrt(), equal);
        line(format!("{step}"), found);
        fixed.push((f64::from(step), found));
    }
    let mut stepped = vec![];
    for (name, flags) in [
        ("from roughness", half_vector_flag::UNSTRATIFIED),
        ("from roughness, over the image", 0),
    ] {
        let found = measure(usual.half_vector_step, flags);
        line(name.to_string(), found);
        stepped.push((name, found));
    }
    for (title, scale, value) in [
        ("Acceptance over the step", Scale::Linear, 0),
        ("Error over the step", Scale::Logarithmic, 1),
    ] {
        let points = |y: f64| fixed.iter().map(|(x, _)| (*x, y)).collect();
        let mut series = vec![Series {
            label: "the same step everywhere".into(),
            mark: Mark::Line,
            colour: 0,
            points: fixed.iter().map(|(x, y)| (*x, y[value])).collect(),
        }];
        series.extend(stepped.iter().enumerate().map(|(i, (name, y))| Series {
            label: (*name).into(),
            mark: Mark::Dashed,
            colour: i + 1,
            points: points(y[value]),
        }));
        report.plots.push(Plot {
            title: title.into(),
            axes: [
                "mean step".into(),
                ["share", "relative error"][value].into(),
            ],
            scales: [Scale::Logarithmic, scale],
            series,
        });
    }
    report
}
