//! Sampler quality, path diffusion and virtual merging.

mod common;

use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::lobe;
use halflight_kernel::bsdf::{Lobe, microfacet};
use halflight_kernel::regularize::bandwidth::TAU_MAX;
use halflight_kernel::regularize::heuristic::{
    PathDiffusion, SamplerQuality, diffusion_threshold, quality_threshold, smooth_quality_threshold,
};
use halflight_kernel::regularize::virtual_merge::virtual_merge;
use halflight_kernel::scene::{distribution, lobe_kind};
use proptest::prelude::*;
use std::f32::consts::PI;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Equation 17 gathered segment by segment is the minimum over the full path.
    #[test]
    fn quality_is_the_least_connection(
        rho in prop::collection::vec(1e-3_f32..1e8, 6),
        d in prop::collection::vec(1e-3_f32..1e3, 5),
    ) {
        let mut q = SamplerQuality::EMPTY;
        for i in 0..d.len() {
            q.add(rho[i], rho[i + 1], d[i]);
        }
        let path: f64 = d.iter().map(|&x| f64::from(x)).sum();
        let want = (0..d.len())
            .map(|i| f64::from(rho[i]) * f64::from(rho[i + 1]) * (path / f64::from(d[i])).powi(2))
            .fold(f64::MAX, f64::min);
        prop_assert!((f64::from(q.value()) / want - 1.0).abs() < 1e-5);
    }

    /// The smooth variant lies between full regularisation and none, is continuous and falls with q; its limit is
    /// equation 18.
    #[test]
    fn the_smooth_transition_is_monotone(
        log_tau in 0.0_f32..6.0,
        x in 0.0_f32..2.0,
        off in 0.0_f32..0.99,
    ) {
        let tau = 10_f32.powf(log_tau);
        let at = |x: f32| smooth_quality_threshold(tau, x * tau * tau, off);
        let (here, next) = (at(x), at(x + 1e-4));
        prop_assert!(here >= tau && here <= TAU_MAX);
        prop_assert!(next <= here * (1.0 + 1e-5));
        if x > 1.0 {
            prop_assert_eq!(here, tau);
            prop_assert_eq!(quality_threshold(tau, x * tau * tau), tau);
        }
        if x < 0.999 {
            prop_assert_eq!(quality_threshold(tau, x * tau * tau), TAU_MAX);
        }
        if x < off * 0.999 {
            prop_assert_eq!(here, TAU_MAX);
        }
        // The reciprocal, how much is regularised, has no jump.
        prop_assert!((tau / here - tau / next).abs() < 3e-4 / (1.0 - off) + 1e-5);
    }

    /// Finite and not negative, whatever is put in.
    #[test]
    fn heuristics_are_total(
        a in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        b in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        c in prop::num::f32::NORMAL | prop::num::f32::ZERO,
    ) {
        let mut q = SamplerQuality::EMPTY;
        q.add(a, b, c);
        q.add(b, c, a);
        prop_assert!(q.value().is_finite() && q.value() >= 0.0);
        let mut diffusion = PathDiffusion::SHARP;
        for _ in 0..4 {
            diffusion.scatter(a, b);
            diffusion.travel(c);
        }
        prop_assert!(diffusion.position.is_finite() && diffusion.direction.is_finite());
        for tau in [quality_threshold(a, b), smooth_quality_threshold(a, b, c), diffusion_threshold(a, &diffusion)] {
            prop_assert!(tau.is_finite() && tau <= TAU_MAX.max(a));
        }
    }
}

/// Sharp until the first scattering, where tau' is infinite; then the blur of each lobe adds up.
#[test]
fn diffusion_follows_the_equations() {
    let mut d = PathDiffusion::SHARP;
    d.travel(3.0);
    assert_eq!((d.position, d.direction), (0.0, 0.0));
    assert_eq!(diffusion_threshold(10.0, &d), TAU_MAX);
    let rho = 8.0;
    d.scatter(rho, 0.5);
    let lobe = 1.0 / (2.0 * PI * rho).sqrt();
    assert!((d.direction - lobe).abs() < 1e-6);
    assert!((diffusion_threshold(10.0, &d) - 10.0 / lobe).abs() < 1e-3);
    d.travel(2.0);
    assert!((d.position - 2.0 * lobe).abs() < 1e-6);
    // Curvature turns the footprint into directions, of either sign.
    d.scatter(TAU_MAX, -0.25);
    assert!((d.direction - (lobe + 0.5 * lobe)).abs() < 1e-6);
}

