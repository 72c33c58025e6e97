//! Step sizes, proposals and break-up points.

#[path = "common/chains.rs"]
mod chains;
#[path = "common/mod.rs"]
mod common;
#[path = "common/dense.rs"]
mod dense;
#[path = "common/primitives.rs"]
mod primitives;

use chains::{N, chain};
use common::Random;
use glam::{DVec2, Mat2, Vec2, Vec3};
use halflight_kernel::manifold::breakup::{STOP, WHOLE, choose, probabilities_b, probabilities_c};
use halflight_kernel::manifold::slope_gaussian::SlopeGaussian;
use halflight_kernel::manifold::step_size::*;
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, half_vector_form, vertex_kind};
use primitives::{point, runner};
use proptest::prelude::*;
use std::cell::Cell;

/// Misprint: the optimal mean step of a Gaussian of variance alpha^2 / 2 is alpha / sqrt(pi) as printed, but not by the
/// printed general formula (2 / pi) |Sigma|, which is the square of a step.
#[test]
fn mean_step_is_that_of_the_beckmann_gaussian() {
    let alpha = 0.3f32;
    let n = 1_000_000;
    let mut random = Random(9);
    let gaussian = |deviation: f32| SlopeGaussian {
        center: Vec2::ZERO,
        axis: Vec2::X,
        deviation: Vec2::splat(deviation),
    };
    let mut mean = |deviation: f32| {
        let sum: f64 = (0..n)
            .map(|_| f64::from(gaussian(deviation).sample(random.next_2d()).x.abs()))
            .sum();
        sum / f64::from(n)
    };
    // E |N(0, alpha / sqrt 2)| = alpha / sqrt(pi); five standard errors are 0.4 %.
    let lobe = mean(alpha / 2.0f32.sqrt());
    assert!((lobe / f64::from(mean_step(alpha, 1.0)) - 1.0).abs() < 4e-3);
    let printed = 2.0 / std::f64::consts::PI * f64::from(alpha * alpha / 2.0);
    assert!(
        (lobe / printed - 1.0).abs() > 1.0,
        "the printed formula is no step"
    );
    assert!(
        (lobe * lobe / printed - 1.0).abs() < 1e-2,
        "but the square of one"
    );
    let proposal = mean(bsdf_deviation(alpha, GAMMA));
    assert!((proposal / f64::from(mean_step(alpha, GAMMA)) - 1.0).abs() < 4e-3);
    assert!(bsdf_deviation(1000.0, 1.0) <= LARGEST_DEVIATION && bsdf_deviation(0.0, 1.0) == 0.0);
}

/// The claimed optimum of "about 35 %" acceptance is not at alpha / sqrt(pi): random-walk Metropolis on the Beckmann Gaussian
/// accepts 55 % with a proposal as wide as the lobe and 36 % at 1.7 times that.
#[test]
fn acceptance_of_gaussian_proposals_on_a_beckmann_lobe() {
    let acceptance = |ratio: f64| {
        let mut random = Random(1);
        let (mut x, mut accepted, n) = (DVec2::ZERO, 0, 300_000);
        let unit = SlopeGaussian {
            center: Vec2::ZERO,
            axis: Vec2::X,
            deviation: Vec2::ONE,
        };
        for _ in 0..n {
            let y = x + unit.sample(random.next_2d()).as_dvec2() * ratio;
            let a = (0.5 * (x.length_squared() - y.length_squared())).exp();
            if f64::from(random.next_1d()) < a {
                x = y;
                accepted += 1;
            }
        }
        100.0 * f64::from(accepted) / f64::from(n)
    };
    let (one, wide) = (acceptance(1.0), acceptance(1.68));
    println!("acceptance: {one:.1} % at sigma, {wide:.1} % at 1.68 sigma");
    assert!((one - 55.0).abs() < 1.5 && (wide - 36.0).abs() < 1.5);
}

