//! Parameters of the algorithms: one block that all share, and one of each algorithm's own.
//!
//! Plain data of 32-bit words, because shaders read them too.

use crate::path::rules::PathRules;
pub use crate::regularize::settings::RegularizationSettings;
use crate::scene::NONE;
use crate::transport::photon::schedule::OPTIMAL_ALPHA;
use crate::transport::photon::statistics;
use bytemuck::{Pod, Zeroable};

/// Which algorithm makes the image.
pub mod integrator_kind {
    /// Unidirectional path tracing ([`crate::transport::path`]).
    pub const PATH: u32 = 0;
    /// Direct illumination with chosen numbers of samples ([`crate::transport::direct`]).
    pub const DIRECT: u32 = 1;
    /// Ambient occlusion ([`crate::transport::ambient_occlusion`]).
    pub const AMBIENT_OCCLUSION: u32 = 2;
    /// Bidirectional path tracing (`transport/bidirectional/`).
    pub const BIDIRECTIONAL: u32 = 3;
    /// Light tracing (`transport/bidirectional/` without camera subpaths).
    pub const LIGHT_TRACING: u32 = 4;
    /// Path tracing with manifold next event estimation (`transport/manifold_path.rs`).
    pub const MANIFOLD_PATH: u32 = 5;
    /// Bidirectional path tracing with manifold next event estimation (`transport/bidirectional/manifold.rs`).
    pub const MANIFOLD_BIDIRECTIONAL: u32 = 6;
    /// Metropolis chains in the space of primary samples (`transport/markov`).
    pub const PRIMARY_SAMPLE_MLT: u32 = 8;
    /// Metropolis chains of full paths (`transport/markov/veach`).
    pub const VEACH_MLT: u32 = 9;
    /// Progressive photon mapping (`transport/photon/progressive.rs`).
    pub const PROGRESSIVE_PHOTONS: u32 = 16;
    /// Vertex connection and merging, or vertex merging alone (`transport/photon/merging.rs`).
    pub const VERTEX_MERGING: u32 = 17;
    /// Adaptive progressive photon mapping (`transport/photon/adaptive.rs`).
    pub const ADAPTIVE_PHOTONS: u32 = 18;
    /// Progressive photon mapping with Metropolis photon tracing (`transport/photon/metropolis.rs`).
    pub const METROPOLIS_PHOTONS: u32 = 19;
}

/// How an algorithm renders: what all share, and the blocks of each.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct IntegratorSettings {
    /// One of [`integrator_kind`].
    pub kind: u32,
    /// Depth, hidden emitters, strict normals, Russian roulette.
    pub rules: PathRules,
    /// Of direct illumination.
    pub direct: DirectSettings,
    /// Of ambient occlusion.
    pub occlusion: OcclusionSettings,
    /// Of bidirectional path tracing and light tracing.
    pub bidirectional: BidirectionalSettings,
    /// Of photon mapping.
    pub photon: PhotonSettings,
    /// Of Metropolis chains.
    pub chains: ChainSettings,
    /// Of regularisation, in the algorithms that connect subpaths: [`integrator_kind::PATH`], [`integrator_kind::BIDIRECTIONAL`],
    /// [`integrator_kind::VERTEX_MERGING`], and Markov chains over bidirectional path tracing and of full paths.
    pub regularization: RegularizationSettings,
}

/// Parameters of direct illumination.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct DirectSettings {
    /// Emitter samples per sensor ray.
    pub emitter_samples: u32,
    /// BSDF samples per sensor ray.
    pub bsdf_samples: u32,
}

/// Parameters of ambient occlusion.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct OcclusionSettings {
    /// Rays per sensor ray.
    pub samples: u32,
    /// Longest distance that occludes, as a fraction of the scene's radius.
    pub distance: f32,
}

