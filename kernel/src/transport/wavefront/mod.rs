//! Path tracing of many paths in lockstep: one bounce of each before the next of any.
//!
//! Rays are traced for all paths at once. Paths are then sorted into queues by the code that shades them, and each step of
//! [`super::path`] is a loop over a queue, over structures of arrays ([`crate::simd::lanes`]): the bodies are the functions of
//! single paths, which the compiler vectorises (Laine, Karras and Aila 2013, "Megakernels Considered Harmful", with lanes
//! for threads). Paths at materials, shapes or settings without such loops are shaded one by one.
//!
//! | file | content |
//! |---|---|
//! | `driver` | [`Wavefront`]: adding paths, tracing them to their ends |
//! | `wave_bounce` | a bounce of all: rays, queues, shadow rays, compaction |
//! | `camera_rays` | film positions and rays |
//! | `queues`, `segment`, [`bsdf_variant`] | which code shades a path, and in which slots |
//! | `paths`, `shadow_rays`, `random_numbers` | states and numbers of paths |
//! | `shading`, `fallback` | the bounce of a queue, step by step or path by path |
//! | `surfaces`, `lobes`, `textures` | surface points and material parameters |
//! | `emitter_samples`, `environment`, `cdf_search` | next event estimation |
//! | `division` | parts of paths by path expressions |
//! | `regularized` | connections below tau |
//! | `scattering`, `microfacet_normals`, `bsdf_samples` | sampled directions |
//!
//! Invariant (tests): the results are those of single paths, to the bit.

mod bsdf_samples;
pub mod bsdf_variant;
mod camera_rays;
mod cdf_search;
mod diffuse_shares;
mod division;
mod driver;
mod emitter_samples;
mod environment;
mod fallback;
mod lobes;
mod microfacet_normals;
mod paths;
mod queues;
mod random_numbers;
mod regularized;
mod scattering;
mod segment;
mod shading;
mod shadow_rays;
mod surfaces;
mod textures;
mod wave_bounce;

pub use division::WaveDivision;
pub use driver::Wavefront;
