//! The walk where the answer is known: plane mirrors, spheres from outside and inside, a slab of glass; its reversibility;
//! manifold exploration beside it.

#[path = "common/mod.rs"]
mod common;
#[path = "common/mirrors.rs"]
mod mirrors;
#[path = "common/primitives.rs"]
mod primitives;

use glam::{DVec2, Vec2, Vec3};
use halflight_kernel::manifold::walk::{Walk, WalkOptions, walk, walk_status};
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, MAX_CHAIN};
use halflight_kernel::scene::SceneView;
use mirrors::{Mirrors, Vertices, mirror};
use primitives::{point, runner};
use proptest::prelude::*;
use std::cell::Cell;

const SPECULAR: [Vec2; MAX_CHAIN] = [Vec2::ZERO; MAX_CHAIN];

fn run(
    scene: &Mirrors,
    start: &Vertices,
    len: usize,
    target: &[Vec2; MAX_CHAIN],
) -> Walk<MAX_CHAIN> {
    let view = SceneView {
        tables: scene.geometry.tables(),
        traverse: scene,
    };
    let options = WalkOptions::new(4.0);
    let jacobian = ChainJacobian::new(start, len, options.form);
    walk(&view, start, &jacobian, target, &options)
}

/// Between two parallel mirrors a path of n reflections is a straight line to an image of its end.
#[test]
fn parallel_mirrors_give_the_unfolded_path() {
    let scene = Mirrors::default()
        .quad(Vec3::ZERO, Vec3::X * 50.0, Vec3::Y * 50.0, 0)
        .quad(Vec3::Z * 2.0, Vec3::Y * 50.0, Vec3::X * 50.0, 0);
    let steps = Cell::new((0, 0));
    let inputs = (
        point(2.0),
        point(2.0),
        1usize..8,
        prop::collection::vec(point(0.5), 8),
    );
    runner(3000)
        .run(&inputs, |(a, b, n, jitter)| {
            let a = Vec3::new(a.x, a.y, 1.0 + 0.4 * a.z);
            let b = Vec3::new(b.x, b.y, 1.0 + 0.4 * b.z);
            // Unfolded: the light at height a.z, mirrors at 0, -2, -4 ..., the end's image behind the n-th.
            let image = if n % 2 == 1 { -b.z } else { b.z } - 2.0 * (n - n % 2) as f32;
            let expected: Vec<Vec3> = (0..n)
                .map(|i| {
                    let t = (a.z + 2.0 * i as f32) / (a.z - image);
                    a.lerp(b, t).with_z(if i % 2 == 0 { 0.0 } else { 2.0 })
                })
                .collect();
            let guesses: Vec<Vec3> = expected
                .iter()
                .zip(&jitter)
                .map(|(p, j)| *p + j.with_z(0.0))
                .collect();
            let end = ChainVertex::point(b);
            let (start, len) = scene
                .chain(ChainVertex::point(a), &guesses, end, mirror)
                .unwrap();
            let walk = run(&scene, &start, len, &SPECULAR);
            prop_assert_eq!(walk.status, walk_status::CONVERGED);
            for i in 0..n {
                let off = (walk.vertices[i + 1].position - expected[i]).length();
                prop_assert!(off < 4e-4, "vertex {i} is {off} off");
            }
            let (sum, all) = steps.get();
            steps.set((sum + walk.iterations, all + 1));
            Ok(())
        })
        .unwrap();
    let (sum, all) = steps.get();
    println!(
        "parallel mirrors: {:.2} iterations",
        f64::from(sum) / f64::from(all)
    );
    assert!(sum < 4 * all);
}

/// Points of the unit circle where a path from `a` to `b` in its plane is reflected: roots of the sine between the normal
/// and the bisector.
fn circle_roots(a: DVec2, b: DVec2) -> Vec<f64> {
    let f = |phi: f64| {
        let n = DVec2::from_angle(phi);
        let h = (a - n).normalize() + (b - n).normalize();
        n.perp_dot(h)
    };
    let steps = 4000;
    let at = |i: usize| std::f64::consts::TAU * (i as f64 + 0.37) / steps as f64;
    let mut roots = vec![];
    for i in 0..steps {
        let (mut low, mut high) = (at(i), at(i + 1));
        if f(low) * f(high) < 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if f(low) * f(middle) <= 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            let n = DVec2::from_angle(low);
            let h = (a - n).normalize() + (b - n).normalize();
            // Not where the bisector vanishes: the straight line through the sphere.
            if h.length() > 1e-2 {
                roots.push(low);
            }
        }
    }
    roots
}

/// A mirror ball from outside has one reflection: found from nearly anywhere on the visible side, and never another.
#[test]
fn sphere_reflects_where_alhazen_says() {
    let scene = Mirrors::default().sphere(Vec3::ZERO, 1.0, 0);
    let (found, missed) = (Cell::new(0), Cell::new(0));
    let inputs = (1.3f64..4.0, 1.3f64..4.0, -2.2f64..2.2, point(0.4));
    runner(2000)
        .run(&inputs, |(ra, rb, angle, jitter)| {
            let a = DVec2::new(ra, 0.0);
            let b = DVec2::from_angle(angle) * rb;
            let lit = |phi: f64| {
                let n = DVec2::from_angle(phi);
                (a - n).dot(n) > 0.1 && (b - n).dot(n) > 0.1
            };
            let roots: Vec<f64> = circle_roots(a, b).into_iter().filter(|r| lit(*r)).collect();
            prop_assume!(roots.len() == 1);
            let root = DVec2::from_angle(roots[0]);
            let to3 = |p: DVec2| Vec3::new(p.x as f32, 0.0, p.y as f32);
            let near = (to3(root) + jitter).normalize();
            let end = ChainVertex::point(to3(b));
            let chain = scene.chain(ChainVertex::point(to3(a)), &[near], end, mirror);
            prop_assume!(chain.is_some());
            let (start, len) = chain.unwrap();
            let visible = |p: Vec3| start[1].position.dot(p - start[1].position) > 0.05;
            prop_assume!(visible(to3(a)) && visible(to3(b)));
            let walk = run(&scene, &start, len, &SPECULAR);
            if !walk.is_converged() {
                missed.set(missed.get() + 1);
                return Ok(());
            }
            let off = (walk.vertices[1].position - to3(root)).length();
            prop_assert!(off < 5e-4, "{off} off");
            found.set(found.get() + 1);
            Ok(())
        })
        .unwrap();
    let (found, missed) = (found.get(), missed.get());
    println!("mirror ball: {found} found, {missed} not");
    assert!(found > 1900 && missed * 50 < found);
}

