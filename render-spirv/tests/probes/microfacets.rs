//! Microfacet distributions.

use super::common::device;
use super::harness::{COUNT, assert_none, compare, module};
use super::kernel_common::Random;
use super::random::{powers, uniform, unit, upper};
use halflight_spirv::probe::microfacets::{MicrofacetInput, evaluate, microfacet};
use halflight_spirv::probe_runner::Probe;

/// A distribution of a kind, and a normal that it may well have.
fn input(kind: u32, random: &mut Random) -> MicrofacetInput {
    let edges = [1e-3, 1.0, 1e-4];
    let alpha = powers(random, &edges, -3.0, 0.0);
    let across = if random.bits().is_multiple_of(2) {
        alpha
    } else {
        powers(random, &edges, -3.0, 0.0)
    };
    let mut input = MicrofacetInput {
        kind,
        alpha: [alpha, across],
        exponent: uniform(random, &[1.0, 0.4, 4.0], 0.4, 4.0),
        w: upper(random).to_array(),
        m: upper(random).to_array(),
        u: [unit(random), unit(random)],
    };
    if !random.bits().is_multiple_of(3) {
        let m = evaluate(microfacet::NORMAL, &input);
        input.m = [m[0], m[1], m[2]];
    }
    input
}

#[test]
fn microfacets_agree() {
    let Some(device) = device() else { return };
    let mut probe = Probe::<MicrofacetInput, _>::new(
        &device,
        &module(),
        c"probe::microfacet",
        COUNT,
        &[0.0],
        &[],
    )
    .expect("a pipeline");
    println!("compiled in {:.2} s", probe.compile_time.as_secs_f64());
    let mut failures = Vec::new();
    let kinds = ["Beckmann", "GGX", "Phong", "exponential power"];
    let functions = ["values", "normal", "visible normal"];
    for (kind, kind_name) in kinds.iter().enumerate() {
        for (function, function_name) in functions.iter().enumerate() {
            let mut random = Random(201 + 10 * kind as u64 + function as u64);
            let inputs: Vec<_> = (0..COUNT)
                .map(|_| input(kind as u32, &mut random))
                .collect();
            let name = format!("{kind_name} {function_name}");
            failures.extend(compare(&mut probe, &name, function as u32, &inputs, |i| {
                evaluate(function as u32, i)
            }));
        }
    }
    assert_none(&failures);
}
