//! `halflight image`: image files converted, put together, compared and measured.

use super::output_file;
use super::render_values::parse_exposure;
use super::scene_args::parse_numbers;
use crate::compare::heatmap;
use crate::film::luminance;
use crate::image::picture::Picture;
use crate::image::picture_output::{EXTENSIONS, ImageFormat, write_picture};
use crate::image::png_output::{Exposure, Look, ToneCurve, write_png_bytes};
use crate::say::{print, print_line};
use clap::{Args, Subcommand};
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

type AnyError = Box<dyn Error + Send + Sync>;

/// Convert, compare and measure image files.
#[derive(Args, Clone, Debug)]
pub struct ImageArgs {
    /// What to do.
    #[command(subcommand)]
    pub operation: Operation,
}

/// What can be done with images.
#[derive(Subcommand, Clone, Debug)]
pub enum Operation {
    /// Write an image, a part of it or a layer in another format
    Convert(ConvertArgs),
    /// Write an image minus another one
    Difference(DifferenceArgs),
    /// Write the mean of images
    Average(ManyArgs),
    /// Put crops of one image together
    Assemble(ManyArgs),
    /// Print the range, mean and spread of the values
    Statistics(StatisticsArgs),
    /// Show the luminance as colours, with a legend
    FalseColor(FalseColorArgs),
}

/// Where an image goes, and how it looks there.
#[derive(Args, Clone, Debug)]
pub struct OutputArgs {
    /// The image to write: .exr, .pfm, .hdr, .png or .jpg.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Exposure of a PNG or JPEG in stops, or "auto".
    #[arg(long, value_name = "EV", default_value = "0", value_parser = parse_exposure, allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// How a PNG or JPEG shows what is brighter than white.
    #[arg(long, value_enum, default_value_t)]
    pub tone: ToneCurve,
}

