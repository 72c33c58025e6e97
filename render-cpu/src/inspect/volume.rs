//! A box of virtual medium that shows the light which passes through it (Kaplanyan 2017, section 9.1.2;
//! [`halflight_kernel::transport::light_volume`]): beams, caustics and shadows in free space.
//!
//! Light walks are divided into as many groups whatever the number of threads, and the groups' sums are added in order, so that a
//! volume is a function of its seed.

use super::pixel_film::pixel_film;
use crate::film::{Film, FilmError, luminance};
use crate::scene::build::Scene;
use glam::DVec3;
use halflight_kernel::math::Rgb;
use halflight_kernel::path::PathExpressions;
use halflight_kernel::sampler::{IndependentSampler, mix};
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::bidirectional::Bidirectional;
use halflight_kernel::transport::light_volume::VoxelGrid;
use halflight_kernel::transport::{IntegratorSettings, integrator_kind, path};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Groups of light walks.
const GROUPS: u32 = 8;

/// Most voxels: their sums take 1.5 gigabytes.
pub const MAX_VOXELS: usize = 1 << 23;

/// Tells the numbers of these walks from others.
const STREAM: u32 = 0x7c15_9e37;

/// The light in a box.
#[derive(Clone, Debug)]
pub struct LightVolume {
    /// Its voxels.
    pub grid: VoxelGrid,
    /// Mean fluence rate of each, in W/m^2.
    pub fluence: Vec<Rgb>,
}

impl LightVolume {
    /// Follows `walks` light walks, of the paths of an expression if there is one.
    pub fn measure<T: Traverse + Sync>(
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        expressions: Option<&PathExpressions<'_>>,
        grid: VoxelGrid,
        walks: u32,
        seed: u32,
    ) -> LightVolume {
        let settings = IntegratorSettings {
            kind: integrator_kind::LIGHT_TRACING,
            ..*settings
        };
        let algorithm = Bidirectional::new(&view.tables, &settings);
        let groups: Vec<Vec<DVec3>> = (0..GROUPS)
            .into_par_iter()
            .map(|group| {
                let mut sums = vec![DVec3::ZERO; grid.len()];
                for walk in (group..walks).step_by(GROUPS as usize) {
                    let mut sampler = IndependentSampler::new(mix(seed ^ STREAM), walk, 0);
                    grid.trace_light(
                        view,
                        &algorithm,
                        expressions,
                        &mut sampler,
                        |voxel, light| {
                            sums[voxel] += light.as_dvec3();
                        },
                    );
                }
                sums
            })
            .collect();
        let scale = 1.0 / (f64::from(walks) * f64::from(grid.voxel_volume()));
        let fluence = (0..grid.len())
            .map(|voxel| {
                let sum: DVec3 = groups.iter().map(|group| group[voxel]).sum();
                (sum * scale).as_vec3()
            })
            .collect();
        LightVolume { grid, fluence }
    }

    /// Luminance of the fluence rate of each voxel.
    pub fn luminance(&self) -> Vec<f32> {
        let of = |v: &Rgb| luminance(v.to_array().map(f64::from)) as f32;
        self.fluence.iter().map(of).collect()
    }

    /// The image of a scene with the medium in it, by path tracing: what surfaces show, dimmed by the medium, and what it scatters.
    ///
    /// # Errors
    /// If the film does not fit into memory.
    pub fn film<T: Traverse + Sync>(
        &self,
        view: &SceneView<'_, T>,
        scene: &Scene,
        samples: u32,
        seed: u32,
    ) -> Result<Film, FilmError> {
        pixel_film(&view.tables, samples, seed, |sampler, ray| {
            let hit = view.traverse.closest_hit(ray);
            let t_max = if hit.is_hit() { hit.t } else { f32::MAX };
            let (scattered, through) = self.grid.scattered(&self.fluence, ray, t_max);
            let behind = path::radiance(view, &scene.settings, sampler, ray);
            scattered + behind * through
        })
    }
}
