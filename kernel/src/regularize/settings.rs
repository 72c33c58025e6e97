//! Parameters of regularisation: as scene files and command lines give them, and as one sample has them.
//!
//! Both shrink with the index of the sample, n = index + 1, and not with a pass or a thread: a share of the samples, a run that
//! goes on later and their union then have the numbers of one run (Jendersie and Grosch 2019, equation 16; Kaplanyan 2017,
//! equation 6.5).
//!
//! - microfacet models: `tau_n`, the largest value of a regularised BSDF per steradian, that of a cone whose tangent shrinks as
//!   `n^-lambda`;
//! - path space: `r_n = r_0 n^-lambda`, the radius at the far end of a connection within which a discrete direction counts; Markov
//!   chains shrink it further from step to step, `r_n gamma^m`.
//!
//! Plain data of 32-bit words, because shaders read the block of all settings.

use super::bandwidth::{TAU_MAX, optimal_exponent, power_law, tau_power_law};
use super::heuristic::{PathDiffusion, diffusion_threshold, quality_share};
use super::mollifier;
use super::near_specular::{DEFAULT_QUANTILE, half_tangent};
use bytemuck::{Pod, Zeroable};

/// Bits of [`RegularizationSettings::flags`].
pub mod flag {
    /// tau and r stay those of the first sample, so that the bias stays too.
    pub const CONSTANT: u32 = 1;
    /// [`super::RegularizationSettings::radius`] is a share of the scene's radius.
    pub const RELATIVE_RADIUS: u32 = 2;
    /// Path tracing takes a sample of every emitter, not of one.
    pub const ALL_LIGHTS: u32 = 4;
    /// Paths that some connection samples well are left alone ([`super::super::heuristic::SamplerQuality`]).
    pub const QUALITY: u32 = 8;
    /// tau grows where the walk from the sensor is sharp ([`super::super::heuristic::PathDiffusion`]).
    pub const DIFFUSION: u32 = 16;
    /// For comparison: weights by the densities of the model itself (the paper's figure 3, left), which do not know
    /// how large the contributions are. A partition of one where no vertex is specular; where one is, light is counted twice.
    pub const PLAIN_WEIGHTS: u32 = 32;
    /// For tests: values of the model itself, with the weights of regularisation. Without specular surfaces this has the mean
    /// of the algorithm without regularisation, if the weights are a partition of one.
    pub const PLAIN_VALUES: u32 = 64;
    /// Path tracing connects regularised vertices by virtual merges ([`super::super::virtual_merge`]), not by rougher models.
    pub const VIRTUAL_MERGE: u32 = 128;
}

/// What a run is asked for.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RegularizationSettings {
    /// tau of the first sample, [`TAU_MAX`] for none.
    pub tau: f32,
    /// r of the first sample, zero for none.
    pub radius: f32,
    /// lambda, by which r shrinks, or the tangent of the cone of value tau.
    pub exponent: f32,
    /// One of the kernels of [`mollifier`].
    pub kernel: u32,
    /// Bits of [`flag`].
    pub flags: u32,
    /// Share of tau^2 below which the quality of a path switches regularisation off; it fades in from there to tau^2, and one
    /// makes that a step.
    pub fade: f32,
    /// 1 - gamma, by which the radius shrinks with each step of a Markov chain.
    pub one_minus_gamma: f32,
    /// Share of a rough lobe that lies within the radius where it counts as specular ([`super::near_specular`]); one for none.
    pub quantile: f32,
}

impl RegularizationSettings {
    /// 1e-4 (Kaplanyan and Dachsbacher 2013).
    pub const DEFAULT_RATE: f32 = 1e-4;

    /// Nothing is regularised.
    pub const NONE: RegularizationSettings = RegularizationSettings {
        tau: TAU_MAX,
        radius: 0.0,
        exponent: 1.0 / 6.0,
        kernel: mollifier::PERLIN,
        flags: 0,
        fade: 1.0,
        one_minus_gamma: RegularizationSettings::DEFAULT_RATE,
        quantile: DEFAULT_QUANTILE,
    };

    /// Whether the tau of a vertex, or whether a path is regularised, depends on the path.
    #[inline]
    pub fn is_adaptive(&self) -> bool {
        self.tau < TAU_MAX && self.flags & (flag::QUALITY | flag::DIFFUSION) != 0
    }

    /// Whether a path keeps anything of its own for it, or takes other samples than path tracing does.
    #[inline]
    pub fn follows_paths(&self) -> bool {
        self.is_some() && self.flags & !(flag::CONSTANT | flag::RELATIVE_RADIUS) != 0
    }

    /// Whether anything is.
    #[inline]
    pub fn is_some(&self) -> bool {
        self.tau < TAU_MAX || self.radius > 0.0
    }

    /// The exponent of the fastest convergence, for one mollified vertex.
    pub fn default_exponent() -> f32 {
        optimal_exponent(2)
    }
}

/// The regularisation of one sample.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Zeroable)]
pub struct Regularization {
    /// tau_n, [`TAU_MAX`] for none.
    pub tau: f32,
    /// r_n in scene units, zero for none.
    pub radius: f32,
    /// One of the kernels of [`mollifier`].
    pub kernel: u32,
    /// Bits of [`flag`].
    pub flags: u32,
    /// See [`RegularizationSettings::fade`].
    pub fade: f32,
    /// See [`RegularizationSettings::quantile`].
    pub quantile: f32,
    /// [`super::near_specular::half_tangent`] of the radius, seen from the scene's radius away.
    pub half_tangent: f32,
}

impl Regularization {
    /// The share of a path of quality `q` that is regularised.
    #[inline]
    pub fn share(&self, q: f32) -> f32 {
        if self.flags & flag::QUALITY == 0 {
            1.0
        } else {
            quality_share(self.tau, q, self.fade)
        }
    }

    /// tau at a vertex where the walk from the sensor has the given spread, never less than without a heuristic.
    #[inline]
    pub fn threshold(&self, diffusion: &PathDiffusion) -> f32 {
        if self.flags & flag::DIFFUSION == 0 {
            self.tau
        } else {
            // A deviation above one is that of all directions.
            diffusion_threshold(self.tau, diffusion).max(self.tau)
        }
    }
}

impl Regularization {
    /// None.
    pub const NONE: Regularization = Regularization {
        tau: TAU_MAX,
        radius: 0.0,
        kernel: mollifier::PERLIN,
        flags: 0,
        fade: 1.0,
        quantile: 1.0,
        half_tangent: 0.0,
    };

    /// That of the sample with an index counted from zero, in a scene of the given radius.
    pub fn of_sample(
        settings: &RegularizationSettings,
        scene_radius: f32,
        sample: u32,
    ) -> Regularization {
        let n = if settings.flags & flag::CONSTANT != 0 {
            1
        } else {
            sample.saturating_add(1)
        };
        let unit = if settings.flags & flag::RELATIVE_RADIUS != 0 {
            scene_radius
        } else {
            1.0
        };
        let radius = if settings.radius > 0.0 {
            power_law(settings.radius * unit, n, settings.exponent)
        } else {
            0.0
        };
        Regularization {
            // The schedule of the first sample is tau_0 but for rounding.
            tau: if n > 1 {
                tau_power_law(settings.tau, n, settings.exponent)
            } else {
                settings.tau
            },
            radius,
            half_tangent: half_tangent(radius, scene_radius),
            quantile: settings.quantile,
            kernel: settings.kernel,
            flags: settings.flags,
            fade: settings.fade,
        }
    }
}
