//! Functions of numbers.

use super::common::device;
use super::harness::{COUNT, assert_none, compare, module};
use super::kernel_common::Random;
use super::random::{powers, signed, uniform};
use halflight_kernel::math::filter;
use halflight_kernel::scene::filter_kind;
use halflight_spirv::probe::numbers::{NumberInput, evaluate, number};
use halflight_spirv::probe_runner::Probe;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

fn numbers(x: &[f32]) -> NumberInput {
    let mut input = NumberInput::default();
    input.x[..x.len()].copy_from_slice(x);
    input
}

fn with_kinds(x: &[f32], k: [u32; 4]) -> NumberInput {
    NumberInput { k, ..numbers(x) }
}

const COSINES: [f32; 9] = [
    0.0,
    1.0,
    -1.0,
    1e-8,
    -1e-8,
    1e-4,
    0.745_356,
    -0.745_356,
    0.999_999_9,
];
const INDICES: [f32; 8] = [
    1.0,
    1.000_000_1,
    0.999_999_9,
    1.5,
    1.0 / 1.5,
    1e-3,
    1e3,
    2.419,
];

/// Name, function, inputs.
type Case = (&'static str, u32, fn(&mut Random) -> NumberInput);

const CASES: &[Case] = &[
    ("sqrt", number::SQRT, |r| {
        numbers(&[powers(r, &[0.0, 1.0, 1e-30, 1e30], -12.0, 12.0)])
    }),
    ("sin", number::SIN, |r| {
        numbers(&[uniform(r, &[0.0, PI, -PI, 1e-8], -7.0, 7.0)])
    }),
    ("cos", number::COS, |r| {
        numbers(&[uniform(r, &[0.0, FRAC_PI_2, PI, 1e-8], -7.0, 7.0)])
    }),
    ("tan", number::TAN, |r| {
        numbers(&[uniform(r, &[0.0, 1e-8, 1.5, -1.5], -1.56, 1.56)])
    }),
    ("atan", number::ATAN, |r| {
        let x = powers(r, &[0.0, 1.0, 1e-8, 1e8], -6.0, 6.0);
        numbers(&[signed(r, x)])
    }),
    ("exp", number::EXP, |r| {
        numbers(&[uniform(r, &[0.0, 1.0, -80.0, 80.0, 1e-8], -80.0, 80.0)])
    }),
    ("ln", number::LN, |r| {
        numbers(&[powers(
            r,
            &[1.0, 0.999_999_94, 1.000_000_1, 1e-30],
            -12.0,
            12.0,
        )])
    }),
    ("ceil", number::CEIL, |r| {
        numbers(&[uniform(
            r,
            &[0.0, 1.0, -1.0, 0.5, 1e9, -0.999_999_94],
            -1e4,
            1e4,
        )])
    }),
    ("floor", number::FLOOR, |r| {
        numbers(&[uniform(r, &[0.0, 1.0, -1.0, 0.5, 1e9, -1e-7], -1e4, 1e4)])
    }),
    ("atan2", number::ATAN2, |r| {
        let y = uniform(r, &[0.0, 1.0, -1.0, 1e-20], -2.0, 2.0);
        let x = uniform(r, &[0.0, 1.0, -1.0, 1e-20], -2.0, 2.0);
        numbers(&[y, x])
    }),
    ("pow", number::POW, |r| {
        let x = powers(r, &[0.0, 1.0, -1.0, 1e-20], -4.0, 2.0);
        numbers(&[x, uniform(r, &[1.0, 0.5, 2.0], 0.1, 8.0)])
    }),
    ("erf", number::ERF, |r| {
        numbers(&[uniform(r, &[0.0, 1.0, -1.0, 1e-8, 10.0], -4.0, 4.0)])
    }),
    ("erfc_scaled", number::ERFC_SCALED, |r| {
        numbers(&[powers(r, &[0.0, 1.0, -1.0, 1e8], -4.0, 4.0)])
    }),
    ("erf_inv", number::ERF_INV, |r| {
        numbers(&[uniform(r, &[0.0, 1.0, -1.0, 1e-8, 0.999_999_94], -1.0, 1.0)])
    }),
    ("gamma_1p", number::GAMMA_1P, |r| {
        numbers(&[uniform(r, &[0.0, 1.0, 10.0, -1.0, 0.5], 0.0, 10.0)])
    }),
    ("inverse_gamma", number::INVERSE_GAMMA, |r| {
        let shape = uniform(r, &[0.2, 5.0, 1.0], 0.2, 5.0);
        numbers(&[shape, uniform(r, &[0.0, 0.5, 1e-6, 0.999_999_94], 0.0, 1.0)])
    }),
    ("scaled product", number::SCALED_PRODUCT, |r| {
        let mut next = || {
            let x = powers(r, &[1.0, 0.0, 1e30, 1e-30], -20.0, 20.0);
            signed(r, x)
        };
        numbers(&[next(), next(), next(), next()])
    }),
    ("fresnel_dielectric", number::FRESNEL_DIELECTRIC, |r| {
        let cos = uniform(r, &COSINES, -1.0, 1.0);
        numbers(&[cos, powers(r, &INDICES, -0.6, 0.6)])
    }),
    ("fresnel_conductor", number::FRESNEL_CONDUCTOR, |r| {
        let mut x = [0.0; 7];
        x[0] = uniform(r, &COSINES, -1.0, 1.0);
        for x in &mut x[1..] {
            *x = uniform(r, &[0.0, 1.0, 1e-3], 0.05, 8.0);
        }
        numbers(&x)
    }),
    (
        "fresnel_diffuse_reflectance",
        number::FRESNEL_DIFFUSE,
        |r| numbers(&[powers(r, &INDICES, -0.6, 0.6)]),
    ),
    ("filter", number::FILTER, |r| {
        let kind = r.bits() as u32 % 6;
        let radius = if kind == filter_kind::LANCZOS {
            3.0
        } else {
            0.5 + r.next_1d() * 3.0
        };
        let parameters = if kind == filter_kind::MITCHELL {
            [2.0, r.next_1d(), r.next_1d()]
        } else {
            [radius, 0.3 + r.next_1d(), 0.0]
        };
        let reach = filter::radius(kind, parameters);
        let x = uniform(
            r,
            &[0.0, reach, -reach, 1.0, 1e-5],
            -1.1 * reach,
            1.1 * reach,
        );
        with_kinds(
            &[x, parameters[0], parameters[1], parameters[2]],
            [kind, 0, 0, 0],
        )
    }),
    ("sampler", number::SAMPLER, |r| {
        let mut word = |edge: u32| {
            if r.bits().is_multiple_of(8) {
                edge
            } else {
                r.bits() as u32
            }
        };
        with_kinds(&[], [word(0) % 2, word(0), word(u32::MAX), word(1)])
    }),
    ("mollifier", number::MOLLIFIER, |r| {
        let t = uniform(r, &[0.0, 1.0, 0.999_999_94, 2.0], 0.0, 1.1);
        let bandwidth = powers(r, &[1.0, 1e-12, 1e-3], -3.0, 2.0);
        with_kinds(
            &[t, bandwidth],
            [
                r.bits() as u32 % 4,
                1 + r.bits() as u32 % 3,
                r.bits() as u32 % 5,
                0,
            ],
        )
    }),
    ("mollifier radius", number::MOLLIFIER_RADIUS, |r| {
        let u = uniform(r, &[0.0, 1.0, 0.5, 0.999_999_94], 0.0, 1.0);
        with_kinds(&[u], [r.bits() as u32 % 4, 1 + r.bits() as u32 % 3, 0, 0])
    }),
    ("bandwidth", number::BANDWIDTH, |r| {
        let initial = powers(r, &[1.0, 1e-3], -3.0, 2.0);
        let rate = uniform(r, &[1.0 / 6.0, 1e-4, 1e-2], 0.0, 0.5);
        let tau = powers(r, &[0.0, 0.16, 1e18, 1e3], -1.0, 12.0);
        let tangent = powers(r, &[1.0, 1e-8], -6.0, 2.0);
        let n = 1 + (r.bits() as u32 % 10_000);
        with_kinds(
            &[initial, rate, tau, tangent],
            [n, r.bits() as u32 % 5, 0, 0],
        )
    }),
    ("bounds", number::BOUNDS, |r| {
        let x = powers(r, &[1e-3, 1.0, 0.0, FRAC_1_SQRT_2], -4.0, 0.0);
        let y = powers(r, &[1e-3, 1.0, 0.0], -4.0, 0.0);
        let eta = powers(r, &[1.0, 1.5, 1.000_000_1], -0.6, 0.6);
        with_kinds(
            &[x, y, eta],
            [r.bits() as u32 % 2, r.bits() as u32 % 3, 0, 0],
        )
    }),
    ("alpha_hat", number::ALPHA_HAT, |r| {
        let tau = powers(r, &[0.0, 1e18, 1.0, 1e3], -3.0, 16.0);
        let eta = powers(r, &[1.0, 1.5, 1.000_000_1], -0.6, 0.6);
        let x = [tau, r.next_1d(), powers(r, &[1e-3, 1.0], -4.0, 0.0), eta];
        with_kinds(&x, [r.bits() as u32 % 2, r.bits() as u32 % 3, 0, 0])
    }),
    ("heuristics", number::HEURISTICS, |r| {
        let mut x = [0.0; 7];
        for (i, x) in x.iter_mut().enumerate() {
            *x = match i {
                0 | 1 => powers(r, &[0.0, 1e18, 1.0], -3.0, 6.0),
                2 | 3 => powers(r, &[0.0, 1.0], -3.0, 3.0),
                4 => uniform(r, &[0.0, 1.0], -10.0, 10.0),
                5 => powers(r, &[1.0], -1.0, 6.0),
                _ => uniform(r, &[0.0, 0.5], 0.0, 0.9),
            };
        }
        numbers(&x)
    }),
];

#[test]
fn numbers_agree() {
    let Some(device) = device() else { return };
    let mut probe =
        Probe::<NumberInput, _>::new(&device, &module(), c"probe::number", COUNT, &[0.0], &[])
            .expect("a pipeline");
    println!("compiled in {:.2} s", probe.compile_time.as_secs_f64());
    let mut failures = Vec::new();
    for (name, function, input) in CASES {
        let mut random = Random(u64::from(*function) + 1);
        let inputs: Vec<_> = (0..COUNT).map(|_| input(&mut random)).collect();
        failures.extend(compare(&mut probe, name, *function, &inputs, |i| {
            evaluate(*function, i)
        }));
    }
    assert_none(&failures);
}
