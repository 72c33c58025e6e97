//! Functions of vectors.

use super::common::device;
use super::harness::{COUNT, assert_none, compare, module};
use super::kernel_common::Random;
use super::random::{direction, powers, uniform, unit};
use glam::Vec2;
use halflight_spirv::probe::vectors::{VectorInput, evaluate, vector};
use halflight_spirv::probe_runner::Probe;

/// A point of the disk: the centre, near the rim, or anywhere.
fn disk(random: &mut Random) -> [f32; 2] {
    let r = uniform(random, &[0.0, 0.999_999, 1e-6], 0.0, 1.0);
    let (s, c) = (random.next_1d() * std::f32::consts::TAU).sin_cos();
    [r * c, r * s]
}

/// An input whose fields all hold something sensible.
fn input(random: &mut Random) -> VectorInput {
    VectorInput {
        a: direction(random).to_array(),
        b: direction(random).to_array(),
        u: [unit(random), unit(random)],
        p: disk(random),
        q: disk(random),
        x: [
            uniform(random, &[0.0, 1.0, 2.0, 1e-6], 0.0, 2.0),
            random.next_1d(),
        ],
        kind: random.bits() as u32 % 4,
    }
}

/// With a unit vector of the plane in `a` and two exponents.
fn lobe(random: &mut Random) -> VectorInput {
    let angle = random.next_1d() * std::f32::consts::TAU;
    VectorInput {
        a: [angle.cos(), angle.sin(), 0.0],
        x: [
            powers(random, &[0.0, 1.0, 1e6], -1.0, 4.0),
            powers(random, &[0.0, 1.0], -1.0, 4.0),
        ],
        ..input(random)
    }
}

/// With a slope anywhere on the plane in `p`.
fn slope(random: &mut Random) -> VectorInput {
    let p = Vec2::from(disk(random)) * powers(random, &[1.0], -3.0, 4.0);
    VectorInput {
        p: p.to_array(),
        ..input(random)
    }
}

/// With an index of refraction in `x`.
fn refractive(random: &mut Random) -> VectorInput {
    let eta = powers(random, &[1.0, 1.5, 1.0 / 1.5, 1.000_001], -0.4, 0.4);
    VectorInput {
        x: [eta, 0.0],
        ..input(random)
    }
}

/// With a narrow or wide cap in `x` and directions inside it, or not.
fn cap(random: &mut Random) -> VectorInput {
    let i = input(random);
    let cap = powers(random, &[2.0, 1e-12, 1.0], -8.0, 0.3);
    let b = if random.bits().is_multiple_of(4) {
        i.b
    } else {
        let w = halflight_kernel::regularize::cone::sample(0, i.a.into(), cap, i.u.into());
        w.to_array()
    };
    VectorInput {
        b,
        x: [cap, powers(random, &[1.0, 0.0], -3.0, 6.0)],
        ..i
    }
}

type Case = (&'static str, u32, fn(&mut Random) -> VectorInput);

const CASES: &[Case] = &[
    ("square_to_disk", vector::WARP_DISK, input),
    ("square_to_cosine_hemisphere", vector::WARP_COSINE, input),
    ("square_to_uniform_sphere", vector::WARP_SPHERE, input),
    (
        "square_to_uniform_hemisphere",
        vector::WARP_HEMISPHERE,
        input,
    ),
    ("square_to_uniform_cone", vector::WARP_CONE, input),
    ("square_to_triangle", vector::WARP_TRIANGLE, input),
    ("frame", vector::FRAME, input),
    ("reflect and refract", vector::REFRACT, refractive),
    ("moebius", vector::MOEBIUS, input),
    ("disk lobe sample", vector::DISK_LOBE_SAMPLE, lobe),
    ("disk lobe density", vector::DISK_LOBE_PDF, lobe),
    ("slope gaussian", vector::SLOPE_GAUSSIAN, lobe),
    ("cone sample", vector::CONE_SAMPLE, cap),
    ("cone value", vector::CONE_EVAL, cap),
    ("mollifier sample", vector::MOLLIFIER_SAMPLE, input),
    ("half vector", vector::HALF_VECTOR, refractive),
    ("half vector charts", vector::HALF_VECTOR_CHARTS, slope),
    (
        "half vector outgoing",
        vector::HALF_VECTOR_OUTGOING,
        refractive,
    ),
];

#[test]
fn vectors_agree() {
    let Some(device) = device() else { return };
    let mut probe =
        Probe::<VectorInput, _>::new(&device, &module(), c"probe::vector", COUNT, &[0.0], &[])
            .expect("a pipeline");
    println!("compiled in {:.2} s", probe.compile_time.as_secs_f64());
    let mut failures = Vec::new();
    for (name, function, input) in CASES {
        let mut random = Random(u64::from(*function) + 101);
        let inputs: Vec<_> = (0..COUNT).map(|_| input(&mut random)).collect();
        failures.extend(compare(&mut probe, name, *function, &inputs, |i| {
            evaluate(*function, i)
        }));
    }
    assert_none(&failures);
}
