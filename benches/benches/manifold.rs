//! What a half-vector mutation is made of: the block solvers against dense ones, constraints, a proposal, a walk.
//!
//! Two tables of least times, 3000 batches each, of functions that ran in turn ([`halflight_benches::Race`]). All in `f32`.
//!
//! The first solves J x = h of a chain with k - 1 inner vertices, 2 (k - 1) unknowns: by elimination from both ends
//! (`block_elimination`), by factors that are kept and one solution (`BlockLu`), and by nalgebra's dense LU with partial pivoting,
//! of dynamic and of fixed size, factors and one solution, of a matrix that was filled and copied beforehand (its
//! factorisation works in place: dynamic sizes pay for the copy's memory, as every caller who factors does).
//!
//! The second times all parts of a mutation beside one evaluation of a rough GGX conductor with its density. `constraints` makes
//! all blocks and factors them. `walk` moves the vertices of a path through a glass ball over a plane by a tenth of their
//! roughness, over a brute-force ray tracer of the two surfaces, so that traversal is a small part; `mutate` adds the walk
//! back and the densities.

#[path = "../../kernel/tests/common/spheres.rs"]
mod spheres;

use glam::{Mat2, Vec2, Vec3};
use halflight_benches::Race;
use halflight_kernel::bsdf::{Lobe, lobe};
use halflight_kernel::manifold::disk_lobe::DiskLobe;
use halflight_kernel::manifold::mutation::mutate;
use halflight_kernel::manifold::step_size::{
    GAMMA, disk_proposal, image_step, slope_proposal, spectrum_weights,
};
use halflight_kernel::manifold::walk::{WalkOptions, walk};
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, half_vector_form, vertex_kind};
use halflight_kernel::math::Ray;
use halflight_kernel::math::block_elimination;
use halflight_kernel::math::block_tridiagonal::BlockLu;
use halflight_kernel::math::moebius::{moebius, moebius_jacobian};
use halflight_kernel::regularize::bounds;
use halflight_kernel::scene::{
    SceneView, Traverse, distribution, lobe_flag, lobe_kind, surface_at,
};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use spheres::Spheres;
use std::hint::black_box;

const N: usize = 32;

/// A fixed stream of numbers in [-1, 1).
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }

    fn block(&mut self) -> Mat2 {
        Mat2::from_cols_array(&[self.next(), self.next(), self.next(), self.next()])
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

/// A line of the first table for a path of `$k` edges with `$d` unknowns. nalgebra knows fixed sizes only by name. The block
/// solvers have the capacity that they need.
macro_rules! solvers {
    ($k:literal, $d:literal) => {{
        const K: usize = $k;
        let n = K - 1;
        let mut numbers = Numbers(7);
        let mut a = [Mat2::ZERO; K];
        let (mut b, mut c, mut h) = (a, a, [Vec2::ZERO; K]);
        for i in 0..K {
            a[i] = numbers.block();
            b[i] = numbers.block() + Mat2::IDENTITY * 4.0;
            c[i] = numbers.block();
            h[i] = Vec2::new(numbers.next(), numbers.next());
        }
        let mut dense = DMatrix::<f32>::zeros(2 * n, 2 * n);
        for i in 0..n {
            let mut put = |j: usize, m: Mat2| {
                for r in 0..2 {
                    for s in 0..2 {
                        dense[(2 * i + r, 2 * j + s)] = m.col(s)[r];
                    }
                }
            };
            put(i, b[i]);
            if i > 0 {
                put(i - 1, a[i]);
            }
            if i + 1 < n {
                put(i + 1, c[i]);
            }
        }
        let right = DVector::from_fn(2 * n, |i, _| h[i / 2][i % 2]);
        let fixed = SMatrix::<f32, $d, $d>::from_fn(|i, j| dense[(i, j)]);
        let fixed_right = SVector::<f32, $d>::from_fn(|i, _| right[i]);

        // All four agree.
        let mut once = h;
        assert!(block_elimination::solve(&a, &b, &c, n, &mut once));
        let mut twice = h;
        assert!(BlockLu::<K>::factor(&a, &b, &c, n).solve(&mut twice));
        let expected = dense.clone().lu().solve(&right).unwrap();
        for i in 0..2 * n {
            let x = [once[i / 2][i % 2], twice[i / 2][i % 2]];
            assert!((x[0] - expected[i]).abs() < 1e-5 && (x[1] - expected[i]).abs() < 1e-5);
        }

        let mut race = Race::new();
        race.add(50, || {
            let (a, b, c, h) = black_box((&a, &b, &c, &h));
            let mut x = *h;
            block_elimination::solve(a, b, c, n, &mut x);
            x
        });
        race.add(50, || {
            let (a, b, c, h) = black_box((&a, &b, &c, &h));
            let mut x = *h;
            let lu: BlockLu<K> = BlockLu::factor(a, b, c, n);
            lu.solve(&mut x);
            x
        });
        race.add(50, || {
            black_box(&dense).clone().lu().solve(black_box(&right))
        });
        race.add(50, || {
            (*black_box(&fixed)).lu().solve(black_box(&fixed_right))
        });
        let t = race.run();
        println!(
            "| {K} | {:.1} | {:.1} | {:.1} | {:.0} | {:.0} | {:.1} | {:.1} | {:.1} |",
            t[0],
            t[0] / n as f64,
            t[1],
            t[2],
            t[3],
            t[2] / t[0],
            t[3] / t[0],
            t[2] / t[1],
        );
    }};
}

/// A chain of mirrors and glass with curvature.
fn chain(len: usize) -> [ChainVertex; N] {
    let mut numbers = Numbers(3);
    let mut vertices = [ChainVertex::NONE; N];
    let mut position = Vec3::ZERO;
    for (i, x) in vertices.iter_mut().enumerate().take(len) {
        let n = (Vec3::Z + numbers.vector() * 0.3).normalize();
        let (u, v) = n.any_orthonormal_pair();
        *x = ChainVertex {
            position,
            geometric_normal: n,
            tangent_u: u,
            tangent_v: v,
            normal: n,
            dn_u: u * numbers.next(),
            dn_v: v * numbers.next(),
            reference: u,
            alpha: Vec2::splat(0.1),
            ..ChainVertex::NONE
        };
        if i > 0 && i + 1 < len {
            x.kind = vertex_kind::REFLECTION + (i % 2) as u32;
            x.eta = if i % 2 == 0 { 1.0 } else { 1.5 };
        }
        let up = if i % 2 == 0 { 1.0 } else { -0.8 };
        position += Vec3::new(numbers.next(), numbers.next(), up).normalize();
    }
    vertices
}

/// The parts of a mutation, by name, in one race.
struct Parts<'a> {
    race: Race<'a>,
    names: Vec<String>,
}

