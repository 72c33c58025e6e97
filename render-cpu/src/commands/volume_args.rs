//! Arguments of the box of virtual medium.

use crate::inspect::volume::{LightVolume, MAX_VOXELS};
use crate::scene::build::Scene;
use clap::Args;
use glam::Vec3;
use halflight_kernel::path::PathExpressions;
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::light_volume::VoxelGrid;

/// Where the box is, and what is in it.
#[derive(Args, Clone, Debug)]
pub struct VolumeArgs {
    /// Box of medium: two corners. Default: around the scene.
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_parser = parse_box, allow_hyphen_values = true)]
    pub bounds: Option<BoxCorners>,
    /// Voxels along the longest side of the box; they are cubes, or nearly.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub voxels: u32,
    /// Light walks that are followed through the box.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub walks: u32,
    /// What the medium scatters per unit of length. Default: a fifth over the longest side of the box.
    #[arg(long, value_name = "VALUE", value_parser = parse_coefficient)]
    pub scattering: Option<f32>,
    /// What it takes from light per unit of length.
    #[arg(long, value_name = "VALUE", default_value = "0", value_parser = parse_coefficient)]
    pub extinction: f32,
}

/// Two corners of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxCorners([f32; 6]);

impl VolumeArgs {
    /// The voxels.
    ///
    /// # Errors
    /// If the box is empty, or has too many.
    fn grid(&self, scene: &Scene) -> Result<VoxelGrid, String> {
        let (low, high) = match self.bounds {
            Some(BoxCorners([a, b, c, d, e, f])) => {
                let (p, q) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
                (p.min(q), p.max(q))
            }
            None => {
                let info = &scene.tables.info;
                let center = Vec3::from_array(info.center);
                (center - info.radius, center + info.radius)
            }
        };
        let size = high - low;
        let longest = size.max_element();
        if !(size.min_element() > 0.0) || !size.is_finite() {
            return Err("--box: the corners span no space".into());
        }
        let side = longest / self.voxels as f32;
        let counts = size.to_array().map(|s| ((s / side).round() as u32).max(1));
        let grid = VoxelGrid {
            low,
            high,
            counts,
            scattering: self.scattering.unwrap_or(0.2 / longest),
            extinction: self.extinction,
        };
        if grid.len() > MAX_VOXELS {
            let count = grid.len();
            return Err(format!(
                "--voxels: {count} voxels are more than {MAX_VOXELS}"
            ));
        }
        Ok(grid)
    }

    /// Measures the light in the box.
    ///
    /// # Errors
    /// As of the box.
    pub(super) fn measure<T: Traverse + Sync>(
        &self,
        view: &SceneView<'_, T>,
        scene: &Scene,
        expressions: Option<&PathExpressions<'_>>,
        seed: u32,
    ) -> Result<LightVolume, String> {
        let grid = self.grid(scene)?;
        let settings = &scene.settings;
        Ok(LightVolume::measure(
            view,
            settings,
            expressions,
            grid,
            self.walks,
            seed,
        ))
    }
}

fn parse_coefficient(text: &str) -> Result<f32, String> {
    let value = text
        .parse()
        .ok()
        .filter(|v: &f32| *v >= 0.0 && v.is_finite());
    value.ok_or_else(|| "expected a number that is not negative".to_owned())
}

fn parse_box(text: &str) -> Result<BoxCorners, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .filter_map(|t| t.trim().parse().ok())
        .filter(|v: &f32| v.is_finite())
        .collect();
    let count = text.split(',').count();
    let corners: Result<[f32; 6], _> = numbers.try_into();
    let corners = corners.ok().filter(|_| count == 6);
    corners
        .map(BoxCorners)
        .ok_or_else(|| "expected X,Y,Z,X,Y,Z".to_owned())
}
