//! The solver and the constraints of chains.

use super::common::device;
use super::harness::{COUNT, assert_none, compare, module};
use super::kernel_common::Random;
use super::random::powers;
use glam::Vec3;
use halflight_kernel::manifold::half_vector_form;
use halflight_kernel::manifold::vertex::vertex_kind;
use halflight_kernel::math::Frame;
use halflight_spirv::probe::chains::{
    ChainInput, ROWS, SolveInput, VERTICES, VertexInput, constraint, measure, solve,
};
use halflight_spirv::probe_runner::Probe;

fn between(random: &mut Random, from: f32, to: f32) -> f32 {
    from + (to - from) * random.next_1d()
}

/// A system whose diagonal outweighs the rest, of any scale; now and then of fewer rows, or with a singular block.
fn system(random: &mut Random) -> SolveInput {
    let mut input = SolveInput {
        len: 1 + random.bits() as u32 % ROWS as u32,
        ..SolveInput::default()
    };
    if random.bits().is_multiple_of(2) {
        input.len = ROWS as u32;
    }
    let scale = powers(random, &[1.0], -6.0, 6.0);
    for i in 0..ROWS {
        for k in 0..4 {
            input.a[i][k] = scale * between(random, -0.4, 0.4);
            input.b[i][k] = scale * between(random, -0.3, 0.3);
            input.c[i][k] = scale * between(random, -0.4, 0.4);
        }
        let sign = if random.bits().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        input.b[i][0] += sign * 2.0 * scale;
        input.b[i][3] += 2.0 * scale;
        input.h[i] = [between(random, -1.0, 1.0), between(random, -1.0, 1.0)];
    }
    match random.bits() % 16 {
        // Zero, and of rank one, exactly.
        0 => input.b[0] = [0.0; 4],
        1 => input.b[0] = [scale, 2.0 * scale, 2.0 * scale, 4.0 * scale],
        2 => input.h = [[0.0; 2]; ROWS],
        _ => {}
    }
    input
}

/// Like a surface a few units along a random walk, with curvature, a tilted normal and a kind.
fn vertex(random: &mut Random, position: Vec3, towards: Vec3, kind: u32) -> VertexInput {
    let n = (towards.normalize() + 0.7 * random.direction()).normalize();
    let frame = Frame::from_normal(n);
    let tilted = (n + 0.1 * random.direction()).normalize();
    let curvature = if random.bits().is_multiple_of(4) {
        0.0
    } else {
        between(random, -2.0, 2.0)
    };
    let across = Frame::from_normal(tilted);
    VertexInput {
        position: position.to_array(),
        geometric_normal: frame.n.to_array(),
        tangent_u: frame.s.to_array(),
        tangent_v: frame.t.to_array(),
        normal: tilted.to_array(),
        dn_u: (across.s * curvature).to_array(),
        dn_v: (across.t * curvature).to_array(),
        reference: halflight_kernel::manifold::vertex::reference_for(tilted).to_array(),
        eta: if kind == vertex_kind::REFRACTION {
            1.5
        } else {
            1.0
        },
        kind,
    }
}

/// A chain of reflections and refractions between pinned ends.
fn chain(random: &mut Random) -> ChainInput {
    let mut input = ChainInput {
        form: if random.bits().is_multiple_of(2) {
            half_vector_form::SLOPE
        } else {
            half_vector_form::PROJECTED
        },
        ..ChainInput::default()
    };
    let mut points = [Vec3::ZERO; VERTICES];
    for i in 1..VERTICES {
        points[i] = points[i - 1] + random.direction() * powers(random, &[1.0], -1.0, 1.0);
    }
    for i in 0..VERTICES {
        let is_end = i == 0 || i + 1 == VERTICES;
        let kind = if is_end {
            random.bits() as u32 % 2
        } else {
            vertex_kind::REFLECTION + random.bits() as u32 % 3
        };
        let previous = points[i.max(1) - 1] - points[i];
        let next = points[(i + 1).min(VERTICES - 1)] - points[i];
        let towards = match kind {
            vertex_kind::REFLECTION => previous.normalize_or_zero() + next.normalize_or_zero(),
            vertex_kind::REFRACTION => {
                previous.normalize_or_zero() + 1.5 * next.normalize_or_zero()
            }
            _ => previous - next,
        };
        let towards = if towards.length() > 1e-3 {
            towards
        } else {
            Vec3::Z
        };
        input.vertices[i] = vertex(random, points[i], towards, kind);
    }
    if random.bits().is_multiple_of(32) {
        // Two vertices in one place: no constraint.
        input.vertices[1].position = input.vertices[0].position;
    }
    input
}

#[test]
fn solutions_agree() {
    let Some(device) = device() else { return };
    let mut probe =
        Probe::<SolveInput, _>::new(&device, &module(), c"probe::solve", COUNT, &[0.0], &[])
            .expect("a pipeline");
    println!(
        "solve compiled in {:.2} s",
        probe.compile_time.as_secs_f64()
    );
    let mut random = Random(401);
    let inputs: Vec<_> = (0..COUNT).map(|_| system(&mut random)).collect();
    assert_none(
        Vec::from_iter(compare(
            &mut probe,
            "block-tridiagonal solve",
            0,
            &inputs,
            solve,
        ))
        .as_slice(),
    );
}

#[test]
fn constraints_agree() {
    let Some(device) = device() else { return };
    let mut random = Random(402);
    let inputs: Vec<_> = (0..COUNT).map(|_| chain(&mut random)).collect();
    let mut probe =
        Probe::<ChainInput, _>::new(&device, &module(), c"probe::constraint", COUNT, &[0.0], &[])
            .expect("a pipeline");
    println!(
        "constraint compiled in {:.2} s",
        probe.compile_time.as_secs_f64()
    );
    assert_none(
        Vec::from_iter(compare(&mut probe, "constraint", 0, &inputs, constraint)).as_slice(),
    );
    let mut probe =
        Probe::<ChainInput, _>::new(&device, &module(), c"probe::measure", COUNT, &[0.0], &[])
            .expect("a pipeline");
    println!(
        "measure compiled in {:.2} s",
        probe.compile_time.as_secs_f64()
    );
    assert_none(
        Vec::from_iter(compare(&mut probe, "chain measure", 0, &inputs, measure)).as_slice(),
    );
}
