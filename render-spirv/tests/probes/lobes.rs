//! Single lobes of every kind.

use super::common::device;
use super::harness::{COUNT, assert_none, compare, module};
use super::kernel_common::Random;
use super::kernel_common::lobes::{Case, delta_cases, smooth_cases};
use super::random::{direction, powers, unit};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, lobe, mode};
use halflight_kernel::scene::{NONE, distribution, features, lobe_flag, lobe_kind};
use halflight_spirv::probe::lobes::{CoatInput, LobeInput, LobeOutput, bounds, sample, value};
use halflight_spirv::probe_runner::Probe;
use std::time::Duration;

/// The records of the lobes that the statistical tests go through, and their tables one after the other.
fn lobes() -> (Vec<LobeInput>, Vec<f32>) {
    let mut data = Vec::new();
    let mut inputs = Vec::new();
    for Case {
        lobe, data: table, ..
    } in smooth_cases().iter().chain(&delta_cases())
    {
        let first = data.len() as u32;
        data.extend_from_slice(table);
        inputs.push(record(lobe, first));
    }
    (inputs, data)
}

fn record(lobe: &Lobe, first: u32) -> LobeInput {
    let moved = |table: u32| if table == NONE { NONE } else { table + first };
    LobeInput {
        kind: lobe.kind,
        distribution: lobe.distribution,
        flags: lobe.flags,
        normal: lobe.frame.n.to_array(),
        has_frame: u32::from(lobe.has_frame),
        reflectance: lobe.reflectance.to_array(),
        specular_reflectance: lobe.specular_reflectance.to_array(),
        specular_transmittance: lobe.specular_transmittance.to_array(),
        eta: lobe.eta.to_array(),
        k: lobe.k.to_array(),
        alpha: lobe.alpha.to_array(),
        table: moved(lobe.table),
        table_rows: lobe.table_rows,
        internal_reflectance: lobe.internal_reflectance,
        optical_depth: lobe.optical_depth.to_array(),
        coat_count: lobe.coat_count,
        coats: lobe.coats.map(|c| CoatInput {
            eta: c.eta,
            optical_depth: c.optical_depth.to_array(),
            alpha: c.alpha,
            table: moved(c.table),
            table_rows: c.table_rows,
        }),
        exponent: lobe.exponent,
        ..LobeInput::default()
    }
}

/// A lobe with its roughness and index changed now and then, and directions: any, or one that it would sample.
fn input(lobes: &[LobeInput], data: &[f32], i: usize, random: &mut Random) -> LobeInput {
    let mut input = lobes[i % lobes.len()];
    if random.bits().is_multiple_of(3) && input.table == NONE {
        let alpha = powers(random, &[1e-3, 1.0], -3.0, 0.0);
        input.alpha = [alpha; 2];
        let is_dielectric =
            [lobe_kind::DIELECTRIC, lobe_kind::ROUGH_DIELECTRIC].contains(&input.kind);
        if is_dielectric {
            input.eta = [powers(random, &[1.0, 1.001, 1.5], -0.4, 0.4); 3];
        }
    }
    if random.bits().is_multiple_of(4) {
        input.flags |= lobe_flag::FLIP_BACK;
    }
    input.mode = if random.bits().is_multiple_of(2) {
        mode::RADIANCE
    } else {
        mode::IMPORTANCE
    };
    let wi = direction(random);
    input.wi = wi.to_array();
    input.u = [unit(random), unit(random), unit(random)];
    let made = halflight_spirv::probe::lobes::lobe_of(&input, features::ALL);
    let s = lobe::sample(
        &made,
        data,
        wi,
        random.next_1d(),
        Vec2::new(random.next_1d(), random.next_1d()),
    );
    let wo = if s.pdf > 0.0 && !random.bits().is_multiple_of(4) {
        s.wo
    } else {
        direction(random)
    };
    input.wo = wo.to_array();
    input.tau = powers(random, &[1e18, 0.16], -1.0, 6.0);
    debug_assert!(Vec3::from(input.wi).is_finite());
    input
}

/// Kinds that share a pipeline, for lavapipe takes seconds for each, and their distribution.
struct Group {
    kinds: &'static [(u32, &'static str)],
    distribution: u32,
}

const ROUGH: &[(u32, &str)] = &[
    (lobe_kind::ROUGH_CONDUCTOR, "rough conductor"),
    (lobe_kind::ROUGH_DIELECTRIC, "rough dielectric"),
];

