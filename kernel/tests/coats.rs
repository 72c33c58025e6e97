//! Coats: refraction both ways, its Jacobian against f64, composition, energy, and tables of rough transmittance.

mod common;

use common::coated::{coat, under_coat};
use common::furnace;
use common::lobes::white;
use common::{Random, direction_at};
use glam::{DVec3, Vec2, Vec3};
use halflight_kernel::bsdf::coat::{refract_in, refract_out, round_trip};
use halflight_kernel::bsdf::rough_transmittance::{
    ENTRIES, ROW, ROWS, boundary_transmittance, fill, fill_row, internal_reflectance,
    row_internal_reflectance, transmittance,
};
use halflight_kernel::bsdf::{Bsdf, Coat, Lobe, lobe};
use halflight_kernel::scene::{MAX_LOBES, NONE, distribution, lobe_kind};

const TWO: [Coat; 2] = [
    Coat {
        eta: 1.3,
        optical_depth: Vec3::new(0.0, 0.1, 0.4),
        ..Coat::NONE
    },
    Coat {
        eta: 1.4,
        optical_depth: Vec3::new(0.3, 0.2, 0.0),
        ..Coat::NONE
    },
];

/// Refraction into one boundary after another, in f64.
fn refracted(w: DVec3, etas: &[f64]) -> DVec3 {
    etas.iter().fold(w, |w, eta| {
        let (x, y) = (w.x / eta, w.y / eta);
        DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
    })
}

#[test]
fn entering_and_leaving_are_inverse() {
    let mut random = Random(1);
    let mut worst = 0.0_f32;
    for _ in 0..10_000 {
        let w = random.upper_direction();
        let inside = refract_in(&TWO, 2, &[], w);
        assert!(inside.valid);
        let back = refract_out(&TWO, 2, &[], inside.w);
        // The cosine of a grazing direction is lost in that of the refracted one.
        if w.z > 0.05 {
            assert!(back.valid);
            worst = worst.max((back.w - w).length() * w.z);
        }
        assert!((inside.w.length() - 1.0).abs() < 1e-6);
    }
    assert!(worst < 2e-6, "{worst}");
}

