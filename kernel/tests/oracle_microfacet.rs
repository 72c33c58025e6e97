//! Fresnel terms, rough conductors and rough dielectrics against numbers from Mitsuba 3.9.1.
//!
//! The files hold directions and values in eight digits; `wi` there is the direction that is known, as here.

mod common;

use common::lobes::specular;
use common::oracle::{Row, rows};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, fresnel, rough_conductor, rough_dielectric};
use halflight_kernel::scene::{distribution, lobe_kind};

/// The tolerance table. Errors are relative unless they say otherwise.
mod tolerance {
    /// Absolute. Both evaluate in f32; the formulas differ in rounding. Reached: 8.4e-7.
    pub const FRESNEL: f64 = 2e-6;
    /// Rounding of the half vector through D, whose logarithm is steep in the tail. Reached: 1.9e-5.
    pub const VALUE: f64 = 4e-5;
    /// As for the value, and 1 - F beside the critical angle, which the other renderer computes with cancellation.
    /// Reached: 2.6e-5.
    pub const DENSITY: f64 = 5e-5;
    /// Beckmann only: the other renderer's masking is a rational fit, up to 0.4 % off per direction; ours is exact.
    /// Reached: 6.2e-3.
    pub const RATIONAL_FIT: f64 = 8e-3;
    /// Absolute: the other renderer sets what is below about 1e-20 to zero, before factors that may be large.
    pub const NOTHING: f64 = 1e-16;
}

