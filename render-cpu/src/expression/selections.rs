//! Selections of parts of paths, for edits of light transport ([`halflight_kernel::path::retarget_states`]).
//!
//! A selection names the vertices at one end of a path, and with a last X the surface to which its light or its importance is
//! sent: `L S^T+ X` for what has passed through glass, `X S^R E` for what a mirror shows. It is an expression like any other,
//! whose last letter may be any surface; what distinguishes surfaces there is for the edit's source to say.

use super::automaton::{Deterministic, End, Letters};
use super::compile::CompiledExpressions;
use super::error::ExpressionError;
use super::names::SceneNames;
use super::read::{Read, ends};
use super::unmatched::nameless;
use halflight_kernel::path::expression::START;
use halflight_kernel::path::retarget::flow;
use halflight_kernel::path::retarget_states::{MAX_STATES, PAIRS, label};
use halflight_kernel::scene::Tables;
use std::collections::{BTreeSet, HashSet};

/// Selections, compiled, and the flow that each names.
#[derive(Clone, Debug)]
pub struct CompiledSelections {
    /// The automata; those from each end have matched where an edit of its flow applies behind what has been read.
    pub words: CompiledExpressions,
    /// One of [`flow`] for each selection.
    pub flows: Vec<u32>,
    /// Whether some path over the scene's surfaces, by the lobes of their materials, can be selected.
    pub is_possible: Vec<bool>,
}

/// Compiles selections over the paths of a scene.
///
/// # Errors
/// The first mistake, as of expressions; a selection that names no part of a path; selections that are too complex together.
pub fn compile_selections(
    texts: &[&str],
    tables: &Tables<'_>,
    names: &SceneNames,
) -> Result<CompiledSelections, ExpressionError> {
    let Read {
        positions,
        alphabet,
        accepted,
    } = Read::new(texts, tables, names)?;
    let too_complex = || {
        let text = texts.last().copied().unwrap_or_default();
        ExpressionError::new(
            text,
            0,
            "the selections of all edits are too complex together",
        )
    };
    let (from_light, from_sensor) = ends(&alphabet, &accepted);
    let made = |letters: &Letters<'_>, end: End| {
        let made = Deterministic::new(&positions, letters, end, 0);
        made.filter(|made| made.states.len() <= MAX_STATES)
            .ok_or_else(too_complex)
    };
    let mut light = made(&from_light, End::Light)?;
    let mut sensor = made(&from_sensor, End::Sensor)?;
    let of_light = select(&mut light, &from_light, texts, tables.emitters.is_empty())?;
    let of_sensor = select(&mut sensor, &from_sensor, texts, false)?;
    let mut flows = Vec::new();
    for (i, text) in texts.iter().enumerate() {
        flows.push(match (of_light >> i & 1, of_sensor >> i & 1) {
            (0, 1) => flow::IMPORTANCE,
            (1, 0) => flow::LIGHT,
            // Without emitters there is nothing to turn.
            (0, 0) if tables.emitters.is_empty() => flow::LIGHT,
            (0, 0) if let Some(error) = nameless(text, tables, names) => return Err(error),
            _ => {
                let message = "a selection leads from L over at least one vertex to X, as in L S^T+ X, or from X to E, as in X S^R E; where the last X shall be is said by the source";
                return Err(ExpressionError::new(text, 0, message));
            }
        });
    }
    for (automaton, other, letters, own_flow) in [
        (&light, &sensor, &from_light, flow::LIGHT),
        (&sensor, &light, &from_sensor, flow::IMPORTANCE),
    ] {
        let others: Vec<u32> = (0..texts.len() as u32)
            .filter(|i| flows[*i as usize] != own_flow)
            .collect();
        if !has_room(automaton, other, letters, &others) {
            return Err(too_complex());
        }
    }
    let surfaces = alphabet.scattered(tables);
    let possible = behind_surfaces(&light, &from_light.first, &surfaces)
        | behind_surfaces(&sensor, &from_sensor.first, &surfaces);
    Ok(CompiledSelections {
        is_possible: (0..texts.len()).map(|i| possible >> i & 1 != 0).collect(),
        words: CompiledExpressions::new(texts.len() as u32, 0, alphabet, light, sensor, Vec::new()),
        flows,
    })
}

