//! Path expressions: which of several sets of paths a path belongs to, by automata over its vertices.
//!
//! A path x_0 ... x_k is read as a word of letters, one for each vertex: the emitter at x_0, at each surface the kind of
//! scattering ([`scattering`]; diffuse, glossy or specular, reflected or transmitted: Heckbert 1990) with the object and the
//! regions that it lies in (Kaplanyan 2017, section 9.1.1.1), and the sensor at x_k. A front end compiles expressions to the
//! tables of [`PathExpressions`]; all vertices that no expression distinguishes share a letter. Up to [`MAX_PARTS`] expressions
//! are one automaton, whose states say by bits which of them have matched.
//!
//! There are two automata, because walks come from both ends: `from_light` reads x_0 first, `from_sensor` reads x_k first. Both
//! are deterministic, so that a state is all that a walk needs to know of its past. Where two walks meet, `joins` says which
//! expressions hold for the whole: with F the positions of the expressions that the light walk may be in, and B those from
//! which what the camera walk has read leads to the end, the expressions with a position in both.
//! Invariant (tests): the answer is that of a matcher which tries all derivations of an expression, wherever the path is divided.

use crate::math::affine::transform_point;
use crate::scene::SurfacePoint;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Most expressions at a time: the bits of a word.
pub const MAX_PARTS: usize = 32;

/// Most regions: their subsets are counted.
pub const MAX_REGIONS: usize = 8;

/// The state of an automaton from which no expression can match any more.
pub const DEAD: u32 = 0;

/// The state of an automaton that has read nothing.
pub const START: u32 = 1;

/// Kinds of scattering at a surface.
pub mod scattering {
    /// D^R.
    pub const DIFFUSE_REFLECTION: u32 = 0;
    /// D^T.
    pub const DIFFUSE_TRANSMISSION: u32 = 1;
    /// G^R.
    pub const GLOSSY_REFLECTION: u32 = 2;
    /// G^T.
    pub const GLOSSY_TRANSMISSION: u32 = 3;
    /// S^R.
    pub const SPECULAR_REFLECTION: u32 = 4;
    /// S^T.
    pub const SPECULAR_TRANSMISSION: u32 = 5;
    /// Number of kinds.
    pub const COUNT: u32 = 6;
}

/// Shapes of a [`Region`].
pub mod region_kind {
    /// The cube from -1 to 1.
    pub const BOX: u32 = 0;
    /// The unit ball.
    pub const SPHERE: u32 = 1;
}

/// A part of space, the image of a cube or a ball under an affine map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Region {
    /// World to the cube or the ball, three rows of four.
    pub to_unit: [f32; 12],
    /// One of [`region_kind`].
    pub kind: u32,
}

impl Region {
    /// Whether a point lies in it.
    #[inline]
    pub fn contains(&self, position: Vec3) -> bool {
        let p = transform_point(&self.to_unit, position);
        if self.kind == region_kind::SPHERE {
            p.length_squared() <= 1.0
        } else {
            p.abs().max_element() <= 1.0
        }
    }
}

/// A deterministic automaton: `next[state * letters + letter]`, and which expressions have matched in each state.
#[derive(Clone, Copy, Debug)]
pub struct Automaton<'a> {
    /// The state after a letter, by state and letter.
    pub next: &'a [u32],
    /// Bits of the expressions that match what has been read, by state.
    pub matched: &'a [u32],
    /// Number of letters.
    pub letters: u32,
}

impl Automaton<'_> {
    /// The state after a letter.
    #[inline]
    pub fn after(&self, state: u32, letter: u32) -> u32 {
        self.next[(state * self.letters + letter) as usize]
    }

    /// Bits of the expressions that match once a last letter is read.
    #[inline]
    pub fn matched_with(&self, state: u32, letter: u32) -> u32 {
        self.matched[self.after(state, letter) as usize]
    }
}

/// Several expressions over the paths of a scene.
#[derive(Clone, Copy, Debug)]
pub struct PathExpressions<'a> {
    /// Number of expressions, at most [`MAX_PARTS`].
    pub count: u32,
    /// 1 if nothing counts but paths that the first expression matches: what it does not match matches none.
    pub only: u32,
    /// Class of each shape.
    pub shapes: &'a [u32],
    /// Class of each instance.
    pub instances: &'a [u32],
    /// Number of classes of instances.
    pub instance_classes: u32,
    /// The regions, at most [`MAX_REGIONS`].
    pub regions: &'a [Region],
    /// Letter of a surface vertex, by class of the shape, class of the instance, bits of the regions, and [`scattering`].
    pub letters: &'a [u32],
    /// Letter of each emitter.
    pub emitters: &'a [u32],
    /// Letter of the sensor.
    pub sensor: u32,
    /// Reads paths from the light.
    pub from_light: Automaton<'a>,
    /// Reads paths from the sensor.
    pub from_sensor: Automaton<'a>,
    /// Bits of the expressions that hold for a path, by the states of a walk from the light and of one from the sensor which
    /// have read all of it together: `joins[light * (states from the sensor) + sensor]`.
    pub joins: &'a [u32],
}

impl PathExpressions<'_> {
    /// Where the letters of a surface point begin, one for each kind of [`scattering`].
    #[inline]
    pub fn first_letter(&self, point: &SurfacePoint) -> u32 {
        self.first_letter_of(point.shape, point.instance, point.position)
    }

    /// The same of a point of a shape and an instance; the position is of no account where there are no regions.
    #[inline]
    pub fn first_letter_of(&self, shape: u32, instance: u32, position: Vec3) -> u32 {
        let mut inside = 0;
        for i in 0..self.regions.len() {
            if self.regions[i].contains(position) {
                inside |= 1 << i;
            }
        }
        let object =
            self.shapes[shape as usize] * self.instance_classes + self.instances[instance as usize];
        ((object << self.regions.len() as u32) + inside) * scattering::COUNT
    }

    /// Whether there is but one [`PathExpressions::first_letter`], 0: no expression names an object or a region.
    #[inline]
    pub fn has_one_first_letter(&self) -> bool {
        self.letters.len() == scattering::COUNT as usize
    }

    /// Whether any expression tells diffuse from glossy scattering.
    pub fn tells_glossy(&self) -> bool {
        let kinds = scattering::COUNT as usize;
        let mut found = false;
        for i in 0..self.letters.len() / kinds {
            for side in 0..2 {
                let kind = |kind: u32| self.letters[i * kinds + kind as usize + side];
                found |=
                    kind(scattering::DIFFUSE_REFLECTION) != kind(scattering::GLOSSY_REFLECTION);
            }
        }
        found
    }

    /// The letter of scattering of a kind at a [`PathExpressions::first_letter`].
    #[inline]
    pub fn letter(&self, first_letter: u32, kind: u32) -> u32 {
        self.letters[(first_letter + kind) as usize]
    }

    /// Bits of the expressions that hold for a path of two walks.
    #[inline]
    pub fn joined(&self, light: u32, sensor: u32) -> u32 {
        self.joins[light as usize * self.from_sensor.matched.len() + sensor as usize]
    }
}
