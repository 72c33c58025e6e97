//! What the heuristics of regularisation know of a camera walk: how far it has come, how far its neighbours have spread, and
//! how sharp the lobe was by which it left its last vertex.
//!
//! Jendersie and Grosch 2019, section 3.5; the numbers are those of [`crate::regularize::heuristic`], here along a walk.

use super::evaluation::Interaction;
use super::subpath::Subpath;
use crate::regularize::heuristic::{PathDiffusion, SamplerQuality};
use crate::regularize::regularized_bsdf::mixture_bound;
use crate::scene::{SurfacePoint, Tables, emitter_kind};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// The state of a walk after its last scattering.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// Of its neighbours.
    pub diffusion: PathDiffusion,
    /// Length so far.
    pub length: f32,
    /// Bound of the BSDF at its last vertex, on the side to which it left.
    pub rho: f32,
}

impl Spread {
    /// At a pinhole.
    pub const START: Spread = Spread {
        diffusion: PathDiffusion::SHARP,
        length: 0.0,
        rho: 0.0,
    };

    /// At the surface where the walk arrives.
    #[inline]
    pub fn arrive(mut self, subpath: &Subpath, point: &SurfacePoint) -> Spread {
        let d = (point.position - subpath.position).length();
        self.diffusion.travel(d);
        self.length += d;
        self
    }

    /// After scattering there into the local direction `wo`.
    #[inline]
    pub fn scatter(mut self, at: &Interaction<'_>, wo: Vec3) -> Spread {
        self.rho = mixture_bound(at.bsdf, at.wi.z * wo.z < 0.0);
        self.diffusion.scatter(self.rho, mean_curvature(at.point));
        self
    }
}

/// Quality of the connection of a vertex, `length` away from the sensor with a BSDF bounded by `rho`, with an emitter in the
/// distance `d` (equation 17 for the one connection that path tracing has).
#[inline]
pub fn emitter_quality(tables: &Tables<'_>, emitter: u32, rho: f32, length: f32, d: f32) -> f32 {
    let mut quality = SamplerQuality::EMPTY;
    // Of an infinite path all but the last edge has no length.
    if d < f32::MAX {
        quality.add(rho, emission_bound(tables, emitter), d);
        quality.length += length;
    } else {
        quality.add(rho, emission_bound(tables, emitter), 1.0);
    }
    quality.value()
}

/// Bound of an emitter's share of its own light per steradian, instead of a BSDF's bound: 1 / pi for surfaces, one over the
/// sphere where light goes everywhere, [`crate::regularize::bandwidth::TAU_MAX`] for one direction.
pub fn emission_bound(tables: &Tables<'_>, emitter: u32) -> f32 {
    match tables.emitters[emitter as usize].kind {
        emitter_kind::AREA => FRAC_1_PI,
        emitter_kind::DIRECTIONAL => crate::regularize::bandwidth::TAU_MAX,
        _ => 0.25 * FRAC_1_PI,
    }
}

/// Mean curvature of the surface with its shading normals, of any sign, one over scene units; zero where it has no tangents.
///
/// `H = (E N - 2 F M + G L) / (2 (E G - F^2))` by the first and second fundamental forms.
pub fn mean_curvature(point: &SurfacePoint) -> f32 {
    let (u, v) = (point.dp_du, point.dp_dv);
    let (nu, nv) = (point.dn_du, point.dn_dv);
    let (e, f, g) = (u.dot(u), u.dot(v), v.dot(v));
    let area = e * g - f * f;
    if !(area > 1e-6 * e * g) {
        return 0.0;
    }
    let cross = 0.5 * (u.dot(nv) + v.dot(nu));
    (e * v.dot(nv) - 2.0 * f * cross + g * u.dot(nu)) / (2.0 * area)
}
