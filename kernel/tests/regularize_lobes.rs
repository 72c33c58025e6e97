//! Regularised lobes: those that are left alone, anisotropic axes and perturbed frames, thin slabs, mixtures.

mod common;

use common::lobes::{conductor, rough_cases, white};
use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Bsdf, lobe};
use halflight_kernel::math::Frame;
use halflight_kernel::regularize::bandwidth::TAU_MAX;
use halflight_kernel::regularize::regularized_bsdf::{
    bound, eval_cosine_pdf, masking_ratio, mixture_bound, mixture_eval_cosine_pdf, regularized_lobe,
};
use halflight_kernel::scene::{distribution, lobe_kind};

/// What is not to be regularised: diffuse and null lobes, equal indices, rough lobes at large tau.
#[test]
fn other_lobes_are_left_alone() {
    let mut matched = white(lobe_kind::DIELECTRIC);
    matched.eta = Vec3::ONE;
    let mut rough_matched = matched;
    rough_matched.kind = lobe_kind::ROUGH_DIELECTRIC;
    rough_matched.alpha = Vec2::splat(0.2);
    let untouched = [
        white(lobe_kind::DIFFUSE),
        white(lobe_kind::NULL),
        matched,
        rough_matched,
    ];
    for lobe in untouched {
        for transmission in [false, true] {
            let r = regularized_lobe(&lobe, transmission, 10.0);
            assert_eq!((r.kind, r.alpha), (lobe.kind, lobe.alpha));
        }
        let (wi, wo) = (direction_at(30.0, 0.0), direction_at(150.0, 180.0));
        let own = lobe::eval_cosine_pdf(&lobe, &[], wi, wo);
        assert_eq!(eval_cosine_pdf(&lobe, &[], wi, wo, 10.0), own);
    }
    for case in rough_cases() {
        let (wi, wo) = (direction_at(30.0, 0.0), direction_at(40.0, 170.0));
        let own = lobe::eval_cosine_pdf(&case.lobe, &case.data, wi, wo);
        assert_eq!(
            eval_cosine_pdf(&case.lobe, &case.data, wi, wo, TAU_MAX),
            own
        );
        // alpha_hat is below every roughness of the cases.
        let high = eval_cosine_pdf(&case.lobe, &case.data, wi, wo, 1e9);
        assert!(
            (high.0 - own.0).length() <= 1e-6 * own.0.length(),
            "{}",
            case.name
        );
        assert!((high.1 - own.1).abs() <= 1e-5 * own.1, "{}", case.name);
    }
}

/// Anisotropic axes are raised one by one; a two-sided lobe in a perturbed frame gives what it gives in its own frame.
#[test]
fn axes_and_frames_are_respected() {
    let mut lobe = conductor(lobe_kind::ROUGH_CONDUCTOR);
    lobe.alpha = Vec2::new(0.01, 0.6);
    lobe.distribution = distribution::GGX;
    let r = regularized_lobe(&lobe, false, 100.0);
    let hat = (std::f32::consts::PI * 100.0).powf(-0.25);
    assert!((r.alpha.x - hat).abs() < 1e-5 && r.alpha.y == 0.6);
    assert!(bound(&r, false) <= 100.0 && bound(&lobe, false) > 1e4);
    let ratio = masking_ratio(&lobe, &r, Vec3::Z, Vec3::Z);
    assert!((ratio - 1.0).abs() < 1e-6);

    let mut perturbed = lobe;
    perturbed.has_frame = true;
    perturbed.frame = Frame::from_normal(Vec3::new(0.2, -0.1, 0.95).normalize());
    let (wi, wo) = (direction_at(30.0, 10.0), direction_at(20.0, 160.0));
    let (f, p) = eval_cosine_pdf(&perturbed, &[], wi, wo, 100.0);
    let (li, lo) = (perturbed.frame.to_local(wi), perturbed.frame.to_local(wo));
    let (g, q) = eval_cosine_pdf(&lobe, &[], li, lo, 100.0);
    assert!((p / q - 1.0).abs() < 1e-4, "{p} {q}");
    // The value has the terminator's shadowing in addition.
    assert!(f.y > 0.5 * g.y && f.y <= g.y * 1.0001, "{f} {g}");
}

/// Thin slabs reflect and transmit into cones of value tau that hold the whole energy.
#[test]
fn thin_slabs_are_cones() {
    let slab = white(lobe_kind::THIN_DIELECTRIC);
    let wi = direction_at(25.0, 60.0);
    let tau = 50.0;
    let reflected = lobe::sample(&slab, &[], wi, 0.0, Vec2::ZERO).pdf;
    let mut random = Random(6);
    for (axis, share) in [
        (Vec3::new(-wi.x, -wi.y, wi.z), reflected),
        (-wi, 1.0 - reflected),
    ] {
        let (f, p) = eval_cosine_pdf(&slab, &[], wi, axis, tau);
        assert!((p - share * tau).abs() < 1e-4 * tau && (f.y - p).abs() < 1e-5 * tau);
        // Solid angle of the support by uniform samples around the axis.
        let half = (1.0 - 1.0 / (6.2831855 * tau)).acos() * 1.5;
        let cap = 1.0 - half.cos();
        let (mut inside, n) = (0.0, 40_000);
        for _ in 0..n {
            let w = halflight_kernel::math::warp::square_to_uniform_cone(random.next_2d(), cap);
            let w = Frame::from_normal(axis).to_world(w);
            inside += eval_cosine_pdf(&slab, &[], wi, w, tau).1;
        }
        let mass = inside / n as f32 * 6.2831855 * cap;
        assert!((mass / share - 1.0).abs() < 0.03, "{mass} {share}");
    }
}

#[test]
fn mixtures_add_their_lobes() {
    let (lobes, count) = common::lobes::mixture();
    let wi = direction_at(30.0, 10.0);
    let bsdf = Bsdf::from_lobes(lobes, count, &[], wi);
    let wo = direction_at(32.0, 192.0);
    let (f, p) = mixture_eval_cosine_pdf(&bsdf, &[], wi, wo, TAU_MAX);
    let (own_f, own_p) = bsdf.eval_cosine_pdf(&[], wi, wo);
    assert!((f - own_f).length() < 1e-6 && (p - own_p).abs() < 1e-6);
    // The mirror among them has a value now.
    let (f_hat, p_hat) = mixture_eval_cosine_pdf(&bsdf, &[], wi, wo, 1000.0);
    assert!(f_hat.y > own_f.y && p_hat > own_p);
    assert_eq!(mixture_bound(&bsdf, false), 0.3 * TAU_MAX);
}
