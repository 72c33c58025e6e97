//! A cache of photons: where light walks have arrived, sorted so that those near a point are found quickly.
//!
//! Positions are quantised to 2^10 cells along each side of a cube around all photons, and photons are sorted by the Morton
//! code of their cell (Morton 1966), ten times three bits whose leading `3 l` name the cell of level l, one of 2^l along a
//! side. So the photons of every cell of every level lie side by side. A table holds where those of each cell of one level
//! begin; what lies in coarser cells follows from it directly, what lies in finer ones is searched within. A query takes
//! cells no smaller than its radius, at most 27 of them, so that radii far above and far below the table's cells stay
//! cheap: one cache serves pixels of different radii, and nothing has to be known of them when it is built. Radii below a
//! finest cell, 1/1024 of the cube, find all photons of the cell before they look at distances.
//!
//! The owner of the cache builds and lends it; a shader queries it with the same functions. Memory per photon: 60 bytes of
//! record and position, 4 of key, and at most 16 of the table ([`table_level`]).
//! Invariants (tests): a query returns each photon within the radius exactly once, whatever the radius.

use crate::math::vec3;
use crate::path::PartialWeights;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Levels of cells below the whole cube.
pub const LEVELS: u32 = 10;

/// Cells of the finest level along a side of the cube.
const FINEST: f32 = (1 << LEVELS) as f32;

/// Bits of a key per level.
const CELL_BITS: u32 = 3;

/// Where a light walk has arrived and could be found by a camera walk nearby.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Photon {
    /// Direction in which it flies.
    pub direction: [f32; 3],
    /// Flux that the walk carries, for one light walk.
    pub throughput: [f32; 3],
    /// Geometric normal where it arrived.
    pub normal: [f32; 3],
    /// See [`crate::path::PartialWeights::d_vcm`].
    pub d_vcm: f32,
    /// See [`crate::path::PartialWeights::d_vc`].
    pub d_vc: f32,
    /// Edges from the emitter.
    pub depth: u32,
    /// Index of the record of its walk that its owner keeps for it: states of path expressions or of edits, or the vertex.
    pub record: u32,
}

impl Photon {
    /// The weights' share of its walk.
    #[inline]
    pub fn weights(&self) -> PartialWeights {
        PartialWeights {
            d_vcm: self.d_vcm,
            d_vc: self.d_vc,
        }
    }
}

/// The cube of cells.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PhotonGrid {
    /// Its lower corner.
    pub origin: [f32; 3],
    /// Finest cells per unit of length.
    pub cells_per_length: f32,
    /// Level of the table's cells.
    pub table_level: u32,
}

/// Level of the table's cells for a number of photons: at most four entries per photon.
#[inline]
pub fn table_level(count: u32) -> u32 {
    let mut level = 0;
    while level < 8 && (1 << (CELL_BITS * (level + 1))) <= count.min(1 << 28) * 4 {
        level += 1;
    }
    level
}

/// The bits of `x < 1024`, each followed by two zeros.
#[inline]
fn spread(x: u32) -> u32 {
    let mut x = x & 0x3ff;
    x = (x | (x << 16)) & 0x0300_00ff;
    x = (x | (x << 8)) & 0x0300_f00f;
    x = (x | (x << 4)) & 0x030c_30c3;
    (x | (x << 2)) & 0x0924_9249
}

/// Morton code of a cell.
#[inline]
fn morton(x: u32, y: u32, z: u32) -> u32 {
    spread(x) | (spread(y) << 1) | (spread(z) << 2)
}

impl PhotonGrid {
    /// The cube around the box from `low` to `high` for `count` photons; cells of some size even where they all lie at one
    /// point.
    pub fn around(low: Vec3, high: Vec3, count: u32) -> PhotonGrid {
        // Distances that positions cannot resolve need no cells.
        let coarse = low.abs().max(high.abs()).max_element() * 1e-6;
        let side = (high - low).max_element().max(coarse).max(1e-30);
        let cells_per_length = FINEST / side;
        PhotonGrid {
            origin: low.to_array(),
            cells_per_length: cells_per_length.min(1e30),
            table_level: table_level(count),
        }
    }

    /// Number of the finest cell along an axis; positions outside of the cube count to its rim.
    #[inline]
    fn cell(&self, axis: usize, x: f32) -> u32 {
        let x = (x - self.origin[axis]) * self.cells_per_length;
        // Casts saturate, in shaders they must not.
        x.max(0.0).min(FINEST - 1.0) as u32
    }

    /// Morton code of the finest cell that holds a position.
    #[inline]
    pub fn key(&self, position: Vec3) -> u32 {
        morton(
            self.cell(0, position.x),
            self.cell(1, position.y),
            self.cell(2, position.z),
        )
    }

