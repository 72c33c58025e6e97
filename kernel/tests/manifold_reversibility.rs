//! Walks that come back, on mirrors and bumps, those that do not and are noticed, and where projections start.

#[path = "common/mod.rs"]
mod common;
#[path = "common/mirrors.rs"]
mod mirrors;
#[path = "common/primitives.rs"]
mod primitives;

use glam::{Vec2, Vec3};
use halflight_kernel::manifold::exploration::explore;
use halflight_kernel::manifold::mutation::{mutate, mutation_kind};
use halflight_kernel::manifold::projection::{project, sides_agree};
use halflight_kernel::manifold::walk::{WalkOptions, starts_at_sensor, walk};
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, MAX_CHAIN};
use halflight_kernel::scene::SceneView;
use mirrors::{Mirrors, mirror};
use primitives::{point, runner};
use proptest::prelude::*;
use std::cell::Cell;

/// A ball of glass between a directional light and an orthographic sensor: rough half vectors, both ends moving.
#[test]
fn pinned_directions_walk_and_come_back() {
    let scene = Mirrors::default().sphere(Vec3::ZERO, 1.0, 0);
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: &scene,
    };
    let options = WalkOptions::new(3.0);
    let walks = Cell::new(0);
    let inputs = (point(0.3), point(0.1), prop::array::uniform2(point(0.02)));
    runner(2000)
        .run(&inputs, |(at, tilt, steps)| {
            let light = Vec3::new(tilt.x, tilt.y, -1.0).normalize();
            let from = Vec3::new(at.x, at.y, 0.0) - light * 3.0;
            let start = ChainVertex::pinned_direction(from, light);
            let glass = |i: usize, x: ChainVertex| {
                let eta = if i == 1 { 1.5 } else { 1.0 / 1.5 };
                x.scattering(true, eta, Vec2::splat(0.1))
            };
            let first = from + light * 3.0;
            let second = Vec3::new(0.3 * at.x, 0.3 * at.y, -0.9);
            let sensor = Vec3::new(0.1 * at.y, 0.1 * at.x, 1.0).normalize();
            let (mut vertices, len) = scene
                .chain(start, &[first, second], ChainVertex::NONE, glass)
                .unwrap();
            vertices[3] =
                ChainVertex::pinned_direction(vertices[2].position - sensor * 2.0, sensor);
            let jacobian = ChainJacobian::new(&vertices, len, options.form);
            prop_assert!(jacobian.is_regular());
            let mut target = jacobian.h;
            target[1] += steps[0].truncate();
            target[2] += steps[1].truncate();
            let m = mutate(&view, &vertices, &jacobian, &target, &options);
            prop_assume!(m.kind == mutation_kind::WALK);
            walks.set(walks.get() + 1);
            let x = &m.vertices;
            for i in 1..=2 {
                prop_assert!((m.jacobian.h[i] - target[i]).length() < 2e-4);
            }
            // The directions of both ends are kept.
            let w = (x[1].position - x[0].position).normalize();
            prop_assert!((w - light).length() < 1e-5);
            let w = (x[2].position - x[3].position).normalize();
            prop_assert!((w - sensor).length() < 1e-5);
            Ok(())
        })
        .unwrap();
    assert_eq!(walks.get(), 2000);
}

