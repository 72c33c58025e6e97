//! Jumps between sub-manifolds: their densities and their way back.

#[path = "common/chains.rs"]
mod chains;
#[path = "common/mod.rs"]
mod common;
#[path = "common/dense.rs"]
mod dense;
#[path = "common/mirrors.rs"]
mod mirrors;
#[path = "common/primitives.rs"]
mod primitives;

use chains::{N, TestChain, chain};
use common::Random;
use dense::Dense;
use glam::{DMat2, DVec2, Vec2, Vec3};
use halflight_kernel::manifold::mutation::{mutate, mutation_kind, prediction_between};
use halflight_kernel::manifold::projection::project;
use halflight_kernel::manifold::slope_gaussian::SlopeGaussian;
use halflight_kernel::manifold::walk::WalkOptions;
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, half_vector_form};
use halflight_kernel::scene::SceneView;
use mirrors::{Mirrors, mirror};
use primitives::{point, runner};
use proptest::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::cell::Cell;

/// `to` is `from` with moved inner vertices and turned tangent planes; ends with pinned directions follow.
fn other_path(from: &TestChain, moves: &[Vec3], turns: &[Vec3]) -> [ChainVertex; N] {
    let mut to = from.vertices;
    for i in 1..from.len - 1 {
        let x = &mut to[i];
        x.position += moves[i];
        let n = (x.geometric_normal + turns[i]).normalize();
        let (u, v) = n.any_orthonormal_pair();
        (x.geometric_normal, x.tangent_u, x.tangent_v) = (n, u, v);
    }
    to
}

/// The factor of a prediction is |d half vectors / d vertices| of the path it leads to: against central differences.
#[test]
fn density_of_a_prediction_is_its_jacobian() {
    let cases = Cell::new(0);
    let inputs = (
        chain(4),
        prop::collection::vec(point(0.1), N),
        prop::collection::vec(point(0.3), N),
        any::<bool>(),
    );
    runner(3000)
        .run(&inputs, |(chain, moves, turns, from_sensor)| {
            let jacobian = ChainJacobian::new(&chain.vertices, chain.len, half_vector_form::SLOPE);
            let to = other_path(&chain, &moves, &turns);
            let between = |to: &[ChainVertex; N]| {
                prediction_between(&chain.vertices, to, chain.len, &jacobian, from_sensor)
            };
            let found = between(&to);
            // Away from grazing rays and singular constraints, where differences in f32 say nothing.
            if !(jacobian.condition() < 1e4) || !found.valid || chain.least_cosine() < 0.3 {
                return Ok(());
            }
            let inner = chain.len - 2;
            let mut differences = Dense::zeros(2 * inner);
            let e = 5e-3f32;
            for j in 0..inner {
                let column = |u: bool| -> Option<Vec<DVec2>> {
                    let at = |step: f32| {
                        let mut moved = to;
                        let x = &mut moved[j + 1];
                        let d = if u { x.tangent_u } else { x.tangent_v };
                        x.position += d * step;
                        let p = between(&moved);
                        p.valid.then_some(p.target)
                    };
                    let (a, b) = (at(e)?, at(-e)?);
                    Some(
                        (1..=inner)
                            .map(|i| (a[i] - b[i]).as_dvec2() / f64::from(2.0 * e))
                            .collect(),
                    )
                };
                let (Some(u), Some(v)) = (column(true), column(false)) else {
                    return Ok(());
                };
                for i in 0..inner {
                    differences.set(i, j, DMat2::from_cols(u[i], v[i]));
                }
            }
            let (inverse, ln, _) = differences.inverse();
            // Not for singular ones, whose condition is a NaN.
            let condition = differences.norm() * inverse.norm();
            if condition.is_nan() || condition > 50.0 {
                return Ok(());
            }
            cases.set(cases.get() + 1);
            let error = (f64::from(found.factor.ln_abs()) - ln).abs();
            prop_assert!(error < 0.02, "{error}");
            Ok(())
        })
        .unwrap();
    println!("{} predictions", cases.get());
    assert!(cases.get() > 300);
}

