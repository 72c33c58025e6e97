//! alpha-hat inverts the bounds of BSDFs, and both are total.

use glam::Vec2;
use halflight_kernel::regularize::bounds::{
    self, SMITH, V_CAVITY, reflection_alpha, reflection_bound, refraction_alpha, refraction_bound,
    refraction_factor, tight_refraction_alpha, tight_refraction_bound,
};
use halflight_kernel::scene::distribution;
use proptest::prelude::*;

const BECKMANN: u32 = distribution::BECKMANN;
const GGX: u32 = distribution::GGX;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// alpha_hat is the inverse where it is below 1, and keeps both axes under tau on its own.
    #[test]
    fn alpha_hat_inverts_the_bound(
        masking in 0_u32..2,
        kind in 0_u32..3,
        log_tau in 0.7_f32..12.0,
        eta in prop_oneof![0.4_f32..0.95, 1.05_f32..3.0],
        alpha in (1e-4_f32..1.0, 1e-4_f32..1.0),
    ) {
        let tau = 10_f32.powf(log_tau);
        let a = reflection_alpha(masking, kind, tau);
        let at = reflection_bound(masking, kind, Vec2::splat(a));
        prop_assert!((at / tau - 1.0).abs() < 1e-5, "{at} {tau}");
        let t = refraction_alpha(masking, kind, tau, eta);
        let through = refraction_bound(masking, kind, Vec2::splat(t), eta);
        if t < 1.0 {
            prop_assert!((through / tau - 1.0).abs() < 1e-5, "{through} {tau}");
        } else {
            prop_assert!(through >= tau * (1.0 - 1e-5));
        }
        let t = tight_refraction_alpha(kind, tau, eta);
        if t < 1.0 {
            let through = tight_refraction_bound(kind, t, eta);
            prop_assert!((through / tau - 1.0).abs() < 1e-5, "{through} {tau}");
            prop_assert!(t <= refraction_alpha(SMITH, kind, tau, eta) * 1.0001);
            // Rougher lobes stay below.
            prop_assert!(tight_refraction_bound(kind, t.max(alpha.0), eta) <= tau * (1.0 + 1e-5));
        }
        let alpha = Vec2::new(alpha.0, alpha.1);
        let raised = bounds::raise(alpha, a);
        prop_assert!(reflection_bound(masking, kind, raised) <= tau * (1.0 + 1e-5));
        prop_assert!(raised.x == alpha.x.max(a) && raised.y == alpha.y.max(a));
    }

    /// The same boundary from either side, and every value finite.
    #[test]
    fn bounds_are_total(
        masking in any::<u32>(),
        kind in 0_u32..4,
        x in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        y in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        eta in 0.01_f32..100.0,
    ) {
        let alpha = Vec2::new(x.abs(), y.abs());
        for value in [
            reflection_bound(masking, kind, alpha),
            refraction_bound(masking, kind, alpha, eta),
            refraction_bound(masking, kind, alpha, y),
            reflection_alpha(masking, kind, x),
            refraction_alpha(masking, kind, x, eta),
            tight_refraction_bound(kind, x.abs(), eta),
            tight_refraction_alpha(kind, x, y),
        ] {
            prop_assert!(value.is_finite() && value >= 0.0);
        }
        let (a, b) = (refraction_factor(eta), refraction_factor(1.0 / eta));
        prop_assert!((a / b - 1.0).abs() < 1e-5 * (1.0 + a.sqrt()), "{a} {b}");
    }
}

/// The table of the paper for tau = 10 and n = 1.5.
#[test]
fn thresholds_of_ten() {
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-3, "{a} {b}");
    close(reflection_alpha(V_CAVITY, GGX, 10.0), 0.0892);
    close(reflection_alpha(SMITH, GGX, 10.0), 0.4224);
    close(reflection_alpha(SMITH, BECKMANN, 10.0), 0.5623);
    close(refraction_alpha(V_CAVITY, GGX, 10.0, 1.5), 0.535);
    // 1.035 and 1.377 before the clamp.
    assert_eq!(refraction_alpha(SMITH, GGX, 10.0, 1.5), 1.0);
    assert_eq!(refraction_alpha(SMITH, BECKMANN, 10.0, 1.5), 1.0);
    close(
        refraction_alpha(SMITH, GGX, 100.0, 1.5),
        1.0353 * 0.1_f32.powf(0.25),
    );
}
