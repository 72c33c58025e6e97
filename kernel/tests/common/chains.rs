//! Random chains whose geometry is known in f64: the reference of every Jacobian of the manifold.
//!
//! A vertex lies on a patch p(a, b) = p0 + a U + b V + q(a, b) N with q and its gradient zero at the vertex, so that (a, b)
//! are moves along the tangents. Its shading normal is a field of its own. Half vectors of moved vertices are computed from
//! these in f64, by definitions and not by the kernel's formulas.

// Each test file uses its part.
#![allow(dead_code)]

use super::dense::Dense;
use super::primitives::point;
use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};
use halflight_kernel::manifold::half_vector_form;
use halflight_kernel::manifold::{ChainVertex, vertex_kind};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::SurfacePoint;
use proptest::prelude::*;

/// Capacity of the tests' chains.
pub const N: usize = 12;

/// The shape of a patch around its vertex.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Plane,
    /// Signed radius.
    Sphere(f64),
    Cylinder(f64),
    /// Three curvatures and the height and frequency of waves.
    Bumpy([f64; 3], f64, f64),
}

/// A patch in f64.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub origin: DVec3,
    pub u: DVec3,
    pub v: DVec3,
    pub n: DVec3,
    pub shape: Shape,
    /// Added to the geometric normal: constant, per a, per b.
    pub tilt: [DVec3; 3],
}

impl Patch {
    fn height(&self, a: f64, b: f64) -> f64 {
        match self.shape {
            Shape::Plane => 0.0,
            Shape::Sphere(r) => r - r.signum() * (r * r - a * a - b * b).sqrt(),
            Shape::Cylinder(r) => r - r.signum() * (r * r - a * a).sqrt(),
            Shape::Bumpy([x, y, z], height, frequency) => {
                let wave = (frequency * a).cos() * (frequency * b).cos() - 1.0;
                0.5 * (x * a * a + y * b * b) + z * a * b + height * wave
            }
        }
    }

    /// The point at a move.
    pub fn position(&self, m: DVec2) -> DVec3 {
        self.origin + self.u * m.x + self.v * m.y + self.n * self.height(m.x, m.y)
    }

    /// The shading normal at a move.
    pub fn normal(&self, m: DVec2) -> DVec3 {
        let e = 1e-5;
        let slope = |d: DVec2| {
            let (p, q) = (m + d * e, m - d * e);
            (self.height(p.x, p.y) - self.height(q.x, q.y)) / (2.0 * e)
        };
        let n = self.n - self.u * slope(DVec2::X) - self.v * slope(DVec2::Y);
        (n.normalize() + self.tilt[0] + self.tilt[1] * m.x + self.tilt[2] * m.y).normalize()
    }

    /// The kernel's record under the parametrisation (a, b) = `m` (u, v).
    pub fn surface_point(&self, m: DMat2) -> SurfacePoint {
        let e = 1e-4;
        let n = |d: DVec2| self.normal(m * d);
        let dn = |d: DVec2| ((n(d * e) - n(-d * e)) / (2.0 * e)).as_vec3();
        let dp = |d: DVec2| {
            let d = m * d;
            (self.u * d.x + self.v * d.y).as_vec3()
        };
        let dp_du = dp(DVec2::X);
        SurfacePoint {
            position: self.origin.as_vec3(),
            position_error: 1e-6,
            geometric_normal: self.n.as_vec3(),
            frame: Frame::from_normal_tangent(self.normal(DVec2::ZERO).as_vec3(), dp_du),
            dp_du,
            dp_dv: dp(DVec2::Y),
            dn_du: dn(DVec2::X),
            dn_dv: dn(DVec2::Y),
            ..SurfacePoint::ZERO
        }
    }
}

/// What a strategy draws for a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    direction: Vec3,
    length: f64,
    kind: u32,
    eta: f64,
    slope: [f64; 2],
    shape: Shape,
    map: [f64; 4],
    tilt: [Vec3; 3],
    alpha: [f32; 2],
}

fn shape() -> impl Strategy<Value = Shape> + Clone {
    let radius = (0.4f64..5.0, any::<bool>()).prop_map(|(r, s)| if s { r } else { -r });
    prop_oneof![
        Just(Shape::Plane),
        radius.clone().prop_map(Shape::Sphere),
        radius.prop_map(Shape::Cylinder),
        (
            prop::array::uniform3(-2.0f64..2.0),
            0.0f64..0.05,
            1.0f64..6.0
        )
            .prop_map(|(k, h, f)| Shape::Bumpy(k, h, f)),
    ]
}

