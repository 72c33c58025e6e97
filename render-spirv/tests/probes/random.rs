//! Random inputs with their edges: one of a few special values now and then.

use super::kernel_common::{Random, direction_at};
use glam::Vec3;

/// Uniform between two numbers, or an edge.
pub fn uniform(random: &mut Random, edges: &[f32], from: f32, to: f32) -> f32 {
    edge(random, edges).unwrap_or_else(|| from + (to - from) * random.next_1d())
}

/// Uniform in the exponent of ten, or an edge.
pub fn powers(random: &mut Random, edges: &[f32], from: f32, to: f32) -> f32 {
    edge(random, edges).unwrap_or_else(|| 10f32.powf(from + (to - from) * random.next_1d()))
}

fn edge(random: &mut Random, edges: &[f32]) -> Option<f32> {
    let is_edge = !edges.is_empty() && random.bits().is_multiple_of(5);
    is_edge.then(|| edges[random.bits() as usize % edges.len()])
}

/// Of either sign.
pub fn signed(random: &mut Random, x: f32) -> f32 {
    if random.bits().is_multiple_of(2) {
        x
    } else {
        -x
    }
}

/// A number of the unit interval, with its ends.
pub fn unit(random: &mut Random) -> f32 {
    uniform(random, &[0.0, 0.5, 1e-7, 0.999_999_94], 0.0, 1.0)
}

/// A unit vector: uniform, along an axis, or grazing the plane z = 0.
pub fn direction(random: &mut Random) -> Vec3 {
    match random.bits() % 8 {
        0 => [Vec3::X, -Vec3::Y, Vec3::Z, -Vec3::Z][random.bits() as usize % 4],
        1 => direction_at(
            90.0 + 2e-3 * (random.next_1d() - 0.5),
            360.0 * random.next_1d(),
        ),
        2 => direction_at(1e-2 * random.next_1d(), 360.0 * random.next_1d()),
        _ => random.direction(),
    }
}

/// The same above the plane.
pub fn upper(random: &mut Random) -> Vec3 {
    let w = direction(random);
    Vec3::new(w.x, w.y, w.z.abs())
}
