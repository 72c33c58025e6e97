//! The diffracting conductor: its tables against closed forms and limits, and the balance of its energy.

mod common;

use common::rough_cases::{diffracting, diffracting_cases};
use common::{Random, direction_at, furnace};
use glam::Vec3;
use halflight_kernel::bsdf::diffracting_conductor::fill_table;
use halflight_kernel::bsdf::diffraction_table::{
    COSINES, FineScale, HEADER, WORDS, ln_spectrum, rho,
};
use halflight_kernel::bsdf::{Lobe, lobe, mode};
use halflight_kernel::scene::lobe_kind;
use std::f64::consts::PI;

const SCALE: FineScale = FineScale {
    wavelengths: [0.6114, 0.5491, 0.4642],
    sigma: 0.05,
    b: 2.0,
    c: 2.2,
};

fn spectrum(scale: &FineScale, f: f64) -> f64 {
    let (b, c) = (f64::from(scale.b), f64::from(scale.c));
    b * b * (c - 1.0) / (2.0 * PI) * (1.0 + (b * f).powi(2)).powf(-0.5 * (c + 1.0))
}

fn table(scale: &FineScale, alpha: f32, exponent: f32) -> Vec<f32> {
    let mut data = vec![0.0; WORDS];
    fill_table(scale, alpha, exponent, &mut data);
    data
}

#[test]
fn share_of_real_directions_has_its_closed_form_at_normal_incidence() {
    for wavelength in [0.4, 0.55, 0.7] {
        let b = f64::from(SCALE.b) / wavelength;
        let want = 1.0 - (1.0 + b * b).powf(0.5 * (1.0 - f64::from(SCALE.c)));
        assert!((rho(&SCALE, wavelength, 1.0) - want).abs() < 1e-9);
        // At grazing incidence half of a narrow spectrum is below the horizon.
        let coarse = FineScale { b: 200.0, ..SCALE };
        assert!((rho(&coarse, wavelength, 0.0) - 0.5).abs() < 0.02);
    }
}

#[test]
fn smooth_facets_leave_the_spectrum_as_it_is() {
    let data = table(&SCALE, 2e-4, 1.0);
    let u_max = f64::from(SCALE.b / 0.4642);
    for i in 0..40 {
        for share in [0.05, 0.3, 0.7, 1.0] {
            let theta = 0.02 + 0.035 * f64::from(i);
            let u = u_max * share;
            let got = f64::from(ln_spectrum(&data, 0, theta as f32, u as f32)).exp();
            let want = spectrum(&SCALE, 2.0 * u * theta.sin() / f64::from(SCALE.b));
            // Linear interpolation of the logarithm; where u is small the rows are far apart in ratio.
            let tolerance = if share < 0.1 { 0.05 } else { 0.012 };
            assert!(
                (got / want - 1.0).abs() < tolerance,
                "{theta} {u}: {got} {want}"
            );
        }
    }
}

#[test]
fn a_narrow_spectrum_takes_the_shape_of_the_facets() {
    // b of 400 micrometres: the spectrum is far narrower than facets of alpha 0.3.
    let scale = FineScale {
        b: 400.0,
        c: 3.5,
        ..SCALE
    };
    let data = table(&scale, 0.3, 1.0);
    let u = f64::from(scale.b / 0.4642);
    for theta in [0.05_f64, 0.1, 0.2, 0.4, 0.6] {
        let t2 = theta.tan().powi(2) / 0.09;
        let d_cos = (-t2).exp() / (PI * 0.09 * theta.cos().powi(3));
        // The spectrum integrates to one over frequencies: over angles, to (b / 2 u)^2.
        let want = d_cos * (f64::from(scale.b) / (2.0 * u)).powi(2);
        let got = f64::from(ln_spectrum(&data, 0, theta as f32, u as f32)).exp();
        assert!((got / want - 1.0).abs() < 0.03, "{theta}: {got} {want}");
    }
}

#[test]
fn convolution_conserves_mass() {
    for (alpha, p) in [(0.05, 1.0), (0.1, 0.6), (0.02, 3.0)] {
        let scale = FineScale {
            b: 20.0,
            c: 3.0,
            ..SCALE
        };
        let data = table(&scale, alpha, p);
        let u = f64::from(scale.b / 0.4642);
        // Over the half vectors, with the frequency of a level facet: f = 2 u sin / b.
        let n = 40_000;
        let mut sum = 0.0;
        for i in 0..n {
            let q = (f64::from(i) + 0.5) / f64::from(n);
            let theta = 0.5 * PI * q.powi(3);
            let dtheta = 1.5 * PI * q * q / f64::from(n);
            let density = f64::from(ln_spectrum(&data, 0, theta as f32, u as f32)).exp();
            let df2 = (2.0 * u / f64::from(scale.b)).powi(2) * theta.sin() * theta.cos();
            sum += density * 2.0 * PI * df2 * dtheta;
        }
        assert!((sum - 1.0).abs() < 0.02, "{alpha} {p}: {sum}");
    }
}

#[test]
fn without_finer_roughness_it_is_the_rough_conductor() {
    let case = diffracting(0.2, 0.7, 0.0, 2.0, 2.0);
    let plain = Lobe {
        kind: lobe_kind::ROUGH_CONDUCTOR,
        ..case.lobe
    };
    let mut random = Random(2);
    for _ in 0..2_000 {
        let (wi, wo) = (random.upper_direction(), random.upper_direction());
        let got = lobe::eval_cosine(&case.lobe, &case.data, wi, wo);
        let want = lobe::eval_cosine(&plain, &[], wi, wo);
        assert!(
            (got - want).abs().max_element() <= 1e-5 * want.max_element(),
            "{got} {want}"
        );
    }
}