fn draw() -> impl Strategy<Value = Draw> + Clone {
    (
        (point(1.0), 0.4f64..2.5, 0u32..8, 1.2f64..2.4),
        prop::array::uniform2(-0.9f64..0.9),
        shape(),
        (-0.6f64..0.6, -1.0f64..1.0, 0.3f64..3.0, 0.3f64..3.0),
        (
            any::<bool>(),
            prop::array::uniform3(point(0.3)),
            prop::array::uniform2(0.01f32..0.7),
        ),
    )
        .prop_map(
            |(
                (d, length, kind, eta),
                slope,
                shape,
                (shear, turn, x, y),
                (shading, tilt, alpha),
            )| {
                let (s, c) = turn.sin_cos();
                Draw {
                    direction: d.try_normalize().unwrap_or(Vec3::X),
                    length,
                    kind: match kind {
                        0..4 => vertex_kind::REFLECTION,
                        7 => vertex_kind::INDEX_MATCHED,
                        _ => vertex_kind::REFRACTION,
                    },
                    eta: if kind == 5 { 1.0 / eta } else { eta },
                    slope,
                    shape,
                    map: [c * x, s * x, (shear * c - s) * y, (shear * s + c) * y],
                    tilt: if shading { tilt } else { [Vec3::ZERO; 3] },
                    alpha,
                }
            },
        )
}

/// A chain and its reference.
#[derive(Clone, Debug)]
pub struct TestChain {
    pub vertices: [ChainVertex; N],
    pub patches: Vec<Patch>,
    pub len: usize,
}

/// Kinds of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    Surface,
    Point,
    Direction,
}

fn end() -> impl Strategy<Value = End> + Clone {
    prop_oneof![Just(End::Surface), Just(End::Point), Just(End::Direction)]
}

/// Chains with 1 to `most` inner vertices. Half vectors are at least 0.2 long and 35 degrees above the horizon.
pub fn chain(most: usize) -> impl Strategy<Value = TestChain> {
    (prop::collection::vec(draw(), 3..most + 3), end(), end())
        .prop_filter_map("half vectors too short", |(draws, first, last)| {
            TestChain::build(&draws, first, last)
        })
}

impl TestChain {
    fn build(draws: &[Draw], first: End, last: End) -> Option<TestChain> {
        let len = draws.len();
        let mut positions = vec![DVec3::new(0.3, -0.2, 0.1)];
        for d in &draws[1..] {
            let step = d.direction.as_dvec3() * d.length;
            positions.push(positions[positions.len() - 1] + step);
        }
        let mut chain = TestChain {
            vertices: [ChainVertex::NONE; N],
            patches: vec![],
            len,
        };
        for (i, d) in draws.iter().enumerate() {
            let inner = i > 0 && i + 1 < len;
            let wi = (positions[i.saturating_sub(1)] - positions[i]).try_normalize();
            let wo = (positions[(i + 1).min(len - 1)] - positions[i]).try_normalize();
            let (mut kind, mut eta) = (d.kind, d.eta);
            if kind != vertex_kind::REFRACTION {
                eta = 1.0;
            }
            let mut around = d.direction.as_dvec3();
            if inner {
                let sum = wi? + wo? * eta;
                if kind == vertex_kind::INDEX_MATCHED {
                    around = wo?;
                } else if sum.length() < 0.2 {
                    return None;
                } else {
                    around = sum.normalize();
                }
            } else {
                kind = vertex_kind::PINNED_POSITION;
            }
            let (s, t) = around.any_orthonormal_pair();
            let n = (around + s * d.slope[0] + t * d.slope[1]).normalize();
            let (u, v) = n.any_orthonormal_pair();
            let patch = Patch {
                origin: positions[i],
                u,
                v,
                n,
                shape: d.shape,
                tilt: d.tilt.map(Vec3::as_dvec3),
            };
            let surface = patch.surface_point(DMat2::from_cols_array(&d.map));
            let mut vertex = ChainVertex::from_surface(&surface);
            if inner {
                let transmits = kind != vertex_kind::REFLECTION;
                vertex = vertex.scattering(transmits, eta as f32, Vec2::from_array(d.alpha));
                assert_eq!(vertex.kind, kind);
                let h = (wi? + wo? * eta).normalize();
                if kind != vertex_kind::INDEX_MATCHED
                    && h.dot(patch.normal(DVec2::ZERO)).abs() < 0.5
                {
                    return None;
                }
            }
            chain.vertices[i] = vertex;
            chain.patches.push(patch);
        }
        for (end, i, neighbour) in [(first, 0, 1), (last, len - 1, len - 2)] {
            let (x, y) = (positions[i].as_vec3(), positions[neighbour].as_vec3());
            if end != End::Surface {
                let vertex = match end {
                    End::Point => ChainVertex::point(x),
                    _ => ChainVertex::pinned_direction(x, (y - x).normalize()),
                };
                let facing = vertex.facing(y);
                let (u, v) = (facing.tangent_u.as_dvec3(), facing.tangent_v.as_dvec3());
                chain.vertices[i] = vertex;
                chain.patches[i] = Patch {
                    u,
                    v,
                    n: u.cross(v),
                    shape: Shape::Plane,
                    tilt: [DVec3::ZERO; 3],
                    ..chain.patches[i]
                };
            }
        }
        Some(chain)
    }

