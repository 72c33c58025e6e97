//! Densities over the unit square that depend on an incident direction: bilinear, with a mapping from even numbers and back.
//!
//! A grid holds a value at each corner of its cells, with the sums along each row and of all rows before it, cells counting one
//! each: the integral of the bilinear function. The row is drawn first, by the sums of rows between which the density is linear, then
//! the column in the row at that position; both are inverted in closed form. Tables of neighbouring incident directions are interpolated
//! linearly with their sums, so that the mapping stays exact. Invariants (tests): samples follow the density.

use crate::math::float;
use glam::Vec2;

/// A table over the unit square, and where it is: that of the first incident direction.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) first: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Grid {
    /// Values at the corners of the cells.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.width * self.height
    }

    /// Words of a density with its cumulative distributions: values, sums along each row, sums of rows.
    #[inline]
    pub(super) fn density_words(&self) -> usize {
        2 * self.len() + self.height
    }
}

/// The tables around an incident direction and their weights.
#[derive(Clone, Copy)]
pub(super) struct Slices {
    index: [usize; 4],
    weight: [f32; 4],
}

/// The interval of ascending words `first..first + count` that holds `x`, and the relative position in it; its ends outside.
#[inline]
fn interval(data: &[f32], first: usize, count: usize, x: f32) -> (usize, f32) {
    if count < 2 {
        return (0, 0.0);
    }
    let (mut low, mut high) = (0, count - 2);
    // The last interval that starts at or before x.
    while low < high {
        let middle = (low + high).div_ceil(2);
        if data[first + middle] <= x {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    let (a, b) = (data[first + low], data[first + low + 1]);
    (low, ((x - a) / (b - a)).max(0.0).min(1.0))
}

impl Slices {
    /// Around the incident direction (phi, theta); `first` is the word of the measured azimuths, which the elevations follow.
    #[inline]
    pub(super) fn around(
        data: &[f32],
        first: usize,
        [azimuths, elevations]: [usize; 2],
        phi: f32,
        theta: f32,
    ) -> Slices {
        let (p, t_p) = interval(data, first, azimuths, phi);
        let (e, t_e) = interval(data, first + azimuths, elevations, theta);
        let p1 = (p + 1).min(azimuths - 1);
        let e1 = (e + 1).min(elevations - 1);
        let at = |p: usize, e: usize| p * elevations + e;
        Slices {
            index: [at(p, e), at(p, e1), at(p1, e), at(p1, e1)],
            weight: [
                (1.0 - t_p) * (1.0 - t_e),
                (1.0 - t_p) * t_e,
                t_p * (1.0 - t_e),
                t_p * t_e,
            ],
        }
    }

    /// The word `at` of the first table, interpolated between tables of `stride` words.
    #[inline]
    fn look_up(&self, data: &[f32], at: usize, stride: usize) -> f32 {
        let mut sum = 0.0;
        for k in 0..4 {
            sum += self.weight[k] * data[at + self.index[k] * stride];
        }
        sum
    }
}

/// No slices: a table that does not depend on the incident direction.
pub(super) const ONE: Slices = Slices {
    index: [0; 4],
    weight: [1.0, 0.0, 0.0, 0.0],
};

/// The cell of a point of the square and the relative position in it.
#[derive(Clone, Copy)]
struct Cell {
    x: usize,
    y: usize,
    t: Vec2,
}

#[inline]
fn cell(grid: &Grid, u: Vec2) -> Cell {
    let x = u.x.max(0.0).min(1.0) * (grid.width - 1) as f32;
    let y = u.y.max(0.0).min(1.0) * (grid.height - 1) as f32;
    let column = (x as usize).min(grid.width - 2);
    let row = (y as usize).min(grid.height - 2);
    Cell {
        x: column,
        y: row,
        t: Vec2::new(x - column as f32, y - row as f32),
    }
}

/// The value at both ends of a cell in x, interpolated in y, of a grid at the word `first`.
#[inline]
fn ends(
    data: &[f32],
    slices: &Slices,
    first: usize,
    width: usize,
    stride: usize,
    c: Cell,
) -> (f32, f32) {
    let at = first + c.y * width + c.x;
    let left = float::lerp(
        slices.look_up(data, at, stride),
        slices.look_up(data, at + width, stride),
        c.t.y,
    );
    let right = float::lerp(
        slices.look_up(data, at + 1, stride),
        slices.look_up(data, at + width + 1, stride),
        c.t.y,
    );
    (left, right)
}

/// The bilinear value of a grid at the word `first`.
#[inline]
pub(super) fn bilinear(
    data: &[f32],
    slices: &Slices,
    grid: &Grid,
    first: usize,
    stride: usize,
    u: Vec2,
) -> f32 {
    let c = cell(grid, u);
    let (left, right) = ends(data, slices, first, grid.width, stride, c);
    float::lerp(left, right, c.t.x)
}

/// A point of the square and a density there.
#[derive(Clone, Copy)]
pub(super) struct Warped {
    pub(super) u: Vec2,
    pub(super) pdf: f32,
}

impl Grid {
    /// Density per unit of the square of values that sum to one over the cells.
    #[inline]
    pub(super) fn per_square(&self) -> f32 {
        ((self.width - 1) * (self.height - 1)) as f32
    }

    /// Sum along row `y` before column `x`.
    #[inline]
    fn along(&self, data: &[f32], slices: &Slices, x: usize, y: usize) -> f32 {
        let at = self.first + self.len() + y * self.width + x;
        slices.look_up(data, at, self.density_words())
    }

    /// The same between rows `y` and `y + 1`.
    #[inline]
    fn along_between(&self, data: &[f32], slices: &Slices, x: usize, y: usize, t: f32) -> f32 {
        float::lerp(
            self.along(data, slices, x, y),
            self.along(data, slices, x, y + 1),
            t,
        )
    }

    /// Sum of the rows before `y`.
    #[inline]
    fn below(&self, data: &[f32], slices: &Slices, y: usize) -> f32 {
        let at = self.first + 2 * self.len() + y;
        slices.look_up(data, at, self.density_words())
    }

    /// The numbers that [`Grid::sample`] takes to `u`, and the density there.
    #[inline]
    pub(super) fn invert(&self, data: &[f32], slices: &Slices, u: Vec2) -> Warped {
        let c = cell(self, u);
        let words = self.density_words();
        let (left, right) = ends(data, slices, self.first, self.width, words, c);
        let last = self.width - 1;
        let (r0, r1) = (
            self.along(data, slices, last, c.y),
            self.along(data, slices, last, c.y + 1),
        );
        let before = self.along_between(data, slices, c.x, c.y, c.t.y);
        let row = float::lerp(r0, r1, c.t.y);
        let x = (before + segment_area(left, right, c.t.x)) / row.max(f32::MIN_POSITIVE);
        let y = self.below(data, slices, c.y) + segment_area(r0, r1, c.t.y);
        Warped {
            u: Vec2::new(x, y),
            pdf: float::lerp(left, right, c.t.x) * self.per_square(),
        }
    }

    /// A point of the density.
    #[inline]
    pub(super) fn sample(&self, data: &[f32], slices: &Slices, u: Vec2) -> Warped {
        let (mut low, mut high) = (0, self.height - 2);
        // The last row that begins at or below u.y.
        while low < high {
            let middle = (low + high).div_ceil(2);
            if self.below(data, slices, middle) <= u.y {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        let row = low;
        let last = self.width - 1;
        let (r0, r1) = (
            self.along(data, slices, last, row),
            self.along(data, slices, last, row + 1),
        );
        let t_y = invert_segment_area(r0, r1, u.y - self.below(data, slices, row));
        let target = u.x * float::lerp(r0, r1, t_y);
        let (mut low, mut high) = (0, self.width - 2);
        while low < high {
            let middle = (low + high).div_ceil(2);
            if self.along_between(data, slices, middle, row, t_y) <= target {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        let c = Cell {
            x: low,
            y: row,
            t: Vec2::new(0.0, t_y),
        };
        let words = self.density_words();
        let (left, right) = ends(data, slices, self.first, self.width, words, c);
        let before = self.along_between(data, slices, low, row, t_y);
        let t_x = invert_segment_area(left, right, target - before);
        Warped {
            u: Vec2::new(
                (low as f32 + t_x) / (self.width - 1) as f32,
                (row as f32 + t_y) / (self.height - 1) as f32,
            ),
            pdf: float::lerp(left, right, t_x) * self.per_square(),
        }
    }
}

/// Area below the line from a to b on [0, t].
#[inline]
fn segment_area(a: f32, b: f32, t: f32) -> f32 {
    t * (a + 0.5 * t * (b - a))
}

/// The inverse of [`segment_area`] in t.
#[inline]
fn invert_segment_area(a: f32, b: f32, area: f32) -> f32 {
    let root = float::safe_sqrt(a * a + 2.0 * area * (b - a));
    let sum = a + root;
    if sum > 0.0 {
        (2.0 * area / sum).max(0.0).min(1.0)
    } else {
        0.0
    }
}
