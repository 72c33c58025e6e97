//! Regularisation where it has poles: roughness near zero, indices near one, grazing pairs, thresholds from zero to beyond
//! the largest. No panic, nothing that is not finite, no negative value or density, every inverse of a bound in its range.
//!
//! One body for the fuzz target and for the test that feeds it random bytes.

#[path = "hostile_lobes.rs"]
pub mod hostile_lobes;

use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Bsdf, Lobe, lobe, lobe::eval_cosine_pdf as plain};
use halflight_kernel::regularize::bandwidth::{TAU_MAX, cone_tangent, cone_value, tau_schedule};
use halflight_kernel::regularize::bounds::{
    ALPHA_MAX, raise, reflection_alpha, reflection_bound, refraction_alpha, refraction_bound,
    refraction_factor, tight_refraction_alpha, tight_refraction_bound,
};
use halflight_kernel::regularize::heuristic::{
    PathDiffusion, diffusion_threshold, quality_threshold, smooth_quality_threshold,
};
use halflight_kernel::regularize::regularized_bsdf::{
    alpha_hat, bound, eval_cosine_pdf, mixture_bound, mixture_eval_cosine_pdf, regularized_lobe,
};
use halflight_kernel::regularize::{cone, mollifier};
use halflight_kernel::scene::MAX_LOBES;
use halflight_kernel::scene::lobe_kind;
use hostile_lobes::Bytes;

/// What a case has reached, for the test that wants to know that cases are not all trivial.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reached {
    /// A lobe was made rougher.
    pub rougher: bool,
    /// A regularised lobe had a value.
    pub positive: bool,
}

fn is_threshold(tau: f32) -> bool {
    tau.is_finite() && tau >= 0.0
}

/// Makes lobes, a pair of directions and a threshold out of bytes and calls everything on them.
pub fn check(bytes: &[u8]) -> Reached {
    let mut input = Bytes(bytes);
    let tau = input.magnitude();
    let count = 1 + usize::from(input.byte()) % 3;
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    for lobe in &mut lobes[..count] {
        *lobe = input.lobe();
        if lobe.kind == lobe_kind::DIFFRACTING_CONDUCTOR {
            // Regularisation leaves it alone, and its table is another target's.
            lobe.kind = lobe_kind::ROUGH_DIELECTRIC;
        }
    }
    let wi = input.direction();
    let wo = match input.byte() % 4 {
        // The pairs where lobes peak: mirrored, straight on, straight back.
        0 => Vec3::new(-wi.x, -wi.y, wi.z),
        1 => -wi,
        2 => wi,
        _ => input.direction(),
    };
    let u = [input.number(), input.number(), input.number()];
    bounds_of(&lobes[0], tau);
    thresholds_of(tau, input.magnitude(), input.magnitude());

    let mut reached = Reached::default();
    for l in &lobes[..count] {
        reached.rougher |= values_of(l, wi, wo, tau);
        reached.positive |= eval_cosine_pdf(l, &[], wi, wo, tau).1 > 0.0;
        samples_of(l, wi, u, tau);
    }
    let bsdf = Bsdf::from_lobes(lobes, count as u32, &[], wi);
    let (f, p) = mixture_eval_cosine_pdf(&bsdf, &[], wi, wo, tau);
    assert!(f.is_finite() && f.min_element() >= 0.0, "{f} {lobes:?}");
    assert!(p.is_finite() && p >= 0.0, "{p} {lobes:?} {wi} {wo} {tau}");
    for transmission in [false, true] {
        assert!(is_threshold(mixture_bound(&bsdf, transmission)));
    }
    reached
}

