//! A chain that starts from the distribution of states stays in it, whatever its mutations: number of edges, block of pixels and emitter
//! of its state are as likely after many steps as before.
//!
//! Groups of chains start from candidates that are resampled by their weights, as those of an image do. With S the sum of a group's weights
//! and M its chains, every cell c of a partition of the states has
//!
//! ```text
//! d_c = S / M sum_chains ([end in c] - [start in c]),
//! ```
//!
//! whose mean over groups is zero if the distribution is kept, and Hotelling's T^2 of that mean, by the covariance that the groups
//! show, has a chi-square distribution of as many degrees of freedom as there are cells, less one. `HALFLIGHT_STATISTICS=N` makes chains N times as long;
//! `HALFLIGHT_CHAIN_STEPS=100000` follows one chain of each group for as many steps, `HALFLIGHT_CHAIN_GROUPS=N` makes as many groups. Random
//! numbers are fixed.
//!
//! Detailed balance, I(x) T(x -> y) = I(y) T(y -> x), says more: of the first steps as many lead from any cell into another as back, so
//! that d_ab, counted like d_c from the steps between two cells a and b, has the mean zero too.

use crate::agreement::effort;
use crate::brightness::{BALL, DIFFUSE, GLOSSY, POINT};
use crate::hotelling::statistic;
use crate::scenes::{LAMP, PINHOLE, View, room, scene, with_view};
use crate::variants::MIRROR;
use halflight_kernel::math::luminance;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::markov::algorithm::Observation;
use halflight_kernel::transport::markov::primary_space::{PrimarySpace, technique};
use halflight_kernel::transport::markov::{ChainAlgorithm, PrimaryChains, Splat, VeachChains};
use halflight_kernel::transport::settings::ChainSettings;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Groups of chains, or as many as the environment wants.
fn groups() -> u32 {
    match std::env::var("HALFLIGHT_CHAIN_GROUPS") {
        Ok(groups) => groups.parse().expect("HALFLIGHT_CHAIN_GROUPS: a number"),
        Err(_) => 400,
    }
}

/// Candidates of a group.
const CANDIDATES: u32 = 256;

/// Chains of a group and steps of each, as the environment wants them.
fn lengths() -> [u32; 2] {
    match std::env::var("HALFLIGHT_CHAIN_STEPS") {
        Ok(steps) => [1, steps.parse().expect("HALFLIGHT_CHAIN_STEPS: a number")],
        Err(_) => [8, 64 * effort()],
    }
}

/// First steps whose moves between cells are counted.
const COUNTED_STEPS: u32 = 8;

/// Probability that all tests here fail with correct mutations, over random seeds.
const FALSE_ALARM: f64 = 1e-3;

/// Number of tests.
const TESTS: f64 = 122.0;

/// A cell of the states.
pub type Cell = fn(&Observation) -> usize;

const PARTITIONS: [(&str, Cell); 5] = [
    ("edges", |o| o.edges.min(9) as usize),
    ("blocks", |o| {
        (o.film.y as usize / 2) * 4 + o.film.x as usize / 2
    }),
    ("pixels", |o| o.film.y as usize * 8 + o.film.x as usize),
    // What a wrong factor in a density changes first.
    ("octaves of light", |o| {
        (o.luminance.log2() + 32.0).clamp(0.0, 63.0) as usize
    }),
    ("emitters", |o| o.emitter as usize),
];

/// States of a group's chains before and after, the first moves between states, and the group's weight S / M.
struct Group {
    weight: f64,
    states: Vec<[Observation; 2]>,
    moves: Vec<[Observation; 2]>,
}

/// Most cells of a partition.
const CELLS: usize = 64;

/// d_c of a group.
fn of_cells(group: &Group, cell: Cell) -> Vec<f64> {
    let mut d = vec![0.0; CELLS];
    for [before, after] in &group.states {
        d[cell(after)] += group.weight;
        d[cell(before)] -= group.weight;
    }
    d
}

/// d_ab of a group.
fn of_pairs(group: &Group, cell: Cell) -> Vec<f64> {
    let mut d = vec![0.0; CELLS * CELLS];
    for [before, after] in &group.moves {
        let (a, b) = (cell(before), cell(after));
        if a < b {
            d[a * CELLS + b] += group.weight;
        } else if b < a {
            d[b * CELLS + a] -= group.weight;
        }
    }
    d
}