/// The ellipse is the image of the unit circle: its axis is stretched by the first length, and both are singular values.
#[test]
fn ellipses_are_singular_values() {
    let entries = prop::array::uniform4(-1.0f32..1.0);
    runner(4000)
        .run(&(entries, -6i32..6), |(m, power)| {
            let scale = 10.0f32.powi(power);
            let m = Mat2::from_cols_array(&m) * scale;
            let e = ellipse_of(m);
            prop_assert!((e.axis.length() - 1.0).abs() < 1e-5 && e.length.x >= e.length.y);
            let m64 = m.as_dmat2();
            let (a, b) = (f64::from(e.length.x), f64::from(e.length.y));
            let d = m64.determinant().abs();
            prop_assert!(
                (a * b - d).abs() <= 1e-5 * a * a,
                "product is the determinant"
            );
            // |M^T axis| is the first singular value, |M^T across| the second.
            let axis = e.axis.as_dvec2();
            let stretched = (m64.transpose() * axis).length();
            prop_assert!((stretched / a - 1.0).abs() < 1e-4);
            let across = (m64.transpose() * axis.perp()).length();
            prop_assert!((across - b).abs() <= 2e-3 * a);
            Ok(())
        })
        .unwrap();
    assert_eq!(ellipse_of(Mat2::ZERO).length, Vec2::ZERO);
    assert!(image_step(Mat2::ZERO, Vec2::X, Vec2::Y).length.x == f32::MAX);
}

/// Perturbing h_i alone by D_i^-1 dx moves x_{k-1} by dx, to first order, by the solver itself.
#[test]
fn image_steps_move_the_last_vertex() {
    let cases = Cell::new(0);
    runner(2000)
        .run(
            &(chain(6), prop::array::uniform4(-1.0f32..1.0)),
            |(chain, pixel)| {
                let j: ChainJacobian<N> =
                    ChainJacobian::new(&chain.vertices, chain.len, half_vector_form::SLOPE);
                prop_assume!(j.condition() < 1e4);
                let last = chain.len - 2;
                let mut d = [Mat2::ZERO; N];
                j.lu.row_of_inverse(last, &mut d);
                let pixel = Mat2::from_cols_array(&pixel) * 1e-2;
                for i in 1..=last {
                    let ellipse = image_step(d[i], pixel.x_axis, pixel.y_axis);
                    if ellipse.length.x > 1e3 || ellipse.length.y < 1e-4 * ellipse.length.x {
                        continue;
                    }
                    // A step of length along the axis is the image of a unit vector: its move of x_{k-1} has, in units of the
                    // pixel's parallelogram, length one.
                    let mut dx = [Vec2::ZERO; N];
                    dx[i] = ellipse.axis * ellipse.length.x;
                    prop_assert!(j.lu.solve(&mut dx));
                    let inverse = pixel.as_dmat2().inverse();
                    if inverse.to_cols_array().iter().any(|x| x.abs() > 3e3) {
                        continue;
                    }
                    let moved = (inverse * dx[last].as_dvec2()).length();
                    cases.set(cases.get() + 1);
                    prop_assert!((moved - 1.0).abs() < 2e-2, "vertex {i}: {moved} pixels");
                }
                Ok(())
            },
        )
        .unwrap();
    println!("{} image steps", cases.get());
    assert!(cases.get() > 1000);
}

