//! Where an expression that no path of the scene can match goes wrong.
//!
//! Its text is read as a path would be, from the end at which it begins, and the first vertex to which no path can come is told: most
//! often its name is one that nothing has.

use super::error::ExpressionError;
use super::names::{SceneNames, is_named};
use super::read::Read;
use super::syntax::Node;
use super::{automaton::Letters, parser::parse};
use halflight_kernel::scene::Tables;

/// The mistake in expression `index` of those that have been read. `light` and `sensor` are the letters as walks from both ends read
/// them.
pub(super) fn unmatched(
    read: &Read,
    index: usize,
    text: &str,
    [light, sensor]: [&Letters<'_>; 2],
    tables: &Tables<'_>,
    names: &SceneNames,
) -> ExpressionError {
    let begins_at_sensor = text
        .chars()
        .find(|c| !c.is_whitespace() && *c != '(')
        .is_some_and(|c| c == 'C');
    let letters = if begins_at_sensor { sensor } else { light };
    let reached = reached(read, index, letters, begins_at_sensor);
    let positions = &read.positions;
    let lost = (0..positions.count())
        .filter(|p| positions.expression[*p] == index && positions.atoms[*p].is_some())
        .filter(|p| !reached[*p])
        .map(|p| positions.places[p])
        .min();
    let what = "no path of this scene can match";
    match (nameless(text, tables, names), lost) {
        (Some(error), _) => error,
        (None, Some(at)) => {
            let message = format!(
                "{what}: none comes to this vertex; from the light it leads from L over surfaces to E, from the camera from C to L"
            );
            ExpressionError::new(text, at, message)
        }
        (None, None) => {
            let end = if begins_at_sensor { "L" } else { "E" };
            let message = format!("{what}: it does not end with {end}");
            ExpressionError::new(text, text.trim_end().chars().count(), message)
        }
    }
}

/// That an expression asks for a name which nothing fits, if it does.
pub(super) fn nameless(
    text: &str,
    tables: &Tables<'_>,
    names: &SceneNames,
) -> Option<ExpressionError> {
    let node = parse(text).ok()?;
    let (at, glob) = first_nameless(&node, tables, names)?;
    let message =
        format!("no path of this scene can match: it has nothing whose name fits \"{glob}\"");
    Some(ExpressionError::new(text, at, message))
}

/// The positions of an expression that some path of the scene reads.
fn reached(read: &Read, index: usize, letters: &Letters<'_>, begins_at_sensor: bool) -> Vec<bool> {
    let positions = &read.positions;
    let count = positions.count();
    // What comes behind each position in the order of the text, and before all.
    let mut behind = vec![Vec::new(); count];
    let mut first = Vec::new();
    for from in (0..count).filter(|p| positions.expression[*p] == index) {
        for &to in &positions.follow[from] {
            if begins_at_sensor {
                behind[to].push(from);
            } else if positions.atoms[from].is_none() {
                first.push(to);
            } else {
                behind[from].push(to);
            }
        }
    }
    if begins_at_sensor {
        let last = positions.last.iter().copied();
        first.extend(last.filter(|p| positions.expression[*p] == index));
    }
    let accepts = |position: usize, list: &[u32]| {
        let mut list = list.iter();
        list.any(|letter| read.accepted[*letter as usize].contains(position))
    };
    let mut found = vec![false; count];
    let mut is_inside = vec![false; count];
    let mut queue: Vec<usize> = Vec::new();
    for p in first.into_iter().filter(|p| accepts(*p, &letters.first)) {
        found[p] = true;
        queue.push(p);
    }
    while let Some(p) = queue.pop() {
        for &next in &behind[p] {
            if accepts(next, &letters.last) {
                found[next] = true;
            }
            if !is_inside[next] && accepts(next, &letters.inner) {
                is_inside[next] = true;
                found[next] = true;
                queue.push(next);
            }
        }
    }
    found
}

/// The first pattern of names that nothing fits, where a vertex must fit one; and where it stands.
fn first_nameless(node: &Node, tables: &Tables<'_>, names: &SceneNames) -> Option<(usize, String)> {
    match node {
        Node::Atom(atom, _) if atom.is_negated => None,
        Node::Atom(atom, _) => {
            // Of several that may stand there, all must be nameless.
            let all = atom.tests.iter().map(|test| {
                let found = test.names.iter().find(|n| {
                    let mut all = n.patterns.iter();
                    !n.is_negated && !all.any(|(p, _)| is_named(p, tables, names))
                });
                let (pattern, at) = found?.patterns.first()?;
                Some((*at, pattern.glob.as_str().to_owned()))
            });
            first_of(all.collect::<Option<Vec<_>>>()?)
        }
        Node::Choice(nodes) => {
            let all = nodes.iter().map(|n| first_nameless(n, tables, names));
            first_of(all.collect::<Option<Vec<_>>>()?)
        }
        Node::Sequence(nodes) => {
            let found = nodes
                .iter()
                .filter_map(|n| first_nameless(n, tables, names));
            first_of(found.collect())
        }
        Node::Repeat(_, 0, _) => None,
        Node::Repeat(node, ..) => first_nameless(node, tables, names),
    }
}

/// The one that stands first in the text.
fn first_of(found: Vec<(usize, String)>) -> Option<(usize, String)> {
    found.into_iter().min_by_key(|(at, _)| *at)
}
