//! Polygons to triangles.
//!
//! A convex polygon becomes the fan around its first corner, which is what Mitsuba makes of it, so that triangle indices
//! agree. A fan of a concave polygon leaves the polygon; there, ears are cut off instead (Meisters, "Polygons have
//! ears", 1975) in the plane of the polygon's area vector (Newell's sum of the edges' cross products). A polygon of n
//! corners always yields n - 2 triangles that use its corners only.
//!
//! Cutting ears takes cubic time at worst. A budget per file bounds it; polygons beyond the budget become fans.

use super::{cross, dot, subtract, to_f64};

/// Corner visits that one file may spend on cutting ears: about a second.
const BUDGET: u64 = 1 << 28;

/// Triangulates the polygons of one file.
pub(super) struct Triangulator {
    budget: u64,
    points: Vec<[f64; 2]>,
    ring: Vec<usize>,
}

impl Triangulator {
    pub(super) fn new() -> Triangulator {
        Triangulator {
            budget: BUDGET,
            points: Vec::new(),
            ring: Vec::new(),
        }
    }

    /// Passes the triangles of a polygon to `emit`, as indices into `corners`, which holds three positions at least.
    pub(super) fn polygon(&mut self, corners: &[[f32; 3]], mut emit: impl FnMut([usize; 3])) {
        let n = corners.len();
        if n > 3 && self.budget > 0 {
            self.project(corners);
            if !self.is_convex() {
                self.cut_ears(&mut emit);
                return;
            }
        }
        for k in 2..n {
            emit([0, k - 1, k]);
        }
    }

    /// Corners in the coordinate plane that faces the polygon most, anticlockwise.
    fn project(&mut self, corners: &[[f32; 3]]) {
        let origin = to_f64(corners[0]);
        let mut area = [0.0; 3];
        for k in 2..corners.len() {
            let a = subtract(to_f64(corners[k - 1]), origin);
            let b = subtract(to_f64(corners[k]), origin);
            let c = cross(a, b);
            for axis in 0..3 {
                area[axis] += c[axis];
            }
        }
        let mut axis = 0;
        for k in 1..3 {
            if area[k].abs() > area[axis].abs() {
                axis = k;
            }
        }
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if area[axis] < 0.0 {
            std::mem::swap(&mut u, &mut v);
        }
        self.points.clear();
        self.points.extend(corners.iter().map(|p| {
            let p = subtract(to_f64(*p), origin);
            [p[u], p[v]]
        }));
    }

    fn is_convex(&self) -> bool {
        let n = self.points.len();
        (0..n).all(|k| {
            let (a, b, c) = (
                self.points[k],
                self.points[(k + 1) % n],
                self.points[(k + 2) % n],
            );
            // Straight corners pass, and so do those that only rounding bends inwards.
            orientation(a, b, c) >= -1e-6 * (distance(a, b) * distance(b, c))
        })
    }

    fn cut_ears(&mut self, emit: &mut impl FnMut([usize; 3])) {
        self.ring.clear();
        self.ring.extend(0..self.points.len());
        while self.ring.len() > 3 {
            let n = self.ring.len();
            // A simple polygon has two ears at least; a self-intersecting one may have none, then any corner goes.
            let ear = (0..n).find(|&k| self.is_ear(k)).unwrap_or(0);
            emit(self.corner(ear));
            self.ring.remove(ear);
        }
        emit([self.ring[0], self.ring[1], self.ring[2]]);
    }

    /// The ring's corner `k` between its neighbours.
    fn corner(&self, k: usize) -> [usize; 3] {
        let n = self.ring.len();
        [
            self.ring[(k + n - 1) % n],
            self.ring[k],
            self.ring[(k + 1) % n],
        ]
    }

    fn is_ear(&mut self, k: usize) -> bool {
        let indices = self.corner(k);
        let [a, b, c] = indices.map(|i| self.points[i]);
        if self.budget == 0 || orientation(a, b, c) <= 0.0 {
            return false;
        }
        self.budget = self.budget.saturating_sub(self.ring.len() as u64);
        self.ring.iter().all(|&i| {
            let p = self.points[i];
            // Corners that coincide with those of the ear (bridges to holes) do not block it.
            indices.contains(&i)
                || p == a
                || p == b
                || p == c
                || orientation(a, b, p) < 0.0
                || orientation(b, c, p) < 0.0
                || orientation(c, a, p) < 0.0
        })
    }
}

/// Twice the signed area of a triangle, positive when anticlockwise.
fn orientation(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1], 0.0];
    dot(d, d).sqrt()
}