/// Weights are shares; the proposal is never wider than the BSDF or the image allow, and specular vertices do not move.
#[test]
fn proposals_take_the_smaller_step() {
    runner(3000)
        .run(
            &(chain(9), prop::array::uniform4(-1.0f32..1.0)),
            |(mut chain, m)| {
                if chain.len > 3 {
                    chain.vertices[1].alpha = Vec2::ZERO;
                }
                let mut weights = [0.0; N];
                spectrum_weights(&chain.vertices, chain.len, &mut weights);
                let sum: f32 = weights.iter().sum();
                prop_assert!((sum - 1.0).abs() < 1e-5);
                prop_assert!(weights[0] == 0.0 && weights[chain.len - 1] == 0.0);
                for i in 1..chain.len - 1 {
                    let x = &chain.vertices[i];
                    let image = ellipse_of(Mat2::from_cols_array(&m));
                    let h = Vec2::new(0.2, -0.1);
                    for image in [image, StepEllipse::UNLIMITED] {
                        let p = slope_proposal(x, h, image, weights[i], 1.0);
                        let widest = x.alpha.max_element() / 2.0f32.sqrt();
                        prop_assert!(p.deviation.max_element() <= widest * 1.0001);
                        if image.length.x < f32::MAX {
                            prop_assert!(p.deviation.x <= image.length.x * weights[i] * 1.0001);
                        } else if x.alpha.x > 0.0 {
                            // On the BSDF's own axes the deviations are its own.
                            let own = x.alpha / 2.0f32.sqrt();
                            prop_assert!((p.deviation - own).length() < 1e-4 * own.length());
                        }
                        // Along each axis the smaller of the two, neither less: the section of the BSDF's ellipse,
                        // 1 / sqrt(d^T Sigma^-1 d).
                        let section = |d: Vec2| {
                            let (d, a) = (d.as_dvec2(), x.alpha_axis.as_dvec2());
                            let s = x.alpha.as_dvec2() / 2.0f64.sqrt();
                            1.0 / (d.dot(a).powi(2) / (s.x * s.x)
                                + d.dot(a.perp()).powi(2) / (s.y * s.y))
                                .sqrt()
                        };
                        for (axis, d) in [p.axis, p.axis.perp()].into_iter().enumerate() {
                            let own = section(d).min(f64::from(LARGEST_DEVIATION));
                            let limit = f64::from(image.length[axis]) * f64::from(weights[i]);
                            let expected = own.min(limit);
                            let got = f64::from(p.deviation[axis]);
                            if x.alpha.min_element() > 0.0 && x.alpha.max_element() < 2.0 {
                                prop_assert!(
                                    (got - expected).abs() <= 1e-4 * expected + 1e-9,
                                    "{got}, not {expected}"
                                );
                                // The exponents of the lobe on the disk belong to the same axes.
                                let exponent = (1.0 / (expected * expected) - 3.0).clamp(0.0, 1e12);
                                let got = f64::from(disk_proposal(&p).exponent[axis]);
                                prop_assert!((got - exponent).abs() <= 1e-3 * (exponent + 3.0));
                            }
                        }
                        if x.alpha == Vec2::ZERO {
                            prop_assert_eq!(p.sample(Vec2::splat(0.9)), h);
                        }
                        let disk = disk_proposal(&p);
                        prop_assert!(
                            disk.center.length() < 1.0 && disk.exponent.min_element() >= 0.0
                        );
                    }
                }
                Ok(())
            },
        )
        .unwrap();
}

/// Narrow Phong lobes on the disk, moved to the pivot, are as wide in slopes as the Gaussian they stand for.
#[test]
fn disk_proposals_are_as_wide_as_slope_proposals() {
    for center in [Vec2::ZERO, Vec2::new(0.8, -0.5)] {
        let gaussian = SlopeGaussian {
            center,
            axis: Vec2::from_angle(0.4),
            deviation: Vec2::splat(0.02),
        };
        let lobe = disk_proposal(&gaussian);
        let mut random = Random(4);
        let n = 200_000;
        let sum: f64 = (0..n)
            .map(|_| {
                let h = lobe.sample(random.next_2d());
                let slope = halflight_kernel::manifold::half_vector::slope_of_projected(h);
                f64::from((slope - center).length_squared())
            })
            .sum();
        // A Moebius map scales by cos^2 at the pivot, slopes to disk by cos^3 along the slope and by cos across it: in slope
        // units areas are kept and the deviations are s / cos and s cos.
        let cos2 = 1.0 / (1.0 + f64::from(center.length_squared()));
        let expected = (cos2 + 1.0 / cos2) * f64::from(0.02f32).powi(2);
        let ratio = sum / f64::from(n) / expected;
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    }
}

