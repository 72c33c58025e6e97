//! Expressions as trees of our own, written as text in both notations, and matched by trying all ways.

use halflight_kernel::glam::Vec3;
use halflight_kernel::path::expression::{PathExpressions, START, scattering};
use halflight_kernel::scene::{SurfacePoint, Tables};
use proptest::prelude::*;

/// Names of the shapes of the scene, and of their materials.
pub const SHAPES: [(&str, &str); 4] = [
    ("floor", "wood"),
    ("ring", "gold"),
    ("ball", "glass"),
    ("door", "wood"),
];

/// A vertex of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vertex {
    Light(usize),
    Surface {
        kind: u32,
        shape: usize,
        in_door: bool,
    },
    Sensor,
}

/// What a vertex is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    Any,
    Sensor,
    Light,
    Object,
    Background,
    Key,
    Class(char),
    Side(char),
    ClassAndSide(char, char),
    OnRing,
    OnWood,
    InDoor,
}

#[derive(Clone, Debug)]
pub enum Tree {
    One(Test),
    Set(bool, Vec<Test>),
    Then(Vec<Tree>),
    Or(Vec<Tree>),
    Times(Box<Tree>, u32, Option<u32>),
}

impl Test {
    fn accepts(self, vertex: Vertex) -> bool {
        use scattering::*;
        let class = |c: char, kind: u32| match c {
            'D' => kind == DIFFUSE_REFLECTION || kind == DIFFUSE_TRANSMISSION,
            'G' => kind == GLOSSY_REFLECTION || kind == GLOSSY_TRANSMISSION,
            'S' => kind == SPECULAR_REFLECTION || kind == SPECULAR_TRANSMISSION,
            _ => true,
        };
        let side = |c: char, kind: u32| (c == 'T') == (kind % 2 == 1);
        match (self, vertex) {
            (Test::Any, _) => true,
            (Test::Sensor, v) => v == Vertex::Sensor,
            (Test::Light, v) => matches!(v, Vertex::Light(_)),
            (Test::Object | Test::Key, v) => v == Vertex::Light(0),
            (Test::Background, v) => v == Vertex::Light(2),
            (Test::Class(c), Vertex::Surface { kind, .. }) => class(c, kind),
            (Test::Side(s), Vertex::Surface { kind, .. }) => side(s, kind),
            (Test::ClassAndSide(c, s), Vertex::Surface { kind, .. }) => {
                class(c, kind) && side(s, kind)
            }
            (Test::OnRing, Vertex::Surface { shape, .. }) => SHAPES[shape].0 == "ring",
            (Test::OnWood, Vertex::Surface { shape, .. }) => SHAPES[shape].1 == "wood",
            (Test::InDoor, Vertex::Surface { in_door, .. }) => in_door,
            _ => false,
        }
    }

    fn text(self, from_camera: bool) -> String {
        match (self, from_camera) {
            (Test::Any, _) => ".".into(),
            (Test::Sensor, true) => "C".into(),
            (Test::Sensor, false) => "E".into(),
            (Test::Light, _) => "L".into(),
            (Test::Object, _) => "O".into(),
            (Test::Background, _) => "B".into(),
            (Test::Key, true) => "<L.'key'>".into(),
            (Test::Key, false) => "L[emitter:k?y]".into(),
            (Test::Class(c), _) => c.to_string(),
            (Test::Side(s), _) => s.to_string(),
            (Test::ClassAndSide('X', s), true) => format!("<{s}.>"),
            (Test::ClassAndSide(c, s), true) => format!("<{s}{c}>"),
            (Test::ClassAndSide(c, s), false) => format!("{c}^{s}"),
            (Test::OnRing, true) => "<.[DGS] 'ring'>".into(),
            (Test::OnRing, false) => "X[object:ring]".into(),
            (Test::OnWood, true) => "<[RT].'wo*'>".into(),
            (Test::OnWood, false) => "X[wood, nothing*]".into(),
            (Test::InDoor, _) => "X{door}".into(),
        }
    }
}

