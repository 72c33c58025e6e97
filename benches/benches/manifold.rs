//! What a half-vector mutation is made of: the block solver against a dense one, constraints, a proposal, a walk.
//!
//! `solve` factors J of a chain with k - 1 inner vertices and solves for one right-hand side; nalgebra does the same with its
//! dense LU of dynamic size 2 (k - 1), filled beforehand. `constraints` makes all blocks and factors them. `walk` moves both
//! vertices of a path through a glass ball over a plane by a tenth of their roughness, over a brute-force ray tracer of the
//! two surfaces, so that traversal is a small part; `mutate` adds the walk back and the densities.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Mat2, Vec2, Vec3};
use halflight_kernel::manifold::mutation::mutate;
use halflight_kernel::manifold::step_size::{
    GAMMA, disk_proposal, image_step, slope_proposal, spectrum_weights,
};
use halflight_kernel::manifold::walk::{WalkOptions, walk};
use halflight_kernel::manifold::{ChainJacobian, ChainVertex, half_vector_form, vertex_kind};
use halflight_kernel::math::Ray;
use halflight_kernel::math::block_tridiagonal::BlockLu;
use halflight_kernel::math::disk_lobe::DiskLobe;
use halflight_kernel::math::moebius::{moebius, moebius_jacobian};
use halflight_kernel::scene::intersect::intersect_quadric;
use halflight_kernel::scene::*;
use nalgebra::{DMatrix, DVector};
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

/// Both solvers for a path of K edges; the block solver has the capacity that it needs.
fn solver<const K: usize>(c: &mut Criterion) {
    let mut numbers = Numbers(7);
    let n = K - 1;
    let (mut lower, mut diagonal, mut upper) = ([Mat2::ZERO; K], [Mat2::ZERO; K], [Mat2::ZERO; K]);
    let mut h = [Vec2::ZERO; K];
    for i in 0..K {
        lower[i] = numbers.block();
        diagonal[i] = numbers.block() + Mat2::IDENTITY * 4.0;
        upper[i] = numbers.block();
        h[i] = Vec2::new(numbers.next(), numbers.next());
    }
    let mut group = c.benchmark_group("solve");
    group.throughput(Throughput::Elements(n as u64));
    group.bench_function(BenchmarkId::new("block", K), |b| {
        b.iter(|| {
            let (a, d, u) = black_box((&lower, &diagonal, &upper));
            let lu: BlockLu<K> = BlockLu::factor(a, d, u, n);
            let mut x = h;
            lu.solve(&mut x);
            x
        });
    });
    let mut dense = DMatrix::<f32>::zeros(2 * n, 2 * n);
    for i in 0..n {
        let mut put = |j: usize, m: Mat2| {
            for r in 0..2 {
                for s in 0..2 {
                    dense[(2 * i + r, 2 * j + s)] = m.col(s)[r];
                }
            }
        };
        put(i, diagonal[i]);
        if i > 0 {
            put(i - 1, lower[i]);
        }
        if i + 1 < n {
            put(i + 1, upper[i]);
        }
    }
    let right = DVector::from_fn(2 * n, |i, _| h[i / 2][i % 2]);
    group.bench_function(BenchmarkId::new("nalgebra", K), |b| {
        b.iter(|| black_box(dense.clone()).lu().solve(black_box(&right)));
    });
    group.finish();
}