#[test]
fn jacobian_is_that_of_the_refraction() {
    let mut random = Random(2);
    for count in 1..=2 {
        let etas = &[1.3_f64, 1.4][..count];
        for _ in 0..500 {
            let w = random.upper_direction();
            if w.z < 0.02 {
                continue;
            }
            // Area of the image of a small parallelogram of directions over its own.
            let w64 = w.as_dvec3().normalize();
            let (s, t) = w64.any_orthonormal_pair();
            let h = 1e-6;
            let derivative = |d: DVec3| {
                (refracted((w64 + d * h).normalize(), etas)
                    - refracted((w64 - d * h).normalize(), etas))
                    / (2.0 * h)
            };
            let expected = derivative(s).cross(derivative(t)).length();
            let found = f64::from(refract_in(&TWO, count as u32, &[], w).jacobian);
            assert!(
                (found - expected).abs() < 1e-5 * expected,
                "{w}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn transmittance_is_the_product_over_the_coats() {
    let mut random = Random(3);
    for _ in 0..1_000 {
        let w = random.upper_direction();
        let first = refract_in(&TWO, 1, &[], w);
        let second = refract_in(&[TWO[1], Coat::NONE], 1, &[], first.w);
        let both = refract_in(&TWO, 2, &[], w);
        assert!((both.transmittance - first.transmittance * second.transmittance).length() < 1e-6);
        assert!((both.w - second.w).length() < 1e-6);
        let guess = round_trip(&TWO, 2, &[], w);
        let exact =
            both.transmittance * refract_in(&TWO, 2, &[], random.upper_direction()).transmittance;
        assert!((guess - exact).min_element() > -1e-6, "{guess} {exact}");
    }
}

#[test]
fn total_reflection_lets_nothing_through() {
    let thin = [
        Coat {
            eta: 1.0 / 1.5,
            ..Coat::NONE
        },
        Coat::NONE,
    ];
    assert!(!refract_in(&thin, 1, &[], direction_at(42.0, 0.0)).valid);
    assert!(refract_in(&thin, 1, &[], direction_at(41.0, 0.0)).valid);
    assert!(!refract_out(&TWO, 1, &[], direction_at(51.0, 0.0)).valid);
    assert!(refract_out(&TWO, 1, &[], direction_at(50.0, 0.0)).valid);
    assert!(!refract_in(&TWO, 2, &[], -Vec3::Z).valid);
}

#[test]
fn white_base_under_a_clear_coat_returns_what_passes_twice() {
    // f = (1 - F(wi)) (1 - F(wo)) / (n^2 pi): its furnace is (1 - F(wi)) / n^2 times the hemispherical mean of 1 - F,
    // here by the midpoint rule in f64 with Fresnel's amplitudes.
    let n = 1.5_f64;
    let passes = |c: f64| {
        let t = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
        let (s, p) = ((c - n * t) / (c + n * t), (n * c - t) / (n * c + t));
        1.0 - 0.5 * (s * s + p * p)
    };
    let steps = 20_000;
    let mean: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
        .map(|c| 2.0 * c * passes(c) / f64::from(steps))
        .sum();
    let clear = Coat {
        eta: 1.5,
        ..Coat::NONE
    };
    let coated = under_coat(white(lobe_kind::DIFFUSE), clear);
    for degrees in [0.0_f32, 40.0, 80.0] {
        let wi = direction_at(degrees, 30.0);
        let expected = passes(f64::from(wi.z)) * mean / (n * n);
        let (albedo, error) = furnace::albedo(&coated, &[], wi, 100_000, 7);
        let miss = (f64::from(albedo.x) - expected).abs();
        assert!(
            miss < f64::from(5.0 * error.x) + 2e-5,
            "{degrees}: {albedo}, {expected}"
        );
    }
    // 0.0400 from the surface and 0.3875 from below: formulas of the layered model put the sum at 0.428.
    assert!((0.04 + passes(1.0) * mean / (n * n) - 0.428).abs() < 1e-3);
}

#[test]
fn coat_of_matching_index_only_absorbs() {
    let mut random = Random(4);
    let bare = white(lobe_kind::DIFFUSE);
    let dyed = under_coat(bare, coat(1.0));
    for _ in 0..100 {
        let (wi, wo) = (random.upper_direction(), random.upper_direction());
        let tau = dyed.coats[0].optical_depth;
        let expected = lobe::eval_cosine(&bare, &[], wi, wo)
            * (tau * -(1.0 / wi.z.max(0.01) + 1.0 / wo.z.max(0.01))).exp();
        if wi.z.min(wo.z) > 0.01 {
            let found = lobe::eval_cosine(&dyed, &[], wi, wo);
            assert!((found - expected).length() < 1e-5, "{found} {expected}");
        }
    }
}

#[test]
fn coat_and_base_together_create_no_light() {
    for coats in 1..=2_u32 {
        let mut lobes = [Lobe::NONE; MAX_LOBES];
        lobes[0] = white(lobe_kind::COAT);
        lobes[0].eta = Vec3::splat(TWO[0].eta);
        lobes[1] = white(lobe_kind::COAT);
        lobes[1].eta = Vec3::splat(TWO[1].eta);
        lobes[1].coat_count = 1;
        lobes[1].coats = TWO;
        let base = coats as usize;
        lobes[base] = white(lobe_kind::DIFFUSE);
        lobes[base].coat_count = coats;
        lobes[base].coats = TWO;
        for lobe in &mut lobes {
            lobe.coats[0].optical_depth = Vec3::ZERO;
            lobe.coats[1].optical_depth = Vec3::ZERO;
        }
        for degrees in [0.0, 45.0, 75.0, 88.0] {
            let wi = direction_at(degrees, 0.0);
            let bsdf = Bsdf::from_lobes(lobes, coats + 1, &[], wi);
            let chosen: f32 = (0..=coats).map(|i| bsdf.selection(i)).sum();
            assert!((chosen - 1.0).abs() < 1e-5);
            let mut random = Random(5);
            let mut sum = 0.0_f64;
            let n = 20_000;
            for _ in 0..n {
                let u1 = random.next_1d();
                let s = bsdf.sample(&[], wi, u1, random.next_2d());
                if s.pdf > 0.0 {
                    sum += f64::from(s.weight.x);
                }
            }
            let albedo = sum / f64::from(n);
            assert!(albedo < 1.0 && albedo > 0.3, "{coats}, {degrees}: {albedo}");
        }
    }
}

#[test]
fn table_rows_hold_the_quadrature() {
    let (kind, eta) = (distribution::GGX, 1.5);
    let mut row = vec![0.0; ROW];
    fill_row(kind, 0.3, eta, &mut row);
    for i in [0, 7, ENTRIES - 1] {
        let cos = i as f32 / (ENTRIES - 1) as f32;
        let at_node = transmittance(&row, 0, 1, eta, 0.3, cos);
        assert!((at_node - boundary_transmittance(kind, 0.3, eta, cos)).abs() < 1e-6);
    }
    assert_eq!(row[ENTRIES], row_internal_reflectance(kind, 0.3, eta));
    // Without a table, the smooth boundary; a vanishing roughness agrees with it.
    let smooth = transmittance(&[], NONE, 1, eta, 0.3, 1.0);
    assert!((smooth - 0.96).abs() < 1e-6);
}

#[test]
fn table_over_roughness_interpolates() {
    for kind in [distribution::BECKMANN, distribution::GGX] {
        let eta = 1.5;
        let mut table = vec![0.0; ROWS * ROW];
        fill(kind, eta, &mut table);
        let mut worst = Vec2::ZERO;
        for alpha in [0.0, 0.013, 0.1, 0.2, 0.37, 0.6, 0.95, 1.0] {
            let mut row = vec![0.0; ROW];
            fill_row(kind, alpha, eta, &mut row);
            for i in 0..ENTRIES {
                let cos = i as f32 / (ENTRIES - 1) as f32;
                let found = transmittance(&table, 0, ROWS as u32, eta, alpha, cos);
                worst.x = worst.x.max((found - row[i]).abs());
            }
            let found = internal_reflectance(&table, 0, ROWS as u32, alpha);
            worst.y = worst.y.max((found - row[ENTRIES]).abs());
        }
        assert!(worst.x < 1.2e-2 && worst.y < 2e-3, "{kind}: {worst}");
        // Roughness beyond the table is that of its last row.
        let last = transmittance(&table, 0, ROWS as u32, eta, 1.0, 0.5);
        assert_eq!(transmittance(&table, 0, ROWS as u32, eta, 7.0, 0.5), last);
    }
}