/// Where both walks converge they find the same path; half vectors are those asked for; what `mutate` calls a walk comes
/// back by itself.
#[test]
fn both_walks_agree_and_come_back() {
    let scene = Mirrors::default()
        .sphere(Vec3::new(0.0, 0.0, -1.0), 1.0, 0)
        .quad(Vec3::Z * 2.5, Vec3::Y * 9.0, Vec3::X * 9.0, 0);
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: &scene,
    };
    let options = WalkOptions::new(4.0);
    let counts = Cell::new([0u32; 3]);
    let iterations = Cell::new(0);
    let inputs = (point(0.3), point(0.5), prop::array::uniform3(point(0.05)));
    runner(2000)
        .run(&inputs, |(at, away, steps)| {
            let light = ChainVertex::point(Vec3::new(-2.0, away.x, 1.5));
            let sensor = ChainVertex::point(Vec3::new(2.5, away.y, 0.5));
            let guesses = [Vec3::new(-0.6 + at.x, at.y, 0.0), Vec3::new(1.0, at.y, 2.5)];
            let chain = scene.chain(light, &guesses, sensor, mirror);
            prop_assume!(chain.is_some());
            let (vertices, len) = chain.unwrap();
            let jacobian = ChainJacobian::new(&vertices, len, options.form);
            prop_assume!(jacobian.is_regular());
            let mut target = jacobian.h;
            for i in 1..3 {
                target[i] += steps[i].truncate();
            }
            let m = mutate(&view, &vertices, &jacobian, &target, &options);
            let [mut walks, mut both, mut failed] = counts.get();
            if m.kind == mutation_kind::WALK {
                walks += 1;
                for i in 1..3 {
                    prop_assert!((m.jacobian.h[i] - target[i]).length() < 2e-4);
                }
                let back = walk(&view, &m.vertices, &m.jacobian, &jacobian.h, &options);
                prop_assert!(back.is_converged());
                for i in 0..len {
                    let off = (back.vertices[i].position - vertices[i].position).length();
                    prop_assert!(off < 4e-3);
                }
                prop_assert!(m.forward_factor == m.jacobian.half_vectors_per_vertex_area());
                prop_assert!(m.reverse_factor == jacobian.half_vectors_per_vertex_area());
                let other = explore(&view, &vertices, len, &target, &options);
                if other.is_converged() {
                    both += 1;
                    iterations.set(iterations.get() + other.iterations);
                    for i in 0..len {
                        let off = (other.vertices[i].position - m.vertices[i].position).length();
                        // Within what 4e-4 at the end is along the chain.
                        prop_assert!(off < 2e-2, "vertex {i}: {off}");
                    }
                }
            } else {
                failed += 1;
            }
            counts.set([walks, both, failed]);
            Ok(())
        })
        .unwrap();
    let [walks, both, failed] = counts.get();
    let mean = f64::from(iterations.get()) / f64::from(both);
    println!(
        "{walks} reversible walks, {both} found by exploration too, in {mean:.2} iterations, {failed} others"
    );
    assert!(walks > 1500 && both > 1200);
    // Newton's steps from a few hundredths away: digits double.
    assert!(mean < 3.5, "{mean}");
}

/// On a bumpy mirror walks end on other parts of it from which there is no way back. Walks that are called reversible are, and
/// the others are not.
#[test]
fn walks_across_bumps_that_do_not_return_are_noticed() {
    let bump = |a: f32, b: f32| {
        let (p, q) = (9.0 * a, 7.0 * b);
        let height = 0.05 * p.sin() * q.cos();
        let slope = Vec3::new(-0.45 * p.cos() * q.cos(), 0.35 * p.sin() * q.sin(), 1.0);
        (Vec3::new(a, b, height), slope.normalize())
    };
    let scene = Mirrors::default().patch(48, 0, bump);
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: &scene,
    };
    let options = WalkOptions::new(2.0);
    let mut random = common::Random(21);
    let (mut walks, mut lost) = (0, 0);
    for _ in 0..1500 {
        let mut jitter = |r: f32| (random.next_2d() * 2.0 - 1.0) * r;
        let light = ChainVertex::point(Vec3::new(-1.0, 0.1, 1.5));
        let sensor = ChainVertex::point(Vec3::new(1.0, -0.1, 1.5));
        let rough = |_, x: ChainVertex| x.scattering(false, 1.0, Vec2::splat(0.3));
        let guess = jitter(0.6).extend(0.0);
        let Some((start, len)) = scene.chain(light, &[guess], sensor, rough) else {
            continue;
        };
        let jacobian = ChainJacobian::new(&start, len, options.form);
        let mut target = jacobian.h;
        target[1] += jitter(0.5);
        let m = mutate(&view, &start, &jacobian, &target, &options);
        if m.kind != mutation_kind::WALK && m.kind != mutation_kind::NOT_REVERSIBLE {
            continue;
        }
        let back = walk(&view, &m.vertices, &m.jacobian, &jacobian.h, &options);
        let off = (back.vertices[1].position - start[1].position).length();
        let returns = back.is_converged() && off < 2e-3;
        assert_eq!(m.kind == mutation_kind::WALK, returns, "{off} away");
        if returns {
            walks += 1;
        } else {
            lost += 1;
        }
    }
    println!("{walks} walks return, {lost} do not");
    assert!(walks > 300 && lost > 30);
}

