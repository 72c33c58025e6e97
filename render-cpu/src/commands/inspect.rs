//! `halflight inspect`: tools that look at the light of a scene.

use super::inspect_page::PageArgs;
use super::output_file;
use super::path_args::PathArgs;
use super::scene_args::{SceneArgs, build_accel, parse_numbers};
use super::volume_args::VolumeArgs;
use crate::expression::{PartsRequest, PathParts};
use crate::film::aov::AovSet;
use crate::film::luminance;
use crate::image::png_output::{Exposure, tone_map, write_png_bytes};
use crate::inspect::paths::{Places, picture};
use crate::inspect::spherical_plot::{Probe, SphericalPlot};
use crate::inspect::{ColorScale, false_color};
use crate::plot::canvas::Canvas;
use crate::processor::set_threads;
use crate::render::{Goal, RenderOptions, render_film};
use crate::say::{note, print_line};
use clap::{Args, ValueEnum};
use glam::{DVec3, Vec3};
use halflight_kernel::scene::{SceneView, Traverse};
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What a tool shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tool {
    /// The image in colours that tell its numbers.
    FalseColor,
    /// The radiance that arrives at a point from all around.
    SphericalPlot,
    /// Bundles of the image's paths as arrows.
    Paths,
    /// A box of virtual medium that shows the light passing through.
    Volume,
}

/// What false colours tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quantity {
    /// Towards the sensor.
    Radiance,
    /// On the surfaces that the sensor sees.
    Irradiance,
}

/// Look at the light of a scene.
#[derive(Args, Clone, Debug)]
pub struct InspectArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// What to look with. Without one, all of them are in a page for a browser, OUT.html.
    #[arg(long, value_enum, value_name = "TOOL")]
    pub tool: Option<Tool>,
    /// The picture, or the page.
    #[arg(short, long, value_name = "OUT.png|OUT.html")]
    pub output: PathBuf,
    /// Nothing but the paths that an expression matches.
    #[arg(long, value_name = "EXPRESSION")]
    pub only: Option<String>,
    /// Samples per pixel or direction. Default: 64.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Number of threads. Default: one per processor.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What false colours tell.
    #[arg(long, value_enum, value_name = "NAME", default_value = "radiance")]
    pub quantity: Quantity,
    /// Equal ratios of values are equal steps of colour and, in a spherical plot, of distance.
    #[arg(long)]
    pub log: bool,
    /// Value of the first colour. Default: 0, or a ten-thousandth of the last with --log.
    #[arg(long, value_name = "VALUE", value_parser = parse_value)]
    pub min: Option<f64>,
    /// Value of the last colour, and of the rim of a spherical plot. Default: the largest but for a thousandth.
    #[arg(long, value_name = "VALUE", value_parser = parse_value)]
    pub max: Option<f64>,
    /// Where a spherical plot is taken: a point in free space.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, conflicts_with = "pixel")]
    pub at: Option<[f32; 3]>,
    /// Where a spherical plot is taken: the surface that a pixel sees.
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pub pixel: Option<[u32; 2]>,
    /// Rows of directions of a spherical plot; there are twice as many around.
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(2..=1024))]
    pub rows: u32,
    /// From where a spherical plot is seen, in the frame of its axes.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, default_value = "1,-2,1.2")]
    pub view: [f32; 3],
    /// Recorded paths.
    #[command(flatten)]
    pub path: PathArgs,
    /// The box of medium.
    #[command(flatten)]
    pub volume: VolumeArgs,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print numbers as JSON: the scale and, of a spherical plot, the integral; of paths, the tree of clusters.
    #[arg(long)]
    pub json: bool,
}

