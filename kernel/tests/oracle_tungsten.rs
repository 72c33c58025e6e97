//! Rough conductors, rough dielectrics and Oren-Nayar against numbers from Tungsten (2019).
//!
//! Values only: Tungsten samples dielectrics from a wider distribution and conductors from all normals, so its
//! densities are others.

mod common;

use common::oracle::{Row, rows};
use glam::Vec3;
use halflight_kernel::bsdf::{Lobe, lobe};
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};

/// The tolerance table, relative.
mod tolerance {
    /// Rounding of the half vector through D, whose logarithm is steep in the tail.
    pub const VALUE: f64 = 5e-5;
    /// Over alpha squared: Tungsten takes the tangent of the half vector from its cosine, which beside 1 has steps of
    /// 6e-8, through D.
    pub const COSINE: f64 = 4e-7;
    /// Dielectrics: beside the critical angle Tungsten computes 1 - F with cancellation (in f64 the row that is worst
    /// gives our value to 1e-5).
    pub const CRITICAL_ANGLE: f64 = 3e-4;
    /// Beckmann and Phong as they are: Tungsten's masking is the rational fit, ours the exact expression.
    pub const RATIONAL_FIT: f64 = 8e-3;
    /// The angles by acos and atan2, which Tungsten takes from cosines near 1.
    pub const OREN_NAYAR: f64 = 1e-4;
    /// Absolute: Tungsten sets what is below about 1e-20 to zero.
    pub const NOTHING: f64 = 1e-16;
}

macro_rules! tables {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!("oracle/tungsten/", $name, ".csv")))),*]
    };
}

/// The rational fit of Beckmann's masking over the exact expression.
fn rational_over_exact_g1(alpha: f64, w: Vec3) -> f64 {
    let (x, y, z) = (f64::from(w.x), f64::from(w.y), f64::from(w.z.abs()));
    let spread = alpha * x.hypot(y);
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

fn white(kind: u32) -> Lobe {
    Lobe {
        kind,
        flags: lobe_flag::FRONT | lobe_flag::BACK,
        weight: 1.0,
        reflectance: Vec3::ONE,
        specular_reflectance: Vec3::ONE,
        specular_transmittance: Vec3::ONE,
        eta: Vec3::splat(1.5),
        ..Lobe::NONE
    }
}

/// The BSDF without a cosine.
fn value(l: &Lobe, row: &Row) -> Vec3 {
    lobe::eval_cosine(l, &[], row.wi, row.wo) / row.wo.z.abs()
}

#[track_caller]
fn assert_close(name: &str, row: &Row, got: f64, want: f64, relative: f64) {
    assert!(
        (got - want).abs() <= relative * want.abs() + tolerance::NOTHING,
        "{name}: {got:e}, not {want:e}, at {row:?}"
    );
}

#[test]
fn microfacet_values_agree() {
    let tables = tables!(
        "rough_conductor-beckmann-0.05" "rough_conductor-beckmann-0.2" "rough_conductor-beckmann-0.6"
        "rough_conductor-ggx-0.05" "rough_conductor-ggx-0.2" "rough_conductor-ggx-0.6"
        "rough_conductor-phong-0.05" "rough_conductor-phong-0.2" "rough_conductor-phong-0.6"
        "rough_dielectric-beckmann-0.05" "rough_dielectric-beckmann-0.2" "rough_dielectric-beckmann-0.6"
        "rough_dielectric-ggx-0.05" "rough_dielectric-ggx-0.2" "rough_dielectric-ggx-0.6"
        "rough_dielectric-phong-0.05" "rough_dielectric-phong-0.2" "rough_dielectric-phong-0.6"
    );
    for (name, csv) in tables {
        let parts: Vec<&str> = name.split('-').collect();
        let mut l = white(if parts[0] == "rough_conductor" {
            lobe_kind::ROUGH_CONDUCTOR
        } else {
            lobe_kind::ROUGH_DIELECTRIC
        });
        if parts[0] == "rough_conductor" {
            l.eta = Vec3::new(0.143, 0.375, 1.442);
            l.k = Vec3::new(3.983, 2.386, 1.603);
        }
        l.distribution = match parts[1] {
            "ggx" => distribution::GGX,
            "phong" => distribution::PHONG,
            _ => distribution::BECKMANN,
        };
        let alpha: f32 = parts[2].parse().expect("a roughness");
        l.alpha = glam::Vec2::splat(alpha);
        let mut close = tolerance::VALUE + tolerance::COSINE / f64::from(alpha * alpha);
        if l.kind == lobe_kind::ROUGH_DIELECTRIC {
            close += tolerance::CRITICAL_ANGLE;
        }
        let mut compared = 0;
        for row in rows(csv) {
            let f = value(&l, &row);
            let fit = if l.distribution == distribution::GGX {
                1.0
            } else {
                rational_over_exact_g1(f64::from(alpha), row.wi)
                    * rational_over_exact_g1(f64::from(alpha), row.wo)
            };
            for c in 0..3 {
                let (got, want) = (f64::from(f[c]), f64::from(row.f[c]));
                assert_close(name, &row, got, want, tolerance::RATIONAL_FIT);
                assert_close(name, &row, got * fit, want, close);
            }
            compared += u32::from(row.f.max_element() > 1e-16);
        }
        assert!(compared > 40, "{name}: only {compared} values are not zero");
    }
}

#[test]
fn oren_nayar_values_agree() {
    for (name, csv) in tables!("oren_nayar-0.0" "oren_nayar-0.3" "oren_nayar-1.0") {
        let mut l = white(lobe_kind::ROUGH_DIFFUSE);
        l.reflectance = Vec3::new(0.2, 0.5, 0.8);
        l.alpha = glam::Vec2::splat(name[11..].parse().expect("a roughness"));
        for row in rows(csv) {
            let f = value(&l, &row);
            for c in 0..3 {
                assert_close(
                    name,
                    &row,
                    f64::from(f[c]),
                    f64::from(row.f[c]),
                    tolerance::OREN_NAYAR,
                );
            }
        }
    }
}
