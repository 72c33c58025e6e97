//! Expressions over a scene, compiled.

use super::alphabet::Alphabet;
use super::automaton::{Deterministic, End, Letters};
use super::error::ExpressionError;
use super::names::SceneNames;
use super::positions::{PositionSet, Positions};
use super::read::{Read, ends};
use super::unmatched::unmatched;
use halflight_kernel::path::expression::{
    Automaton, MAX_PARTS, PathExpressions, Region, scattering,
};
use halflight_kernel::path::path_states::CAPACITY;
use halflight_kernel::scene::Tables;
use std::collections::BTreeSet;

/// Most entries of the table of joins.
const MAX_JOINS: usize = 1 << 22;

/// The tables of several expressions.
#[derive(Clone, Debug)]
pub struct CompiledExpressions {
    pub(super) count: u32,
    pub(super) only: u32,
    pub(super) shapes: Vec<u32>,
    pub(super) instances: Vec<u32>,
    pub(super) instance_classes: u32,
    pub(super) regions: Vec<Region>,
    pub(super) letters: Vec<u32>,
    pub(super) emitters: Vec<u32>,
    pub(super) sensor: u32,
    pub(super) alphabet: u32,
    pub(super) light_next: Vec<u32>,
    pub(super) light_matched: Vec<u32>,
    pub(super) sensor_next: Vec<u32>,
    pub(super) sensor_matched: Vec<u32>,
    pub(super) joins: Vec<u32>,
}

impl CompiledExpressions {
    /// Of the automata that read `count` expressions over an alphabet from either end.
    pub(super) fn new(
        count: u32,
        only: u32,
        alphabet: Alphabet,
        light: Deterministic,
        sensor: Deterministic,
        joins: Vec<u32>,
    ) -> CompiledExpressions {
        CompiledExpressions {
            count,
            only,
            shapes: alphabet.shapes,
            instances: alphabet.instances,
            instance_classes: alphabet.instance_classes,
            regions: alphabet.regions,
            letters: alphabet.letters,
            emitters: alphabet.emitters,
            sensor: alphabet.sensor,
            alphabet: alphabet.accepted.len() as u32,
            light_next: light.next,
            light_matched: light.matched,
            sensor_next: sensor.next,
            sensor_matched: sensor.matched,
            joins,
        }
    }

    /// The tables, borrowed for the kernel.
    pub fn view(&self) -> PathExpressions<'_> {
        PathExpressions {
            count: self.count,
            only: self.only,
            shapes: &self.shapes,
            instances: &self.instances,
            instance_classes: self.instance_classes,
            regions: &self.regions,
            letters: &self.letters,
            emitters: &self.emitters,
            sensor: self.sensor,
            from_light: Automaton {
                next: &self.light_next,
                matched: &self.light_matched,
                letters: self.alphabet,
            },
            from_sensor: Automaton {
                next: &self.sensor_next,
                matched: &self.sensor_matched,
                letters: self.alphabet,
            },
            joins: &self.joins,
        }
    }

    /// Number of expressions.
    pub fn count(&self) -> usize {
        self.count as usize
    }
}

/// Compiles expressions over the paths of a scene. If `only` is given, the first expression is one that paths must match to
/// match any other.
///
/// # Errors
/// The first mistake: in the text of an expression, in a name that the scene does not have, in an expression that no path
/// matches; or the expressions are too many or too complex together.
pub fn compile(
    texts: &[&str],
    only: bool,
    tables: &Tables<'_>,
    names: &SceneNames,
) -> Result<CompiledExpressions, ExpressionError> {
    let too_complex = |message: &str| {
        let text = texts.last().copied().unwrap_or_default();
        ExpressionError::new(text, 0, message)
    };
    if texts.len() > MAX_PARTS {
        return Err(too_complex(&format!("more than {MAX_PARTS} expressions")));
    }
    let read = Read::new(texts, tables, names)?;
    let Read {
        positions,
        alphabet,
        accepted,
    } = &read;
    let (from_light, from_sensor) = ends(alphabet, accepted);
    let only = u32::from(only);
    let made = |letters: &Letters<'_>, end: End| {
        Deterministic::new(positions, letters, end, only)
            .ok_or_else(|| too_complex("these expressions are too complex together"))
    };
    let mut light = made(&from_light, End::Light)?;
    let mut sensor = made(&from_sensor, End::Sensor)?;
    let matchable = light.merge_dead_states(&from_light);
    sensor.merge_dead_states(&from_sensor);
    if !tables.emitters.is_empty() {
        for (i, text) in texts.iter().enumerate() {
            if matchable >> i & 1 == 0 && (only == 0 || i == 0) {
                let both = [&from_light, &from_sensor];
                return Err(unmatched(&read, i, text, both, tables, names));
            }
        }
    }
    check_capacity(&light, &sensor, alphabet, &from_light, &from_sensor)
        .map_err(|message| too_complex(&message))?;
    let joins = joins(positions, &light, &sensor, texts.len(), only)
        .ok_or_else(|| too_complex("these expressions are too complex together"))?;
    let count = texts.len() as u32;
    Ok(CompiledExpressions::new(
        count,
        only,
        read.alphabet,
        light,
        sensor,
        joins,
    ))
}

/// Makes sure that walks can hold all states that they can be in.
fn check_capacity(
    light: &Deterministic,
    sensor: &Deterministic,
    alphabet: &Alphabet,
    from_light: &Letters<'_>,
    from_sensor: &Letters<'_>,
) -> Result<(), String> {
    let mut pairs = BTreeSet::new();
    let mut singles = BTreeSet::new();
    for of_place in alphabet.letters.chunks(scattering::COUNT as usize) {
        let at = |kind: u32| of_place[kind as usize];
        for side in 0..2 {
            pairs.insert([
                at(scattering::DIFFUSE_REFLECTION + side),
                at(scattering::GLOSSY_REFLECTION + side),
            ]);
            singles.insert(at(scattering::SPECULAR_REFLECTION + side));
        }
    }
    let pairs: Vec<_> = pairs.into_iter().collect();
    let singles: Vec<_> = singles.into_iter().collect();
    for (automaton, letters) in [(light, from_light), (sensor, from_sensor)] {
        let most = automaton.most_states(&letters.first, &pairs, &singles);
        if most.is_none_or(|most| most > CAPACITY) {
            return Err(
                "these expressions tell too many orders of diffuse and glossy scattering apart"
                    .to_owned(),
            );
        }
    }
    Ok(())
}

/// The table of joins, by states from the light and states from the sensor.
fn joins(
    positions: &Positions,
    light: &Deterministic,
    sensor: &Deterministic,
    count: usize,
    only: u32,
) -> Option<Vec<u32>> {
    let entries = light.states.len() * sensor.states.len();
    if entries > MAX_JOINS {
        return None;
    }
    let sets: Vec<PositionSet> = (0..count)
        .map(|expression| {
            let mut set = PositionSet::empty(positions.count());
            let all = positions.expression.iter().enumerate();
            all.filter(|(_, e)| **e == expression)
                .for_each(|(p, _)| set.insert(p));
            set
        })
        .collect();
    let mut joins = Vec::with_capacity(entries);
    for a in &light.states {
        for b in &sensor.states {
            let mut both = a.clone();
            both.keep(b);
            let bits = if both.is_empty() {
                0
            } else {
                let held = sets.iter().enumerate().filter(|(_, set)| set.meets(&both));
                held.fold(0, |bits, (i, _)| bits | 1 << i)
            };
            joins.push(if bits & only == only { bits } else { 0 });
        }
    }
    Some(joins)
}
