//! Rules of path length, hidden emitters, strict normals and Russian roulette, the same for every algorithm.
//!
//! - Depth: a path has at most `max_depth` edges; null scattering at masks does not count.
//! - Hidden emitters: emitters are transparent on the edge at the sensor, for camera rays as for light that reaches the lens.
//! - Strict normals: a direction must lie on the same side of the geometric and of the shading normal, or the path ends.
//! - Russian roulette: from `rr_depth` edges on, a camera walk of throughput beta survives with probability
//!   min(max(beta) eta^2, 0.95), where max is that over channels and eta^2 undoes the scaling of refracted radiance; a light
//!   walk of initial throughput beta_0 with min(max(beta) / max(beta_0), 0.95). These probabilities are left out of the
//!   densities in weights: any weights that sum to one over the strategies are unbiased, as long as they depend on the path
//!   alone.

use crate::scene::SurfacePoint;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Highest probability of survival, so that walks without absorption end as well.
pub const MAX_SURVIVAL: f32 = 0.95;

/// What a walk does next, as numbers, because buffers hold them.
pub mod step {
    /// The walk has ended.
    pub const END: u32 = 0;
    /// Trace its ray.
    pub const TRACE: u32 = 1;
    /// Scatter at the surface that was hit.
    pub const SCATTER: u32 = 2;
}

/// The parameters of these rules.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PathRules {
    /// Largest number of edges of a path: 1 sees emitters, 2 adds direct illumination; [`u32::MAX`] for no limit.
    pub max_depth: u32,
    /// Number of edges from which Russian roulette is played.
    pub rr_depth: u32,
    /// 1 if emitters are invisible to the sensor.
    pub hide_emitters: u32,
    /// 1 if directions must lie on the same side of the geometric and the shading normal.
    pub strict_normals: u32,
}

impl PathRules {
    /// No depth limit, Russian roulette from the fifth edge: Mitsuba's defaults.
    pub const DEFAULT: PathRules = PathRules {
        max_depth: u32::MAX,
        rr_depth: 5,
        hide_emitters: 0,
        strict_normals: 0,
    };

    /// Whether a path may leave the point along the world `direction`, whose local cosine is `cos_theta`.
    #[inline]
    pub fn allows(&self, point: &SurfacePoint, direction: Vec3, cos_theta: f32) -> bool {
        self.strict_normals == 0 || is_same_side(point, direction, cos_theta)
    }
}

/// Whether a direction with local cosine `cos_theta` is on the same side of both normals.
#[inline]
pub fn is_same_side(point: &SurfacePoint, direction: Vec3, cos_theta: f32) -> bool {
    point.geometric_normal.dot(direction) * cos_theta > 0.0
}
