//! Weights of the strategies of a full path, from the densities at its vertices.
//!
//! The recursion along subpaths ([`super::weight`]) needs densities that a subpath knows by itself. Where the regularisation of a
//! vertex depends on the rest of the path (Jendersie and Grosch 2019, section 3.5), its density p_hat does too, and the sum over
//! the strategies is made for each path anew, in time linear in its length.
//!
//! Vertices are x_0 on the light to x_k on the lens. With P_i the density per area of x_i for a light walk and R_i that for a camera
//! walk, the strategies with s and s + 1 vertices of the light subpath differ in x_s alone, and merging at x_i takes both of its
//! densities and the area eta of the kernel times the number of light walks:
//!
//! ```text
//! p_(s+1) / p_s = P_s / R_s,   p_merge,i = p_(i+1) eta_i R_i,   w = h(p) / sum h(p),
//! ```
//!
//! where x_0 of the strategy s = 1 has the density of next event estimation. Sums are in double precision: densities of
//! regularised mirrors are large, and their products over a path more so. A strategy counts where the two vertices that it
//! connects, or the one at which it merges, are no discrete events.
//!
//! Invariant (tests): equal to the weights of the recursion where a vertex's regularisation does not depend on the rest.
//!
//! Hosts only, because it needs the full path.

use super::strategies::Strategies;
use arrayvec::ArrayVec;
use glam::Vec3;

/// Most inner vertices of a path.
pub const MAX_INNER: usize = 64;

/// A vertex between the light and the lens.
#[derive(Clone, Copy, Debug)]
pub struct InnerVertex {
    /// Where it is.
    pub position: Vec3,
    /// Geometric normal.
    pub normal: Vec3,
    /// Density per solid angle with which a camera walk goes on to the vertex before.
    pub pdf_to_light: f32,
    /// Density per solid angle with which a light walk goes on to the next; of a discrete event both are one.
    pub pdf_to_sensor: f32,
    /// Whether it can be connected.
    pub is_connectable: bool,
    /// Whether light walks end here.
    pub is_one_way: bool,
}

impl InnerVertex {
    /// Density per area here of a density per solid angle at `from`.
    fn pdf_area(&self, pdf: f32, from: Vec3) -> f64 {
        let between = from - self.position;
        let distance2 = between.length_squared();
        let cosine = self.normal.dot(between).abs() / between.length();
        f64::from(pdf) * f64::from(cosine) / f64::from(distance2)
    }
}

/// The light's end of a path.
#[derive(Clone, Copy, Debug)]
pub struct LightStart {
    /// Density of the ray from x_0 to x_1 of a light walk, [`crate::scene::emitter::emission::EmissionDensity::product`].
    pub emission: f32,
    /// Density of next event estimation at x_1, per solid angle or of the choice.
    pub direct: f32,
    /// [`crate::scene::emitter::emission::light_cosine`].
    pub cosine: f32,
    /// Unit direction from x_1 to x_0.
    pub direction: Vec3,
    /// Whether no ray meets the light.
    pub is_delta: bool,
}

impl LightStart {
    /// No light.
    pub const NONE: LightStart = LightStart {
        emission: 0.0,
        direct: 0.0,
        cosine: 1.0,
        direction: Vec3::Z,
        is_delta: false,
    };
}

/// A strategy of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// That with so many vertices of the light subpath.
    Connects(usize),
    /// Merging at a vertex.
    Merges(usize),
}

/// A path as its weights see it.
#[derive(Clone, Debug)]
pub struct PathDensities {
    /// x_1 to x_(k-1).
    pub inner: ArrayVec<InnerVertex, MAX_INNER>,
    /// x_0.
    pub start: LightStart,
    /// Position of the lens point.
    pub sensor: Vec3,
    /// Density of x_(k-1) for a camera walk, per area perpendicular to its ray.
    pub first: f32,
}

/// Far above all that a weight distinguishes from zero, and far below what does not fit.
const LARGEST: f64 = 1e60;

