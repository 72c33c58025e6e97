//! Light that passes through a box of space, in voxels: the volumetric inspection tool (Reiner et al. 2012, "Selective Inspection and
//! Interactive Visualization of Light Transport in Virtual Scenes"; Kaplanyan 2017, section 9.1.2).
//!
//! A virtual box holds a homogeneous medium of scattering coefficient s and extinction coefficient e, which scatters light once and
//! evenly over all directions. Light walks are those of light tracing, and do not know of it. Each of their segments, of flux Phi,
//! adds to every voxel that it crosses the integral of what is left of it along its way there,
//!
//! ```text
//! phi_v = 1 / (N V) sum_walks sum_segments Phi  int_(t0)^(t1) exp(-e (d + t)) dt,
//! ```
//!
//! with V the voxel's volume, N the number of walks and d the way through the box before the segment: an unbiased estimate of the mean
//! fluence rate in the voxel, in W/m^2. A ray of the sensor gathers along its way through the box
//!
//! ```text
//! L = int s / (4 pi) phi(t) exp(-e t) dt,
//! ```
//!
//! exactly for voxels of constant phi. Which paths count is said by an expression in which the sensor stands for the medium: `L S+ E` is
//! light that mirrors and glass have thrown there.
//! Invariants (tests): lengths in voxels add up to that in the box; phi is I / d^2 around a point light, and less by exp(-e d).
//!
//! Hosts only: grids are in their memory.

use super::bidirectional::Bidirectional;
use crate::math::{Ray, Rgb, float};
use crate::path::rules::step;
use crate::path::{PathExpressions, PathStates, Scattered, ShadingPoint, Walk};
use crate::sampler::Sampler;
use crate::scene::{SceneView, Traverse};
use core::f32::consts::PI;
use glam::Vec3;

/// A box along the axes of the world, in voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelGrid {
    /// Its least corner.
    pub low: Vec3,
    /// Its greatest.
    pub high: Vec3,
    /// Voxels along each axis, none of them zero.
    pub counts: [u32; 3],
    /// Scattering coefficient s, per unit of length.
    pub scattering: f32,
    /// Extinction coefficient e.
    pub extinction: f32,
}

impl VoxelGrid {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.counts.iter().map(|n| *n as usize).product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Volume of a voxel.
    pub fn voxel_volume(&self) -> f32 {
        (self.high - self.low).element_product() / self.len() as f32
    }

    /// Index of a voxel, x fastest.
    fn index(&self, cell: [u32; 3]) -> usize {
        let [nx, ny, _] = self.counts.map(|n| n as usize);
        (cell[2] as usize * ny + cell[1] as usize) * nx + cell[0] as usize
    }

    /// The parts of a ray, no farther than `t_max`, in the voxels that it crosses: `take` gets index and distances (a three-dimensional
    /// digital differential analyser, Amanatides and Woo 1987).
    pub fn along(&self, ray: &Ray, t_max: f32, mut take: impl FnMut(usize, f32, f32)) {
        let (origin, direction) = (ray.origin, ray.direction);
        let (mut t, mut end) = (0.0_f32, t_max);
        for axis in 0..3 {
            let (a, b) = (
                self.low[axis] - origin[axis],
                self.high[axis] - origin[axis],
            );
            if direction[axis] == 0.0 {
                if a > 0.0 || b < 0.0 {
                    return;
                }
                continue;
            }
            let (t0, t1) = (a / direction[axis], b / direction[axis]);
            t = t.max(t0.min(t1));
            end = end.min(t0.max(t1));
        }
        if !(t < end) {
            return;
        }
        let size = (self.high - self.low)
            / Vec3::new(
                self.counts[0] as f32,
                self.counts[1] as f32,
                self.counts[2] as f32,
            );
        let position = origin + direction * t;
        let mut cell = [0_u32; 3];
        let mut next = [f32::MAX; 3];
        for axis in 0..3 {
            let at = (position[axis] - self.low[axis]) / size[axis];
            cell[axis] = (at.max(0.0) as u32).min(self.counts[axis] - 1);
            let side = cell[axis] + u32::from(direction[axis] > 0.0);
            if direction[axis] != 0.0 {
                let border = self.low[axis] + side as f32 * size[axis];
                next[axis] = (border - origin[axis]) / direction[axis];
            }
        }
        // Each step leaves a cell along one axis: there are no more than this, whatever rounding says.
        for _ in 0..self.counts.iter().sum::<u32>() + 3 {
            let axis = if next[0] <= next[1] && next[0] <= next[2] {
                0
            } else if next[1] <= next[2] {
                1
            } else {
                2
            };
            let leave = next[axis].min(end);
            if leave > t {
                take(self.index(cell), t, leave);
                t = leave;
            }
            if !(next[axis] < end) {
                return;
            }
            let is_last = if direction[axis] > 0.0 {
                cell[axis] + 1 == self.counts[axis]
            } else {
                cell[axis] == 0
            };
            if is_last {
                return;
            }
            if direction[axis] > 0.0 {
                cell[axis] += 1;
            } else {
                cell[axis] -= 1;
            }
            next[axis] += size[axis] / float::abs(direction[axis]);
        }
    }

