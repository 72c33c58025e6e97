//! Cost of regularisation per call: bounds and their inverses, tau, mollifiers, the regularised lobe against the lobe itself.
//!
//! Every function runs over the same 256 inputs, prepared before; one element of throughput is one call.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, lobe};
use halflight_kernel::regularize::{bandwidth, bounds, cone, mollifier, regularized_bsdf};
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};
use halflight_kernel::transport::photon::statistics::laplacian_kernel;
use std::hint::black_box;

const COUNT: usize = 256;

/// Numbers in [0, 1) of a fixed sequence.
fn numbers(salt: u32) -> Vec<f32> {
    (0..COUNT as u32)
        .map(|i| {
            let x = (i * 2 + 1).wrapping_mul(0x9e37_79b9) ^ salt.wrapping_mul(0x85eb_ca6b);
            (x >> 8) as f32 / 16_777_216.0
        })
        .collect()
}

fn directions(salt: u32) -> Vec<Vec3> {
    let (u, v) = (numbers(salt), numbers(salt + 1));
    (0..COUNT)
        .map(|i| {
            let z = 0.05 + 0.95 * u[i];
            let r = (1.0 - z * z).sqrt();
            let phi = std::f32::consts::TAU * v[i];
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        })
        .collect()
}

fn lobe_of(kind: u32) -> Lobe {
    Lobe {
        kind,
        distribution: distribution::GGX,
        flags: lobe_flag::FRONT | lobe_flag::BACK,
        weight: 1.0,
        specular_reflectance: Vec3::ONE,
        specular_transmittance: Vec3::ONE,
        eta: Vec3::splat(1.5),
        k: Vec3::splat(3.0),
        alpha: Vec2::splat(0.15),
        ..Lobe::NONE
    }
}

fn regularize(c: &mut Criterion) {
    let mut group = c.benchmark_group("regularize");
    group.throughput(Throughput::Elements(COUNT as u64));
    let taus: Vec<f32> = numbers(1)
        .iter()
        .map(|u| 10_f32.powf(1.0 + 4.0 * u))
        .collect();
    let alphas: Vec<f32> = numbers(2).iter().map(|u| 0.01 + 0.9 * u).collect();
    let u = numbers(3);
    let (wi, wo) = (directions(4), directions(6));

    let mut each = |name: &str, f: &dyn Fn(usize) -> f32| {
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for i in 0..COUNT {
                    sum += f(black_box(i));
                }
                sum
            });
        });
    };
    each("reflection bound", &|i| {
        bounds::reflection_bound(bounds::SMITH, distribution::GGX, Vec2::splat(alphas[i]))
    });
    each("alpha-hat, reflection", &|i| {
        bounds::reflection_alpha(bounds::SMITH, distribution::GGX, taus[i])
    });
    each("alpha-hat, refraction", &|i| {
        bounds::tight_refraction_alpha(distribution::GGX, taus[i], 1.5)
    });
    each("tau_N", &|i| {
        bandwidth::tau_schedule(taus[i], 1 + 37 * i as u32)
    });
    each("Perlin kernel, evaluated", &|i| {
        mollifier::eval_scaled(mollifier::PERLIN, 2, u[i], 0.8)
    });
    each("Perlin kernel, sampled", &|i| {
        mollifier::sample_2d(mollifier::PERLIN, Vec2::new(u[i], u[COUNT - 1 - i])).x
    });
    each("quartic kernel, sampled", &|i| {
        mollifier::sample_2d(mollifier::QUARTIC, Vec2::new(u[i], u[COUNT - 1 - i])).x
    });
    each("constant cone, evaluated", &|i| {
        cone::eval(mollifier::CONSTANT, wi[i], wo[i], 0.1)
    });
    each("Laplacian kernel", &|i| {
        laplacian_kernel(Vec2::new(u[i], 0.3), 0.7)
    });
    for (name, kind) in [
        ("conductor", lobe_kind::ROUGH_CONDUCTOR),
        ("dielectric", lobe_kind::ROUGH_DIELECTRIC),
    ] {
        let rough = lobe_of(kind);
        each(&format!("{name}, as it is"), &|i| {
            let (f, p) = lobe::eval_cosine_pdf(&rough, &[], wi[i], wo[i]);
            f.x + p
        });
        each(&format!("{name}, regularised"), &|i| {
            let (f, p) = regularized_bsdf::eval_cosine_pdf(&rough, &[], wi[i], wo[i], taus[i]);
            f.x + p
        });
    }
    group.finish();
}

criterion_group!(benches, regularize);
criterion_main!(benches);