impl<'a> Parts<'a> {
    fn add<T>(&mut self, name: impl Into<String>, f: impl FnMut() -> T + 'a) {
        self.names.push(name.into());
        self.race.add(20, f);
    }

    /// Prints times and their ratios to the first.
    fn print(self) {
        let times = self.race.run();
        println!("\n| part | ns | ratio |\n|---|---|---|");
        for (name, time) in self.names.iter().zip(&times) {
            println!("| {name} | {time:.0} | {:.2} |", time / times[0]);
        }
    }
}

/// A path from a light into a glass ball, out of it, off the ground and to the eye.
fn caustic(scene: &Spheres) -> [ChainVertex; N] {
    let tables = scene.tables();
    let mut vertices = [ChainVertex::NONE; N];
    vertices[0] = ChainVertex::point(Vec3::new(0.4, 0.0, 3.0));
    let guesses = [
        Vec3::new(0.15, 0.05, 0.99),
        Vec3::new(0.05, 0.02, -0.99),
        Vec3::new(0.0, 0.02, -1.5),
    ];
    for (i, guess) in guesses.iter().enumerate() {
        let from = vertices[i];
        let d = (*guess - from.position).normalize();
        let side = from.geometric_normal.dot(d).signum();
        let origin = from.position + from.geometric_normal * side * from.position_error;
        let ray = Ray::new(origin, d);
        let point = surface_at(&tables, &ray, &scene.closest_hit(&ray));
        let eta = [1.5, 1.0 / 1.5, 1.0][i];
        vertices[i + 1] =
            ChainVertex::from_surface(&point).scattering(i < 2, eta, Vec2::splat(0.1));
    }
    vertices[4] = ChainVertex::point(Vec3::new(3.0, 0.5, 0.5));
    vertices
}