impl PathDensities {
    /// The weight of `strategy`, one of the strategies of the path; `merging` is eta at a position, zero where nothing is merged.
    pub fn weight(
        &self,
        strategies: &Strategies,
        strategy: Strategy,
        merging: impl Fn(Vec3) -> f32,
    ) -> f32 {
        let k = self.inner.len() + 1;
        let h = |x: f64| {
            let x = if x < LARGEST { x } else { LARGEST };
            if strategies.heuristic.is_power {
                x * x
            } else {
                x
            }
        };
        // p_s over the p of `strategy`, for s from its own on upwards and then downwards.
        let (start, scale) = match strategy {
            Strategy::Connects(s) => (s, 1.0),
            Strategy::Merges(i) => {
                let eta = f64::from(merging(self.vertex(i).position));
                (i + 1, eta * self.density_from_sensor(i))
            }
        };
        let mut sum = 1.0;
        let mut add = |s: usize, ratio: f64| {
            if strategy != Strategy::Connects(s) && self.connects(strategies, s) {
                sum += h(ratio);
            }
            let at = s.wrapping_sub(1);
            if strategy != Strategy::Merges(at) && self.merges(at) {
                let eta = f64::from(merging(self.vertex(at).position));
                if eta > 0.0 {
                    sum += h(ratio * eta * self.density_from_sensor(at));
                }
            }
        };
        let mut ratio = 1.0 / scale;
        for s in start..=k {
            add(s, ratio);
            if s < k {
                ratio *= self.step(s);
            }
        }
        let mut ratio = 1.0 / scale;
        for s in (0..start).rev() {
            ratio /= self.step(s);
            add(s, ratio);
        }
        (1.0 / sum) as f32
    }

    fn vertex(&self, i: usize) -> &InnerVertex {
        &self.inner[i - 1]
    }

    /// R_i.
    fn density_from_sensor(&self, i: usize) -> f64 {
        let vertex = self.vertex(i);
        if i == self.inner.len() {
            let between = self.sensor - vertex.position;
            let cosine = vertex.normal.dot(between).abs() / between.length();
            return f64::from(self.first) * f64::from(cosine);
        }
        let next = self.vertex(i + 1);
        vertex.pdf_area(next.pdf_to_light, next.position)
    }

    /// p_(s+1) / p_s, bounded, for s below k.
    fn step(&self, s: usize) -> f64 {
        let start = &self.start;
        let ratio = match s {
            0 => f64::from(start.direct) / f64::from(self.vertex(1).pdf_to_light),
            1 => self.first_from_light() / self.density_from_sensor(1),
            _ => {
                let before = self.vertex(s - 1);
                let from_light = self
                    .vertex(s)
                    .pdf_area(before.pdf_to_sensor, before.position);
                from_light / self.density_from_sensor(s)
            }
        };
        // A NaN of densities that vanish counts as the largest.
        if ratio < LARGEST {
            ratio.max(1.0 / LARGEST)
        } else {
            LARGEST
        }
    }

    /// Density of the ray to x_1 per area there, over that of x_0 for next event estimation.
    fn first_from_light(&self) -> f64 {
        let start = &self.start;
        let cosine = self.vertex(1).normal.dot(start.direction).abs();
        f64::from(start.emission) * f64::from(cosine)
            / (f64::from(start.direct) * f64::from(start.cosine))
    }

    /// Whether some strategy has s vertices of the light subpath.
    fn connects(&self, strategies: &Strategies, s: usize) -> bool {
        let last = self.inner.len();
        let is_open = |i: usize| self.vertex(i).is_connectable;
        match s {
            0 => !self.start.is_delta,
            1 => is_open(1),
            _ if s > last => strategies.light_image && is_open(last) && self.passes(s - 2),
            _ => is_open(s - 1) && is_open(s) && self.passes(s - 2),
        }
    }

    /// Whether something is merged at a vertex of any path.
    fn merges(&self, i: usize) -> bool {
        (1..=self.inner.len()).contains(&i) && self.vertex(i).is_connectable && self.passes(i - 1)
    }

    /// Whether a light walk passes the first `count` inner vertices.
    fn passes(&self, count: usize) -> bool {
        self.inner[..count].iter().all(|v| !v.is_one_way)
    }
}