/// Probabilities of b and c are such for every chain, with the exceptions that the method names.
#[test]
fn breakup_probabilities_sum_to_one() {
    runner(3000)
        .run(&(chain(9), any::<bool>()), |(mut chain, specular)| {
            let last = chain.len - 1;
            if specular {
                for x in &mut chain.vertices {
                    x.alpha = Vec2::ZERO;
                }
            }
            let mut p = [0.0; N];
            probabilities_b(&chain.vertices, chain.len, &mut p);
            prop_assert!((p.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            let matched = |i: usize| chain.vertices[i].kind == vertex_kind::INDEX_MATCHED;
            let smooth = specular || (1..last).all(matched);
            if smooth {
                prop_assert!(p[0] == 1.0);
            } else {
                prop_assert!(p[0] == WHOLE && p[last] == WHOLE);
                prop_assert!((1..last).all(|i| (p[i] == 0.0) == matched(i)));
            }
            for b in 0..=last {
                probabilities_c(&chain.vertices, chain.len, b, &mut p);
                let sum: f32 = p.iter().sum();
                let expected = f32::from(b > 0);
                prop_assert!((sum - expected).abs() < 1e-5);
                prop_assert!((b..N).all(|c| p[c] == 0.0), "c is before b");
                prop_assert!(b != last || last == 1 || p[last - 1] == 0.0);
            }
            Ok(())
        })
        .unwrap();
}

/// P(c | b) follows alpha_c times the squared length of the edge, and both what rough vertices on the way let pass; choices have their
/// frequencies.
#[test]
fn breakup_points_have_their_probabilities() {
    let mut vertices = [ChainVertex::NONE; 8];
    for i in 0..5 {
        vertices[i].position = Vec3::X * [0.0, 1.0, 3.0, 4.0, 4.5][i];
        if i > 0 && i < 4 {
            let alpha = Vec2::splat([0.0, 0.2, 0.1, 0.4][i]);
            vertices[i] = vertices[i].scattering(false, 1.0, alpha);
        }
    }
    let mut p = [0.0; 8];
    probabilities_c(&vertices, 5, 4, &mut p);
    // 1 * 1, 0.2 * 4, 0.1 * 1, each times what is passed; the edge to the sensor is out.
    let pass = |alpha: f32| 1.0 - STOP * alpha;
    let weights = [pass(0.1) * pass(0.2), 0.8 * pass(0.1), 0.1, 0.0, 0.0];
    let expected = weights.map(|weight| weight / weights.iter().sum::<f32>());
    for i in 0..5 {
        assert!((p[i] - expected[i]).abs() < 1e-6);
    }
    probabilities_b(&vertices, 5, &mut p);
    // 0.2, 0.1 and 0.4 of what the two ends leave, each times what is passed.
    let weights = [0.2 * pass(0.4) * pass(0.1), 0.1 * pass(0.4), 0.4];
    let inner = weights.map(|weight| 0.8 * weight / weights.iter().sum::<f32>());
    let expected = [0.1, inner[0], inner[1], inner[2], 0.1];
    for i in 0..5 {
        assert!((p[i] - expected[i]).abs() < 1e-6);
    }
    let mut counts = [0u32; 8];
    let mut random = Random(8);
    for _ in 0..100_000 {
        counts[choose(&p, random.next_1d())] += 1;
    }
    for i in 0..8 {
        let share = f64::from(counts[i]) / 1e5;
        // Five standard errors of 100 000 draws.
        assert!((share - f64::from(p[i])).abs() < 0.008, "{counts:?} {p:?}");
    }
    assert_eq!(choose(&p, 0.999_999_94), 4);
}

/// Ray differentials on a tangent plane.
#[test]
fn tangent_plane_offsets_meet_the_ray() {
    runner(2000)
        .run(&(chain(1), point(2.0), point(0.3)), |(chain, origin, d)| {
            let x = &chain.vertices[1];
            let towards = (x.position - origin).normalize_or(Vec3::Z);
            prop_assume!(towards.dot(x.geometric_normal).abs() > 0.2);
            let direction = (towards + d * 0.3).normalize();
            prop_assume!(direction.dot(x.geometric_normal).abs() > 0.1);
            let p = x.moved(tangent_plane_offset(x, origin, direction));
            let off = (p - origin)
                .normalize_or(direction)
                .cross(direction)
                .length();
            prop_assert!(off < 1e-4 || (p - origin).length() < 1e-2);
            prop_assert!(
                (p - x.position).dot(x.geometric_normal).abs() < 1e-4 * (1.0 + p.length())
            );
            Ok(())
        })
        .unwrap();
    let x = ChainVertex::NONE;
    assert_eq!(tangent_plane_offset(&x, Vec3::ZERO, Vec3::X), Vec2::ZERO);
}
