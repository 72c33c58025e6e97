//! Fresnel reflectance and the directions of reflection and refraction, against `f64` and against physics.

use glam::Vec3;
use halflight_kernel::bsdf::fresnel::{
    fresnel_conductor, fresnel_dielectric, fresnel_diffuse_reflectance, reflect, refract,
    relative_eta,
};
use proptest::prelude::*;

/// Textbook formula in f64; `cos_i` in [0, 1], `e` transmitted over incident.
fn dielectric_f64(cos_i: f64, e: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (e * e);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let r_s = (cos_i - e * cos_t) / (cos_i + e * cos_t);
    let r_p = (e * cos_i - cos_t) / (e * cos_i + cos_t);
    0.5 * (r_s * r_s + r_p * r_p)
}

/// Complex numbers as pairs, for the conductor's reference.
type Complex = (f64, f64);
fn mul(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}
fn sqrt(a: Complex) -> Complex {
    let r = a.0.hypot(a.1);
    let re = (0.5 * (r + a.0)).max(0.0).sqrt();
    (re, if re > 0.0 { 0.5 * a.1 / re } else { r.sqrt() })
}
fn norm2(a: Complex) -> f64 {
    a.0 * a.0 + a.1 * a.1
}

/// Fresnel's amplitudes with complex numbers: r_s = (c - q) / (c + q), r_p = (n^2 c - q) / (n^2 c + q), with
/// q = sqrt(n^2 - sin^2).
fn conductor_f64(c: f64, eta: f64, k: f64) -> f64 {
    let n2 = mul((eta, k), (eta, k));
    let q = sqrt((n2.0 - (1.0 - c * c), n2.1));
    let r_s = norm2((c - q.0, -q.1)) / norm2((c + q.0, q.1));
    let r_p = norm2((n2.0 * c - q.0, n2.1 * c - q.1)) / norm2((n2.0 * c + q.0, n2.1 * c + q.1));
    0.5 * (r_s + r_p)
}

/// Closed form of the external hemispherical mean (Walsh 1926), `n > 1`.
fn diffuse_f64(n: f64) -> f64 {
    let n2 = n * n;
    let n4 = n2 * n2;
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln()
}

#[test]
fn dielectric_limits() {
    for eta in [1.1_f32, 1.33, 1.5, 2.4, 3.0] {
        let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
        for c in [1.0, -1.0] {
            let (f, cos_t) = fresnel_dielectric(c, eta);
            assert!((f - normal).abs() < 1e-7 && (cos_t + c).abs() < 1e-6);
        }
        // Grazing: total reflection from both sides.
        assert_eq!(fresnel_dielectric(0.0, eta).0, 1.0);
        assert_eq!(fresnel_dielectric(-1e-6, eta), (1.0, 0.0));
        // Beyond the critical angle, and just inside it.
        let critical = -(1.0 - 1.0 / (eta * eta)).sqrt();
        assert_eq!(fresnel_dielectric(critical * 0.999, eta), (1.0, 0.0));
        assert!(fresnel_dielectric(critical * 1.001, eta).0 < 1.0);
    }
}

#[test]
fn equal_indices_reflect_nothing() {
    for i in -100..=100 {
        let c = i as f32 * 0.01;
        assert_eq!(fresnel_dielectric(c, 1.0), (0.0, -c));
    }
    assert_eq!(fresnel_conductor(0.3, Vec3::ONE, Vec3::ZERO), Vec3::ZERO);
}

#[test]
fn conductor_limits() {
    let eta = Vec3::new(0.143, 0.375, 1.442);
    let k = Vec3::new(3.983, 2.386, 1.603);
    assert!(
        (fresnel_conductor(0.0, eta, k) - Vec3::ONE)
            .abs()
            .max_element()
            < 1e-6
    );
    // Perfect mirrors, as formats write them: an index of i, and no index at all.
    for c in [0.0, 0.1, 1.0] {
        assert_eq!(fresnel_conductor(c, Vec3::ZERO, Vec3::ONE), Vec3::ONE);
        assert!(fresnel_conductor(c, Vec3::ZERO, Vec3::ZERO).is_finite());
    }
}

#[test]
fn diffuse_reflectance_is_the_closed_form() {
    for i in 1..=200 {
        let n = 1.0 + 0.01 * f64::from(i);
        let want = diffuse_f64(n);
        let external = f64::from(fresnel_diffuse_reflectance(n as f32));
        assert!((external - want).abs() < 1e-5, "{n}: {external} {want}");
        let internal = f64::from(fresnel_diffuse_reflectance((1.0 / n) as f32));
        let want = 1.0 - (1.0 - want) / (n * n);
        assert!((internal - want).abs() < 1e-5, "{n}: {internal} {want}");
    }
    assert!(fresnel_diffuse_reflectance(1.0).abs() < 1e-6);
    // Internal means of water, glass and flint, known to four digits.
    for (n, want) in [(1.33, 0.4719), (1.5, 0.5963), (1.8, 0.7327)] {
        assert!((fresnel_diffuse_reflectance(1.0 / n) - want).abs() < 1e-4);
    }
}