/// Complex numbers, for the polarisation factors.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn add(self, o: Complex) -> Complex {
        Complex(self.0 + o.0, self.1 + o.1)
    }
    fn scale(self, s: f64) -> Complex {
        Complex(self.0 * s, self.1 * s)
    }
    fn mul(self, o: Complex) -> Complex {
        Complex(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn norm2(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
    fn sqrt(self) -> Complex {
        let r = self.norm2().sqrt();
        Complex(
            (0.5 * (r + self.0)).max(0.0).sqrt(),
            (0.5 * (r - self.0)).max(0.0).sqrt(),
        )
    }
}

/// The four squared Rayleigh-Rice factors summed (Stover 1995, "Optical Scattering", chapter 5); phi is measured from the
/// plane of the mirror direction.
fn polarisation_sum(epsilon: Complex, theta_i: f64, theta_s: f64, phi: f64) -> f64 {
    let (si, ci) = theta_i.sin_cos();
    let (ss, cs) = theta_s.sin_cos();
    let (sp, cp) = phi.sin_cos();
    let root = |s: f64| epsilon.add(Complex(-s * s, 0.0)).sqrt();
    let (ri, rs) = (root(si), root(ss));
    let (di, ds) = (ri.add(Complex(ci, 0.0)), rs.add(Complex(cs, 0.0)));
    let (ei, es) = (epsilon.scale(ci).add(ri), epsilon.scale(cs).add(rs));
    let front = epsilon.add(Complex(-1.0, 0.0));
    let q = |numerator: Complex, a: Complex, b: Complex| {
        front.mul(numerator).norm2() / a.mul(b).norm2()
    };
    let pp = ri.mul(rs).scale(cp).add(epsilon.scale(-si * ss));
    q(Complex(cp, 0.0), di, ds) + q(rs.scale(sp), di, es) + q(ri.scale(sp), ei, ds) + q(pp, ei, es)
}

#[test]
fn half_the_polarisation_factors_are_fresnels_reflectance() {
    for (n, k) in [(1.5, 0.0), (0.143, 3.983), (2.5, 3.0), (0.375, 2.386)] {
        let epsilon = Complex(n * n - k * k, 2.0 * n * k);
        let fresnel = |theta: f64| {
            f64::from(
                halflight_kernel::bsdf::fresnel::fresnel_conductor(
                    theta.cos() as f32,
                    Vec3::splat(n as f32),
                    Vec3::splat(k as f32),
                )
                .x,
            )
        };
        // In the mirror direction, at every angle; at normal incidence in every plane.
        for degrees in [0.0_f64, 20.0, 50.0, 70.0, 85.0] {
            let theta = degrees.to_radians();
            let half = 0.5 * polarisation_sum(epsilon, theta, theta, 0.0);
            assert!(
                (half - fresnel(theta)).abs() < 1e-5,
                "{n} {k} {degrees}: {half}"
            );
            let normal = polarisation_sum(epsilon, 0.0, 0.0, theta);
            assert!((normal - 2.0 * fresnel(0.0)).abs() < 1e-5);
        }
    }
}

/// A lobe that reflects everything, in the mode without scaling.
fn lossless(lobe: Lobe) -> Lobe {
    Lobe {
        eta: Vec3::ZERO,
        k: Vec3::ONE,
        mode: mode::IMPORTANCE,
        ..lobe
    }
}

#[test]
fn reflection_and_diffraction_share_the_energy() {
    let (mut bounded, mut unbounded, mut doubled) = (0.0_f32, 0.0_f32, 0.0_f32);
    for mut case in diffracting_cases() {
        let lobe = lossless(case.lobe);
        let without = Lobe {
            kind: lobe_kind::ROUGH_CONDUCTOR,
            ..lobe
        };
        for degrees in [0.0, 30.0, 60.0, 75.0, 85.0, 89.0] {
            let wi = direction_at(degrees, 10.0);
            let (albedo, error) = furnace::albedo(&lobe, &case.data, wi, 40_000, 3);
            bounded = bounded.max((albedo - 4.0 * error).max_element());
            // The excess is not one of the facets.
            let (facets, _) = furnace::albedo(&without, &case.data, wi, 10_000, 3);
            assert!(facets.max_element() < 1.01);
        }
        let first = HEADER + 3 * COSINES;
        case.data[first..first + 3 * COSINES].fill(1.0);
        for degrees in [0.0, 60.0, 75.0, 85.0] {
            let wi = direction_at(degrees, 10.0);
            let (albedo, _) = furnace::albedo(&lobe, &case.data, wi, 40_000, 3);
            unbounded = unbounded.max(albedo.max_element());
            // Twice the Q: the diffraction doubles, the reflection stays.
            let mut data = case.data.clone();
            data[first..first + 3 * COSINES].fill(2.0);
            let (albedo, _) = furnace::albedo(&lobe, &data, wi, 40_000, 3);
            doubled = doubled.max(albedo.max_element());
        }
    }
    // The figures of the model's documentation. The limit is interpolated between 32 cosines.
    assert!(bounded < 1.01, "{bounded}");
    assert!(unbounded > 1.3 && unbounded < 1.4, "{unbounded}");
    assert!(doubled > 1.9, "{doubled}");
}

#[test]
fn strong_roughness_diffracts_everything_around_the_mirror() {
    // sigma of half a wavelength: A is 0 but at grazing angles, and the light is still there.
    let case = diffracting(0.1, 1.0, 0.3, 8.0, 3.0);
    let (albedo, error) = furnace::albedo(
        &lossless(case.lobe),
        &case.data,
        direction_at(30.0, 0.0),
        40_000,
        5,
    );
    assert!(error.max_element() < 0.01);
    assert!(
        albedo.min_element() > 0.9 && albedo.max_element() < 1.005,
        "{albedo}"
    );
}