/// Arguments of a conversion.
#[derive(Args, Clone, Debug)]
pub struct ConvertArgs {
    /// The image.
    pub image: PathBuf,
    /// Layer of an OpenEXR file instead of its radiance, as albedo or samples.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// A part of it, in pixels of the whole image.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    pub crop: Option<[u32; 4]>,
    /// Where it goes.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of a difference.
#[derive(Args, Clone, Debug)]
pub struct DifferenceArgs {
    /// The image.
    pub image: PathBuf,
    /// What is taken from it.
    pub reference: PathBuf,
    /// Write absolute values; a PNG or JPEG shows no others.
    #[arg(long)]
    pub absolute: bool,
    /// Layer of OpenEXR files instead of their radiance.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Where it goes.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of what takes several images.
#[derive(Args, Clone, Debug)]
pub struct ManyArgs {
    /// The images.
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// Layer of OpenEXR files instead of their radiance.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Where the result goes.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of statistics.
#[derive(Args, Clone, Debug)]
pub struct StatisticsArgs {
    /// The image.
    pub image: PathBuf,
    /// Layer of an OpenEXR file instead of its radiance.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of false colours.
#[derive(Args, Clone, Debug)]
pub struct FalseColorArgs {
    /// The image.
    pub image: PathBuf,
    /// The picture.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// Layer of an OpenEXR file instead of its radiance.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Value of the last colour. Default: the largest of the image but for a thousandth of its pixels.
    #[arg(long, value_name = "VALUE", value_parser = parse_positive)]
    pub max: Option<f64>,
}

fn parse_crop(text: &str) -> Result<[u32; 4], String> {
    parse_numbers(text, &[','], "X,Y,WIDTH,HEIGHT")
}

fn parse_positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|v: &f64| *v > 0.0 && v.is_finite())
        .ok_or_else(|| "expected a number above zero".to_owned())
}

/// Runs the command.
///
/// # Errors
/// If an image cannot be read or written, or images do not go together.
pub fn run(args: &ImageArgs) -> Result<ExitCode, AnyError> {
    match &args.operation {
        Operation::Convert(args) => {
            let format = args.output.check([args.image.as_path()])?;
            let mut picture = Picture::load(&args.image, args.layer.as_deref())?;
            if let Some(crop) = args.crop {
                picture = picture.crop(crop)?;
            }
            args.output.write(format, &picture)?;
        }
        Operation::Difference(args) => {
            let format = args
                .output
                .check([args.image.as_path(), args.reference.as_path()])?;
            let load = |path: &Path| Picture::load(path, args.layer.as_deref());
            let is_absolute = args.absolute || !format.is_linear();
            let difference = |a: f32, b: f32| if is_absolute { (a - b).abs() } else { a - b };
            let picture = load(&args.image)?.combine(&load(&args.reference)?, difference)?;
            args.output.write(format, &picture)?;
        }
        Operation::Average(args) => {
            let (format, pictures) = args.load()?;
            args.output.write(format, &average(&pictures)?)?;
        }
        Operation::Assemble(args) => {
            let (format, pictures) = args.load()?;
            args.output.write(format, &Picture::assemble(&pictures)?)?;
        }
        Operation::Statistics(args) => {
            let picture = Picture::load(&args.image, args.layer.as_deref())?;
            print_statistics(&picture, args.json)?;
        }
        Operation::FalseColor(args) => {
            output_file::check(&args.output, &["png"], [args.image.as_path()])?;
            let picture = Picture::load(&args.image, args.layer.as_deref())?;
            let values: Vec<f64> = luminances(&picture);
            let largest = args.max.unwrap_or_else(|| {
                let mut sorted: Vec<f64> =
                    values.iter().copied().filter(|v| v.is_finite()).collect();
                sorted.sort_unstable_by(f64::total_cmp);
                legible(percentile(&sorted, 0.999))
            });
            let width = picture.window.width as usize;
            let (width, height, bytes) = heatmap::render(&values, width, largest);
            write_png_bytes(&args.output, width as u32, height as u32, &bytes)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl OutputArgs {
    /// Makes sure that it can be written.
    fn check<'a>(&self, inputs: impl IntoIterator<Item = &'a Path>) -> Result<ImageFormat, String> {
        output_file::check(&self.output, &EXTENSIONS, inputs)?;
        // The check knows the same names.
        ImageFormat::of_file(&self.output).ok_or_else(|| "the format is not known".to_owned())
    }

    fn write(&self, format: ImageFormat, picture: &Picture) -> Result<(), AnyError> {
        let look = Look {
            exposure: self.exposure,
            curve: self.tone,
        };
        Ok(write_picture(&self.output, format, picture, look)?)
    }
}

impl ManyArgs {
    fn load(&self) -> Result<(ImageFormat, Vec<Picture>), AnyError> {
        let format = self
            .output
            .check(self.images.iter().map(PathBuf::as_path))?;
        let load = |path: &PathBuf| Picture::load(path, self.layer.as_deref());
        let pictures: Result<Vec<_>, _> = self.images.iter().map(load).collect();
        Ok((format, pictures?))
    }
}

/// The mean of pictures, each with the same weight.
fn average(pictures: &[Picture]) -> Result<Picture, AnyError> {
    let (first, rest) = pictures.split_first().ok_or("there are no images")?;
    let mut mean = first.clone();
    for (i, picture) in rest.iter().enumerate() {
        let weight = 1.0 / (i as f32 + 2.0);
        mean = mean.combine(picture, |mean, v| mean + (v - mean) * weight)?;
    }
    Ok(mean)
}

fn luminances(picture: &Picture) -> Vec<f64> {
    let pixels = picture.pixels.iter();
    pixels.map(|p| luminance(p.map(f64::from))).collect()
}

/// A value of a sorted list that so much of it is below.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let index = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(index).copied().unwrap_or(0.0)
}

/// The next value above with two digits, which a legend can show; one for what is not positive.
fn legible(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    // Through text, so that it is the shortest number of that value.
    let digits = 10f64.powf(value.log10().floor() - 1.0);
    let rounded = (value / digits).ceil() * digits;
    format!("{rounded:.1e}").parse().unwrap_or(rounded)
}

/// A number of at most eleven characters.
fn in_column(value: f64) -> String {
    let fixed = format!("{value:.5}");
    if fixed.len() <= 11 && (value == 0.0 || value.abs() >= 1e-4) {
        fixed
    } else {
        format!("{value:.3e}")
    }
}

/// Prints what there is to know about the channels and the luminance.
fn print_statistics(picture: &Picture, is_json: bool) -> Result<(), AnyError> {
    let channel = |c: usize| picture.pixels.iter().map(|p| f64::from(p[c])).collect();
    let lists: [(&str, Vec<f64>); 4] = [
        ("red", channel(0)),
        ("green", channel(1)),
        ("blue", channel(2)),
        ("luminance", luminances(picture)),
    ];
    let ([w, h], window) = (picture.full_size, picture.window);
    let mut text = format!(
        "{} x {} pixels at ({}, {}) of {w} x {h}\n{:<11}{:>12}{:>12}{:>12}{:>12}{:>12}{:>12}\n",
        window.width,
        window.height,
        window.origin[0],
        window.origin[1],
        "",
        "least",
        "median",
        "99 %",
        "most",
        "mean",
        "deviation"
    );
    let mut values = serde_json::Map::new();
    for (name, list) in lists {
        let mut sorted: Vec<f64> = list.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len().max(1) as f64;
        let mean = sorted.iter().sum::<f64>() / n;
        let deviation = (sorted.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let of = [0.0, 0.5, 0.99, 1.0].map(|share| percentile(&sorted, share));
        let not_finite = list.len() - sorted.len();
        let negative = sorted.iter().filter(|v| **v < 0.0).count();
        text.push_str(&format!("{name:<11}"));
        for value in of.iter().chain(&[mean, deviation]) {
            text.push_str(&format!("{:>12}", in_column(*value)));
        }
        if not_finite + negative > 0 {
            text.push_str(&format!("  {not_finite} not finite, {negative} negative"));
        }
        text.push('\n');
        values.insert(
            name.to_owned(),
            json!({ "least": of[0], "median": of[1], "percentile_99": of[2], "most": of[3], "mean": mean,
                "deviation": deviation, "not_finite": not_finite, "negative": negative }),
        );
    }
    if is_json {
        let all = json!({ "width": window.width, "height": window.height, "origin": window.origin,
            "full_size": picture.full_size, "values": values });
        print_line(format_args!("{all:#}"))?;
    } else {
        print(text)?;
    }
    Ok(())
}