    /// Integral of exp(-e t) from one distance to another.
    fn attenuated_length(&self, from: f32, to: f32) -> f32 {
        let e = self.extinction;
        let depth = e * (to - from);
        // (1 - exp(-depth)) / e, and its limit.
        let length = if depth < 1e-4 {
            (to - from) * (1.0 - 0.5 * depth)
        } else {
            -float::exp_m1(-depth) / e
        };
        float::exp(-e * from) * length
    }

    /// One light walk; `add` takes what it leaves in voxels, to be divided by their volume and the number of walks.
    pub fn trace_light<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        algorithm: &Bidirectional<'_>,
        expressions: Option<&PathExpressions<'_>>,
        sampler: &mut S,
        mut add: impl FnMut(usize, Rgb),
    ) {
        let connector = &algorithm.connector;
        let start = algorithm.emit(sampler);
        if !start.is_some() || connector.rules.max_depth == 0 {
            return;
        }
        let mut walk = Walk::from_emitter(&start);
        let mut states = expressions.map(|e| PathStates::at_emitter(e, start.emitter));
        let mut site = ShadingPoint::NONE;
        let mut passed = 0.0;
        let mut next = step::TRACE;
        while next == step::TRACE {
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            let t_max = if hit.is_hit() { hit.t } else { f32::MAX };
            let counted = match (expressions, &states) {
                (Some(expressions), Some(states)) => states.reach_sensor(expressions).of(0),
                _ => Vec3::ONE,
            };
            let flux = walk.subpath.throughput * counted;
            let mut first = f32::MAX;
            let mut last = 0.0;
            self.along(&walk.subpath.ray, t_max, |index, t0, t1| {
                first = first.min(t0);
                last = t1;
                if flux.max_element() > 0.0 {
                    let length = self.attenuated_length(passed + t0 - first, passed + t1 - first);
                    add(index, flux * length);
                }
            });
            if first < last {
                passed += last - first;
            }
            let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
            (_, next) = connector.arrive(&mut walk, &hit, &mut site);
            if next != step::SCATTER {
                continue;
            }
            let at = site.interaction(direction);
            let h = connector.strategies.heuristic;
            next = walk.scatter(connector.tables, &connector.rules, h, sampler, &at);
            if next == step::TRACE
                && walk.subpath.depth > depth
                && let (Some(expressions), Some(states)) = (expressions, &mut states)
            {
                let wo = at.effective(walk.subpath.ray.direction);
                let data = connector.tables.data;
                let happened = Scattered::sampled(at.bsdf, data, at.wi, wo, walk.event);
                states.advance(expressions, &expressions.from_light, at.point, &happened);
                if states.is_dead() {
                    return;
                }
            }
        }
    }

    /// What the medium scatters along a ray, no farther than `t_max`, for the fluence rates of the voxels; and the transmittance.
    pub fn scattered(&self, fluence: &[Rgb], ray: &Ray, t_max: f32) -> (Rgb, f32) {
        let mut sum = Vec3::ZERO;
        let (mut first, mut last) = (f32::MAX, 0.0);
        self.along(ray, t_max, |index, t0, t1| {
            first = first.min(t0);
            last = t1;
            sum += fluence[index] * self.attenuated_length(t0 - first, t1 - first);
        });
        let through = if first < last {
            float::exp(-self.extinction * (last - first))
        } else {
            1.0
        };
        (sum * (self.scattering / (4.0 * PI)), through)
    }
}