/// Samples of the half vector, predicted and projected onto a bumpy mirror, against the density: chi-square over cells of
/// the mirror.
#[test]
fn projected_predictions_have_their_density() {
    let scene = Mirrors::default().sphere(Vec3::new(0.1, 0.0, -0.7), 0.7, 0);
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: &scene,
    };
    let light = ChainVertex::point(Vec3::new(-1.0, 0.2, 1.4));
    let sensor = ChainVertex::point(Vec3::new(0.9, -0.3, 1.8));
    let (start, len) = scene
        .chain(light, &[Vec3::new(0.05, 0.03, 0.0)], sensor, mirror)
        .unwrap();
    let jacobian = ChainJacobian::new(&start, len, half_vector_form::SLOPE);
    let gaussian = SlopeGaussian {
        center: jacobian.h[1],
        axis: Vec2::X,
        deviation: Vec2::new(0.12, 0.08),
    };
    let (side, half, n) = (24usize, 0.25f32, 200_000);
    let middle = start[1].position.truncate();
    let mut observed = vec![0.0f64; side * side];
    let mut random = Random(11);
    for _ in 0..n {
        let mut dx = [Vec2::ZERO; halflight_kernel::manifold::MAX_CHAIN];
        dx[1] = gaussian.sample(random.next_2d()) - jacobian.h[1];
        assert!(jacobian.lu.solve(&mut dx));
        let mut predicted = [Vec3::ZERO; halflight_kernel::manifold::MAX_CHAIN];
        predicted[1] = start[1].moved(dx[1]);
        let found = project(&view, &start, len, &predicted, false);
        if found.valid {
            let at = (found.vertices[1].position.truncate() - middle + half) / (2.0 * half);
            if at.min_element() >= 0.0 && at.max_element() < 1.0 {
                let cell = (at * side as f32).floor();
                observed[cell.y as usize * side + cell.x as usize] += 1.0;
            }
        }
    }
    let fine = 8;
    let mut expected = vec![0.0f64; side * side];
    for j in 0..side * fine {
        for i in 0..side * fine {
            let at = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / (side * fine) as f32;
            let p = middle + (at * 2.0 - 1.0) * half;
            // The vertex above (x, y), by a ray straight down.
            let ray = halflight_kernel::math::Ray::new(p.extend(3.0), -Vec3::Z);
            let Some(surface) = scene.hit(&ray) else {
                continue;
            };
            let mut to = start;
            to[1] = mirror(1, ChainVertex::from_surface(&surface));
            let back = prediction_between(&start, &to, len, &jacobian, false);
            if back.valid {
                let pdf = gaussian.pdf_slope(back.target[1]) * back.factor.value();
                let cosine = surface.geometric_normal.z;
                let area = (2.0 * half / (side * fine) as f32).powi(2) / cosine;
                expected[(j / fine) * side + i / fine] += f64::from(pdf * area * n as f32);
            }
        }
    }
    let (mut statistic, mut cells) = (0.0, 0);
    for (o, e) in observed.iter().zip(&expected) {
        if *e > 20.0 {
            statistic += (o - e) * (o - e) / e;
            cells += 1;
        }
    }
    let p = 1.0 - ChiSquared::new(f64::from(cells)).unwrap().cdf(statistic);
    println!("{cells} cells, chi-square {statistic:.0}, p = {p:.3}");
    // One seed in a thousand fails by chance.
    assert!(cells > 200 && p > 1e-3);
}

/// Across the edge of a roof the walk fails and a jump is made; from its end the same rule jumps back to the start.
#[test]
fn jumps_lead_back() {
    // Two facets that meet at the y axis, with normals leaning away from each other.
    let roof = |sign: f32| {
        let down = Vec3::new(sign, 0.0, -0.15).normalize();
        (down * 0.5, down * 0.5, Vec3::Y)
    };
    let mut scene = Mirrors::default();
    for sign in [-1.0, 1.0] {
        let (center, u, v) = roof(sign);
        let (u, v) = if sign > 0.0 { (u, v) } else { (v, u) };
        scene = scene.quad(center, u, v, 0);
    }
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: &scene,
    };
    let options = WalkOptions::new(2.0);
    let (mut jumps, mut walks, mut back) = (0, 0, 0);
    let mut random = Random(3);
    for _ in 0..4000 {
        let mut jitter = |r: f32| (random.next_2d() * 2.0 - 1.0) * r;
        let light = ChainVertex::point(Vec3::new(-1.0, 0.1, 1.5));
        let sensor = ChainVertex::point(Vec3::new(1.0, -0.1, 1.5));
        let rough = |_, x: ChainVertex| x.scattering(false, 1.0, Vec2::splat(0.3));
        let guess = jitter(0.3).extend(-0.02);
        let Some((start, len)) = scene.chain(light, &[guess], sensor, rough) else {
            continue;
        };
        let jacobian = ChainJacobian::new(&start, len, options.form);
        let mut target = jacobian.h;
        target[1] += jitter(0.15);
        let m = mutate(&view, &start, &jacobian, &target, &options);
        walks += usize::from(m.kind == mutation_kind::WALK);
        if m.kind != mutation_kind::JUMP {
            continue;
        }
        jumps += 1;
        assert!(
            start[1].position.x * m.vertices[1].position.x < 0.0,
            "the other facet"
        );
        let r = mutate(&view, &m.vertices, &m.jacobian, &m.reverse_target, &options);
        if r.kind != mutation_kind::JUMP {
            continue;
        }
        back += 1;
        assert!((r.vertices[1].position - start[1].position).length() < 1e-4);
        // The same pair of densities, seen from the other end.
        assert!((r.forward_factor.ln_abs() - m.reverse_factor.ln_abs()).abs() < 1e-3);
        assert!((r.reverse_factor.ln_abs() - m.forward_factor.ln_abs()).abs() < 1e-3);
        assert!((r.reverse_target[1] - target[1]).length() < 1e-3);
    }
    println!("{walks} walks, {jumps} jumps, {back} of them jump back");
    assert!(jumps > 50 && back == jumps);
}
