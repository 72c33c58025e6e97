//! Rays per second of the CPU's wide trees, of the kernel's binary walk and of obvhs alone.
//!
//! The scene is a bumpy sphere of 100 352 triangles over a ground of two. `camera` rays come from a grid of pixels, in
//! order; `scattered` rays start on the surface in random directions of the hemisphere; `shadow` rays ask only whether the
//! way to a point above is free. One element of throughput is one ray. `obvhs` is the library's own traversal with its
//! own triangle test, which returns only a distance: the cost of bare traversal. `batch` is the wide tree with 1024 rays at
//! once.

use bytemuck::Zeroable;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec3, Vec3A};
use halflight::accel::{Accel, GroupRange};
use halflight_kernel::math::{Frame, Ray};
use halflight_kernel::scene::{
    Bvh2Traverse, HitBatch, Instance, RayBatch, Shape, Tables, Traverse, Triangle, surface_at,
};
use std::hint::black_box;

#[path = "../../kernel/tests/common/empty_tables.rs"]
mod empty_tables;
use empty_tables::empty_tables;

const IDENTITY: [f32; 12] = halflight_kernel::math::affine::IDENTITY;

struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<Triangle>,
    shapes: Vec<Shape>,
    instances: Vec<Instance>,
}

impl Mesh {
    fn bumpy_sphere() -> Mesh {
        let (rings, sectors) = (224, 224);
        let mut positions = vec![];
        for i in 0..=rings {
            for j in 0..sectors {
                let theta = std::f32::consts::PI * i as f32 / rings as f32;
                let phi = std::f32::consts::TAU * j as f32 / sectors as f32;
                let bump = (9.0 * theta).sin() * (7.0 * phi).cos();
                let fine = (41.0 * theta).cos() * (37.0 * phi).sin();
                let r = 1.0 + 0.15 * bump + 0.03 * fine;
                let p = Vec3::new(
                    theta.sin() * phi.cos(),
                    theta.cos(),
                    theta.sin() * phi.sin(),
                );
                positions.push((p * r).to_array());
            }
        }
        let mut triangles = vec![];
        let mut push = |vertices| triangles.push(Triangle { vertices, shape: 0 });
        for i in 0..rings {
            for j in 0..sectors {
                let next = (j + 1) % sectors;
                let (a, b) = (i * sectors + j, i * sectors + next);
                push([a, b, a + sectors]);
                push([b, b + sectors, a + sectors]);
            }
        }
        let first = positions.len() as u32;
        for (x, z) in [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)] {
            positions.push([x, -1.3, z]);
        }
        push([first, first + 1, first + 2]);
        push([first, first + 2, first + 3]);
        Mesh {
            positions,
            triangles,
            shapes: vec![Shape {
                material: 0,
                emitter: u32::MAX,
                flags: 0,
                normal_offset: u32::MAX,
                uv_offset: u32::MAX,
                first_vertex: 0,
                first_primitive: 0,
                primitive_count: 0,
            }],
            instances: vec![Instance {
                to_world: IDENTITY,
                to_object: IDENTITY,
                root: 0,
                group: 0,
            }],
        }
    }

    fn tables(&self) -> Tables<'_> {
        Tables {
            positions: &self.positions,
            triangles: &self.triangles,
            shapes: &self.shapes,
            instances: &self.instances,
            ..empty_tables()
        }
    }
}

/// Numbers in [0, 1) by a multiplicative generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

fn camera_rays(n: usize) -> Vec<Ray> {
    let eye = Vec3::new(0.5, 1.5, 4.0);
    let frame = Frame::from_normal(-eye.normalize());
    (0..n * n)
        .map(|i| {
            let x = ((i % n) as f32 / n as f32 - 0.5) * 0.9;
            let y = ((i / n) as f32 / n as f32 - 0.5) * 0.9;
            Ray::new(eye, frame.to_world(Vec3::new(x, y, 1.0)).normalize())
        })
        .collect()
}