/// Parameters of Metropolis chains.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ChainSettings {
    /// How paths are made of primary samples: 0 by path tracing, 1 by bidirectional path tracing (Mitsuba 0.6:
    /// `bidirectional`), 2 by one strategy of it.
    pub technique: u32,
    /// Probability of a large step (Mitsuba 0.6: `pLarge`).
    pub p_large: f32,
    /// Candidates from which a group estimates the mean of the image and chooses the starts of its chains (Mitsuba 0.6:
    /// `luminanceSamples`); 0 for one per 16 mutations.
    pub candidates: u32,
    /// Chains of a group.
    pub chains: u32,
    /// Mutations per pixel of a group; 0 for as few as make 2^20 in all.
    pub mutations: u32,
    /// Samples per pixel of a group for direct illumination, which chains then leave out; 0 if chains find all (Mitsuba 0.6:
    /// `directSamples`). [`ChainSettings::SOME`] for as many as are worth it, and chains of full paths then leave to path tracing
    /// all that it finds well ([`crate::path::remainder`]).
    pub direct_samples: u32,
    /// Mutations of a chain; 0 for those of the group over its chains (Mitsuba 0.6: `chainLength`).
    pub chain_length: u32,
    /// Weight of the bidirectional mutation of full paths in the choice among those that a path allows.
    pub bidirectional_weight: f32,
    /// Of the lens perturbation.
    pub lens_weight: f32,
    /// Of the caustic perturbation.
    pub caustic_weight: f32,
    /// Of the multi-chain perturbation.
    pub multi_chain_weight: f32,
    /// Of manifold exploration.
    pub manifold_weight: f32,
    /// Of the half-vector mutation.
    pub half_vector_weight: f32,
    /// How narrow the directions are into which manifold exploration turns paths (Mitsuba 0.6: `lambda`).
    pub lambda: f32,
    /// Bits of [`half_vector_flag`].
    pub half_vector_flags: u32,
    /// Steps of half vectors over those of least correlation on a lobe alone: gamma.
    pub half_vector_step: f32,
    /// 1 if a first stage decides how often chains come to each part of the image, so that dark parts are not left to a few
    /// visits (Mitsuba 0.6: `twoStage`; `transport/markov/importance.rs`).
    pub two_stage: u32,
}

/// What the half-vector mutation does otherwise than by default: bits.
pub mod half_vector_flag {
    /// The full path moves in half-vector space, as in the original method, instead of breaking up.
    pub const ORIGINAL: u32 = 1;
    /// Steps from the largest roughness of a material instead of the local one.
    pub const GLOBAL_ROUGHNESS: u32 = 2;
    /// Half vectors projected onto the tangent plane, with Phong lobes, instead of slopes with Gaussians.
    pub const PROJECTED: u32 = 4;
    /// Steps of the same width at all materials, as if their roughness were one.
    pub const EQUAL_STEPS: u32 = 8;
    /// Steps from the roughness alone, however far they lead over the image.
    pub const UNSTRATIFIED: u32 = 16;
    /// Walks project vertices from the light on, instead of from the end where errors shrink, and manifold exploration turns paths
    /// on the way from the light alone.
    pub const FROM_LIGHT: u32 = 32;
    /// The same from the sensor.
    pub const FROM_SENSOR: u32 = 64;
}

impl ChainSettings {
    /// Direct illumination by one sample for eight mutations, but 16 at most.
    pub const SOME: u32 = u32::MAX;

    /// Bidirectional, three large steps of ten, direct illumination apart.
    pub const DEFAULT: ChainSettings = ChainSettings {
        technique: 1,
        p_large: 0.3,
        candidates: 0,
        chains: 128,
        mutations: 0,
        direct_samples: ChainSettings::SOME,
        chain_length: 0,
        bidirectional_weight: 1.0,
        lens_weight: 1.0,
        caustic_weight: 1.0,
        multi_chain_weight: 1.0,
        manifold_weight: 0.0,
        half_vector_weight: 0.0,
        lambda: 50.0,
        half_vector_flags: 0,
        half_vector_step: 0.2,
        two_stage: 0,
    };

    /// Fewest mutations of a group: enough for its chains to be long and its start-up to be cheap.
    const LEAST: u32 = 1 << 20;

    /// Samples per pixel of a group for direct illumination, for an image of so many pixels.
    #[inline]
    pub fn direct_samples_per_pixel(&self, pixels: u32) -> u32 {
        if self.direct_samples == Self::SOME {
            (self.mutations_per_pixel(pixels) / 8).max(1).min(16)
        } else {
            self.direct_samples
        }
    }