/// Inside a mirror ball there are up to four reflections in the plane of the points: the caustic. The walk from near each
/// finds it.
#[test]
fn concave_mirror_has_all_its_caustic_roots() {
    let scene = Mirrors::default().sphere(Vec3::ZERO, 1.0, 0);
    let (found, missed, four) = (Cell::new(0), Cell::new(0), Cell::new(0));
    runner(1000)
        .run(
            &(point(0.75), point(0.75), point(0.01)),
            |(a, b, jitter)| {
                let (a, b) = (
                    DVec2::new(a.x.into(), a.y.into()),
                    DVec2::new(b.x.into(), b.y.into()),
                );
                prop_assume!((a - b).length() > 0.3 && a.length().max(b.length()) < 0.9);
                let roots = circle_roots(a, b);
                prop_assert!(
                    roots.len() == 2 || roots.len() == 4,
                    "{} roots",
                    roots.len()
                );
                four.set(four.get() + usize::from(roots.len() == 4));
                let to3 = |p: DVec2| Vec3::new(p.x as f32, 0.0, p.y as f32);
                for root in roots {
                    let root = to3(DVec2::from_angle(root));
                    let end = ChainVertex::point(to3(b));
                    let (start, len) = scene
                        .chain(ChainVertex::point(to3(a)), &[root + jitter], end, mirror)
                        .unwrap();
                    let walk = run(&scene, &start, len, &SPECULAR);
                    let off = (walk.vertices[1].position - root).length();
                    if walk.is_converged() && off < 2e-3 {
                        found.set(found.get() + 1);
                    } else {
                        // Two roots meet on the caustic, where J is singular; and from near there the other may be found.
                        missed.set(missed.get() + 1);
                    }
                }
                Ok(())
            },
        )
        .unwrap();
    let (found, missed) = (found.get(), missed.get());
    println!(
        "caustic roots: {found} found, {missed} not, {} cases of four",
        four.get()
    );
    assert!(four.get() > 50 && missed * 50 < found);
}

/// Through a slab of glass: the lateral shift by Snell's law, solved in f64. Nearer to index one slopes of half vectors grow
/// as 1 / (eta - 1) and starts this far off are lost more often (one in twelve from 1.05 on).
#[test]
fn slab_refracts_by_snell() {
    let scene = Mirrors::default()
        .quad(Vec3::ZERO, Vec3::X * 50.0, Vec3::Y * 50.0, 0)
        .quad(Vec3::Z, Vec3::X * 50.0, Vec3::Y * 50.0, 0);
    let worst = Cell::new(0.0f32);
    let (found, missed) = (Cell::new(0), Cell::new(0));
    let inputs = (
        point(2.0),
        point(2.0),
        0.3f32..3.0,
        0.3f32..3.0,
        1.2f32..2.5,
        point(0.3),
    );
    runner(3000)
        .run(&inputs, |(p, q, da, db, index, jitter)| {
            let a = Vec3::new(p.x, p.y, -da);
            let b = Vec3::new(q.x, q.y, 1.0 + db);
            let across = f64::from((b - a).truncate().length());
            let eta = f64::from(index);
            // Sum of the lateral shifts as a function of the sine outside.
            let shift = |s: f64, d: f64| d * s / (1.0 - s * s).sqrt();
            let total = |s: f64| shift(s, f64::from(da + db)) + shift(s / eta, 1.0);
            let (mut low, mut high) = (0.0f64, 1.0 - 1e-12);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if total(middle) < across {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let u = (b - a).truncate().normalize_or(Vec2::X);
            let first = a.truncate() + u * shift(low, f64::from(da)) as f32;
            let second = b.truncate() - u * shift(low, f64::from(db)) as f32;
            let guesses = [
                (first + jitter.truncate()).extend(0.0),
                (second - jitter.truncate()).extend(1.0),
            ];
            let glass = |i: usize, x: ChainVertex| {
                let eta = if i == 1 { index } else { 1.0 / index };
                x.scattering(true, eta, Vec2::ZERO)
            };
            let end = ChainVertex::point(b);
            let (start, len) = scene
                .chain(ChainVertex::point(a), &guesses, end, glass)
                .unwrap();
            let walk = run(&scene, &start, len, &SPECULAR);
            if !walk.is_converged() {
                missed.set(missed.get() + 1);
                return Ok(());
            }
            found.set(found.get() + 1);
            for (x, expected) in [(1, first), (2, second)] {
                let off = (walk.vertices[x].position.truncate() - expected).length();
                worst.set(worst.get().max(off));
                prop_assert!(off < 1e-3, "vertex {x} is {off} off");
            }
            Ok(())
        })
        .unwrap();
    let (found, missed) = (found.get(), missed.get());
    println!("slab: {found} found, {missed} not");
    assert!(found > 2500 && missed * 20 < found);
    println!("slab: vertices within {:.1e}", worst.get());
}
