//! `halflight compare`: how much an image differs from a reference.

use super::output_file;
use crate::atomic_file::WriteError;
use crate::compare::comparison::{CompareError, Comparison, ErrorMap, Metric, Options};
use crate::compare::heatmap;
use crate::compare::metrics::ztest::{LevelResult, Settings};
use crate::image::png_output::write_png_bytes;
use crate::image::{ImageError, read_exr};
use crate::say::{print, print_line};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Compare an image with a reference.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// The image, an OpenEXR file.
    #[arg(value_name = "IMAGE.exr")]
    pub image: PathBuf,
    /// What it should look like, an OpenEXR file of the same size.
    #[arg(value_name = "REFERENCE.exr")]
    pub reference: PathBuf,
    /// Write a map of the error.
    #[arg(long, value_name = "OUT.png")]
    pub heatmap: Option<PathBuf>,
    /// Error that the map shows.
    #[arg(long, value_enum, default_value_t, value_name = "ERROR")]
    pub heatmap_of: ErrorMap,
    /// Exit with code 1 if the metric is above the value (mse, relative-mse, trimmed-relative-mse,
    /// reference-variance, residual-rms, cie76, flip, hdr-flip, z-test, non-finite; the z-test rejects above 1).
    #[arg(long, value_name = "METRIC=VALUE", value_parser = parse_threshold)]
    pub fail_above: Vec<(Metric, f64)>,
    /// Exit with code 1 if the metric is below the value (psnr, ssim).
    #[arg(long, value_name = "METRIC=VALUE", value_parser = parse_threshold)]
    pub fail_below: Vec<(Metric, f64)>,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
    /// Probability of a false alarm: that the z-test reports a difference between images of the same radiance.
    #[arg(long, default_value_t = Settings::default().false_alarm_rate, value_name = "P", value_parser = parse_rate)]
    pub false_alarm_rate: f64,
    /// Share of the radiance that the z-test never rejects.
    #[arg(long, default_value_t = Settings::default().relative_floor, value_name = "SHARE", value_parser = parse_share)]
    pub relative_floor: f64,
    /// Independent runs from which the reference's variance comes [default: its samples per pixel, or 16].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    pub reference_runs: Option<u32>,
    /// Samples per pixel of the reference [default: those of its samples layer].
    #[arg(long, value_name = "N", value_parser = parse_share)]
    pub reference_spp: Option<f64>,
}

/// Why there is no reference variance.
const NO_VARIANCE: &str = "the reference has no variance layer";

/// Why images were not compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareCommandError {
    /// An image could not be read.
    #[error(transparent)]
    Read(#[from] ImageError),
    /// The images do not compare.
    #[error("{image} and {reference}: {source}")]
    Compare {
        /// The image.
        image: String,
        /// The reference.
        reference: String,
        /// Why.
        source: CompareError,
    },
    /// The heatmap could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// What cannot be written.
    #[error("{0}")]
    Output(String),
    /// The numbers could not be printed.
    #[error(transparent)]
    Print(#[from] std::io::Error),
    /// A threshold on a metric that these images do not have.
    #[error("there is no {metric} of these images: {why}")]
    NoMetric {
        /// The metric.
        metric: Metric,
        /// Why not.
        why: String,
    },
    /// A threshold on the wrong side.
    #[error("{metric}: larger is {}; use {} instead", if metric.larger_is_better() { "better" } else { "worse" },
        if metric.larger_is_better() { "--fail-below" } else { "--fail-above" })]
    WrongSide {
        /// The metric.
        metric: Metric,
    },
}

