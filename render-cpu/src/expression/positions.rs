//! The automaton of positions of expressions (Glushkov 1961): a state for each atom, and one in which nothing has been read.
//!
//! It has no empty steps, so that the same states serve from both ends: behind a prefix they are the positions just read, before
//! a suffix those from which it leads to the end.

use super::error::ExpressionError;
use super::syntax::{Atom, Node};

/// Most positions of all expressions together: counted repetitions multiply them.
const MAX_POSITIONS: usize = 1024;

/// A set of positions.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct PositionSet(Vec<u64>);

impl PositionSet {
    /// Without any of `count`.
    pub fn empty(count: usize) -> PositionSet {
        PositionSet(vec![0; count.div_ceil(64)])
    }

    /// Adds a position.
    pub fn insert(&mut self, position: usize) {
        self.0[position / 64] |= 1 << (position % 64);
    }

    /// Whether it holds a position.
    pub fn contains(&self, position: usize) -> bool {
        self.0[position / 64] >> (position % 64) & 1 != 0
    }

    /// Keeps what another has as well.
    pub fn keep(&mut self, other: &PositionSet) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a &= b;
        }
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|w| *w == 0)
    }

    /// Whether any position is in both.
    pub fn meets(&self, other: &PositionSet) -> bool {
        self.0.iter().zip(&other.0).any(|(a, b)| a & b != 0)
    }

    /// The positions.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(i, word)| {
            (0..64)
                .filter(move |bit| word >> bit & 1 != 0)
                .map(move |bit| 64 * i + bit)
        })
    }
}

/// The positions of all expressions.
#[derive(Default)]
pub(super) struct Positions {
    /// The atom of each position; none where an expression begins.
    pub atoms: Vec<Option<usize>>,
    /// The expression of each position.
    pub expression: Vec<usize>,
    /// The number of characters before the atom of each position in the text of its expression.
    pub places: Vec<usize>,
    /// Positions that may follow each, with the one where an expression begins before all that it may begin with.
    pub follow: Vec<Vec<usize>>,
    /// Where each expression begins.
    pub starts: Vec<usize>,
    /// Positions with which an expression may end.
    pub last: Vec<usize>,
}

/// What a part of an expression may begin and end with.
struct Part {
    is_optional: bool,
    first: Vec<usize>,
    last: Vec<usize>,
}

impl Positions {
    /// Adds an expression; `number` gives the number of an atom.
    ///
    /// # Errors
    /// If there are too many positions.
    pub fn add(
        &mut self,
        text: &str,
        node: &Node,
        number: &mut impl FnMut(&Atom) -> usize,
    ) -> Result<(), ExpressionError> {
        let start = self.push(text, None, 0)?;
        self.starts.push(start);
        let whole = self.part(text, node, number)?;
        self.follow[start] = whole.first;
        self.last.extend(whole.last);
        for list in &mut self.follow {
            list.sort_unstable();
            list.dedup();
        }
        Ok(())
    }

    /// Number of positions.
    pub fn count(&self) -> usize {
        self.atoms.len()
    }

    fn push(
        &mut self,
        text: &str,
        atom: Option<usize>,
        place: usize,
    ) -> Result<usize, ExpressionError> {
        if self.atoms.len() == MAX_POSITIONS {
            let message = format!(
                "with its repetitions this has more than {MAX_POSITIONS} vertices, those of expressions before it included"
            );
            return Err(ExpressionError::new(text, 0, message));
        }
        self.atoms.push(atom);
        // The start of an expression comes before it is counted.
        let start = self.starts.len() - usize::from(atom.is_some());
        self.expression.push(start);
        self.places.push(place);
        self.follow.push(Vec::new());
        Ok(self.atoms.len() - 1)
    }

    fn part(
        &mut self,
        text: &str,
        node: &Node,
        number: &mut impl FnMut(&Atom) -> usize,
    ) -> Result<Part, ExpressionError> {
        match node {
            Node::Atom(atom, place) => {
                let position = self.push(text, Some(number(atom)), *place)?;
                Ok(Part {
                    is_optional: false,
                    first: vec![position],
                    last: vec![position],
                })
            }
            Node::Sequence(nodes) => {
                let mut all = Part::nothing();
                for node in nodes {
                    let next = self.part(text, node, number)?;
                    all = self.join(all, next);
                }
                Ok(all)
            }
            Node::Choice(nodes) => {
                let mut all = Part {
                    is_optional: false,
                    ..Part::nothing()
                };
                for node in nodes {
                    let next = self.part(text, node, number)?;
                    all.is_optional |= next.is_optional;
                    all.first.extend(next.first);
                    all.last.extend(next.last);
                }
                Ok(all)
            }
            Node::Repeat(node, least, most) => {
                let mut all = Part::nothing();
                // Without a limit, the last of the copies is repeated.
                let copies = most.unwrap_or((*least).max(1));
                for copy in 0..copies {
                    let before = self.count();
                    let mut next = self.part(text, node, number)?;
                    if most.is_none() && copy + 1 == copies {
                        self.link(&next.last, &next.first);
                    }
                    next.is_optional |= copy >= *least;
                    all = self.join(all, next);
                    if self.count() == before {
                        // Nothing, however often.
                        break;
                    }
                }
                Ok(all)
            }
        }
    }

    fn link(&mut self, from: &[usize], to: &[usize]) {
        for &a in from {
            self.follow[a].extend(to);
            self.follow[a].sort_unstable();
            self.follow[a].dedup();
        }
    }

    fn join(&mut self, mut a: Part, b: Part) -> Part {
        self.link(&a.last, &b.first);
        if a.is_optional {
            a.first.extend(&b.first);
        }
        let mut last = b.last;
        if b.is_optional {
            last.extend(&a.last);
        }
        Part {
            is_optional: a.is_optional && b.is_optional,
            first: a.first,
            last,
        }
    }
}

impl Part {
    fn nothing() -> Part {
        Part {
            is_optional: true,
            first: Vec::new(),
            last: Vec::new(),
        }
    }
}
