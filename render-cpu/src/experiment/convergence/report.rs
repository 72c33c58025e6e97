//! The numbers of a comparison as a table, as diagrams and as JSON.

use super::errors::{Errors, Reference};
use super::{Outcome, Point};
use crate::experiment::fit::log_slope;
use crate::plot::{Mark, Plot, Scale, Series};
use serde_json::{Value, json};
use std::fmt::Write;

/// What was compared.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name of the scene.
    pub scene: String,
    /// Width and height of the images.
    pub size: [u32; 2],
    /// The reference's file, if there is one.
    pub reference: Option<String>,
    /// The reference's relative variance, if it is known.
    pub reference_variance: Option<f64>,
    /// The budget of each algorithm, in words.
    pub budget: String,
}

impl Subject {
    /// The report with the data of a reference.
    pub fn with_reference(mut self, name: &str, reference: &Reference) -> Subject {
        self.reference = Some(name.to_owned());
        self.reference_variance = reference.relative_variance;
        self
    }
}

/// An error of a point of a curve.
type Measure = fn(&Errors) -> f64;

/// Slope of an error over processor time, in logarithms: -1 for the squared error of independent samples. None where fewer
/// than two errors are positive.
pub fn slope(curve: &[Point], measure: Measure) -> Option<f64> {
    let points = positive(curve, measure);
    (points.len() > 1).then(|| log_slope(&points))
}

fn positive(curve: &[Point], measure: Measure) -> Vec<(f64, f64)> {
    let points = curve.iter().map(|p| (p.seconds, measure(&p.errors)));
    points.filter(|&(x, y)| x > 0.0 && y > 0.0).collect()
}

/// Relative MSE, less the reference's variance where that is known.
fn relative_mse(errors: &Errors) -> f64 {
    errors.less_reference.map_or(errors.relative_mse, |e| e[0])
}

/// The same without the worst pixels.
fn trimmed(errors: &Errors) -> f64 {
    errors.less_reference.map_or(errors.trimmed, |e| e[1])
}

/// A table of the last images.
pub fn table(subject: &Subject, outcomes: &[Outcome]) -> String {
    let [width, height] = subject.size;
    let against = match (&subject.reference, subject.reference_variance) {
        (Some(name), Some(v)) => format!("against {name}, whose relative variance is {v:.4}"),
        (Some(name), None) => format!("against {name}, whose variance is not known"),
        (None, _) => "by pairs of independent runs".to_owned(),
    };
    let mut text = format!(
        "{}, {width} x {height} pixels, {} each, {against}\n",
        subject.scene, subject.budget
    );
    let columns = [
        "seconds",
        "samples",
        "rel. MSE",
        "trimmed",
        "less ref.",
        "tr. less",
        "res. RMS",
        "sigma",
        "CIE76",
        "SSIM",
        "FLIP",
        "slope",
    ];
    let _ = write!(text, "  {:<10}", "");
    for column in columns {
        let _ = write!(text, "{column:>10}");
    }
    text.push('\n');
    for outcome in outcomes {
        let Some(last) = outcome.curve.last() else {
            continue;
        };
        let e = &last.errors;
        let less = |i: usize| e.less_reference.map_or("-".to_owned(), |l| number(l[i]));
        let cells = [
            format!("{:.1}", last.seconds),
            last.samples.to_string(),
            number(e.relative_mse),
            number(e.trimmed),
            less(0),
            less(1),
            number(e.residual_rms),
            number(e.sigma),
            number(outcome.shown.cie76),
            outcome.shown.ssim.map_or("-".to_owned(), number),
            number(outcome.shown.flip),
            slope(&outcome.curve, trimmed).map_or("-".to_owned(), |s| format!("{s:.2}")),
        ];
        let _ = write!(text, "  {:<10}", outcome.name);
        for cell in cells {
            let _ = write!(text, "{cell:>10}");
        }
        text.push('\n');
    }
    text
}

/// Three significant digits.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-4..1e5).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let digits = if magnitude > 0.0 {
        (2.0 - magnitude.log10().floor()).max(0.0)
    } else {
        0.0
    };
    format!("{value:.*}", digits as usize)
}

/// Relative MSE over processor time, with all pixels and without the worst.
pub fn plots(subject: &Subject, outcomes: &[Outcome]) -> Vec<Plot> {
    let less = match subject.reference_variance {
        Some(_) => ", less the reference's variance",
        None => "",
    };
    let measures: [(&str, Measure); 2] = [
        ("all pixels", relative_mse),
        ("without the worst 0.1 % of the pixels", trimmed),
    ];
    measures
        .map(|(which, measure)| Plot {
            title: format!("{}: {which}{less}", subject.scene),
            axes: [
                "processor time in seconds".to_owned(),
                "relative mean squared error".to_owned(),
            ],
            scales: [Scale::Logarithmic; 2],
            series: outcomes
                .iter()
                .enumerate()
                .flat_map(|(colour, outcome)| {
                    let label = match slope(&outcome.curve, measure) {
                        Some(slope) => format!("{}, slope {slope:.2}", outcome.name),
                        None => outcome.name.clone(),
                    };
                    let series = |label: String, mark: Mark| Series {
                        label,
                        mark,
                        colour,
                        points: positive(&outcome.curve, measure),
                    };
                    [
                        series(label, Mark::Line),
                        series(String::new(), Mark::Points),
                    ]
                })
                .collect(),
        })
        .into()
}

/// All numbers.
pub fn json(subject: &Subject, outcomes: &[Outcome]) -> Value {
    let point = |p: &Point| {
        json!({ "seconds": p.seconds, "samples": p.samples, "relative_mse": p.errors.relative_mse,
            "trimmed": p.errors.trimmed,
            "relative_mse_less_reference": p.errors.less_reference.map(|l| l[0]),
            "trimmed_less_reference": p.errors.less_reference.map(|l| l[1]),
            "residual_rms": p.errors.residual_rms, "sigma": p.errors.sigma })
    };
    let integrators: Vec<Value> = outcomes
        .iter()
        .map(|o| {
            json!({ "integrator": o.name, "curve": o.curve.iter().map(point).collect::<Vec<_>>(),
                "cie76": o.shown.cie76, "ssim": o.shown.ssim, "flip": o.shown.flip,
                "slope": slope(&o.curve, relative_mse), "slope_trimmed": slope(&o.curve, trimmed) })
        })
        .collect();
    json!({
        "scene": subject.scene,
        "width": subject.size[0],
        "height": subject.size[1],
        "budget": subject.budget,
        "reference": subject.reference,
        "reference_relative_variance": subject.reference_variance,
        "integrators": integrators,
    })
}
