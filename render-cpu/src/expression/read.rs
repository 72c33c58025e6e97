//! Expressions as they have been read: their positions, and the letters of the scene that they tell apart.

use super::alphabet::Alphabet;
use super::automaton::Letters;
use super::error::ExpressionError;
use super::names::SceneNames;
use super::parser::parse;
use super::positions::{PositionSet, Positions};
use super::syntax::Atom;
use halflight_kernel::scene::Tables;
use std::collections::{BTreeSet, HashMap};

/// Expressions that have been read, over the letters of a scene.
pub(super) struct Read {
    pub positions: Positions,
    pub alphabet: Alphabet,
    /// By letter: the positions whose atoms accept it.
    pub accepted: Vec<PositionSet>,
}

impl Read {
    pub fn new(
        texts: &[&str],
        tables: &Tables<'_>,
        names: &SceneNames,
    ) -> Result<Read, ExpressionError> {
        let mut positions = Positions::default();
        let mut atoms: Vec<(Atom, String)> = Vec::new();
        let mut numbers: HashMap<Atom, usize> = HashMap::new();
        for text in texts {
            let node = parse(text)?;
            positions.add(text, &node, &mut |atom| {
                *numbers.entry(atom.clone()).or_insert_with(|| {
                    atoms.push((atom.clone(), (*text).to_owned()));
                    atoms.len() - 1
                })
            })?;
        }
        let alphabet = Alphabet::new(&atoms, tables, names)?;
        let accepted = (alphabet.accepted.iter())
            .map(|by_atom| {
                let mut set = PositionSet::empty(positions.count());
                let reading = positions.atoms.iter().enumerate();
                reading
                    .filter(|(_, atom)| atom.is_some_and(|a| by_atom[a]))
                    .for_each(|(p, _)| set.insert(p));
                set
            })
            .collect();
        Ok(Read {
            positions,
            alphabet,
            accepted,
        })
    }
}

/// The letters as walks from the light and from the sensor read them.
pub(super) fn ends<'a>(
    alphabet: &Alphabet,
    accepted: &'a [PositionSet],
) -> (Letters<'a>, Letters<'a>) {
    let unique = |letters: &[u32]| -> Vec<u32> {
        let set: BTreeSet<u32> = letters.iter().copied().collect();
        set.into_iter().collect()
    };
    let inner = unique(&alphabet.letters);
    let emitters = unique(&alphabet.emitters);
    let from_light = Letters {
        first: emitters.clone(),
        inner: inner.clone(),
        last: vec![alphabet.sensor],
        accepted,
    };
    let from_sensor = Letters {
        first: vec![alphabet.sensor],
        inner,
        last: emitters,
        accepted,
    };
    (from_light, from_sensor)
}