impl Tree {
    /// Where a match that begins at `from` may end.
    pub fn ends(&self, word: &[Vertex], from: usize) -> Vec<usize> {
        let mut ends = match self {
            Tree::One(test) => match word.get(from) {
                Some(v) if test.accepts(*v) => vec![from + 1],
                _ => vec![],
            },
            Tree::Set(is_negated, tests) => match word.get(from) {
                Some(v) if tests.iter().any(|t| t.accepts(*v)) != *is_negated => vec![from + 1],
                _ => vec![],
            },
            Tree::Then(parts) => parts.iter().fold(vec![from], |ends, part| {
                ends.iter().flat_map(|e| part.ends(word, *e)).collect()
            }),
            Tree::Or(parts) => parts.iter().flat_map(|p| p.ends(word, from)).collect(),
            Tree::Times(part, least, most) => {
                let mut all = Vec::new();
                let mut now = vec![from];
                for count in 0..=most.unwrap_or(word.len() as u32 + *least) {
                    if count >= *least {
                        all.extend(&now);
                    }
                    now = now.iter().flat_map(|e| part.ends(word, *e)).collect();
                    now.sort_unstable();
                    now.dedup();
                }
                all
            }
        };
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// In the notation from the light, or in that from the camera.
    pub fn text(&self, from_camera: bool) -> String {
        let all =
            |parts: &[Tree]| -> Vec<String> { parts.iter().map(|p| p.text(from_camera)).collect() };
        match self {
            Tree::One(test) => test.text(from_camera),
            Tree::Set(is_negated, tests) => {
                let tests: Vec<_> = tests.iter().map(|t| t.text(from_camera)).collect();
                let sign = if *is_negated { "^" } else { "" };
                // With a space, or it would be names of the letter before.
                format!(" [{sign}{}]", tests.join(""))
            }
            Tree::Then(parts) => {
                let mut parts = all(parts);
                if from_camera {
                    parts.reverse();
                }
                format!("({})", parts.join(" "))
            }
            Tree::Or(parts) => format!("({})", all(parts).join("|")),
            Tree::Times(part, least, most) => {
                let is_end = |test: &Test| {
                    let kinds = [Test::Sensor, Test::Light, Test::Object, Test::Background];
                    kinds.contains(test) || *test == Test::Key
                };
                let ends_paths = match &**part {
                    Tree::One(test) => is_end(test),
                    Tree::Set(false, tests) => tests.iter().all(is_end),
                    _ => false,
                };
                let part = part.text(from_camera);
                // Ends of paths are not repeated by themselves: that is a mistake.
                let part = if ends_paths {
                    format!("({part})")
                } else {
                    part
                };
                let times = match (least, most) {
                    (0, None) => "*".into(),
                    (1, None) => "+".into(),
                    (0, Some(1)) => "?".into(),
                    (n, None) => format!(" {{{n},}}"),
                    (0, Some(m)) => format!(" {{,{m}}}"),
                    (n, Some(m)) if n == m => format!(" {{{n}}}"),
                    (n, Some(m)) => format!(" {{{n},{m}}}"),
                };
                format!("({part}){times}")
            }
        }
    }
}

/// Tests that both notations can say alone.
fn test() -> impl Strategy<Value = Test> {
    let class = prop::sample::select(vec!['D', 'G', 'S', 'X']);
    let side = prop::sample::select(vec!['R', 'T']);
    prop_oneof![
        2 => Just(Test::Any),
        1 => Just(Test::Light),
        1 => Just(Test::Key),
        4 => class.clone().prop_map(Test::Class),
        1 => side.clone().prop_map(Test::Side),
        2 => (class, side).prop_map(|(c, s)| Test::ClassAndSide(c, s)),
        1 => Just(Test::OnRing),
        1 => Just(Test::OnWood),
        1 => Just(Test::InDoor),
    ]
}

/// Tests of one letter.
fn plain_test() -> impl Strategy<Value = Test> {
    prop_oneof![
        3 => prop::sample::select(vec!['D', 'G', 'S', 'X']).prop_map(Test::Class),
        1 => prop::sample::select(vec!['R', 'T']).prop_map(Test::Side),
        1 => Just(Test::Light),
        1 => Just(Test::Object),
        1 => Just(Test::Background),
    ]
}

/// Any expression between the ends of a path.
pub fn tree() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![
        4 => test().prop_map(Tree::One),
        1 => (any::<bool>(), prop::collection::vec(plain_test(), 1..3)).prop_map(|(n, t)| Tree::Set(n, t)),
    ];
    leaf.prop_recursive(4, 16, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Tree::Then),
            prop::collection::vec(inner.clone(), 1..4).prop_map(Tree::Or),
            (inner, 0u32..3, prop::option::of(0u32..3)).prop_map(|(t, n, more)| Tree::Times(
                Box::new(t),
                n,
                more.map(|m| n + m)
            )),
        ]
    })
}

/// Any path: an emitter, some surfaces, the sensor.
pub fn path() -> impl Strategy<Value = Vec<Vertex>> {
    let surface = (0..scattering::COUNT, 0usize..4, any::<bool>()).prop_map(|(kind, shape, d)| {
        Vertex::Surface {
            kind,
            shape,
            in_door: d,
        }
    });
    (0usize..3, prop::collection::vec(surface, 0..7)).prop_map(|(light, surfaces)| {
        let mut path = vec![Vertex::Light(light)];
        path.extend(surfaces);
        path.push(Vertex::Sensor);
        path
    })
}

/// Bits of the expressions that match a path, by the automata, for every way to divide it.
pub fn matched(
    expressions: &PathExpressions<'_>,
    tables: &Tables<'_>,
    path: &[Vertex],
) -> Vec<u32> {
    let letters: Vec<u32> = path
        .iter()
        .map(|vertex| match vertex {
            Vertex::Light(i) => expressions.emitters[*i],
            Vertex::Sensor => expressions.sensor,
            Vertex::Surface {
                kind,
                shape,
                in_door,
            } => {
                let x = if *in_door { 4.5 } else { 0.0 };
                let point = SurfacePoint {
                    position: Vec3::new(x, -1.5, 1.9),
                    shape: *shape as u32,
                    material: tables.shapes[*shape].material,
                    ..SurfacePoint::ZERO
                };
                expressions.letter(expressions.first_letter(&point), *kind)
            }
        })
        .collect();
    let (light, sensor) = (&expressions.from_light, &expressions.from_sensor);
    let mut states = vec![START];
    for letter in &letters {
        states.push(light.after(*states.last().unwrap(), *letter));
    }
    let mut answers = vec![light.matched[states[letters.len()] as usize]];
    let mut state = START;
    for i in (0..letters.len()).rev() {
        state = sensor.after(state, letters[i]);
        if i > 0 {
            answers.push(expressions.joined(states[i], state));
        }
    }
    answers.push(sensor.matched[state as usize]);
    answers
}
