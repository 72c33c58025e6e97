//! Densities of all strategies that can make a path, multiplied out vertex by vertex.
//!
//! Vertex i of x_0 ... x_k has the density f_i when it is sampled from the light and r_i when it is sampled from the sensor, per
//! area, but for light from infinity per solid angle at x_1. A specular vertex has the density one both ways per solid angle, and
//! is neither connected nor merged.

use glam::Vec3;
use halflight_kernel::bsdf::{Bsdf, mode};
use halflight_kernel::scene::emitter::emission::{self, is_delta, is_infinite};
use halflight_kernel::scene::{SurfacePoint, Tables, camera, emitter, emitter_kind};

/// The end of a path at an emitter.
#[derive(Clone, Copy)]
pub struct LightEndPoint {
    pub emitter: u32,
    /// Where light comes from, if not from infinity.
    pub point: SurfacePoint,
    /// Unit direction of the light.
    pub direction: Vec3,
}

/// A path.
pub struct FullPath {
    pub light: LightEndPoint,
    /// x_1 ... x_(k-1).
    pub inner: Vec<SurfacePoint>,
    /// The lens point x_k.
    pub lens: Vec3,
}

impl FullPath {
    /// Whether positions of its vertices say well enough where its edges go: none is short, none lies in a surface.
    pub fn is_well_conditioned(&self, tables: &Tables<'_>) -> bool {
        let first = usize::from(is_infinite(self.kind(tables)));
        let is_long =
            (first..self.k()).all(|i| self.position(i).distance(self.position(i + 1)) > 0.02);
        let is_steep = self.inner.iter().enumerate().all(|(i, point)| {
            let leaves = |to| {
                let d = self.direction(tables, i + 1, to);
                point.geometric_normal.dot(d).abs() > 1e-4
            };
            leaves(i) && leaves(i + 2)
        });
        is_long && is_steep
    }

    fn k(&self) -> usize {
        self.inner.len() + 1
    }

    fn kind(&self, tables: &Tables<'_>) -> u32 {
        tables.emitters[self.light.emitter as usize].kind
    }

    fn position(&self, i: usize) -> Vec3 {
        match i {
            0 => self.light.point.position,
            i if i == self.k() => self.lens,
            i => self.inner[i - 1].position,
        }
    }

    /// Unit direction from a vertex to a neighbour.
    fn direction(&self, tables: &Tables<'_>, from: usize, to: usize) -> Vec3 {
        let is_infinite = is_infinite(self.kind(tables));
        match (from, to) {
            (0, _) if is_infinite => self.light.direction,
            (_, 0) if is_infinite => -self.light.direction,
            _ => (self.position(to) - self.position(from)).normalize(),
        }
    }

    /// Solid angle at `from` per area at the neighbour `to`.
    fn per_area(&self, tables: &Tables<'_>, from: usize, to: usize) -> f64 {
        if to == 0 && is_infinite(self.kind(tables)) {
            return 1.0;
        }
        let normal = match to {
            0 => self.light.point.geometric_normal,
            to if to == self.k() => camera::optical_axis(&tables.camera),
            to => self.inner[to - 1].geometric_normal,
        };
        let d = self.direction(tables, from, to);
        let distance2 = (self.position(to) - self.position(from)).length_squared();
        f64::from(normal.dot(d).abs() / distance2)
    }

    fn bsdf(&self, tables: &Tables<'_>, at: usize, from: usize) -> (Bsdf, Vec3) {
        let point = &self.inner[at - 1];
        let wi = point.frame.to_local(self.direction(tables, at, from));
        (Bsdf::at(tables, point, wi, mode::RADIANCE), wi)
    }

    fn is_smooth(&self, tables: &Tables<'_>, at: usize) -> bool {
        self.bsdf(tables, at, at + 1).0.has_smooth()
    }

    /// Density per solid angle of going on to `to` for a walk that comes from `from`.
    fn pdf(&self, tables: &Tables<'_>, at: usize, from: usize, to: usize) -> f64 {
        let (bsdf, wi) = self.bsdf(tables, at, from);
        if !bsdf.has_smooth() {
            return 1.0;
        }
        let wo = self.inner[at - 1]
            .frame
            .to_local(self.direction(tables, at, to));
        f64::from(bsdf.pdf(tables.data, wi, wo))
    }