    /// The table's cell of a key.
    #[inline]
    pub fn table_cell(&self, key: u32) -> u32 {
        key >> (CELL_BITS * (LEVELS - self.table_level))
    }

    /// Number of the table's cells.
    #[inline]
    pub fn table_cells(&self) -> u32 {
        1 << (CELL_BITS * self.table_level)
    }
}

/// Photons sorted by the Morton codes of their cells.
#[derive(Clone, Copy)]
pub struct PhotonCache<'a> {
    /// The cells.
    pub grid: PhotonGrid,
    /// Index of the first photon of each of the table's cells, and the number of photons.
    pub starts: &'a [u32],
    /// Keys of the photons, ascending.
    pub keys: &'a [u32],
    /// Positions of the photons.
    pub positions: &'a [[f32; 3]],
    /// The photons.
    pub photons: &'a [Photon],
}

impl PhotonCache<'_> {
    /// Number of photons.
    #[inline]
    pub fn len(&self) -> u32 {
        self.keys.len() as u32
    }

    /// Whether there is none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// First index in `start..end` whose key is not below `key`, `end` if there is none.
    #[inline]
    fn first_not_below(&self, start: u32, end: u32, key: u32) -> u32 {
        let (mut low, mut high) = (start, end);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.keys[middle as usize] < key {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Position of a photon.
    #[inline]
    pub fn position(&self, index: u32) -> Vec3 {
        vec3(self.positions[index as usize])
    }
}

/// A walk over the cells that a ball touches: ranges of photons, among them all that lie in it.
///
/// ```text
/// let mut query = PhotonQuery::new(&cache, center, radius);
/// while query.advance(&cache) {
///     for i in query.start..query.end { /* is photon i within the radius? */ }
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PhotonQuery {
    /// First photon of the range.
    pub start: u32,
    /// Behind its last.
    pub end: u32,
    level: u32,
    low: [u32; 3],
    high: [u32; 3],
    next: [u32; 3],
    is_done: bool,
}

impl PhotonQuery {
    /// Of a ball; nothing is found for a radius that is not positive.
    pub fn new(cache: &PhotonCache<'_>, center: Vec3, radius: f32) -> PhotonQuery {
        let grid = &cache.grid;
        let mut query = PhotonQuery {
            start: 0,
            end: 0,
            level: 0,
            low: [0; 3],
            high: [0; 3],
            next: [0; 3],
            is_done: cache.is_empty() || !(radius > 0.0),
        };
        // The coarsest cells first: a cell of the level after the last one taken would be smaller than the radius.
        let cells = radius * grid.cells_per_length;
        let mut size = FINEST * 0.5;
        while query.level < LEVELS && size >= cells {
            size *= 0.5;
            query.level += 1;
        }
        let shift = LEVELS - query.level;
        // Rounding of a photon's cell and of the query's ends must not disagree.
        let reach = radius * 1.000_01 + 1e-3 / grid.cells_per_length;
        let center = center.to_array();
        for axis in 0..3 {
            let low = center[axis] - reach;
            let high = center[axis] + reach;
            let end = grid.origin[axis] + FINEST / grid.cells_per_length;
            if high < grid.origin[axis] || low > end + reach * 1e-3 {
                query.is_done = true;
            }
            query.low[axis] = grid.cell(axis, low) >> shift;
            query.high[axis] = grid.cell(axis, high) >> shift;
        }
        query.next = query.low;
        query
    }

    /// Goes on to the next range that is not empty; returns whether there is one.
    #[inline]
    pub fn advance(&mut self, cache: &PhotonCache<'_>) -> bool {
        while !self.is_done {
            let code = morton(self.next[0], self.next[1], self.next[2]);
            self.step();
            self.range(cache, code);
            if self.start < self.end {
                return true;
            }
        }
        false
    }

    #[inline]
    fn step(&mut self) {
        let mut axis = 0;
        while axis < 3 {
            if self.next[axis] < self.high[axis] {
                self.next[axis] += 1;
                return;
            }
            self.next[axis] = self.low[axis];
            axis += 1;
        }
        self.is_done = true;
    }

    /// Photons of a cell of the query's level.
    #[inline]
    fn range(&mut self, cache: &PhotonCache<'_>, code: u32) {
        let table_level = cache.grid.table_level;
        if self.level <= table_level {
            let finer = CELL_BITS * (table_level - self.level);
            self.start = cache.starts[(code << finer) as usize];
            self.end = cache.starts[((code + 1) << finer) as usize];
            return;
        }
        let cell = (code >> (CELL_BITS * (self.level - table_level))) as usize;
        self.start = cache.starts[cell];
        self.end = cache.starts[cell + 1];
        if self.start < self.end {
            let finer = CELL_BITS * (LEVELS - self.level);
            self.start = cache.first_not_below(self.start, self.end, code << finer);
            self.end = cache.first_not_below(self.start, self.end, (code + 1) << finer);
        }
    }
}
