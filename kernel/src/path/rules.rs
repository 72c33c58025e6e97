//! Rules that all walks and connections keep, whatever algorithm makes them.
//!
//! - Depth: a path has at most `max_depth` edges; straight passage through masks does not count.
//! - Hidden emitters: rays that leave the sensor pass emitters as if they were not there, and so does light that reaches
//!   it.
//! - Strict normals: a direction lies on the same side of the geometric and of the shading surface, or the path ends.
//! - Russian roulette: from `rr_depth` edges on a walk survives with the probability min(max(beta) eta^2, 0.95) on camera
//!   walks, where eta^2 undoes the scaling of refracted radiance, and min(max(beta / beta_0), 0.95) on light walks, which
//!   begin with beta_0. It stays out of the densities in weights: any partition of one serves them, as long as it depends on
//!   the path alone.

use crate::scene::SurfacePoint;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Highest probability of survival, so that a lossless chain ends too.
pub const MAX_SURVIVAL: f32 = 0.95;

/// What a walk does next: a number, as it is kept in a buffer.
pub mod step {
    /// Nothing.
    pub const END: u32 = 0;
    /// Follow its ray.
    pub const TRACE: u32 = 1;
    /// Scatter at the surface where it arrived.
    pub const SCATTER: u32 = 2;
}

/// The rules' parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PathRules {
    /// Most edges of a path.
    pub max_depth: u32,
    /// Number of edges from which walks may end at random.
    pub rr_depth: u32,
    /// 1 if rays from the sensor pass emitters.
    pub hide_emitters: u32,
    /// 1 if directions must lie on the same side of the geometric and the shading surface.
    pub strict_normals: u32,
}

impl PathRules {
    /// Whether the direction, with the local cosine `cos_theta`, may be taken at the point.
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
