//! Light transport mathematics for CPUs and Vulkan shaders.
//!
//! One `no_std`, allocation-free crate: scattering models, scene views, samplers and light-transport
//! algorithms as plain functions over borrowed tables. The CPU front end calls them with its own walks
//! of wide trees, the shaders with the crate's BVH2 walk; only traversal, sampler and film differ.
//!
//! # How to read it
//! Each module depends on those above it in this table only, and no two files import each other.
//!
//! | module | content |
//! |---|---|
//! | [`math`] | numbers, vectors, frames, mappings, distributions, linear systems |
//! | `simd` | structures of arrays and loops compiled per instruction set (hosts only) |
//! | [`sampler`] | counter-based random numbers and Sobol' points |
//! | [`scene`] | the plain records that a front end fills, the view that algorithms read, surfaces, cameras, emitters |
//! | [`bsdf`] | scattering models, and the mixture that a material makes of them at a point |
//! | [`regularize`] | mollifiers and bounds: blurring what cannot be sampled |
//! | [`manifold`] | chains of glossy and specular interactions in half-vector space |
//! | [`path`] | walks, connections, weights and rules that algorithms share |
//! | [`transport`] | the algorithms, one per file, and their drivers |
//!
//! # Conventions
//! - Local frames have z along the shading normal; directions point away from the surface.
//! - `wi` is the direction that is known (towards the sensor for paths traced from it), `wo` the one that is
//!   sampled. `eta` is the index on the transmitted side over the index on the incident side.
//! - `eval` returns a BSDF without a cosine; `eval_cosine` says that it holds one. `pdf` is per solid angle;
//!   a density in another measure says so in its name.
//! - Radiometry in W/(m^2 sr), RGB with linear sRGB primaries; angles in radians.
//! - Functions are total: finite in, finite out; "no contribution" is a zero density.
//!
//! # Notation of the papers
//! | symbol | name here |
//! |---|---|
//! | L_i, L_o | `radiance` |
//! | f_s | `eval` |
//! | p_omega | `pdf` |
//! | alpha | `alpha` (Beckmann width or GGX width, per axis) |
//! | D, G1, G2 | `distribution`, `smith_g1`, product of two `smith_g1` |
//! | beta, p | `alpha`, `exponent` of the exponential power distribution |
//! | sigma_v | `local_beckmann_roughness` |
//! | eta, k | `eta`, `k` (real and imaginary index of refraction) |
//! | x_0 ... x_k | path vertices, light to sensor |
//! | h, h_perp, h_pp | `half_vector`, `projected`, `slope` |
//! | A_i, B_i, C_i | `Constraint` with blocks `a`, `b`, `c` |
//! | J, T_i, D_i | `ChainJacobian`, `transfer`, `row_of_inverse` |

#![cfg_attr(not(feature = "std"), no_std)]
// `clamp` asserts the order of its bounds, and a shader compiler copies what may panic to all its callers; it knows no
// range objects in places that it cannot see through.
#![allow(clippy::manual_clamp, clippy::manual_range_contains)]

pub mod bsdf;
pub mod manifold;
pub mod math;
pub mod path;
pub mod regularize;
pub mod sampler;
pub mod scene;
#[cfg(not(target_arch = "spirv"))]
pub mod simd;
pub mod transport;

/// Vectors and matrices in the release that this crate was built with, for callers that need the same types.
pub use glam;