/// Projections start at the end from which errors shrink along the chain: at the sensor behind a convex mirror, at the light behind a
/// concave one that focuses near the next vertex.
#[test]
fn projections_start_where_errors_shrink() {
    let convex = Mirrors::default()
        .sphere(Vec3::new(-1.0, 0.0, -0.5), 0.5, 0)
        .quad(Vec3::new(1.0, 0.0, 2.5), Vec3::Y * 9.0, Vec3::X * 9.0, 0);
    let concave = Mirrors::default().sphere(Vec3::ZERO, 2.0, 0).quad(
        Vec3::new(-0.5, 0.0, 0.1),
        Vec3::Y * 0.2,
        Vec3::X * 0.2,
        0,
    );
    let options = WalkOptions::new(4.0);
    let mut random = common::Random(5);
    for (scene, light, guesses, sensor, is_from_sensor) in [
        (
            &convex,
            Vec3::new(-2.0, 0.0, 1.0),
            [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 2.5)],
            Vec3::new(2.5, 0.0, 0.5),
            true,
        ),
        (
            &concave,
            Vec3::new(0.5, 0.0, 0.0),
            [Vec3::new(0.0, 0.0, -2.0), Vec3::new(-0.5, 0.0, 0.1)],
            Vec3::new(-0.8, 0.3, -1.0),
            false,
        ),
    ] {
        let mut cases = 0;
        for _ in 0..100 {
            let jitter = ((random.next_2d() - 0.5) * 0.1).extend(0.0);
            let [light, sensor] = [light, sensor].map(ChainVertex::point);
            let guesses = guesses.map(|guess| guess + jitter);
            let Some((vertices, len)) = scene.chain(light, &guesses, sensor, mirror) else {
                continue;
            };
            let jacobian = ChainJacobian::new(&vertices, len, options.form);
            if !jacobian.is_regular() {
                continue;
            }
            let mut transfer = [glam::Mat2::ZERO; MAX_CHAIN];
            jacobian.lu.transfer(len - 1, &mut transfer);
            let [first, last] = [1, len - 2].map(|i| transfer[i].determinant().abs());
            let found = starts_at_sensor(&jacobian);
            assert_eq!(found, first < last, "{first} {last}");
            cases += usize::from(found == is_from_sensor);
        }
        assert!(cases > 60, "{is_from_sensor}: {cases}");
    }
}

/// A vertex whose next one has gone to its other side is another chain, and so is one whose previous one has.
#[test]
fn neighbours_stay_on_their_sides() {
    let mut old = [ChainVertex::NONE; 4];
    old[0] = ChainVertex::point(Vec3::new(-1.0, 0.0, 1.0));
    old[1].geometric_normal = Vec3::Z;
    old[2] = ChainVertex::point(Vec3::new(1.0, 0.0, 1.0));
    for (moved, is_same) in [([-1.0, 0.0, 0.5], true), ([1.0, 0.0, -0.5], false)] {
        for end in [0, 2] {
            let mut new = old;
            new[end].position = Vec3::from_array(moved);
            assert_eq!(sides_agree(&old, &new, 3), is_same, "end {end}");
        }
    }
}

/// A projection around a ball to where the light still sees it and the sensor does not is no projection, from either end.
#[test]
fn projections_keep_neighbours_on_their_sides() {
    let scene = Mirrors::default().sphere(Vec3::ZERO, 1.0, 0);
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: &scene,
    };
    let [light, sensor] = [Vec3::X * 3.0, Vec3::Y * 3.0].map(ChainVertex::point);
    let (old, len) = scene
        .chain(light, &[Vec3::new(0.7, 0.7, 0.0)], sensor, mirror)
        .unwrap();
    for (to, is_valid) in [
        (Vec3::new(0.8, 0.6, 0.0), true),
        (Vec3::new(0.98, -0.2, 0.0), false),
        (Vec3::new(-0.2, 0.98, 0.0), false),
    ] {
        let predicted = [to; MAX_CHAIN];
        // The end at which the projection begins sees the place.
        let from_sensor = to.y > to.x;
        let found = project(&view, &old, len, &predicted, from_sensor);
        assert!((found.vertices[1].position - to).length() < 0.1, "{to}");
        assert_eq!(found.valid, is_valid, "{to}");
    }
}