fn parts() {
    let conductor = Lobe {
        kind: lobe_kind::ROUGH_CONDUCTOR,
        distribution: distribution::GGX,
        flags: lobe_flag::FRONT,
        weight: 1.0,
        specular_reflectance: Vec3::ONE,
        eta: Vec3::splat(1.5),
        k: Vec3::splat(3.0),
        alpha: Vec2::splat(0.2),
        ..Lobe::NONE
    };
    let (wi, wo) = (
        Vec3::new(0.3, -0.2, 0.8).normalize(),
        Vec3::new(-0.2, 0.3, 0.7).normalize(),
    );
    let chains = [2usize, 4, 8, 16, 31].map(|k| (k, chain(k + 1)));
    let vertices = chain(9);
    let jacobian = ChainJacobian::new(&vertices, 9, half_vector_form::SLOPE);
    let image = image_step(Mat2::IDENTITY, Vec2::X * 1e-2, Vec2::Y * 2e-2);
    let slope = slope_proposal(&vertices[1], Vec2::new(0.1, 0.2), image, 0.5, GAMMA);
    let lobe_on_disk: DiskLobe = disk_proposal(&slope);

    // A ball on another that is large enough for a plane.
    let below = Vec3::new(0.0, 0.0, -51.5);
    let scene = Spheres::new([(Vec3::ZERO, 1.0, 0), (below, 50.0, 1)]);
    let view = SceneView {
        tables: scene.tables(),
        traverse: &scene,
    };
    let path = caustic(&scene);
    let options = WalkOptions::new(3.0);
    let at_start = ChainJacobian::new(&path, 5, options.form);
    let mut target = at_start.h;
    for h in &mut target[1..4] {
        *h += Vec2::new(0.007, -0.004);
    }
    let found = walk(&view, &path, &at_start, &target, &options);
    assert!(found.is_converged());
    println!(
        "\nThe walk takes {} iterations of 3 rays.",
        found.iterations
    );

    let mut parts = Parts {
        race: Race::new(),
        names: vec![],
    };
    parts.add("rough GGX conductor, evaluated with its density", || {
        lobe::eval_cosine_pdf(black_box(&conductor), &[], black_box(wi), wo)
    });
    for (k, vertices) in &chains {
        parts.add(format!("constraints and factors, k = {k}"), move || {
            ChainJacobian::new(black_box(vertices), k + 1, half_vector_form::SLOPE)
        });
    }
    parts.add("proposal for 7 vertices, sampled and evaluated", || {
        let jacobian = black_box(&jacobian);
        let (mut weights, mut d) = ([0.0; N], [Mat2::ZERO; N]);
        spectrum_weights(black_box(&vertices), 9, &mut weights);
        jacobian.lu.row_of_inverse(7, &mut d);
        let mut pdf = 1.0;
        let mut target = jacobian.h;
        for i in 1..8 {
            let image = image_step(d[i], Vec2::X * 1e-2, Vec2::Y * 2e-2);
            let p = slope_proposal(&vertices[i], jacobian.h[i], image, weights[i], GAMMA);
            target[i] = p.sample(black_box(Vec2::new(0.3, 0.7)));
            pdf *= p.pdf_slope(target[i]);
        }
        (target, pdf)
    });
    parts.add("Phong lobe on the disk, sampled and evaluated", || {
        let lobe = black_box(&lobe_on_disk);
        let h = lobe.sample(black_box(Vec2::new(0.3, 0.7)));
        (h, lobe.pdf_disk(h))
    });
    parts.add("Moebius map and its Jacobian", || {
        let (a, z) = black_box((Vec2::new(0.5, -0.2), Vec2::new(-0.1, 0.6)));
        (moebius(a, z), moebius_jacobian(a, z))
    });
    parts.add("walk of 3 vertices", || {
        walk(
            &view,
            black_box(&path),
            &at_start,
            black_box(&target),
            &options,
        )
    });
    parts.add("mutation: walk, walk back, densities", || {
        mutate(
            &view,
            black_box(&path),
            &at_start,
            black_box(&target),
            &options,
        )
    });
    parts.add("3 rays of an iteration", || {
        let mut t = 0.0;
        for i in 0..3 {
            let d = path[i + 1].position - path[i].position;
            let ray = Ray::new(black_box(path[i].position), d.normalize());
            t += scene.closest_hit(&ray).t;
        }
        t
    });
    parts.add("bound of reflection", || {
        bounds::reflection_bound(
            bounds::SMITH,
            distribution::GGX,
            black_box(Vec2::splat(0.1)),
        )
    });
    parts.add("alpha-hat of reflection", || {
        bounds::reflection_alpha(bounds::SMITH, distribution::GGX, black_box(100.0))
    });
    parts.add("tight bound of refraction", || {
        bounds::tight_refraction_bound(distribution::GGX, black_box(0.1), 1.5)
    });
    parts.add("tight alpha-hat of refraction", || {
        bounds::tight_refraction_alpha(distribution::GGX, black_box(100.0), black_box(1.5))
    });
    parts.print();
}

fn main() {
    println!(
        "| k | at once | per inner vertex | factors, then solve | nalgebra, dynamic | nalgebra, fixed | dynamic / at once | fixed / at once | dynamic / factors |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    solvers!(2, 2);
    solvers!(4, 6);
    solvers!(8, 14);
    solvers!(16, 30);
    solvers!(32, 62);
    parts();
}
