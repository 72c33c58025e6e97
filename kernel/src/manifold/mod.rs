//! Half-vector space: chains of glossy and specular interactions as manifolds.
//!
//! A note to learn the method from. Sources: Kaplanyan's thesis (2017, chapters 7 and 8), Jakob and Marschner 2012
//! ("Manifold Exploration"), Hanika, Kaplanyan and Dachsbacher 2015 ("Improved Half Vector Space Light Transport").
//!
//! # The problem
//! Light that goes from a lamp through two faces of a glass, off a polished table and into a lens follows a path whose
//! vertices depend on each other: move one and the others must follow, or the path carries nothing. Sampling directions one
//! after the other from either end misses the other end. Moving vertices on their surfaces changes the directions at both
//! neighbours and falls off their narrow lobes.
//!
//! # The idea
//! Describe the path by what its lobes depend on. A path of k edges between fixed ends is determined, near itself, by the half
//! vectors at its inner vertices, just as it is by their positions:
//!
//! ```text
//!        x_0  light                                          x_k  sensor
//!          o                                                   o
//!           \            n_1                                  /
//!            \       h_1  ^                                  /
//!          wi \        \  |   ___ wo                        /
//!              \        \ | _/           h_2 = n_2         /
//!   ------------v--------\|/_                 ^           ^------------
//!              x_1            \_              |          /  x_{k-1}
//!                               \_            |        _/
//!                                 \_          |      _/
//!                                   \_        |    _/
//!        (glossy: h_1 leans off n_1)  v_______|__ /
//!        -------------------------------------x_2---------------
//!                                        (specular: h_2 is n_2)
//! ```
//!
//! With X = (x_1 ... x_{k-1}) and H = (h_1 ... h_{k-1}) there is a smooth map H(X), and where its derivative J = dH/dX has an
//! inverse also X(H). A mirror only says "h = n", a rough lobe says "h is distributed around n", for Beckmann as a Gaussian in
//! the slope of h. So a mutation perturbs each half vector by a step that suits its lobe, and finds the vertices from H:
//! ends stay where they are, all lobes stay sampled, and specular vertices are no special case: their step is zero.
//!
//! # Symbols
//! | symbol | meaning | here |
//! |---|---|---|
//! | x_i | vertex; x_0 on the light, x_k on the sensor | [`ChainVertex`] |
//! | i_i, o_i | unit directions from x_i to x_{i-1} and x_{i+1} | `wi`, `wo` |
//! | eta_i | index towards x_{i+1} over index towards x_{i-1}; 1 for reflection | [`ChainVertex::eta`] |
//! | n_i | shading normal; the geometric one appears in G and o.n | [`ChainVertex::normal`] |
//! | h_i | half vector (i + eta o) / length, on the side of n | [`half_vector::HalfVector`] |
//! | h_perp | its projection onto the tangent plane, in the unit disk | [`half_vector_form::PROJECTED`] |
//! | h_pp | its slope: projection over height, on the whole plane | [`half_vector_form::SLOPE`] |
//! | A_i, B_i, C_i | dh_i / dx_{i-1}, dh_i / dx_i, dh_i / dx_{i+1}, 2x2 | [`constraint::Constraint`] |
//! | J | dH / dX, block tridiagonal of A, B, C | [`ChainJacobian`] |
//! | T_i | dx_i / dx_k at fixed half vectors, transfer matrix | [`BlockLu::transfer`] |
//! | D_i | block (k-1, i) of J^-1: how x_{k-1}, seen by the sensor, moves with h_i | [`BlockLu::row_of_inverse`] |
//! | G(x, y) | geometry term | [`chain::geometry_term`] |
//! | G(x_0 <-> x_k) | generalised geometry term, G(x_0, x_1) det T_1 | [`chain::generalized_geometry_term`] |
//! | s, gamma | mean step of a half vector, factor below the optimum | [`step_size::mean_step`], [`step_size::GAMMA`] |
//! | w_i | share of the image's step that h_i takes | [`step_size::spectrum_weights`] |
//! | a, b, c | points where the improved method breaks a path up | [`breakup`] |
//!
//! # A mutation, step by step
//! 1. Vertices: [`ChainVertex::from_surface`] for each, then [`ChainVertex::scattering`] for the inner ones;
//!    [`ChainVertex::point`] or [`ChainVertex::pinned_direction`] for ends without a surface.
//! 2. [`ChainJacobian::new`]: all blocks, the half vectors, and the factors of J. Linear in k.
//! 3. Steps: pixel offsets at x_{k-1} by [`step_size::tangent_plane_offset`], through D_i into the space of h_i by
//!    [`step_size::image_step`], weighed by [`step_size::spectrum_weights`], the smaller of that and the BSDF's by
//!    [`step_size::slope_proposal`]. Sample each: the target H'.
//! 4. [`mutation::mutate`]: the walk there ([`walk`](walk::walk): predict all vertices by J^-1, correct by rays, repeat), the
//!    walk back as a test that the chain can return, or a jump to another sub-manifold when the walk fails.
//! 5. Accept with `f(X') T(X' -> X) / (f(X) T(X -> X'))`, all per area of vertices: f is BSDFs times
//!    `prod G(x_i, x_{i+1})`, and T the density of the half vectors times the mutation's factor, which for walks is |det J|.
//!    For walks the same ratio comes out of [`chain::half_vector_measure`] instead of G and J: nothing is singular then.
//!
//! # Why the measure is harmless
//! `prod G / |det J| = G(x_0 <-> x_k) prod |do_i / dh_i| |o_i . n_i| q_i` (equations 7.4 to 7.6; see [`chain`]): the left side
//! is a quotient of two numbers that explode together where vertices meet; the right one is not. For a specular chain |do/dh|
//! cancels with the delta distribution of the BSDF (equation 7.8), and what is left is the generalised geometry term.
//!
//! # What limits it
//! Where J is singular two paths merge: caustics seen from a point on them. Beyond lies another sub-manifold, reached only by
//! jumps or by other mutations. Half vectors of refraction lose their meaning as eta tends to 1: below
//! [`vertex::INDEX_MATCHED_TOLERANCE`] the constraint is i + o = 0. Edges short against the roughness of a displaced surface
//! leave the linear prediction nothing to predict; there [`breakup`] keeps the chain short.
//!
//! # Misprints and traps, and the tests that settle them
//! - Section 8.1.2 writes `|dX/dH| = |J|^-1` into the density per area of a jump; it is |det J|:
//!   `manifold_jump::density_of_a_prediction_is_its_jacobian` and the chi-square test beside it.
//! - Section 8.2.1, "s = (2 / pi) |Sigma|" is the square of a step; alpha / sqrt(pi) is right:
//!   `manifold_step::mean_step_is_that_of_the_beckmann_gaussian`.
//! - Section 8.2.1, "about 35 %" acceptance is not reached at that step but at 1.68 deviations:
//!   `manifold_step::acceptance_of_gaussian_proposals_on_a_beckmann_lobe`.
//! - The sentence after equation 7.6 lets T_1 end at x_{k-1}; it is dx_1 / dx_k as in the equation:
//!   `manifold_constraint::transfer_matrices_inverse_rows_and_determinant`, `::path_measure_agrees_with_differences`.
//! - `h_pp = h / sqrt(1 - |h_perp|^2)` is meant for the two components of h_perp: `manifold_half_vector::charts_are_inverse...`.
//! - Reflection off a dielectric has eta = 1 in |do/dh|, whatever its index:
//!   `manifold_half_vector::reflection_off_a_dielectric_takes_eta_one`.
//! - The published derivatives of B hold the tangent dp/du of the shading frame fixed while the frame in use turns with it. Here
//!   the frame is defined by a vector that does stay fixed ([`vertex`]), and B is exact also for h != n:
//!   `manifold_constraint::blocks_are_the_derivatives_of_the_half_vectors`.
//! - Whether projections start at the sensor or at the light (table 8.1) made no difference beyond 0.1 % in our still life:
//!   `manifold_statistics` prints both.

pub mod breakup;
pub mod chain;
pub mod constraint;
pub mod disk_lobe;
pub mod exploration;
pub mod half_vector;
pub mod mutation;
pub mod projection;
pub mod slope_gaussian;
pub mod step_size;
pub mod vertex;
pub mod walk;

#[cfg(doc)]
use crate::math::block_tridiagonal::BlockLu;

pub use chain::ChainJacobian;
pub use constraint::half_vector_form;
pub use vertex::{ChainVertex, vertex_kind};

/// The most vertices of a chain on a host. Shaders choose a smaller capacity.
pub const MAX_CHAIN: usize = 32;
