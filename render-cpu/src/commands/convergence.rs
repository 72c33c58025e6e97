//! `halflight experiment convergence`: algorithms on one scene for the same processor time.

use super::output_file;
use super::race_setup::{load_for_each, read_reference, show_share};
use super::render_values::{parse_duration, parse_exposure};
use super::scene_args::{SceneArgs, build_accel, parse_numbers};
use crate::experiment::convergence::errors::Reference;
use crate::experiment::convergence::race::Budget;
use crate::experiment::convergence::report::{Subject, json, number, plots, table};
use crate::experiment::convergence::sheet::{Column, draw, most_different_windows};
use crate::experiment::convergence::{Outcome, Setup, run as compare};
use crate::image::png_output::{Exposure, exposure_scale, tone_map, write_png_bytes};
use crate::plot::picture::{Picture, Window};
use crate::plot::write_png;
use crate::processor::set_threads;
use crate::say::{print, print_line};
use clap::Args;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Compare algorithms on a scene: images of equal processor time against a reference, error over time.
#[derive(Args, Clone, Debug)]
pub struct ConvergenceArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Algorithms to compare, as path,bdpt.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        required = true,
        conflicts_with = "integrator"
    )]
    pub integrators: Vec<String>,
    /// Processor time for each, of all threads together, as in 90s or 10m.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "60s", conflicts_with = "spp")]
    pub time: Duration,
    /// Samples per pixel for each, instead of a time: the same numbers every time.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Image to measure by, an OpenEXR file; without it, each algorithm is measured by a second run of its own.
    #[arg(long, value_name = "R.exr")]
    pub reference: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Number of threads. Default: one per processor.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Draw error over time.
    #[arg(short, long, value_name = "PLOT.png")]
    pub output: Option<PathBuf>,
    /// Draw the images side by side, with parts of them enlarged.
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// A part to enlarge on the sheet; may be repeated. Default: where the algorithms differ most.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_window, requires = "sheet")]
    pub inset: Vec<Window>,
    /// Exposure of the sheet in stops, or "auto".
    #[arg(long, value_name = "EV", default_value = "0", value_parser = parse_exposure, allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

fn parse_window(text: &str) -> Result<Window, String> {
    parse_numbers(text, &[','], "X,Y,WIDTH,HEIGHT")
}

/// Runs the command.
///
/// # Errors
/// What keeps the comparison from being made or written, in one sentence.
pub fn run(args: &ConvergenceArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let inputs = || args.reference.iter().chain([&args.scene.scene]);
    for path in args.output.iter().chain(&args.sheet) {
        output_file::check(path, &["png"], inputs().map(PathBuf::as_path))?;
    }
    let outputs = [(&args.output, "the diagram"), (&args.sheet, "the sheet")];
    let outputs = outputs.into_iter();
    let outputs = outputs.filter_map(|(path, what)| Some((path.as_deref()?, what)));
    output_file::check_distinct(&outputs.collect::<Vec<_>>())?;
    set_threads(args.threads)?;
    let (mut scene, integrators) = load_for_each(&args.scene, &args.integrators)?;
    let size = scene.tables.camera.crop_size;
    if let Some([x, y, w, h]) = args.inset.iter().find(|w| !is_inside(**w, size)) {
        return Err(format!(
            "--inset {x},{y},{w},{h} is not inside of {} x {} pixels",
            size[0], size[1]
        )
        .into());
    }
    let name = args.reference.as_ref().map(|p| p.display().to_string());
    let reference = read_reference(args.reference.as_deref(), size)?;
    let (budget, words) = match args.spp {
        Some(n) => (Budget::Samples(n), format!("{n} samples per pixel")),
        None => {
            let seconds = args.time.as_secs_f64();
            (
                Budget::Time(args.time),
                format!("{seconds} s of processor time"),
            )
        }
    };
    let mut subject = Subject {
        scene: file_stem(&args.scene.scene),
        size,
        reference: None,
        reference_variance: None,
        budget: words,
    };
    if let (Some(name), Some(reference)) = (&name, &reference) {
        subject = subject.with_reference(name, reference);
    }
    let accel = build_accel(&scene);
    let setup = Setup {
        integrators: &integrators,
        budget,
        seed: args.seed,
        reference: reference.as_ref(),
    };
    let outcomes = compare(&mut scene, &accel, &setup, |share| show_share(quiet, share))?;
    if args.json {
        print_line(format_args!("{:#}", json(&subject, &outcomes)))?;
    } else {
        print(table(&subject, &outcomes))?;
    }
    if let Some(path) = &args.output {
        write_png(path, &plots(&subject, &outcomes))?;
    }
    if let Some(path) = &args.sheet {
        write_sheet(args, path, size, reference.as_ref(), &outcomes)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn file_stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn is_inside([x, y, w, h]: Window, [width, height]: [u32; 2]) -> bool {
    let fits = |from: u32, length: u32, all: u32| {
        length > 0 && u64::from(from) + u64::from(length) <= u64::from(all)
    };
    fits(x, w, width) && fits(y, h, height)
}

fn write_sheet(
    args: &ConvergenceArgs,
    path: &Path,
    size: [u32; 2],
    reference: Option<&Reference>,
    outcomes: &[Outcome],
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let first = match reference {
        Some(reference) => &reference.image.pixels,
        None => &outcomes[0].image.pixels,
    };
    // The same for all, by the first.
    let exposure = Exposure::Stops(exposure_scale(first, args.exposure).log2() as f32);
    let picture = |pixels: &[[f64; 3]]| Picture::new(size[0], size[1], tone_map(pixels, exposure));
    let mut columns = Vec::new();
    if let Some(reference) = reference {
        columns.push(Column {
            label: ["reference".to_owned(), String::new()],
            picture: picture(&reference.image.pixels),
        });
    }
    for outcome in outcomes {
        let line = outcome.curve.last().map(|last| {
            format!(
                "{} samples, relative MSE {}",
                last.samples,
                number(last.errors.relative_mse)
            )
        });
        columns.push(Column {
            label: [outcome.name.clone(), line.unwrap_or_default()],
            picture: picture(&outcome.image.pixels),
        });
    }
    let insets = if args.inset.is_empty() {
        most_different_windows(outcomes, size)
    } else {
        args.inset.clone()
    };
    let canvas = draw(&columns, &insets)?;
    let [width, height] = canvas.size();
    write_png_bytes(path, width, height, canvas.rgb())?;
    Ok(())
}