    /// Mutations per pixel of a group for an image of so many pixels.
    #[inline]
    pub fn mutations_per_pixel(&self, pixels: u32) -> u32 {
        if self.mutations > 0 {
            self.mutations
        } else {
            Self::LEAST.div_ceil(pixels.max(1))
        }
    }
}

/// Parameters of the algorithms that trace subpaths from emitters.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BidirectionalSettings {
    /// 1 if light subpaths are connected to the lens (Mitsuba 0.6: `lightImage`).
    pub light_image: u32,
    /// 1 if the emitter of a camera subpath's next event estimation is sampled for the point that it lights (Mitsuba 0.6:
    /// `sampleDirect`); otherwise it is the light subpath's own start.
    pub sample_direct: u32,
    /// 1 for the power heuristic with exponent two, 0 for the balance heuristic.
    pub power_heuristic: u32,
    /// Vertices of the light subpath in the one strategy that is shown, [`NONE`] for all.
    pub only_s: u32,
    /// Vertices of the camera subpath in the one strategy that is shown, [`NONE`] for all.
    pub only_t: u32,
    /// 1 if contributions are not weighted against those of other strategies.
    pub unweighted: u32,
    /// Vertices of the light walks of many samples with which each camera vertex is connected
    /// ([`crate::transport::bidirectional::SharedWalks`]); zero for all those of its own sample's light walk.
    pub connections: u32,
}

/// Parameters of photon mapping.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PhotonSettings {
    /// Light walks per pass, zero for as many as the algorithm takes by itself
    /// ([`crate::transport::photon::progressive::light_walks`]).
    pub photon_count: u32,
    /// How slowly radii shrink ([`crate::transport::photon::schedule`]).
    pub alpha: f32,
    /// Radius of the first pass in scene units, zero to derive it from the scene.
    pub initial_radius: f32,
    /// Roughness from which camera walks gather photons instead of going on.
    pub gather_roughness: f32,
    /// 1 if vertex merging goes with connections, 0 if it is alone.
    pub connections: u32,
    /// Least radius of adaptive photon mapping, over that of the scene.
    pub least_radius: f32,
    /// Largest radius of adaptive photon mapping, over that of the scene.
    pub largest_radius: f32,
    /// Photons of a pass within the first radius of each pixel of progressive photon mapping
    /// ([`crate::transport::photon::nearest`]), zero for one radius for all; of no account where `initial_radius` is given.
    pub nearest: u32,
}

impl PhotonSettings {
    /// As many photons as the algorithm takes by itself, and the alpha of least error.
    pub const DEFAULT: PhotonSettings = PhotonSettings {
        photon_count: 0,
        alpha: OPTIMAL_ALPHA,
        initial_radius: 0.0,
        gather_roughness: 0.15,
        connections: 1,
        least_radius: statistics::LEAST_RADIUS,
        // Half of the thesis's: the first passes of larger ones take long, and their bias lasts.
        largest_radius: 0.5 * statistics::LARGEST_RADIUS,
        nearest: 0,
    };
}

impl BidirectionalSettings {
    /// All strategies, weighted by the power heuristic.
    pub const DEFAULT: BidirectionalSettings = BidirectionalSettings {
        light_image: 1,
        sample_direct: 1,
        power_heuristic: 1,
        only_s: NONE,
        only_t: NONE,
        unweighted: 0,
        connections: 0,
    };
}

impl IntegratorSettings {
    /// Path tracing without a depth limit, Russian roulette from the fifth edge: Mitsuba's defaults.
    pub const PATH: IntegratorSettings = IntegratorSettings {
        kind: integrator_kind::PATH,
        rules: PathRules::DEFAULT,
        direct: DirectSettings {
            emitter_samples: 1,
            bsdf_samples: 1,
        },
        occlusion: OcclusionSettings {
            samples: 1,
            distance: 0.5,
        },
        bidirectional: BidirectionalSettings::DEFAULT,
        photon: PhotonSettings::DEFAULT,
        chains: ChainSettings::DEFAULT,
        regularization: RegularizationSettings::NONE,
    };
}