/// Runs a group; nothing where it finds no light.
fn run<A: ChainAlgorithm>(algorithm: &A, group: u32, [chains, steps]: [u32; 2]) -> Option<Group> {
    let mut found = Vec::new();
    for candidate in 0..CANDIDATES {
        let mut member = 0;
        algorithm.candidate_weights(candidate, &mut |weight| {
            if weight > 0.0 {
                found.push((candidate, member, f64::from(weight)));
            }
            member += 1;
        });
    }
    let sum: f64 = found.iter().map(|(.., weight)| weight).sum();
    // Systematic resampling at an offset of the group's own.
    let offset = (f64::from(group) * 0.618_033_988_749_895).fract();
    let mut below = 0.0;
    let mut starts = Vec::new();
    for (candidate, member, weight) in found {
        below += weight;
        while (starts.len() as f64 + offset) * sum / f64::from(chains) < below
            && starts.len() < chains as usize
        {
            starts.push((candidate, member));
        }
    }
    let mut moves = Vec::new();
    let states: Vec<_> = starts
        .iter()
        .zip(0..)
        .filter_map(|((candidate, member), number)| {
            let mut chain = algorithm.start(*candidate, *member, number);
            let before = A::observe(&chain)?;
            let mut last = before;
            for step in 0..steps {
                algorithm.step(&mut chain, 1.0, &mut |_| {});
                if step < COUNTED_STEPS {
                    let now = A::observe(&chain)?;
                    moves.push([last, now]);
                    last = now;
                }
            }
            Some([before, A::observe(&chain)?])
        })
        .collect();
    (!states.is_empty()).then_some(Group {
        weight: sum / f64::from(chains),
        states,
        moves,
    })
}

/// Tests every partition of the states of an algorithm.
pub fn keeps<A: ChainAlgorithm>(
    what: &str,
    partitions: &[(&str, Cell)],
    algorithm: impl Fn(u32) -> A + Sync,
) -> Vec<Result<(), String>> {
    let lengths = lengths();
    let groups: Vec<Group> = (0..groups())
        .into_par_iter()
        .filter_map(|group| run(&algorithm(group), group, lengths))
        .collect();
    let moved = groups
        .iter()
        .flat_map(|g| &g.states)
        .filter(|[a, b]| a != b);
    let (moved, all) = (moved.count(), groups.len() * lengths[0] as usize);
    let mut results = Vec::new();
    for (name, cell) in partitions {
        let of_states: Vec<_> = groups.iter().map(|g| of_cells(g, *cell)).collect();
        let of_moves: Vec<_> = groups.iter().map(|g| of_pairs(g, *cell)).collect();
        for (test, (t2, degrees)) in [
            ("", statistic(&of_states, true)),
            (" both ways", statistic(&of_moves, false)),
        ] {
            let p = if degrees == 0 {
                1.0
            } else {
                1.0 - ChiSquared::new(degrees as f64).unwrap().cdf(t2)
            };
            let line = format!(
                "{what}, {name}{test}: {t2:.1} of {degrees}, p = {p:.2e}, {moved} of {all} moved"
            );
            println!("{line}");
            results.push(if moved * 20 < all {
                Err(format!("{line}: chains stand still"))
            } else if p < FALSE_ALARM / TESTS {
                Err(line)
            } else {
                Ok(())
            });
        }
    }
    results
}