fn solvers(c: &mut Criterion) {
    solver::<2>(c);
    solver::<4>(c);
    solver::<8>(c);
    solver::<16>(c);
    solver::<32>(c);
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

fn chains(c: &mut Criterion) {
    let mut group = c.benchmark_group("constraints");
    for k in [2usize, 4, 8, 16, 31] {
        let vertices = chain(k + 1);
        group.throughput(Throughput::Elements(k as u64 - 1));
        group.bench_with_input(BenchmarkId::new("slope", k), &k, |b, &k| {
            b.iter(|| ChainJacobian::new(black_box(&vertices), k + 1, half_vector_form::SLOPE));
        });
    }
    group.finish();

    let vertices = chain(9);
    let jacobian = ChainJacobian::new(&vertices, 9, half_vector_form::SLOPE);
    let mut group = c.benchmark_group("proposal");
    group.throughput(Throughput::Elements(7));
    group.bench_function("slopes of 7 vertices, sampled and evaluated", |b| {
        b.iter(|| {
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
    });
    let image = image_step(Mat2::IDENTITY, Vec2::X * 1e-2, Vec2::Y * 2e-2);
    let slope = slope_proposal(&vertices[1], Vec2::new(0.1, 0.2), image, 0.5, GAMMA);
    let lobe: DiskLobe = disk_proposal(&slope);
    group.throughput(Throughput::Elements(1));
    group.bench_function("Phong lobe on the disk, sampled and evaluated", |b| {
        b.iter(|| {
            let lobe = black_box(&lobe);
            let h = lobe.sample(black_box(Vec2::new(0.3, 0.7)));
            (h, lobe.pdf_disk(h))
        });
    });
    group.finish();

    c.bench_function("moebius/map and Jacobian", |b| {
        b.iter(|| {
            let (a, z) = black_box((Vec2::new(0.5, -0.2), Vec2::new(-0.1, 0.6)));
            (moebius(a, z), moebius_jacobian(a, z))
        });
    });
}

/// Two spheres, one of them large enough for a plane.
struct Spheres {
    quadrics: [Quadric; 2],
}

impl Spheres {
    fn new() -> Spheres {
        let sphere = |x: f32, z: f32, r: f32, shape| Quadric {
            to_world: [r, 0.0, 0.0, x, 0.0, r, 0.0, 0.0, 0.0, 0.0, r, z],
            to_object: [
                1.0 / r,
                0.0,
                0.0,
                -x / r,
                0.0,
                1.0 / r,
                0.0,
                0.0,
                0.0,
                0.0,
                1.0 / r,
                -z / r,
            ],
            kind: quadric_kind::SPHERE,
            shape,
        };
        Spheres {
            quadrics: [sphere(0.0, 0.0, 1.0, 0), sphere(0.0, -51.5, 50.0, 1)],
        }
    }
}

impl Traverse for Spheres {
    fn closest_hit(&self, ray: &Ray) -> Hit {
        let mut hit = Hit::MISS;
        for (i, q) in self.quadrics.iter().enumerate() {
            let o = halflight_kernel::math::affine::transform_point(&q.to_object, ray.origin);
            let d = halflight_kernel::math::affine::transform_vector(&q.to_object, ray.direction);
            let t = intersect_quadric(q.kind, o, d, ray.t_min, ray.t_max.min(hit.t));
            if t < hit.t {
                hit = Hit {
                    t,
                    primitive: i as u32,
                    ..Hit::MISS
                };
                hit.instance = 0;
            }
        }
        hit
    }

    fn is_occluded(&self, ray: &Ray) -> bool {
        self.closest_hit(ray).is_hit()
    }
}

fn walks(c: &mut Criterion) {
    let scene = Spheres::new();
    let shape = |material| Shape {
        material,
        emitter: NONE,
        flags: 0,
        normal_offset: NONE,
        uv_offset: NONE,
        first_vertex: 0,
        first_primitive: 0,
        primitive_count: 1,
    };
    let shapes = [shape(0), shape(1)];
    let camera: Camera = bytemuck::Zeroable::zeroed();
    let info: SceneInfo = bytemuck::Zeroable::zeroed();
    let tables = Tables {
        positions: &[],
        normals: &[],
        uvs: &[],
        triangles: &[],
        quadrics: &scene.quadrics,
        shapes: &shapes,
        instances: &[],
        materials: &[],
        lobes: &[],
        factors: &[],
        frame_maps: &[],
        textures: &[],
        texels: &[],
        data: &[],
        emitters: &[],
        camera,
        info,
    };
    let view = SceneView {
        tables,
        traverse: &scene,
    };
    // Light, into the ball, out of the ball, off the ground, eye.
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
        let point = surface_at(&view.tables, &ray, &scene.closest_hit(&ray));
        let eta = [1.5, 1.0 / 1.5, 1.0][i];
        vertices[i + 1] =
            ChainVertex::from_surface(&point).scattering(i < 2, eta, Vec2::splat(0.1));
    }
    vertices[4] = ChainVertex::point(Vec3::new(3.0, 0.5, 0.5));
    let options = WalkOptions::new(3.0);
    let jacobian = ChainJacobian::new(&vertices, 5, options.form);
    let mut target = jacobian.h;
    for h in &mut target[1..4] {
        *h += Vec2::new(0.007, -0.004);
    }
    let found = walk(&view, &vertices, &jacobian, &target, &options);
    assert!(found.is_converged());
    println!("the walk takes {} iterations of 3 rays", found.iterations);
    let mut group = c.benchmark_group("path");
    group.bench_function("walk of 3 vertices", |b| {
        b.iter(|| {
            walk(
                &view,
                black_box(&vertices),
                &jacobian,
                black_box(&target),
                &options,
            )
        });
    });
    group.bench_function("mutation of 3 vertices", |b| {
        b.iter(|| {
            mutate(
                &view,
                black_box(&vertices),
                &jacobian,
                black_box(&target),
                &options,
            )
        });
    });
    group.bench_function("3 rays", |b| {
        b.iter(|| {
            let mut t = 0.0;
            for i in 0..3 {
                let d = vertices[i + 1].position - vertices[i].position;
                let ray = Ray::new(black_box(vertices[i].position), d.normalize());
                t += scene.closest_hit(&ray).t;
            }
            t
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(30)
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_millis(1000));
    targets = solvers, chains, walks
}
criterion_main!(benches);