    /// f_0 ... f_k.
    fn light_densities(&self, tables: &Tables<'_>) -> Vec<f64> {
        let k = self.k();
        let direction = self.direction(tables, 0, 1);
        let emitted = emission::density(tables, self.light.emitter, &self.light.point, direction);
        let (position, direction) = (f64::from(emitted.position), f64::from(emitted.direction));
        let mut f = vec![0.0; k + 1];
        f[0] = position;
        f[1] = direction * self.per_area(tables, 0, 1);
        if is_infinite(self.kind(tables)) {
            f[0] = direction;
            f[1] = match self.inner.first() {
                Some(first) => {
                    position * f64::from(first.geometric_normal.dot(self.light.direction).abs())
                }
                // Light straight from infinity is no strategy at the lens.
                None => 0.0,
            };
        }
        for i in 2..=k {
            f[i] = self.pdf(tables, i - 1, i - 2, i) * self.per_area(tables, i - 1, i);
        }
        if camera::pdf_lens_area(&tables.camera) <= 0.0
            || k == 1 && self.kind(tables) != emitter_kind::AREA
        {
            f[k] = 0.0;
        }
        f
    }

    /// r_0 ... r_k.
    fn sensor_densities(&self, tables: &Tables<'_>) -> Vec<f64> {
        let k = self.k();
        let mut r = vec![0.0; k + 1];
        let lens = f64::from(camera::pdf_lens_area(&tables.camera));
        r[k] = if lens > 0.0 { lens } else { 1.0 };
        let kind = self.kind(tables);
        if k == 1 && is_infinite(kind) {
            r[0] = 1.0;
        } else {
            let seen = match k {
                1 => &self.light.point,
                _ => &self.inner[k - 2],
            };
            let cosine = self
                .direction(tables, k, k - 1)
                .dot(seen.geometric_normal)
                .abs();
            let distance = seen.position.distance(self.lens);
            let pdf = camera::pdf_perpendicular_area(tables, seen.position, distance);
            r[k - 1] = f64::from(pdf * cosine);
        }
        for i in 0..k - 1 {
            r[i] = self.pdf(tables, i + 1, i + 2, i) * self.per_area(tables, i + 1, i);
        }
        if is_delta(kind) {
            r[0] = 0.0;
        }
        r
    }

    /// Densities of the strategies with s = 0 ... k + 1 light vertices, and of merging at x_1 ... x_(k-1), each with `eta` of its
    /// position as the area of a photon.
    pub fn densities(&self, tables: &Tables<'_>, eta: impl Fn(Vec3) -> f64) -> Vec<f64> {
        let k = self.k();
        let (f, r) = (self.light_densities(tables), self.sensor_densities(tables));
        let smooth: Vec<bool> = (0..=k)
            .map(|i| i == 0 || i == k || self.is_smooth(tables, i))
            .collect();
        let is_area = self.kind(tables) == emitter_kind::AREA;
        let direct = if k > 1 {
            let pdf = emitter::pdf_direct_of(
                tables,
                self.light.emitter,
                self.position(1),
                &self.light.point,
                self.direction(tables, 0, 1),
            );
            let is_per_solid_angle = is_area;
            let per = if is_per_solid_angle {
                self.per_area(tables, 1, 0)
            } else {
                1.0
            };
            f64::from(pdf) * per
        } else if is_area {
            f[0]
        } else {
            0.0
        };
        let connected = (0..=k + 1).map(|s| {
            let is_possible = s == 0 || s == k + 1 || smooth[s - 1] && smooth[s];
            let light: f64 = match s {
                1 => direct,
                s => f[..s].iter().product(),
            };
            light * r[s..].iter().product::<f64>() * f64::from(u8::from(is_possible))
        });
        let merged = (1..k).map(|i| {
            let both = f[..=i].iter().product::<f64>() * r[i..].iter().product::<f64>();
            eta(self.position(i)) * both * f64::from(u8::from(smooth[i]))
        });
        connected.chain(merged).collect()
    }

    /// The strategy that merges at x_i among the [`FullPath::densities`].
    pub fn merged_at(&self, i: usize) -> usize {
        self.k() + 1 + i
    }
}