/// Rays that leave the camera rays' hits, in random order, and segments from there to a point above.
fn secondary_rays(tables: Tables<'_>, traverse: &impl Traverse) -> (Vec<Ray>, Vec<Ray>) {
    let mut random = Random(7);
    let (mut scattered, mut shadow) = (vec![], vec![]);
    for ray in camera_rays(256) {
        let hit = traverse.closest_hit(&ray);
        if !hit.is_hit() {
            continue;
        }
        let point = surface_at(&tables, &ray, &hit);
        let n = point.geometric_normal * -point.geometric_normal.dot(ray.direction).signum();
        let z = 1.0 - 2.0 * random.next();
        let (s, c) = (std::f32::consts::TAU * random.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let d = (n + Vec3::new(r * c, r * s, z))
            .try_normalize()
            .unwrap_or(n);
        scattered.push(point.spawn(d));
        shadow.push(point.segment_to(Vec3::new(3.0 * random.next(), 4.0, 3.0 * random.next())));
    }
    (scattered, shadow)
}

fn obvhs_ray(ray: &Ray) -> obvhs::ray::Ray {
    let (o, d) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
    obvhs::ray::Ray::new(o, d, ray.t_min, ray.t_max)
}

/// Rays of a batch.
const BATCH: usize = 1024;

/// Full batches of these rays.
fn batches(rays: &[Ray]) -> Vec<RayBatch<BATCH>> {
    let mut batches = vec![];
    for rays in rays.chunks_exact(BATCH) {
        let mut batch = RayBatch::zeroed();
        for (i, ray) in rays.iter().enumerate() {
            batch.set(i, ray);
        }
        batches.push(batch);
    }
    batches
}

fn traversal(criterion: &mut Criterion) {
    let mesh = Mesh::bumpy_sphere();
    let range = GroupRange {
        triangles: 0..mesh.triangles.len() as u32,
        quadrics: 0..0,
    };
    let tables = mesh.tables();
    let accel = Accel::build(tables, &[range]);
    println!("{:?}", accel.statistics());
    let wide = accel.traverse(tables);
    let nodes = accel.shader_nodes(tables);
    let binary = Bvh2Traverse {
        tables,
        nodes: &nodes.nodes,
        primitive_indices: &nodes.primitive_indices,
    };
    let triangles: Vec<_> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [v0, v1, v2] = t
                .vertices
                .map(|v| Vec3A::from_array(mesh.positions[v as usize]));
            obvhs::triangle::Triangle { v0, v1, v2 }
        })
        .collect();
    let bare = obvhs::cwbvh::builder::build_cwbvh_from_tris(
        &triangles,
        obvhs::BvhBuildParams::medium_build(),
        &mut std::time::Duration::default(),
    );
    let packed: Vec<obvhs::rt_triangle::RtTriangle> = bare
        .primitive_indices
        .iter()
        .map(|&i| (&triangles[i as usize]).into())
        .collect();
    let camera = camera_rays(256);
    let (scattered, shadow) = secondary_rays(tables, &wide);
    let mut hits = HitBatch::<BATCH>::zeroed();

    for (name, rays) in [("camera", &camera), ("scattered", &scattered)] {
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function("wide", |b| {
            b.iter(|| {
                rays.iter()
                    .map(|r| wide.closest_hit(black_box(r)).is_hit() as usize)
                    .sum::<usize>()
            });
        });
        let batches = batches(rays);
        group.throughput(Throughput::Elements((batches.len() * BATCH) as u64));
        group.bench_function("batch", |b| {
            b.iter(|| {
                for batch in &batches {
                    wide.closest_hits(black_box(batch), BATCH, &mut hits);
                    black_box(&hits);
                }
            });
        });
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function("binary", |b| {
            b.iter(|| {
                rays.iter()
                    .map(|r| binary.closest_hit(black_box(r)).is_hit() as usize)
                    .sum::<usize>()
            });
        });
        group.bench_function("obvhs", |b| {
            b.iter(|| {
                rays.iter()
                    .filter(|r| {
                        let mut hit = obvhs::ray::RayHit::none();
                        bare.ray_traverse(obvhs_ray(black_box(r)), &mut hit, |ray, i| {
                            packed[i].intersect(ray)
                        })
                    })
                    .count()
            });
        });
        group.finish();
    }
    let mut group = criterion.benchmark_group("shadow");
    group.throughput(Throughput::Elements(shadow.len() as u64));
    group.bench_function("wide", |b| {
        b.iter(|| {
            shadow
                .iter()
                .filter(|r| wide.is_occluded(black_box(r)))
                .count()
        });
    });
    let batches = batches(&shadow);
    group.throughput(Throughput::Elements((batches.len() * BATCH) as u64));
    group.bench_function("batch", |b| {
        b.iter(|| {
            for batch in &batches {
                wide.are_occluded(black_box(batch), BATCH, &mut hits);
                black_box(&hits);
            }
        });
    });
    group.throughput(Throughput::Elements(shadow.len() as u64));
    group.bench_function("binary", |b| {
        b.iter(|| {
            shadow
                .iter()
                .filter(|r| binary.is_occluded(black_box(r)))
                .count()
        });
    });
    group.bench_function("obvhs", |b| {
        b.iter(|| {
            shadow
                .iter()
                .filter(|r| {
                    !bare.ray_traverse_miss(obvhs_ray(black_box(r)), |ray, i| {
                        packed[i].intersect(ray)
                    })
                })
                .count()
        });
    });
    group.finish();
}

criterion_group!(benches, traversal);
criterion_main!(benches);