/// Bits of all selections that apply in states behind a first letter and at least one of those of surfaces.
fn behind_surfaces(automaton: &Deterministic, first: &[u32], surfaces: &[u32]) -> u32 {
    let reached = reached(automaton, first, surfaces);
    let states = reached.iter();
    states.fold(0, |bits, state| bits | automaton.matched[*state as usize])
}

/// States behind a first letter and at least one of those of surfaces.
fn reached(automaton: &Deterministic, first: &[u32], surfaces: &[u32]) -> BTreeSet<u32> {
    let mut reached: BTreeSet<u32> = BTreeSet::new();
    let mut queue: Vec<u32> = first.iter().map(|l| automaton.after(START, *l)).collect();
    while let Some(state) = queue.pop() {
        for letter in surfaces {
            let next = automaton.after(state, *letter);
            if reached.insert(next) {
                queue.push(next);
            }
        }
    }
    reached
}

/// Turns what matches into what is selected by a last surface; returns the bits of the selections that some vertices satisfy.
fn select(
    automaton: &mut Deterministic,
    letters: &Letters<'_>,
    texts: &[&str],
    is_dark: bool,
) -> Result<u32, ExpressionError> {
    let automaton_ref = &*automaton;
    let behind = |state: u32| {
        let next = letters.inner.iter();
        next.map(move |l| automaton_ref.matched[automaton_ref.after(state, *l) as usize])
    };
    let states = 0..automaton.states.len() as u32;
    let selected: Vec<u32> = states
        .clone()
        .map(|state| behind(state).fold(u32::MAX, |a, b| a & b))
        .collect();
    let some: Vec<u32> = states
        .map(|state| behind(state).fold(0, |a, b| a | b))
        .collect();
    let mut bits = 0;
    for state in reached(automaton, &letters.first, &letters.inner) {
        let partly = some[state as usize] & !selected[state as usize];
        if partly != 0 && !is_dark {
            let text = texts.get(partly.trailing_zeros() as usize);
            let message = "the vertex to which a selection sends light is a plain X; where it shall be is said by the source";
            return Err(ExpressionError::new(text.unwrap_or(&""), 0, message));
        }
        bits |= selected[state as usize];
    }
    automaton.matched = selected;
    Ok(bits)
}

/// Whether walks that read `automaton` can hold all pairs of its states and sets of states of `other` that they can be in, where
/// the edits `others` are of the other flow.
fn has_room(
    automaton: &Deterministic,
    other: &Deterministic,
    letters: &Letters<'_>,
    others: &[u32],
) -> bool {
    let all = (0..other.states.len()).fold(0_u64, |set, q| set | 1 << q);
    // All that a vertex may say of the edits of the other flow.
    let mut choices: BTreeSet<(u32, u32)> = BTreeSet::new();
    for subset in 0..1_u32 << others.len() {
        let within = (others.iter().enumerate())
            .filter(|(i, _)| subset >> i & 1 != 0)
            .fold(0, |bits, (_, edit)| bits | 1 << edit);
        choices.insert((within, 0));
        (others.iter())
            .filter(|edit| within >> **edit & 1 != 0)
            .for_each(|edit| {
                choices.insert((within, edit + 1));
            });
    }
    let mut seen: HashSet<(u32, u64)> = HashSet::new();
    let mut queue: Vec<(u32, u64)> = letters
        .first
        .iter()
        .map(|l| (automaton.after(START, *l), all))
        .collect();
    while let Some((state, wanted)) = queue.pop() {
        for letter in &letters.inner {
            for (within, chosen) in &choices {
                let mut before = 0_u64;
                for q in 0..other.states.len() as u32 {
                    let after = other.after(q, *letter);
                    let is_right = label(other.matched[after as usize] & within) == *chosen;
                    if wanted >> after & 1 != 0 && is_right {
                        before |= 1 << q;
                    }
                }
                let next = (automaton.after(state, *letter), before);
                if before != 0 && seen.insert(next) {
                    if seen.len() >= PAIRS {
                        return false;
                    }
                    queue.push(next);
                }
            }
        }
    }
    true
}
