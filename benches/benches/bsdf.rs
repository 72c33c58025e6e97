//! Nanoseconds of `eval_cosine`, `pdf` and `sample` of every scattering model.
//!
//! Each figure is the mean over the same 1024 pairs of directions: `wi` uniform over the side that the model serves, `wo`
//! sampled from the model itself for half of the pairs, where the value is large, and uniform for the other half.
//! Models are called through [`halflight_kernel::bsdf::lobe`], as a renderer calls them, dispatch by kind included;
//! `mixture` is a `Bsdf` of three of them. One element of throughput is one call.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::diffracting_conductor::fill_table;
use halflight_kernel::bsdf::diffraction_table::{FineScale, WORDS};
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_transmittance::{ROW, fill_row};
use halflight_kernel::bsdf::{Bsdf, Lobe, event, lobe, local_beckmann_roughness};
use halflight_kernel::scene::{MAX_LOBES, distribution, lobe_flag, lobe_kind};
use std::hint::black_box;

/// Pairs of directions per model.
const PAIRS: usize = 1024;

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

    fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.next() - 1.0;
        let (s, c) = (std::f32::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    }
}

/// What a model is called with.
struct Input {
    wi: Vec3,
    wo: Vec3,
    u1: f32,
    u2: Vec2,
}

fn inputs(l: &Lobe, data: &[f32]) -> Vec<Input> {
    let mut random = Random(11);
    let transmits = matches!(
        l.kind,
        lobe_kind::DIELECTRIC | lobe_kind::ROUGH_DIELECTRIC | lobe_kind::THIN_DIELECTRIC
    );
    (0..PAIRS)
        .map(|k| {
            let (mut wi, mut wo) = (random.direction(), random.direction());
            if !transmits {
                wi.z = wi.z.abs();
                wo.z = wo.z.abs();
            }
            let (u1, u2) = (random.next(), Vec2::new(random.next(), random.next()));
            let s = lobe::sample(l, data, wi, u1, u2);
            if k % 2 == 0 && s.pdf > 0.0 && s.event & event::DELTA == 0 {
                wo = s.wo;
            }
            Input { wi, wo, u1, u2 }
        })
        .collect()
}

fn white(kind: u32) -> Lobe {
    Lobe {
        kind,
        flags: lobe_flag::FRONT | lobe_flag::BACK,
        weight: 1.0,
        reflectance: Vec3::splat(0.5),
        specular_reflectance: Vec3::ONE,
        specular_transmittance: Vec3::ONE,
        eta: Vec3::splat(1.5),
        internal_reflectance: fresnel_diffuse_reflectance(1.0 / 1.5),
        ..Lobe::NONE
    }
}

fn gold(kind: u32) -> Lobe {
    Lobe {
        eta: Vec3::new(0.143, 0.375, 1.442),
        k: Vec3::new(3.983, 2.386, 1.603),
        ..white(kind)
    }
}

/// Every model with the table that it reads.
fn models() -> Vec<(String, Lobe, Vec<f32>)> {
    let mut models = vec![];
    let mut push = |name: &str, l: Lobe, data: Vec<f32>| models.push((name.to_owned(), l, data));
    push("diffuse", white(lobe_kind::DIFFUSE), vec![]);
    let rough = |l: Lobe, kind: u32| Lobe {
        distribution: kind,
        alpha: Vec2::splat(0.2),
        exponent: 0.7,
        ..l
    };
    push(
        "rough diffuse",
        rough(white(lobe_kind::ROUGH_DIFFUSE), 0),
        vec![],
    );
    push("conductor", gold(lobe_kind::CONDUCTOR), vec![]);
    push("dielectric", white(lobe_kind::DIELECTRIC), vec![]);
    push("thin dielectric", white(lobe_kind::THIN_DIELECTRIC), vec![]);
    for (name, kind) in [
        ("beckmann", distribution::BECKMANN),
        ("ggx", distribution::GGX),
        ("phong", distribution::PHONG),
        ("exponential power", distribution::EXPONENTIAL_POWER),
    ] {
        let conductor = rough(gold(lobe_kind::ROUGH_CONDUCTOR), kind);
        push(&format!("rough conductor {name}"), conductor, vec![]);
        let dielectric = rough(white(lobe_kind::ROUGH_DIELECTRIC), kind);
        push(&format!("rough dielectric {name}"), dielectric, vec![]);
    }
    push("plastic", white(lobe_kind::PLASTIC), vec![]);
    let mut row = vec![0.0; ROW];
    fill_row(distribution::GGX, 0.2, 1.5, &mut row);
    let plastic = Lobe {
        table: 0,
        ..rough(white(lobe_kind::ROUGH_PLASTIC), distribution::GGX)
    };
    push("rough plastic ggx", plastic, row);
    let coat = rough(white(lobe_kind::ROUGH_COAT), distribution::GGX);
    push("rough coat ggx", coat, vec![]);
    let mut coated = rough(gold(lobe_kind::ROUGH_CONDUCTOR), distribution::GGX);
    coated.coat_count = 1;
    coated.coats[0].eta = 1.5;
    push("rough conductor ggx under a coat", coated, vec![]);
    let scale = FineScale {
        wavelengths: [0.6114, 0.5491, 0.4642],
        sigma: 0.03,
        b: 2.0,
        c: 2.0,
    };
    let mut words = vec![0.0; WORDS];
    fill_table(&scale, 0.2, 0.7, &mut words);
    let diffracting = Lobe {
        table: 0,
        ..rough(
            gold(lobe_kind::DIFFRACTING_CONDUCTOR),
            distribution::EXPONENTIAL_POWER,
        )
    };
    push("diffracting conductor", diffracting, words);
    models
}

