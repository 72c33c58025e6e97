//! The options of `halflight inspect`.

use super::path_args::PathArgs;
use super::scene_args::{SceneArgs, parse_numbers};
use super::volume_args::VolumeArgs;
use crate::inspect::spherical_plot::Probe;
use crate::render::{Goal, RenderOptions};
use clap::{Args, ValueEnum};
use glam::Vec3;
use halflight_kernel::scene::{SceneView, Traverse};
use std::path::{Path, PathBuf};

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
    /// If the pixel is none of the image's, or sees no surface.
    pub(super) fn probe<T: Traverse>(
        &self,
        view: &SceneView<'_, T>,
    ) -> Result<Option<Probe>, String> {
        match (self.at, self.pixel) {
            (Some(at), _) => Ok(Some(Probe::free(Vec3::from_array(at)))),
            (None, Some([x, y])) => {
                let [width, height] = view.tables.camera.film_size;
                if x >= width || y >= height {
                    return Err(format!(
                        "--pixel: {x},{y} is not in the image of {width} x {height} pixels"
                    ));
                }
                match Probe::of_pixel(view, [x, y]) {
                    Some(probe) => Ok(Some(probe)),
                    None => Err(format!("pixel {x},{y} sees no surface")),
                }
            }
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

/// What a page holds beside paths.
#[derive(Args, Clone, Debug)]
pub struct PageArgs {
    /// The image in the page, of the size of the scene's. Default: it is rendered now.
    #[arg(help_heading = "Page", long, value_name = "IMAGE")]
    pub image: Option<PathBuf>,
    /// Triangles beyond which meshes are thinned out in the page.
    #[arg(help_heading = "Page", long, value_name = "N", default_value_t = 2_000_000, value_parser = clap::value_parser!(u32).range(100..))]
    pub triangles: u32,
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