#[test]
fn nearly_equal_indices_keep_their_digits() {
    // Here the textbook formula in f32 has no digit left: F is about (delta/2)^2.
    for delta in [1e-3_f32, 1e-4, 1e-5, 1e-6] {
        for c in [1.0_f32, 0.7, 0.3, 0.1] {
            let eta = 1.0 + delta;
            let want = dielectric_f64(f64::from(c), f64::from(eta));
            let got = f64::from(fresnel_dielectric(c, eta).0);
            assert!(
                (got / want - 1.0).abs() < 1e-4,
                "{eta} {c}: {got:e} {want:e}"
            );
        }
    }
}

fn unit() -> impl Strategy<Value = Vec3> {
    (-1.0_f32..=1.0, 0.0_f32..core::f32::consts::TAU).prop_map(|(z, phi)| {
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 4096,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn dielectric_is_the_textbook_formula(cos_i in -1.0_f32..=1.0, eta in 1.0_f32 / 3.0..3.0) {
        let got = f64::from(fresnel_dielectric(cos_i, eta).0);
        // Backward error: the reference at arguments within two roundings, because F has a vertical tangent at the
        // critical angle.
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for dc in [-2.4e-7, 0.0, 2.4e-7] {
            for de in [-2.4e-7, 0.0, 2.4e-7] {
                let e = f64::from(eta) * (1.0 + de);
                let e = if cos_i >= 0.0 { e } else { 1.0 / e };
                let f = dielectric_f64((f64::from(cos_i.abs()) * (1.0 + dc)).min(1.0), e);
                low = low.min(f);
                high = high.max(f);
            }
        }
        prop_assert!(got > low - 1e-6 && got < high + 1e-6, "{} not in {} .. {}", got, low, high);
    }

    #[test]
    fn stokes_reciprocity(cos_i in -1.0_f32..=1.0, eta in 1.0_f32 / 3.0..3.0) {
        // The refracted ray, reversed, is reflected as much.
        let (f, cos_t) = fresnel_dielectric(cos_i, eta);
        if cos_t.abs() < 0.05 || cos_i.abs() < 0.05 {
            return Ok(()); // steep: the rounding of a cosine shows
        }
        let (g, back) = fresnel_dielectric(cos_t, eta);
        prop_assert!((f - g).abs() < 4e-5, "{} {}", f, g);
        // A rounding of 1 - cos^2, times eta^2, over the cosine itself.
        prop_assert!((back - cos_i).abs() < 2e-5, "{} {}", back, cos_i);
    }

    #[test]
    fn conductor_is_the_complex_formula(c in 0.0_f32..=1.0, eta in 0.05_f32..6.0, k in 0.0_f32..8.0) {
        let want = conductor_f64(f64::from(c), f64::from(eta), f64::from(k));
        let got = f64::from(fresnel_conductor(c, Vec3::splat(eta), Vec3::splat(k)).x);
        // Without absorption and below 1 the critical angle is as steep as a dielectric's.
        let tolerance = if k < 0.05 && eta < 1.1 { 2e-3 } else { 4e-6 };
        prop_assert!((got - want).abs() < tolerance, "{} {}", got, want);
    }

    #[test]
    fn conductor_without_absorption_is_a_dielectric(c in 0.0_f32..=1.0, eta in 1.05_f32..3.0) {
        let got = fresnel_conductor(c, Vec3::splat(eta), Vec3::ZERO).x;
        prop_assert!((got - fresnel_dielectric(c, eta).0).abs() < 5e-6);
    }

    #[test]
    fn refraction_obeys_snell(w in unit(), m in unit(), eta in 1.0_f32 / 3.0..3.0) {
        let cos_i = w.dot(m);
        let (_, cos_t) = fresnel_dielectric(cos_i, eta);
        let r = reflect(w, m);
        prop_assert!((r.dot(m) - cos_i).abs() < 1e-6 && (r.length() - 1.0).abs() < 1e-6);
        prop_assert!(r.cross(m).abs_diff_eq(-w.cross(m), 1e-6));
        if cos_t == 0.0 {
            return Ok(());
        }
        let e = relative_eta(cos_i, eta);
        let t = refract(w, m, cos_t, e);
        prop_assert!((t.length() - 1.0).abs() < 2e-6);
        prop_assert!((t.dot(m) - cos_t).abs() < 1e-6 && cos_i * cos_t <= 0.0);
        // Snell with directions: w + eta t has no part across m.
        prop_assert!((w + t * e).cross(m).length() < 2e-6);
    }

    #[test]
    fn everything_is_finite(c in any::<f32>(), eta in any::<f32>(), k in any::<f32>()) {
        prop_assume!(c.is_finite() && eta.is_finite() && k.is_finite());
        let c = c.clamp(-1.0, 1.0);
        let (f, cos_t) = fresnel_dielectric(c, eta);
        prop_assert!((0.0..=1.0).contains(&f) && cos_t.abs() <= 1.0 + 1e-6);
        let (eta, k) = (eta.abs().min(1e6), k.abs().min(1e6));
        let f = fresnel_conductor(c, Vec3::splat(eta), Vec3::splat(k)).x;
        prop_assert!((0.0..=1.0).contains(&f), "{}", f);
    }
}
