//! Runs a probe on the device and on the processor and compares.

use super::tolerance::tolerance;
use bytemuck::{NoUninit, Pod};
use halflight_spirv::probe_runner::Probe;
use std::fmt::Debug;

/// Inputs of each probe.
pub const COUNT: usize = 12_000;

/// The words of the module of probes.
pub fn module() -> Vec<u32> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("spirv/probes.spv");
    let bytes = std::fs::read(path).expect("spirv/probes.spv");
    bytemuck::pod_collect_to_vec(&bytes)
}

/// Compares function `function` of a probe for all `inputs`; a text if it is outside the tolerance of `name`.
///
/// # Panics
/// If anything is not finite, or nearly all results are zero.
pub fn compare<I, const N: usize>(
    probe: &mut Probe<I, [f32; N]>,
    name: &str,
    function: u32,
    inputs: &[I],
    expected: impl Fn(&I) -> [f32; N],
) -> Option<String>
where
    I: NoUninit + Debug,
    [f32; N]: Pod,
{
    let device = probe.run(function, inputs).expect("a run");
    check(name, inputs, &device, expected)
}

/// The same for results that are there already.
///
/// # Panics
/// As [`compare`].
pub fn check<I: Debug, const N: usize>(
    name: &str,
    inputs: &[I],
    device: &[[f32; N]],
    expected: impl Fn(&I) -> [f32; N],
) -> Option<String> {
    assert!(inputs.len() >= 10_000, "{name}: {} inputs", inputs.len());
    let row = tolerance(name);
    let (mut outside, mut largest, mut interesting) = (Vec::new(), 0.0f32, 0);
    for (i, (input, device)) in inputs.iter().zip(device).enumerate() {
        let host = expected(input);
        let mut worst = 0.0f32;
        for k in 0..N {
            let (d, h) = (device[k], host[k]);
            assert!(h.is_finite(), "{name}: the host's {k} is {h} for {input:?}");
            assert!(
                d.is_finite(),
                "{name}: the device's {k} is {d} for {input:?}"
            );
            let difference = (d - h).abs();
            let allowed = row.absolute + row.relative * h.abs();
            if difference > 0.0 {
                worst = worst.max(difference / allowed);
            }
        }
        interesting += usize::from(host.iter().any(|x| *x != 0.0));
        if worst > 1.0 {
            outside.push((i, worst));
        } else {
            largest = largest.max(worst);
        }
    }
    assert!(
        2 * interesting > inputs.len(),
        "{name}: only {interesting} results differ from zero"
    );
    println!(
        "{name}: {} of {} outside, else {largest:.2} of the tolerance",
        outside.len(),
        inputs.len()
    );
    let &(i, worst) = outside.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let is_much = outside.len() * 10_000 > row.outliers * inputs.len();
    is_much.then(|| {
        format!(
            "{name}: {} inputs outside, of 10,000 {} may be, by a factor of up to {worst}\n   {}\n   {:?}\n   device {:?}\n   host {:?}\n",
            outside.len(),
            row.outliers,
            row.reason,
            inputs[i],
            device[i],
            expected(&inputs[i])
        )
    })
}

/// # Panics
/// If there is a text.
pub fn assert_none(failures: &[String]) {
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}