pub fn report(results: Vec<Result<(), String>>) {
    let wrong: Vec<_> = results.into_iter().filter_map(Result::err).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Nothing but mutations of these weights.
pub fn weighed(weights: [f32; 6]) -> ChainSettings {
    let [
        bidirectional,
        lens,
        caustic,
        multi_chain,
        manifold,
        half_vector,
    ] = weights;
    ChainSettings {
        bidirectional_weight: bidirectional,
        lens_weight: lens,
        caustic_weight: caustic,
        multi_chain_weight: multi_chain,
        manifold_weight: manifold,
        half_vector_weight: half_vector,
        ..ChainSettings::DEFAULT
    }
}

/// A room with glass, a mirror, a lamp and a point light.
fn with_room(test: impl FnOnce(&View<'_>, &IntegratorSettings)) {
    let room = room(GLOSSY);
    let scene = scene(&[PINHOLE, &room, LAMP, POINT, BALL, MIRROR].concat(), &[]);
    with_view(&scene, |view| test(view, &scene.settings));
}

/// Glass above a room, and all lights in it, so that light comes to every diffuse surface by a discrete event.
const GLASS_ABOVE: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="2"/>
    <rotate x="1" angle="90"/><translate y="1.4"/></transform><bsdf type="dielectric"/></shape>"#;

/// A second lamp beside the first.
const BESIDE: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.3"/>
    <rotate x="1" angle="90"/><translate x="0.8" y="1.8"/></transform>
    <emitter type="area"><rgb name="radiance" value="4, 8, 12"/></emitter></shape>"#;

/// Where caustic and multi-chain perturbations have much to move.
fn with_glass_above(test: impl FnOnce(&View<'_>, &IntegratorSettings)) {
    let content = [
        PINHOLE,
        &room(DIFFUSE),
        LAMP,
        BESIDE,
        POINT,
        GLASS_ABOVE,
        MIRROR,
    ]
    .concat();
    let scene = scene(&content, &[]);
    with_view(&scene, |view| test(view, &scene.settings));
}

/// Tests chains with mutations of these weights over paths of at least `min_edges` edges.
fn full_paths_stay(
    what: &str,
    view: &View<'_>,
    settings: &IntegratorSettings,
    weights: [f32; 6],
    min_edges: u32,
) {
    let settings = IntegratorSettings {
        chains: weighed(weights),
        ..*settings
    };
    report(keeps(what, &PARTITIONS, |group| {
        VeachChains::new(view, &settings, min_edges, 1, group)
    }));
}

macro_rules! full_paths_stay_by {
    ($($name:ident: $scene:ident, $weights:expr, $min_edges:expr;)*) => { $(
        #[test]
        fn $name() {
            $scene(|view, settings| {
                full_paths_stay(stringify!($name), view, settings, $weights, $min_edges);
            });
        }
    )* };
}

full_paths_stay_by! {
    bidirectional_stays: with_room, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1;
    lens_stays: with_room, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 1;
    caustic_stays: with_glass_above, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], 1;
    multi_chain_stays: with_glass_above, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0], 1;
    manifold_stays: with_room, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], 1;
    half_vector_stays: with_room, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 1;
    all_stay: with_room, [1.0; 6], 1;
    all_stay_under_glass: with_glass_above, [1.0; 6], 1;
    all_stay_without_direct_light: with_room, [1.0, 1.0, 1.0, 1.0, 0.0, 0.0], 3;
}

#[test]
fn primary_samples_stay_in_their_distribution() {
    let mut results = Vec::new();
    with_room(|view, settings| {
        for (name, kind) in [
            ("bdpt", technique::BIDIRECTIONAL),
            ("multiplexed", technique::MULTIPLEXED),
        ] {
            for (step, p_large) in [("small steps", 0.0), ("both", 0.3)] {
                let space = PrimarySpace::new(view, settings, kind, 1);
                let chains = PrimaryChains::new(space, p_large, 1, 0);
                let what = format!("{name}, {step}");
                results.extend(keeps(&what, &PARTITIONS[..4], |group| {
                    chains.of_group(group)
                }));
            }
        }
    });
    report(results);
}

/// The luminance of all that a chain adds in `steps` steps.
fn added<A: ChainAlgorithm>(algorithm: &A, steps: u32) -> f64 {
    let mut start = None;
    for candidate in 0..CANDIDATES {
        let mut member = 0;
        algorithm.candidate_weights(candidate, &mut |weight| {
            if weight > 0.0 {
                start.get_or_insert((candidate, member));
            }
            member += 1;
        });
    }
    let (candidate, member) = start.expect("light");
    let mut chain = algorithm.start(candidate, member, 0);
    let mut sum = 0.0;
    let mut add = |splat: Splat| sum += f64::from(luminance(splat.value));
    for _ in 0..steps {
        algorithm.step(&mut chain, 1.0, &mut add);
    }
    algorithm.finish(&mut chain, 1.0, &mut add);
    sum
}

#[test]
fn what_states_add_sums_to_the_length_of_the_chain() {
    let steps = 4096;
    let is_whole = |sum: f64| (sum / f64::from(steps) - 1.0).abs() < 1e-4;
    with_room(|view, settings| {
        let mut settings = *settings;
        settings.chains = weighed([1.0; 6]);
        for min_edges in [1, 3] {
            let sum = added(&VeachChains::new(view, &settings, min_edges, 3, 0), steps);
            assert!(is_whole(sum), "{sum} of {steps}");
        }
        for kind in [technique::PATH, technique::BIDIRECTIONAL] {
            let space = PrimarySpace::new(view, &settings, kind, 1);
            let sum = added(&PrimaryChains::new(space, 0.0, 3, 0), steps);
            assert!(is_whole(sum), "{sum} of {steps}");
        }
    });
}
