//! Deterministic automata of positions, read from either end (subset construction).
//!
//! A state from which no path can match any more is the dead one, so that walks know when to give up. Automata are not made
//! minimal: those of practical expressions have some dozens of states.

use super::positions::{PositionSet, Positions};
use halflight_kernel::path::expression::{DEAD, START};
use std::collections::{BTreeSet, HashMap, HashSet, VecDeque};

/// Most states of an automaton.
const MAX_STATES: usize = 2048;

/// Most sets of states that are looked at to find how many a walk can be in.
const MAX_SETS: usize = 20_000;

/// Letters of a path's ends and of surfaces, as a walk reads them.
pub(super) struct Letters<'a> {
    /// Those that may come first.
    pub first: Vec<u32>,
    /// Those of surfaces.
    pub inner: Vec<u32>,
    /// Those that may come last.
    pub last: Vec<u32>,
    /// By letter: the positions whose atoms accept it.
    pub accepted: &'a [PositionSet],
}

/// From which end an automaton reads.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The light first.
    Light,
    /// The sensor first.
    Sensor,
}

/// An automaton.
pub(super) struct Deterministic {
    /// By state and letter.
    pub next: Vec<u32>,
    /// Bits of the expressions that match, by state.
    pub matched: Vec<u32>,
    /// The positions of each state; none of the dead one.
    pub states: Vec<PositionSet>,
    letters: usize,
}

impl Deterministic {
    /// The automaton that reads from `end`; none if it has too many states. Where `only` is not zero, what lacks its bits
    /// matches nothing.
    pub fn new(
        positions: &Positions,
        letters: &Letters<'_>,
        end: End,
        only: u32,
    ) -> Option<Deterministic> {
        let count = positions.count();
        let mut start = PositionSet::empty(count);
        let begins = match end {
            End::Light => &positions.starts,
            End::Sensor => &positions.last,
        };
        begins.iter().for_each(|p| start.insert(*p));
        let mut precede = vec![Vec::new(); count];
        for (from, list) in positions.follow.iter().enumerate() {
            list.iter().for_each(|to| precede[*to].push(from));
        }
        let mut made = Deterministic {
            next: Vec::new(),
            matched: Vec::new(),
            states: vec![PositionSet::empty(count), start.clone()],
            letters: letters.accepted.len(),
        };
        let mut found = HashMap::from([(start, START)]);
        let all: BTreeSet<u32> = letters
            .first
            .iter()
            .chain(&letters.inner)
            .chain(&letters.last)
            .copied()
            .collect();
        let mut at = 0;
        while at < made.states.len() {
            let set = made.states[at].clone();
            at += 1;
            let mut row = vec![DEAD; made.letters];
            // From the light: all that may follow. From the sensor: what may precede, once the letter is known.
            let mut reachable = PositionSet::empty(count);
            if end == End::Light {
                for p in set.iter() {
                    positions.follow[p]
                        .iter()
                        .for_each(|q| reachable.insert(*q));
                }
            }
            for letter in &all {
                let accepted = &letters.accepted[*letter as usize];
                let mut next;
                if end == End::Light {
                    next = reachable.clone();
                    next.keep(accepted);
                } else {
                    next = PositionSet::empty(count);
                    let mut read = set.clone();
                    read.keep(accepted);
                    for p in read.iter() {
                        precede[p].iter().for_each(|q| next.insert(*q));
                    }
                }
                if next.is_empty() {
                    continue;
                }
                let fresh = made.states.len() as u32;
                let state = *found.entry(next).or_insert_with_key(|next| {
                    made.states.push(next.clone());
                    fresh
                });
                row[*letter as usize] = state;
            }
            made.next.extend(row);
            if made.states.len() > MAX_STATES {
                return None;
            }
        }
        made.matched = (made.states.iter())
            .map(|set| {
                let ends = match end {
                    End::Light => &positions.last,
                    End::Sensor => &positions.starts,
                };
                let held = ends.iter().filter(|p| set.contains(**p));
                let bits = held.fold(0, |bits, p| bits | 1 << positions.expression[*p]);
                if bits & only == only { bits } else { 0 }
            })
            .collect();
        Some(made)
    }

    /// The state after a letter.
    pub fn after(&self, state: u32, letter: u32) -> u32 {
        self.next[state as usize * self.letters + letter as usize]
    }

    /// Bits of the expressions that some path matches; states from which none does become the dead one.
    pub fn merge_dead_states(&mut self, letters: &Letters<'_>) -> u32 {
        // What each state may come to: by a last letter, and then by surfaces before it.
        let mut hopes: Vec<u32> = (0..self.states.len() as u32)
            .map(|state| {
                let ends = letters
                    .last
                    .iter()
                    .map(|l| self.matched[self.after(state, *l) as usize]);
                ends.fold(0, |a, b| a | b)
            })
            .collect();
        loop {
            let mut changed = false;
            for state in 0..self.states.len() {
                let next = letters
                    .inner
                    .iter()
                    .map(|l| hopes[self.after(state as u32, *l) as usize]);
                let hope = next.fold(hopes[state], |a, b| a | b);
                changed |= hope != hopes[state];
                hopes[state] = hope;
            }
            if !changed {
                break;
            }
        }
        let begin: Vec<u32> = letters
            .first
            .iter()
            .map(|l| self.after(START, *l))
            .collect();
        let matchable = begin.iter().fold(0, |bits, s| bits | hopes[*s as usize]);
        for next in &mut self.next {
            let state = *next as usize;
            if hopes[state] == 0 && self.matched[state] == 0 {
                *next = DEAD;
            }
        }
        matchable
    }

    /// The most states that a walk can be in whose vertices are diffuse and glossy at once, of pairs of letters that go
    /// together; none where there are too many possibilities to tell.
    pub fn most_states(&self, first: &[u32], pairs: &[[u32; 2]], singles: &[u32]) -> Option<usize> {
        let live = self.states.len() - 1;
        if live <= halflight_kernel::path::path_states::CAPACITY {
            return Some(live);
        }
        let starts = first.iter().map(|l| vec![self.after(START, *l)]);
        let mut seen: HashSet<Vec<u32>> = starts.filter(|s| s[0] != DEAD).collect();
        let mut queue: VecDeque<Vec<u32>> = seen.iter().cloned().collect();
        let mut most = 1;
        while let Some(set) = queue.pop_front() {
            most = most.max(set.len());
            let step = |letters: &[u32]| {
                let both = set
                    .iter()
                    .flat_map(|s| letters.iter().map(|l| self.after(*s, *l)));
                let mut next: Vec<u32> = both.filter(|s| *s != DEAD).collect();
                next.sort_unstable();
                next.dedup();
                next
            };
            let by_pairs = pairs.iter().map(|pair| step(pair));
            let by_singles = singles.iter().map(|letter| step(&[*letter]));
            for next in by_pairs.chain(by_singles) {
                if !next.is_empty() && seen.insert(next.clone()) {
                    if seen.len() > MAX_SETS {
                        return None;
                    }
                    queue.push_back(next);
                }
            }
        }
        Some(most)
    }
}