/// The rational fit of Beckmann's masking that Mitsuba uses in place of the exact expression (Walter et al. 2007).
fn rational_over_exact_g1(alpha: Vec2, w: Vec3) -> f64 {
    let (x, y, z) = (f64::from(w.x), f64::from(w.y), f64::from(w.z.abs()));
    let spread = (f64::from(alpha.x) * x).hypot(f64::from(alpha.y) * y);
    if spread == 0.0 {
        return 1.0;
    }
    let a = z / spread;
    let rational = if a >= 1.6 {
        1.0
    } else {
        (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
    };
    let exact = 2.0 / (1.0 + libm::erf(a) + libm::exp(-a * a) / (a * core::f64::consts::PI.sqrt()));
    rational / exact
}

#[test]
fn values_and_densities_agree() {
    for (name, csv, kind, dist, alpha) in files() {
        let lobe = lobe(kind, dist, alpha);
        let mut compared = 0;
        for r in rows(csv) {
            let (wi, wo) = (r.wi, r.wo);
            let (f, p) = if kind == lobe_kind::ROUGH_CONDUCTOR {
                (
                    rough_conductor::eval(&lobe, wi, wo),
                    rough_conductor::pdf(&lobe, wi, wo),
                )
            } else {
                (
                    rough_dielectric::eval(&lobe, wi, wo),
                    rough_dielectric::pdf(&lobe, wi, wo),
                )
            };
            // The raw agreement, and the one after our exact masking is replaced by the other renderer's fit.
            let (fit_i, fit_o) = if dist == distribution::BECKMANN {
                (
                    rational_over_exact_g1(alpha, wi),
                    rational_over_exact_g1(alpha, wo),
                )
            } else {
                (1.0, 1.0)
            };
            for c in 0..3 {
                let (got, want) = (f64::from(f[c]), f64::from(r.f[c]));
                assert_close(name, "value", &r, got, want, tolerance::RATIONAL_FIT);
                assert_close(
                    name,
                    "value",
                    &r,
                    got * fit_i * fit_o,
                    want,
                    tolerance::VALUE,
                );
            }
            let (got, want) = (f64::from(p), f64::from(r.pdf));
            assert_close(name, "density", &r, got, want, tolerance::RATIONAL_FIT);
            assert_close(name, "density", &r, got * fit_i, want, tolerance::DENSITY);
            compared += u32::from(want > tolerance::NOTHING);
        }
        assert!(
            compared > 40,
            "{name}: only {compared} densities are not zero"
        );
    }
}

fn assert_close(name: &str, what: &str, row: &Row, got: f64, want: f64, relative: f64) {
    assert!(
        (got - want).abs() <= relative * want.abs() + tolerance::NOTHING,
        "{name}: {what} {got:e}, not {want:e}, at {row:?}"
    );
}

fn lobe(kind: u32, distribution: u32, alpha: Vec2) -> Lobe {
    let mut lobe = specular(kind, distribution, alpha, 1.5);
    if kind == lobe_kind::ROUGH_CONDUCTOR {
        lobe.eta = Vec3::new(0.143, 0.375, 1.442);
        lobe.k = Vec3::new(3.983, 2.386, 1.603);
    }
    lobe
}

macro_rules! file {
    ($model:literal, $kind:ident, $name:literal, $distribution:ident, $alpha:literal, $u:expr, $v:expr) => {
        (
            concat!($model, "-", $name, "-", $alpha),
            include_str!(concat!(
                "oracle/mitsuba/",
                $model,
                "-",
                $name,
                "-",
                $alpha,
                ".csv"
            )),
            lobe_kind::$kind,
            distribution::$distribution,
            Vec2::new($u, $v),
        )
    };
}

type File = (&'static str, &'static str, u32, u32, Vec2);

fn files() -> Vec<File> {
    vec![
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "beckmann",
            BECKMANN,
            "0.05",
            0.05,
            0.05
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "beckmann",
            BECKMANN,
            "0.2",
            0.2,
            0.2
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "beckmann",
            BECKMANN,
            "0.6",
            0.6,
            0.6
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "beckmann",
            BECKMANN,
            "aniso",
            0.1,
            0.4
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "ggx",
            GGX,
            "0.05",
            0.05,
            0.05
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "ggx",
            GGX,
            "0.2",
            0.2,
            0.2
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "ggx",
            GGX,
            "0.6",
            0.6,
            0.6
        ),
        file!(
            "roughconductor",
            ROUGH_CONDUCTOR,
            "ggx",
            GGX,
            "aniso",
            0.1,
            0.4
        ),
        file!(
            "roughdielectric",
            ROUGH_DIELECTRIC,
            "beckmann",
            BECKMANN,
            "0.05",
            0.05,
            0.05
        ),
        file!(
            "roughdielectric",
            ROUGH_DIELECTRIC,
            "beckmann",
            BECKMANN,
            "0.2",
            0.2,
            0.2
        ),
        file!(
            "roughdielectric",
            ROUGH_DIELECTRIC,
            "beckmann",
            BECKMANN,
            "0.6",
            0.6,
            0.6
        ),
        file!(
            "roughdielectric",
            ROUGH_DIELECTRIC,
            "ggx",
            GGX,
            "0.05",
            0.05,
            0.05
        ),
        file!(
            "roughdielectric",
            ROUGH_DIELECTRIC,
            "ggx",
            GGX,
            "0.2",
            0.2,
            0.2
        ),
        file!(
            "roughdielectric",
            ROUGH_DIELECTRIC,
            "ggx",
            GGX,
            "0.6",
            0.6,
            0.6
        ),
    ]
}

#[test]
fn fresnel_agrees() {
    let csv = include_str!("oracle/mitsuba/fresnel.csv");
    let mut compared = 0;
    for line in csv.lines().skip(2) {
        let x: Vec<&str> = line.split(',').collect();
        let number = |i: usize| -> f32 { x[i].parse().expect("a number") };
        let (c, eta, k, want) = (number(1), number(2), number(3), number(4));
        let got = if x[0] == "dielectric" {
            fresnel::fresnel_dielectric(c, eta).0
        } else {
            fresnel::fresnel_conductor(c, Vec3::splat(eta), Vec3::splat(k)).x
        };
        let error = f64::from((got - want).abs());
        assert!(error <= tolerance::FRESNEL, "{line}: {got}");
        compared += 1;
    }
    assert_eq!(compared, 424);
}