/// The bounds of every distribution at the lobe's roughness, and their inverses at the threshold.
fn bounds_of(lobe: &Lobe, tau: f32) {
    let (alpha, eta) = (lobe.alpha, lobe.eta.x);
    let factor = refraction_factor(eta);
    assert!(
        (1.0..=TAU_MAX).contains(&factor) || factor > 0.0,
        "{factor} {eta}"
    );
    for kind in 0..4 {
        for masking in 0..2 {
            let found = [
                (
                    reflection_alpha(masking, kind, tau),
                    reflection_bound(masking, kind, alpha),
                ),
                (
                    refraction_alpha(masking, kind, tau, eta),
                    refraction_bound(masking, kind, alpha, eta),
                ),
                (
                    tight_refraction_alpha(kind, tau, eta),
                    tight_refraction_bound(kind, alpha.x, eta),
                ),
            ];
            for (inverse, bound) in found {
                assert!((0.0..=ALPHA_MAX).contains(&inverse), "{inverse} {tau}");
                assert!((0.0..=TAU_MAX).contains(&bound), "{bound} {alpha}");
            }
            // Where a roughness will do, it does, up to the largest threshold.
            let a = found[0].0;
            if a < ALPHA_MAX {
                let raised = reflection_bound(masking, kind, raise(alpha, a));
                assert!(raised <= tau * (1.0 + 1e-4), "{raised} {tau}");
            }
            let a = found[1].0;
            if a < ALPHA_MAX {
                let raised = refraction_bound(masking, kind, raise(alpha, a), eta);
                assert!(raised <= tau * (1.0 + 1e-4), "{raised} {tau} {eta}");
            }
            let a = found[2].0;
            if a < ALPHA_MAX {
                let raised = tight_refraction_bound(kind, alpha.x.max(a), eta);
                assert!(raised <= tau * (1.0 + 1e-4), "{raised} {tau} {eta}");
            }
        }
    }
}

/// What turns one threshold into another, or into a cone.
fn thresholds_of(tau: f32, x: f32, y: f32) {
    assert!(is_threshold(cone_tangent(tau)) && is_threshold(cone_value(cone_tangent(tau))));
    assert!(is_threshold(tau_schedule(tau, x.min(1e6) as u32)));
    assert!(is_threshold(quality_threshold(tau, x)));
    assert!(is_threshold(smooth_quality_threshold(tau, x, y)));
    let mut diffusion = PathDiffusion::SHARP;
    diffusion.scatter(x, y);
    diffusion.travel(y);
    diffusion.scatter(y, x);
    assert!(is_threshold(diffusion_threshold(tau, &diffusion)));
    let cap = cone::one_minus_cos_of_tau(tau);
    assert!(cap > 0.0 && cap <= 2.0, "{cap}");
    for kind in 0..4 {
        let w = cone::sample(kind, Vec3::Z, cap, Vec2::new(0.3, 0.999_999_9));
        let value = cone::eval(kind, Vec3::Z, w, cap);
        assert!((w.length() - 1.0).abs() < 1e-4 && is_threshold(value));
        assert!(is_threshold(mollifier::eval_scaled(kind, 2, x, y)));
    }
}

/// Value and density of one lobe. Whether it became rougher.
fn values_of(l: &Lobe, wi: Vec3, wo: Vec3, tau: f32) -> bool {
    let (f, p) = eval_cosine_pdf(l, &[], wi, wo, tau);
    assert!(
        f.is_finite() && f.min_element() >= 0.0,
        "{f} {l:?} {wi} {wo} {tau}"
    );
    assert!(p.is_finite() && p >= 0.0, "{p} {l:?} {wi} {wo} {tau}");
    let transmission = wi.z * wo.z < 0.0;
    let hat = alpha_hat(l, transmission, tau);
    assert!((0.0..=ALPHA_MAX).contains(&hat), "{hat} {l:?} {tau}");
    assert!(is_threshold(bound(l, false)) && is_threshold(bound(l, true)));
    let rough = regularized_lobe(l, transmission, tau);
    if rough.kind == l.kind && rough.alpha == l.alpha && l.kind != lobe_kind::THIN_DIELECTRIC {
        // Nothing to regularise: the lobe's own value and density, but for the rounding of a ratio of one.
        let (own, density) = plain(l, &[], wi, wo);
        assert!(f == own, "{f} {own} {l:?}");
        assert!((p - density).abs() <= 1e-5 * density, "{p} {density} {l:?}");
        return false;
    }
    true
}

/// A sample of the regularised lobe.
fn samples_of(l: &Lobe, wi: Vec3, u: [f32; 3], tau: f32) {
    for transmission in [false, true] {
        let rough = regularized_lobe(l, transmission, tau);
        let s = lobe::sample(&rough, &[], wi, u[0], Vec2::new(u[1], u[2]));
        assert!(s.pdf.is_finite() && s.pdf >= 0.0, "{s:?} {rough:?} {wi}");
        if s.pdf > 0.0 {
            assert!(
                s.weight.is_finite() && s.weight.min_element() >= 0.0,
                "{s:?} {rough:?} {wi}"
            );
            // A sampled direction has a density for multiple importance sampling.
            let (f, p) = eval_cosine_pdf(l, &[], wi, s.wo, tau);
            assert!(f.is_finite() && p.is_finite() && p >= 0.0, "{s:?} {l:?}");
        }
    }
}
