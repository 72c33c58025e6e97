//! White furnaces and reciprocity of single lobes.

use super::Random;
use glam::Vec3;
use halflight_kernel::bsdf::{Lobe, event, lobe};
use halflight_kernel::scene::lobe_kind;

/// The directional albedo of `lobe` at `wi`, the integral of f cos and the discrete parts, by `samples` of its own
/// sampler; with its standard error.
pub fn albedo(lobe: &Lobe, data: &[f32], wi: Vec3, samples: u32, seed: u64) -> (Vec3, Vec3) {
    let mut random = Random(seed);
    let (mut sum, mut squares) = ([0.0_f64; 3], [0.0_f64; 3]);
    for _ in 0..samples {
        let (u1, u2) = (random.next_1d(), random.next_2d());
        let s = lobe::sample(lobe, data, wi, u1, u2);
        if s.pdf > 0.0 {
            for c in 0..3 {
                let w = f64::from(s.weight[c]);
                sum[c] += w;
                squares[c] += w * w;
            }
        }
    }
    let n = f64::from(samples);
    let mean = sum.map(|x| x / n);
    let error = [0, 1, 2].map(|c| ((squares[c] / n - mean[c] * mean[c]).max(0.0) / n).sqrt());
    (
        Vec3::from_array(mean.map(|x| x as f32)),
        Vec3::from_array(error.map(|x| x as f32)),
    )
}

/// Largest relative asymmetry of the lobe over random pairs of directions. Reflection is symmetric; transmission is up
/// to the squared index on the side of the viewer: f(wi, wo) / n(wi)^2 = f(wo, wi) / n(wo)^2 for radiance (Veach 1997,
/// section 5.3).
///
/// # Panics
/// When no pair has a value: the lobe is black or discrete.
pub fn asymmetry(lobe: &Lobe, data: &[f32], pairs: u32, seed: u64) -> f32 {
    let mut random = Random(seed);
    let mut worst = 0.0_f32;
    let mut compared = 0;
    for k in 0..pairs {
        let (wi, mut wo) = (random.direction(), random.direction());
        // Every other pair is one that the lobe scatters: random directions miss narrow lobes.
        let (u1, u2) = (random.next_1d(), random.next_2d());
        let s = lobe::sample(lobe, data, wi, u1, u2);
        if k % 2 == 0 && s.pdf > 0.0 && s.event & event::DELTA == 0 {
            wo = s.wo;
        }
        let is_boundary = lobe.kind == lobe_kind::ROUGH_DIELECTRIC;
        let index = |w: Vec3| {
            if w.z > 0.0 || !is_boundary {
                1.0
            } else {
                lobe.eta.x
            }
        };
        let forward = lobe::eval_cosine(lobe, data, wi, wo) / wo.z.abs();
        let backward = lobe::eval_cosine(lobe, data, wo, wi) / wi.z.abs();
        let (mut a, mut b) = (forward, backward);
        if wi.z * wo.z < 0.0 {
            a /= index(wi) * index(wi);
            b /= index(wo) * index(wo);
        }
        for c in 0..3 {
            let size = a[c].max(b[c]);
            if size > 1e-3 {
                worst = worst.max((a[c] - b[c]).abs() / size);
                compared += 1;
            }
        }
    }
    assert!(compared > 0, "no pair of directions has a value");
    worst
}