/// A rough mirror under a sharp beam, and a screen behind it: the spot on the screen is as wide as the segment from
/// the mirror spreads by the deviation after scattering. Equation 20 as printed, with that before it, would give a
/// point.
#[test]
fn the_footprint_grows_by_the_deviation_after_scattering() {
    let mirror = Lobe {
        alpha: Vec2::splat(0.02),
        distribution: distribution::BECKMANN,
        ..common::lobes::conductor(lobe_kind::ROUGH_CONDUCTOR)
    };
    let wi = Vec3::Z;
    let distance = 5.0;
    let mut random = Random(3);
    let n = 50_000;
    let mut square = 0.0_f64;
    let mut peak = 0.0_f32;
    for _ in 0..n {
        let s = lobe::sample(&mirror, &[], wi, 0.5, random.next_2d());
        square += f64::from((s.wo.x / s.wo.z * distance).powi(2));
        peak = peak.max(s.pdf);
    }
    let simulated = (square / f64::from(n)).sqrt() as f32;
    let mut d = PathDiffusion::SHARP;
    d.travel(1.0);
    // The density's own maximum stands for rho: the bound over all directions would include grazing angles.
    d.scatter(peak, 0.0);
    d.travel(distance);
    assert!(
        (d.position / simulated - 1.0).abs() < 0.05,
        "{} {simulated}",
        d.position
    );
    // sigma = alpha sqrt(2): twice the slope's deviation alpha / sqrt(2).
    assert!((d.direction / (0.02 * 2_f32.sqrt()) - 1.0).abs() < 0.05);
    assert!(microfacet::clamp_alpha(mirror.alpha) == mirror.alpha);
}

/// The mean of virtual merges over the sampler is f |cos| convolved with the constant cone, for diffuse and glossy
/// lobes within five standard errors; for a mirror the cone itself.
#[test]
fn virtual_merging_convolves_with_the_cone() {
    let mut random = Random(17);
    let wi = direction_at(30.0, 20.0);
    let mut glossy = common::lobes::conductor(lobe_kind::ROUGH_CONDUCTOR);
    glossy.alpha = Vec2::splat(0.3);
    let diffuse = common::lobes::white(lobe_kind::DIFFUSE);
    for (lobe, tau) in [(diffuse, 3.0), (glossy, 5.0), (glossy, 40.0)] {
        let w = direction_at(35.0, 195.0);
        let n = 200_000;
        let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
        for _ in 0..n {
            let s = lobe::sample(&lobe, &[], wi, random.next_1d(), random.next_2d());
            let merge = virtual_merge(&s, w, tau);
            assert!(merge.pdf == 0.0 || (merge.pdf / tau - 1.0).abs() < 1e-5);
            sum += f64::from(merge.value.y);
            squares += f64::from(merge.value.y).powi(2);
        }
        let mean = sum / f64::from(n);
        let error = ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
        // The convolution by uniform points of the cone, of which each is as likely.
        let cap = 1.0 / (2.0 * PI * tau);
        let frame = halflight_kernel::math::Frame::from_normal(w);
        let m = 40_000;
        let mut want = 0.0_f64;
        for _ in 0..m {
            let v = halflight_kernel::math::warp::square_to_uniform_cone(random.next_2d(), cap);
            want +=
                f64::from(lobe::eval_cosine(&lobe, &[], wi, frame.to_world(v)).y) / f64::from(m);
        }
        assert!(
            (mean - want).abs() < 5.0 * error + 0.01 * want,
            "{mean} {want} {error}"
        );
    }
    let mirror = common::lobes::conductor(lobe_kind::CONDUCTOR);
    let s = lobe::sample(&mirror, &[], wi, 0.5, Vec2::ZERO);
    let inside = virtual_merge(&s, s.wo, 100.0);
    assert!((inside.value / (s.weight * 100.0) - Vec3::ONE).length() < 1e-4);
    assert_eq!(virtual_merge(&s, wi, 100.0).pdf, 0.0);
}