/// Runs the command: prints the metrics; the exit code is 1 if a threshold is exceeded.
///
/// # Errors
/// If an image cannot be read, the images do not compare, or the heatmap cannot be written.
pub fn run(args: &CompareArgs) -> Result<ExitCode, CompareCommandError> {
    check_sides(args)?;
    if let Some(path) = &args.heatmap {
        let inputs = [args.image.as_path(), args.reference.as_path()];
        output_file::check(path, &["png"], inputs).map_err(CompareCommandError::Output)?;
    }
    let (image, reference) = (read_exr(&args.image)?, read_exr(&args.reference)?);
    let (image_name, reference_name) = (
        args.image.display().to_string(),
        args.reference.display().to_string(),
    );
    let options = Options {
        ztest: Settings {
            false_alarm_rate: args.false_alarm_rate,
            relative_floor: args.relative_floor,
        },
        reference_runs: args.reference_runs,
        reference_spp: args.reference_spp,
    };
    let comparison = Comparison::new(
        (&image_name, &image),
        (&reference_name, &reference),
        &options,
    )
    .map_err(|source| CompareCommandError::Compare {
        image: image_name.clone(),
        reference: reference_name.clone(),
        source,
    })?;
    let failures = failures(args, &comparison)?;
    if let Some(path) = &args.heatmap {
        let map = comparison.error_map(args.heatmap_of);
        let (width, height, bytes) = heatmap::render(&map, comparison.width, 1.0);
        write_png_bytes(path, width as u32, height as u32, &bytes)?;
    }
    if args.json {
        print_line(format_args!(
            "{:#}",
            to_json(&image_name, &reference_name, &comparison, &failures)
        ))?;
    } else {
        print(to_table(
            &image_name,
            &reference_name,
            &comparison,
            &failures,
            args.false_alarm_rate,
        ))?;
    }
    Ok(if failures.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn check_sides(args: &CompareArgs) -> Result<(), CompareCommandError> {
    let above = args.fail_above.iter().map(|(metric, _)| (metric, false));
    let below = args.fail_below.iter().map(|(metric, _)| (metric, true));
    match above
        .chain(below)
        .find(|(metric, side)| metric.larger_is_better() != *side)
    {
        Some((&metric, _)) => Err(CompareCommandError::WrongSide { metric }),
        None => Ok(()),
    }
}

/// What exceeds its threshold, in words.
fn failures(
    args: &CompareArgs,
    comparison: &Comparison,
) -> Result<Vec<String>, CompareCommandError> {
    let mut failures = Vec::new();
    for &(metric, limit) in args.fail_above.iter().chain(&args.fail_below) {
        let value = comparison
            .value(metric)
            .ok_or_else(|| CompareCommandError::NoMetric {
                metric,
                why: match metric {
                    Metric::ZTest => comparison.no_ztest.to_owned(),
                    Metric::ReferenceVariance => NO_VARIANCE.to_owned(),
                    _ => "they are too small".to_owned(),
                },
            })?;
        // Written so that a value that is no number fails.
        let (good, word) = if metric.larger_is_better() {
            (value >= limit, "below")
        } else {
            (value <= limit, "above")
        };
        if !good {
            failures.push(format!("{metric} is {}, {word} {limit}", number(value)));
        }
    }
    Ok(failures)
}

fn to_table(
    image: &str,
    reference: &str,
    comparison: &Comparison,
    failures: &[String],
    false_alarm_rate: f64,
) -> String {
    let mut lines = vec![format!(
        "{image} against {reference}, {} x {} pixels",
        comparison.width, comparison.height
    )];
    for metric in Metric::ALL {
        let value = match (metric, comparison.value(metric), &comparison.ztest) {
            (Metric::ZTest, Some(severity), Some(outcome)) => format!(
                "{}: severity {} (differs above 1; false-alarm rate {false_alarm_rate})",
                if outcome.passes() {
                    "passes"
                } else {
                    "differs"
                },
                number(severity)
            ),
            (Metric::ZTest, None, _) => format!("none: {}", comparison.no_ztest),
            (_, Some(value), _) => number(value),
            (Metric::ReferenceVariance, None, _) => {
                format!("none: {NO_VARIANCE}")
            }
            (_, None, _) => "none: the images are too small".to_owned(),
        };
        lines.push(format!("  {metric:<22}{value}"));
    }
    if let Some(outcome) = &comparison.ztest {
        lines.push(format!(
            "  {:<22}mean z {}, |z| > 3 in {:.3} % of the values, noise correlation {}",
            "",
            number(outcome.mean_z),
            100.0 * outcome.share_above_3,
            number(outcome.correlation)
        ));
        for level in &outcome.levels {
            lines.push(format!(
                "  {:<22}{:<12} worst z {:>9} in {} at ({}, {}), severity {}",
                "",
                level_name(level),
                number(level.z),
                ["red", "green", "blue"][level.channel],
                level.x,
                level.y,
                number(level.severity())
            ));
        }
    }
    lines.extend(failures.iter().map(|failure| format!("FAILED: {failure}")));
    lines.join("\n") + "\n"
}

fn level_name(level: &LevelResult) -> String {
    match level.block {
        0 => "whole image".to_owned(),
        1 => "pixels".to_owned(),
        side => format!("{side} x {side}"),
    }
}

/// Five significant digits.
fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&digits) {
        return format!("{value:.4e}");
    }
    let fixed = format!("{value:.*}", (4.0 - digits).max(0.0) as usize);
    if fixed.contains('.') {
        fixed.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        fixed
    }
}

fn to_json(image: &str, reference: &str, comparison: &Comparison, failures: &[String]) -> Value {
    let metrics: serde_json::Map<String, Value> = comparison
        .values
        .iter()
        .map(|(metric, value)| (metric.name().to_owned(), json!(value)))
        .collect();
    let ztest = comparison.ztest.as_ref().map(|outcome| {
        let levels: Vec<Value> = outcome
            .levels
            .iter()
            .map(|l| {
                json!({ "level": level_name(l), "z": l.z, "x": l.x, "y": l.y, "channel": l.channel, "p": l.p,
                    "critical_p": l.critical_p, "severity": l.severity() })
            })
            .collect();
        json!({ "passes": outcome.passes(), "severity": outcome.severity(), "mean_z": outcome.mean_z,
            "share_above_3": outcome.share_above_3, "correlation": outcome.correlation, "levels": levels })
    });
    json!({
        "image": image,
        "reference": reference,
        "width": comparison.width,
        "height": comparison.height,
        "metrics": metrics,
        "z_test": ztest,
        "failures": failures,
    })
}

fn parse_threshold(text: &str) -> Result<(Metric, f64), String> {
    let (metric, value) = text.split_once('=').ok_or("a threshold is METRIC=VALUE")?;
    let value = value.parse().ok().filter(|v: &f64| !v.is_nan());
    Ok((
        metric.parse()?,
        value.ok_or_else(|| format!("\"{text}\": the value is no number"))?,
    ))
}

fn parse_rate(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|v| *v > 0.0 && *v < 1.0)
        .ok_or_else(|| "a number between 0 and 1".to_owned())
}

fn parse_share(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|v: &f64| *v >= 0.0 && v.is_finite())
        .ok_or_else(|| "a number, not negative".to_owned())
}