/// What every run compares.
const GROUPS: &[Group] = &[
    Group {
        kinds: &[
            (lobe_kind::DIFFUSE, "diffuse"),
            (lobe_kind::ROUGH_DIFFUSE, "rough diffuse"),
            (lobe_kind::CONDUCTOR, "conductor"),
            (lobe_kind::DIELECTRIC, "dielectric"),
            (lobe_kind::THIN_DIELECTRIC, "thin dielectric"),
            (lobe_kind::PLASTIC, "plastic"),
            (lobe_kind::COAT, "coat"),
            (lobe_kind::NULL, "null"),
        ],
        distribution: distribution::BECKMANN,
    },
    Group {
        kinds: &[
            (lobe_kind::ROUGH_CONDUCTOR, "rough conductor"),
            (lobe_kind::ROUGH_DIELECTRIC, "rough dielectric"),
            (lobe_kind::ROUGH_PLASTIC, "rough plastic"),
            (lobe_kind::ROUGH_COAT, "rough coat"),
        ],
        distribution: distribution::GGX,
    },
    Group {
        kinds: &[(lobe_kind::MERL, "measured")],
        distribution: distribution::BECKMANN,
    },
    Group {
        kinds: &[(lobe_kind::DIFFRACTING_CONDUCTOR, "diffracting conductor")],
        distribution: distribution::EXPONENTIAL_POWER,
    },
];

/// What is compared besides with `HALFLIGHT_ALL_PROBES` set.
const MORE_GROUPS: &[Group] = &[
    Group {
        kinds: ROUGH,
        distribution: distribution::BECKMANN,
    },
    Group {
        kinds: ROUGH,
        distribution: distribution::PHONG,
    },
    Group {
        kinds: ROUGH,
        distribution: distribution::EXPONENTIAL_POWER,
    },
];

fn compare_lobes(
    entry: &std::ffi::CStr,
    what: &str,
    groups: &[&Group],
    expected: fn(&LobeInput, &[f32], u32) -> LobeOutput,
) {
    let Some(device) = device() else { return };
    let (lobes, data) = lobes();
    let module = module();
    let mut slowest = Duration::ZERO;
    let mut failures = Vec::new();
    for group in groups {
        let features = group
            .kinds
            .iter()
            .fold(features::microfacets(group.distribution), |f, (kind, _)| {
                f | features::lobe(*kind)
            });
        let features = features | features::COATS | features::FRAME_MAPS;
        let mut probe =
            Probe::<LobeInput, _>::new(&device, &module, entry, COUNT, &data, &[features])
                .expect("a pipeline");
        slowest = slowest.max(probe.compile_time);
        for (kind, name) in group.kinds {
            let of_kind: Vec<_> = lobes
                .iter()
                .filter(|l| (l.kind, l.distribution) == (*kind, group.distribution))
                .copied()
                .collect();
            let mut random = Random(301 + u64::from(*kind));
            let inputs: Vec<_> = (0..COUNT)
                .map(|i| input(&of_kind, &data, i, &mut random))
                .collect();
            failures.extend(compare(
                &mut probe,
                &format!("{name} {what}"),
                0,
                &inputs,
                |i| expected(i, &data, features),
            ));
        }
    }
    println!("the slowest pipeline of {what} took {slowest:?}");
    assert_none(&failures);
}

/// The groups of this run.
fn groups() -> Vec<&'static Group> {
    let all = std::env::var_os("HALFLIGHT_ALL_PROBES").is_some();
    let more = if all { MORE_GROUPS } else { &[] };
    GROUPS.iter().chain(more).collect()
}

#[test]
fn values_of_lobes_agree() {
    compare_lobes(c"probe::lobe_value", "value", &groups(), value);
}

#[test]
fn samples_of_lobes_agree() {
    compare_lobes(c"probe::lobe_sample", "sample", &groups(), sample);
}

#[test]
fn bounds_of_lobes_agree() {
    // Measured and diffracting lobes have none. What depends on the distribution is in the probes of numbers, and lavapipe takes a
    // minute for the many copies of the tables of the exponential power distribution here.
    let groups: Vec<_> = GROUPS[..2].iter().collect();
    compare_lobes(c"probe::lobe_bounds", "bounds", &groups, bounds);
}