impl InspectArgs {
    /// Files that are read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let scene = [self.scene.scene.as_path()].into_iter();
        let paths = self.path.paths.as_deref();
        scene.chain(paths).chain(self.page.image.as_deref())
    }

    /// Where a spherical plot is taken, if that is said.
    ///
    /// # Errors
    /// If the pixel sees no surface.
    pub(super) fn probe<T: Traverse>(
        &self,
        view: &SceneView<'_, T>,
    ) -> Result<Option<Probe>, String> {
        match (self.at, self.pixel) {
            (Some(at), _) => Ok(Some(Probe::free(Vec3::from_array(at)))),
            (None, Some(pixel)) => match Probe::of_pixel(view, pixel) {
                Some(probe) => Ok(Some(probe)),
                None => Err(format!("pixel {},{} sees no surface", pixel[0], pixel[1])),
            },
            (None, None) => Ok(None),
        }
    }

    /// Of the image that a tool looks at.
    pub(super) fn options(&self) -> RenderOptions {
        RenderOptions {
            goal: Goal::Samples(self.spp),
            seed: self.seed,
            first_sample: 0,
            adaptive: false,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// What keeps the picture from being made or written, in one sentence.
pub fn run(args: &InspectArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let name = args.output.display();
    let Some(tool) = args.tool else {
        return super::inspect_page::run(args, quiet);
    };
    if let (Some(min), Some(max)) = (args.min, args.max)
        && min >= max
    {
        return Err("--min must be below --max".into());
    }
    output_file::check(&args.output, &["png"], args.inputs())?;
    if tool == Tool::SphericalPlot && args.at.is_none() && args.pixel.is_none() {
        return Err("--tool spherical-plot needs a place: --at X,Y,Z or --pixel X,Y".into());
    }
    set_threads(args.threads)?;
    let mut scene = args.scene.load()?;
    let is_measured = tool != Tool::FalseColor || args.quantity == Quantity::Irradiance;
    if is_measured {
        // These are measured by path tracing, whatever the scene's image is made by.
        scene.settings.kind = halflight_kernel::transport::integrator_kind::PATH;
    }
    let request = PartsRequest {
        layers: Vec::new(),
        only: args.only.clone(),
    };
    // Arrows of some paths stand over the image of all.
    let parts = PathParts::new(&request, &scene.tables.view(), &scene.names)?;
    if !matches!(tool, Tool::Paths | Tool::Volume) {
        scene.divide(&request)?;
    }
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    let scale = |values: &[f64]| ColorScale::of(values, args.min, args.max, args.log);
    let mut summary = String::new();
    let (canvas, numbers) = match tool {
        Tool::FalseColor => {
            let (film, quantity) = match args.quantity {
                Quantity::Irradiance => (
                    false_color::irradiance_film(&scene, args.spp, args.seed)?,
                    "irradiance, W/m²",
                ),
                Quantity::Radiance => {
                    let film = render_film(&scene, &args.options(), AovSet::NONE)?;
                    (film, "radiance, W/(m² sr)")
                }
            };
            let mean = film.mean();
            let values: Vec<f64> = mean.iter().map(|p| luminance(*p)).collect();
            let scale = scale(&values);
            let canvas = false_color::draw(&mean, film.width(), |_| scale, quantity)?;
            let average = values.iter().sum::<f64>() / values.len() as f64;
            (
                canvas,
                json!({"from": scale.least, "to": scale.most, "mean": average}),
            )
        }
        Tool::SphericalPlot => {
            let accel = build_accel(&scene);
            let tables = scene.tables.view();
            let traverse = accel.traverse(tables);
            let view = SceneView {
                tables,
                traverse: &traverse,
            };
            let probe = args.probe(&view)?.ok_or("a spherical plot needs a place")?;
            let expressions = scene.parts.view();
            let plot = SphericalPlot::measure(
                &view,
                &scene.settings,
                expressions.as_ref(),
                &probe,
                args.rows as usize,
                args.spp,
                args.seed,
            );
            let values: Vec<f64> = plot.radiance.iter().map(|p| luminance(*p)).collect();
            let scale = scale(&values);
            let [x, y, z] = probe.position.to_array();
            let title = format!("at {x:.3}, {y:.3}, {z:.3}");
            let from = DVec3::from_array(args.view.map(f64::from));
            if !(from.length() > 0.0) {
                return Err("--view: expected a direction".into());
            }
            let canvas = plot.draw(scale, 480, from, &title)?;
            let integral = plot.integral();
            (
                canvas,
                json!({"from": scale.least, "to": scale.most, "position": [x, y, z], "integral": integral}),
            )
        }
        Tool::Paths => {
            let accel = build_accel(&scene);
            let tables = scene.tables.view();
            let traverse = accel.traverse(tables);
            let view = SceneView {
                tables,
                traverse: &traverse,
            };
            let record = args.path.load(&view, &scene, &parts, args.spp, args.seed)?;
            let film = render_film(&scene, &args.options(), AovSet::NONE)?;
            let places = Places::of(&record);
            let tree = args.path.tree(&record);
            let groups = args.path.groups(&record, &tree, &places);
            let canvas = picture::draw(&view, &film.mean(), &record, &places, &groups)?;
            let bundles: usize = groups.iter().map(|g| g.bundles.len()).sum();
            summary = format!("{} paths as {bundles} bundles", record.paths.len());
            (canvas, tree.json())
        }
        Tool::Volume => {
            let accel = build_accel(&scene);
            let tables = scene.tables.view();
            let traverse = accel.traverse(tables);
            let view = SceneView {
                tables,
                traverse: &traverse,
            };
            let expressions = parts.view();
            let own = &args.volume;
            let volume = own.measure(&view, &scene, expressions.as_ref(), args.seed)?;
            let film = volume.film(&view, &scene, args.spp, args.seed)?;
            let values: Vec<f64> = (volume.fluence.iter())
                .map(|v| luminance(v.to_array().map(f64::from)))
                .collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let most = values.iter().fold(0.0, |a: f64, b| a.max(*b));
            let [nx, ny, nz] = volume.grid.counts;
            summary = format!("{nx} x {ny} x {nz} voxels, mean fluence rate {mean:.4e} W/m²");
            let pixels = tone_map(&film.mean(), Exposure::Stops(0.0));
            let size = [film.width(), film.height()];
            let mut canvas = Canvas::new(size[0], size[1]);
            canvas.paste(&pixels, size, 0, 0);
            (
                canvas,
                json!({
                    "low": volume.grid.low.to_array(), "high": volume.grid.high.to_array(),
                    "voxels": volume.grid.counts, "mean": mean, "most": most,
                    "scattering": volume.grid.scattering, "extinction": volume.grid.extinction,
                }),
            )
        }
    };
    let [width, height] = canvas.size();
    write_png_bytes(&args.output, width, height, canvas.rgb())?;
    if args.json {
        print_line(format_args!("{numbers:#}"))?;
    }
    if !quiet {
        if summary.is_empty() {
            summary = format!("{} to {}", numbers["from"], numbers["to"]);
        }
        note(format_args!("{name}: {summary}"));
    }
    Ok(ExitCode::SUCCESS)
}

fn parse_value(text: &str) -> Result<f64, String> {
    let value = text
        .parse()
        .ok()
        .filter(|v: &f64| *v >= 0.0 && v.is_finite());
    value.ok_or_else(|| "expected a number that is not negative".to_owned())
}

fn parse_point(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text
        .split(',')
        .filter_map(|t| t.trim().parse().ok())
        .collect();
    let point: Result<[f32; 3], _> = numbers.try_into();
    let point = point.ok().filter(|p| p.iter().all(|v| v.is_finite()));
    point
        .filter(|_| text.split(',').count() == 3)
        .ok_or_else(|| "expected X,Y,Z".to_owned())
}

fn parse_pixel(text: &str) -> Result<[u32; 2], String> {
    parse_numbers(text, &[','], "X,Y")
}
