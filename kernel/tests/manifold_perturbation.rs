//! Manifold exploration: the plans by which a path is perturbed, and the lobe of perturbed directions.

use glam::{Vec2, Vec3};
use halflight_kernel::math::Frame;
use halflight_kernel::transport::markov::half_vector::direction_lobe::DirectionLobe;
use halflight_kernel::transport::markov::half_vector::plan::plans;

#[test]
fn plans_start_at_both_ends() {
    let found = |k, rough: &[bool], may_hit, is_far| -> Vec<(usize, usize, Option<usize>)> {
        let plans = plans(k, rough, may_hit, is_far);
        plans.iter().map(|p| (p.a, p.b, p.c)).collect()
    };
    // light, rough, specular, rough, sensor
    let rough = [false, true, false, true, false];
    let expected = [
        (4, 3, Some(1)),
        (3, 1, Some(0)),
        (1, 0, None),
        (0, 1, Some(3)),
        (1, 3, Some(4)),
    ];
    assert_eq!(found(4, &rough, true, false), expected);
    // From infinity, and never onto it if it is a direction.
    let rough = [false, true, false];
    assert_eq!(found(2, &rough, false, true), [(2, 1, Some(0))]);
}

/// The density integrates to one, and the mean cosine of samples is that of the density.
#[test]
fn turns_follow_their_density() {
    let turn = DirectionLobe { kappa: 5.0 };
    let axis = Vec3::new(0.3, -0.5, 0.8).normalize();
    let n = 200_000;
    let mut mean = 0.0;
    for i in 0..n {
        let u = Vec2::new((i as f32 + 0.5) / n as f32, (i as f32 * 0.618_034) % 1.0);
        mean += f64::from(turn.sample(axis, u).dot(axis)) / f64::from(n);
    }
    let steps = 20_000;
    let (mut sum, mut moment) = (0.0, 0.0);
    for i in 0..steps {
        let cos = -1.0 + 2.0 * (i as f32 + 0.5) / steps as f32;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let w = Frame::from_normal(axis).to_world(Vec3::new(sin, 0.0, cos));
        let pdf = f64::from(turn.ln_pdf(axis, w)).exp();
        let p = pdf * 4.0 * std::f64::consts::PI / f64::from(steps);
        sum += p;
        moment += p * f64::from(cos);
    }
    assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    assert!((moment - mean).abs() < 1e-3, "{moment} {mean}");
}