fn bsdf(criterion: &mut Criterion) {
    for (name, l, data) in models() {
        let inputs = inputs(&l, &data);
        let mut group = criterion.benchmark_group(&name);
        group.throughput(Throughput::Elements(PAIRS as u64));
        // Discrete models have nothing to evaluate.
        if !lobe::is_delta(l.kind) {
            group.bench_function("eval", |b| {
                b.iter(|| {
                    inputs.iter().fold(Vec3::ZERO, |sum, x| {
                        sum + lobe::eval_cosine(black_box(&l), &data, x.wi, x.wo)
                    })
                });
            });
            group.bench_function("pdf", |b| {
                b.iter(|| {
                    inputs
                        .iter()
                        .map(|x| lobe::pdf(black_box(&l), &data, x.wi, x.wo))
                        .sum::<f32>()
                });
            });
        }
        group.bench_function("sample", |b| {
            b.iter(|| {
                inputs.iter().fold(Vec3::ZERO, |sum, x| {
                    sum + lobe::sample(black_box(&l), &data, x.wi, x.u1, x.u2).weight
                })
            });
        });
        group.finish();
    }
}

/// A diffuse base, a narrow and a broad metallic lobe.
fn mixture(criterion: &mut Criterion) {
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[0] = white(lobe_kind::DIFFUSE);
    lobes[1] = gold(lobe_kind::ROUGH_CONDUCTOR);
    lobes[1].distribution = distribution::GGX;
    lobes[1].alpha = Vec2::splat(0.05);
    lobes[2] = lobes[1];
    lobes[2].alpha = Vec2::splat(0.4);
    for l in &mut lobes[..3] {
        l.weight = 1.0 / 3.0;
    }
    let inputs = inputs(&lobes[2], &[]);
    let materials: Vec<(Bsdf, &Input)> = inputs
        .iter()
        .map(|x| (Bsdf::from_lobes(lobes, 3, &[], x.wi), x))
        .collect();
    let mut group = criterion.benchmark_group("mixture of three");
    group.throughput(Throughput::Elements(PAIRS as u64));
    group.bench_function("eval", |b| {
        b.iter(|| {
            materials.iter().fold(Vec3::ZERO, |sum, (m, x)| {
                sum + m.eval_cosine(black_box(&[]), x.wi, x.wo)
            })
        });
    });
    group.bench_function("pdf", |b| {
        b.iter(|| {
            materials
                .iter()
                .map(|(m, x)| m.pdf(black_box(&[]), x.wi, x.wo))
                .sum::<f32>()
        });
    });
    group.bench_function("sample", |b| {
        b.iter(|| {
            materials.iter().fold(Vec3::ZERO, |sum, (m, x)| {
                sum + m.sample(black_box(&[]), x.wi, x.u1, x.u2).weight
            })
        });
    });
    group.bench_function("local roughness", |b| {
        b.iter(|| {
            materials
                .iter()
                .map(|(m, x)| local_beckmann_roughness(m, black_box(&[]), x.wi, x.wo))
                .sum::<f32>()
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_millis(600));
    targets = bsdf, mixture
}
criterion_main!(benches);
