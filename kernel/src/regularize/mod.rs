//! Regularisation: making light paths samplable by blurring what cannot be sampled, less and less so.
//!
//! A path of specular and glossy vertices between a point light and a pinhole has no neighbour that a local sampler
//! could find. Regularisation replaces a delta distribution, or a narrow lobe, by a wider function and lets its width
//! shrink over the iterations: every image is biased, the sequence converges to the truth.
//!
//! | file | what for |
//! |---|---|
//! | [`mollifier`] | kernels of unit mass in 1 to 3 dimensions, with the moments that give bias and variance |
//! | [`cone`] | the same on directions: constant and smooth cones around a specular direction |
//! | [`bandwidth`] | how width shrinks: `r_0 n^-lambda`, `r_0 gamma^n`, `tau_N` |
//! | [`bounds`] | how large a microfacet BSDF can be for its roughness, and the roughness for a largest value |
//! | [`power_bounds`] | the same for the exponential power distribution |
//! | [`regularized_bsdf`] | a lobe or material evaluated below tau, and its density for multiple importance sampling |
//! | `plain_lobe` | the same of one lobe, for loops over lanes |
//! | [`both_ways`] | the same of a material with the densities of both directions; `boundary`: of metals and glass in one look |
//! | [`settings`] | what a run is asked for, and what one sample has |
//! | [`heuristic`] | where a path needs it: sampler quality and path diffusion |
//! | [`near_specular`] | rough lobes that count as specular where path space is regularised |
//! | [`virtual_merge`] | the alternative by random acceptance |
//!
//! Sources: Kaplanyan 2017 (thesis), chapters 5 and 6 (Kaplanyan and Dachsbacher 2013, "Path Space Regularization for
//! Holistic and Robust Light Transport" and "Adaptive Progressive Photon Mapping"); Jendersie and Grosch 2019,
//! "Microfacet Model Regularization for Robust Light Transport". The command `halflight experiment` reproduces their
//! statements on integrals with known answers.
//!
//! # Notation
//! | symbol | name here |
//! |---|---|
//! | phi_r, K | mollifier of bandwidth r, kernel of bandwidth 1 |
//! | r_n, lambda, gamma | bandwidth of sample n, its exponent, its factor per mutation |
//! | M_2, k2; k3 | [`mollifier::second_moment`] (per axis), [`mollifier::square_norm`] |
//! | tau, tau_N | largest value of a regularised BSDF per steradian, in iteration N |
//! | rho-bar, alpha-hat | [`bounds`] and their inverses, `*_bound` and `*_alpha` |
//! | rho-hat, p-hat | [`regularized_bsdf::eval_cosine_pdf`] |
//! | q, sigma_angle, sigma_x | [`heuristic::SamplerQuality`], [`heuristic::PathDiffusion`] |
//!
//! # Misprints and gaps of the papers, and the tests that settle them
//! - Thesis, proof of lemma 1: the lower bound of the bandwidth is O(n^(-1/d)), not O(n^(1/d)); `regularize_bandwidth`.
//! - Thesis, section 6.3.1: the variance's constant is g(0)^2, once printed as g(0), and holds for importance sampling
//!   p = g only up to g(0)/p(0); for two vertices the fastest exponent is 1/8, not 1/12; `regularize_bandwidth`.
//! - Thesis, after 5.3: Perlin's kernel over pi r^2 has mass 2/7; after 5.13: k2 is the 1D moment, 5/48 is meant;
//!   `regularize_mollifier`.
//! - Thesis, 5.12: the number of photons in the disk varies, its variance must not be dropped; `regularize_photons`.
//! - Thesis, 5.18: the constant 1.9635 is not reproduced by Silverman's rule, and sigma is not a length;
//!   `regularize_photons`.
//! - Jendersie and Grosch, equation 7: the denominator is (n_i i.h + n_t o.h)^2; equations 8 and 9 fail for Beckmann
//!   above alpha = 1/sqrt(2), for height-correlated masking and for V-cavities, and 9 is loose by its masking factor;
//!   `regularize_bounds`.
//! - Jendersie and Grosch, equation 20: the footprint grows by the deviation after scattering; `regularize_heuristic`.

pub mod bandwidth;
pub mod both_ways;
mod boundary;
pub mod bounds;
pub mod cone;
pub mod heuristic;
pub mod mollifier;
pub mod near_specular;
#[cfg(not(target_arch = "spirv"))]
pub(crate) mod plain_lobe;
pub mod power_bounds;
pub mod regularized_bsdf;
pub mod settings;
pub mod virtual_merge;
