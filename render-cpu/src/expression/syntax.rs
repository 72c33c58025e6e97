//! The syntax tree of a path expression, and which vertices its atoms stand for.

use halflight_kernel::path::expression::scattering;

/// Kinds of vertices, as bits: those of [`scattering`], and the two ends.
pub mod kind {
    use super::scattering;

    /// The emitter.
    pub const LIGHT: u8 = 1 << 6;
    /// The sensor.
    pub const SENSOR: u8 = 1 << 7;
    /// Diffuse scattering.
    pub const DIFFUSE: u8 =
        1 << scattering::DIFFUSE_REFLECTION | 1 << scattering::DIFFUSE_TRANSMISSION;
    /// Glossy scattering.
    pub const GLOSSY: u8 =
        1 << scattering::GLOSSY_REFLECTION | 1 << scattering::GLOSSY_TRANSMISSION;
    /// Specular scattering.
    pub const SPECULAR: u8 =
        1 << scattering::SPECULAR_REFLECTION | 1 << scattering::SPECULAR_TRANSMISSION;
    /// Scattering of any kind.
    pub const SURFACE: u8 = DIFFUSE | GLOSSY | SPECULAR;
    /// Scattering back to the side from which light came.
    pub const REFLECTED: u8 = 1 << scattering::DIFFUSE_REFLECTION
        | 1 << scattering::GLOSSY_REFLECTION
        | 1 << scattering::SPECULAR_REFLECTION;
    /// Scattering to the other side.
    pub const TRANSMITTED: u8 = SURFACE & !REFLECTED;
    /// Any vertex.
    pub const ANY: u8 = SURFACE | LIGHT | SENSOR;
}

/// Kinds of emitters, as bits.
pub mod light {
    /// Of a surface.
    pub const OBJECT: u8 = 1;
    /// From infinity on all sides.
    pub const BACKGROUND: u8 = 2;
    /// Points, spots, directions.
    pub const OTHER: u8 = 4;
    /// All.
    pub const ANY: u8 = 7;
}

/// What a name is the name of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NameKind {
    /// Any of them.
    Any,
    /// A shape or an instance.
    Object,
    /// A BSDF.
    Material,
    /// An emitter.
    Emitter,
}

/// A pattern of names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct NamePattern {
    /// Names of what.
    pub kind: NameKind,
    /// The pattern, with `*` and `?`.
    pub glob: glob::Pattern,
}

/// A requirement on the names of a vertex: one of the patterns, or none of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct NameTest {
    /// The patterns, and where they stand in the text.
    pub patterns: Vec<(NamePattern, usize)>,
    /// Whether none may fit.
    pub is_negated: bool,
}

/// A set of vertices.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct VertexTest {
    /// Bits of [`kind`].
    pub kinds: u8,
    /// Bits of [`light`], for emitters.
    pub lights: u8,
    /// All must hold.
    pub names: Vec<NameTest>,
    /// Names of regions in all of which a vertex lies, and where they stand in the text.
    pub regions: Vec<(String, usize)>,
}

impl VertexTest {
    /// All vertices of some kinds.
    pub fn of(kinds: u8) -> VertexTest {
        VertexTest {
            kinds,
            lights: light::ANY,
            names: Vec::new(),
            regions: Vec::new(),
        }
    }
}

/// An atom: vertices that some test accepts, or that none accepts.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Atom {
    /// The tests.
    pub tests: Vec<VertexTest>,
    /// Whether none may accept the vertex.
    pub is_negated: bool,
}

impl Atom {
    /// Whether it stands for ends of paths alone, which are no more than one each.
    pub fn is_end(&self) -> bool {
        !self.is_negated && self.tests.iter().all(|t| t.kinds & kind::SURFACE == 0)
    }

    /// The vertices of one test.
    pub fn one(test: VertexTest) -> Atom {
        Atom {
            tests: vec![test],
            is_negated: false,
        }
    }
}

/// A node of the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Node {
    /// One vertex, and the number of characters before it in the text.
    Atom(Atom, usize),
    /// One after the other, from the light.
    Sequence(Vec<Node>),
    /// One of them.
    Choice(Vec<Node>),
    /// As often as given, at most the second number of times if there is one.
    Repeat(Box<Node>, u32, Option<u32>),
}

impl Node {
    /// The same read from the other end.
    pub fn reversed(self) -> Node {
        match self {
            Node::Atom(..) => self,
            Node::Sequence(nodes) => {
                Node::Sequence(nodes.into_iter().rev().map(Node::reversed).collect())
            }
            Node::Choice(nodes) => Node::Choice(nodes.into_iter().map(Node::reversed).collect()),
            Node::Repeat(node, least, most) => Node::Repeat(Box::new(node.reversed()), least, most),
        }
    }
}