    /// The tangents in which the kernel measures moves of vertex `i`.
    fn tangents(&self, i: usize) -> (DVec3, DVec3) {
        let neighbour = if i == 0 { 1 } else { i - 1 };
        let x = self.vertices[i].facing(self.vertices[neighbour].position);
        (x.tangent_u.as_dvec3(), x.tangent_v.as_dvec3())
    }

    /// A move in the kernel's tangents as one of the patch.
    pub fn patch_move(&self, i: usize, m: DVec2) -> DVec2 {
        let (u, v) = self.tangents(i);
        let d = u * m.x + v * m.y;
        DVec2::new(self.patches[i].u.dot(d), self.patches[i].v.dot(d))
    }

    /// The position of vertex `i` after a move.
    pub fn position(&self, i: usize, m: DVec2) -> DVec3 {
        self.patches[i].position(self.patch_move(i, m))
    }

    /// The constraint of vertex `i` after moves of all vertices.
    pub fn constraint(&self, i: usize, form: u32, moves: &[DVec2]) -> DVec2 {
        let p = |i: usize| self.position(i, moves[i]);
        let x = &self.vertices[i];
        if i == 0 || i + 1 == self.len {
            let neighbour = if i == 0 { 1 } else { i - 1 };
            if x.kind != vertex_kind::PINNED_DIRECTION {
                return moves[i];
            }
            let (s, t) = self.tangents(i);
            let w = (p(neighbour) - p(i)).normalize();
            return DVec2::new(s.dot(w), t.dot(w));
        }
        let wi = (p(i - 1) - p(i)).normalize();
        let wo = (p(i + 1) - p(i)).normalize();
        let n = self.patches[i].normal(self.patch_move(i, moves[i]));
        let r = x.reference.as_dvec3();
        let s = (r - n * n.dot(r)).normalize();
        let t = n.cross(s);
        let mut h = wi + wo * f64::from(x.eta);
        if x.kind == vertex_kind::INDEX_MATCHED {
        } else if form == half_vector_form::SLOPE {
            h /= h.dot(n);
        } else {
            h = h.normalize() * h.dot(n).signum();
        }
        DVec2::new(s.dot(h), t.dot(h))
    }

    /// Central differences: d constraint i / d vertex j.
    pub fn difference(&self, i: usize, j: usize, form: u32) -> DMat2 {
        let e = 1e-4;
        let column = |d: DVec2| {
            let mut moves = vec![DVec2::ZERO; self.len];
            let mut at = |f: f64| {
                moves[j] = d * (f * e);
                self.constraint(i, form, &moves)
            };
            // Fourth order.
            ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * e)
        };
        DMat2::from_cols(column(DVec2::X), column(DVec2::Y))
    }

    /// J by central differences, all rows and columns.
    pub fn jacobian(&self, form: u32) -> Dense {
        let mut dense = Dense::zeros(2 * self.len);
        for i in 0..self.len {
            for j in i.saturating_sub(1)..(i + 2).min(self.len) {
                dense.set(i, j, self.difference(i, j, form));
            }
        }
        dense
    }

    /// Cosines of the geometric normals of inner vertices with their edges, the least of them.
    pub fn least_cosine(&self) -> f64 {
        let mut least = 1.0f64;
        for i in 0..self.len - 1 {
            let w = (self.patches[i + 1].origin - self.patches[i].origin).normalize();
            for j in [i, i + 1] {
                if self.vertices[j].geometric_normal.length_squared() > 0.0 {
                    least = least.min(self.patches[j].n.dot(w).abs());
                }
            }
        }
        least
    }
}
