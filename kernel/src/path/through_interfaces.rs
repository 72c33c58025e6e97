//! Connections of a surface with a point of a light through refracting interfaces (Hanika, Droske and Fascione 2015, "Manifold
//! Next Event Estimation").
//!
//! The straight line from the surface x_k to the point x_0 of a light meets interfaces x_(k-1) ... x_1 of (rough) glass. They are
//! the start of a walk ([`crate::manifold::walk`]) to the path whose half vectors are zero at smooth interfaces and
//! drawn at rough ones, from the slopes of GGX,
//!
//! ```text
//! p(h) = 1 / (pi alpha^2 (1 + |h|^2 / alpha^2)^2),
//! ```
//!
//! whatever the model: all of the plane must have a density. With f what the path carries in the measure of camera walks, over the
//! half vectors instead of positions (as in the mutations of `transport/markov/half_vector`), the estimate is
//!
//! ```text
//! f M / (p(x_0) prod p(h_i)),   M = G(x_k <-> x_0) / |i_k.n_k| prod_(i=1)^(k-1) m_i.
//! ```
//!
//! **Assumption**: a start finds one path. Other paths with the same half vectors and ends, as behind a lens beyond its focus, are
//! found by no walk of the same start; [`Interfaces::is_found_by_walk`] returns whether a path is the one, so that what other techniques
//! find can be counted where this one does not. So light that other techniques find keeps its mean, and light of points,
//! which nothing else finds through smooth interfaces, is complete where walks are unique.
//!
//! Hosts only: it holds surface points.

use super::rules::PathRules;
use super::specular::discrete;
use super::visibility::pass_through;
use crate::bsdf::{Bsdf, event, fresnel, mode};
use crate::manifold::chain::{ChainJacobian, generalized_geometry_term, scattering_measure};
use crate::manifold::walk::{WalkOptions, is_same_path, walk};
use crate::manifold::{ChainVertex, half_vector_form, vertex_kind};
use crate::math::float::{abs, sqr, sqrt};
use crate::math::{Ray, Rgb, float};
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, NONE, SceneView, SurfacePoint, Tables, Traverse, lobe_kind};
use glam::{Vec2, Vec3};

/// Most interfaces.
pub const MAX_INTERFACES: usize = 6;

/// Most vertices of a chain.
const N: usize = MAX_INTERFACES + 2;

const FORM: u32 = half_vector_form::SLOPE;

/// Half vectors of a chain, by vertex.
pub type HalfVectors = [Vec2; N];

/// The chain of a light, interfaces and a surface.
#[derive(Clone, Copy, Debug)]
pub struct Interfaces {
    /// From the light to the surface.
    pub vertices: [ChainVertex; N],
    /// Their number; two without interfaces.
    pub len: usize,
}

/// What a chain carries.
#[derive(Clone, Copy, Debug)]
pub struct ChainThroughput {
    /// f M, but for the light and for the scattering at the surface.
    pub value: Rgb,
    /// Unit direction from the surface.
    pub direction: Vec3,
    /// Unit direction from the light.
    pub outgoing: Vec3,
}

/// Whether a material does nothing but refract and reflect at one interface, and its roughness, zero where it is smooth.
pub fn interface(bsdf: &Bsdf) -> Option<f32> {
    if bsdf.lobe_count() != 1 {
        return None;
    }
    let lobe = bsdf.lobe(0);
    match lobe.kind {
        lobe_kind::DIELECTRIC => Some(0.0),
        lobe_kind::ROUGH_DIELECTRIC => Some(bsdf.roughness()),
        _ => None,
    }
}

/// The point with all of its surface.
fn looked_up<const DETAIL: u32>(tables: &Tables<'_>, x: &ChainVertex) -> SurfacePoint {
    let hit = Hit {
        t: 0.0,
        b1: x.barycentric.x,
        b2: x.barycentric.y,
        primitive: x.primitive,
        instance: x.instance,
    };
    surface_with::<DETAIL>(tables, &Ray::new(x.position, x.geometric_normal), &hit)
}

/// The vertex of an interface that light passes on its way between two directions.
pub fn interface_vertex(
    point: &SurfacePoint,
    bsdf: &Bsdf,
    alpha: f32,
    to_light: Vec3,
) -> ChainVertex {
    let cosine = point.frame.n.dot(to_light);
    let eta = fresnel::relative_eta(cosine, bsdf.lobe(0).eta.x);
    ChainVertex::from_surface(point).scattering(true, eta, Vec2::splat(alpha))
}

impl Interfaces {
    /// A surface and a light, with nothing between them.
    pub fn between(light: ChainVertex, surface: &SurfacePoint) -> Interfaces {
        let mut vertices = [ChainVertex::NONE; N];
        vertices[0] = light;
        vertices[1] = ChainVertex::from_surface(surface);
        Interfaces { vertices, len: 2 }
    }

    /// Adds an interface next to the light; returns whether there was space.
    pub fn push(&mut self, interface: ChainVertex) -> bool {
        if self.len >= N {
            return false;
        }
        let mut i = self.len;
        while i > 1 {
            self.vertices[i] = self.vertices[i - 1];
            i -= 1;
        }
        self.vertices[1] = interface;
        self.len += 1;
        true
    }

    /// What the straight line between the ends meets; nothing if that is no interface, or if it meets nothing.
    pub fn on_line<T: Traverse>(
        view: &SceneView<'_, T>,
        light: &ChainVertex,
        surface: &SurfacePoint,
        bsdf: &mut Bsdf,
    ) -> Option<Interfaces> {
        let tables = &view.tables;
        let mut chain = Interfaces::between(*light, surface);
        let mut ray = surface.segment_to(light.position);
        // What emits light may stand in its own way, within rounding.
        ray.t_max *= 1.0 - 1e-4;
        let direction = ray.direction;
        loop {
            let hit = view.traverse.closest_hit(&ray);
            if !hit.is_hit() {
                break;
            }
            let point = surface_with::<{ detail::CURVATURE }>(tables, &ray, &hit);
            if point.material == NONE {
                return None;
            }
            let wi = point.frame.to_local(-direction);
            bsdf.look_up(tables, &point, wi, mode::RADIANCE);
            let alpha = interface(bsdf)?;
            let vertex = interface_vertex(&point, bsdf, alpha, direction);
            // Light that is not bent goes straight, and needs no walk.
            if vertex.kind == vertex_kind::INDEX_MATCHED || !chain.push(vertex) {
                return None;
            }
            pass_through(&mut ray, &point);
            if ray.t_max <= 0.0 {
                break;
            }
        }
        (chain.len > 2).then_some(chain)
    }

    /// Whether interfaces are of the same kind as those of another chain.
    fn has_kinds_of(&self, other: &Interfaces) -> bool {
        self.len == other.len
            && (1..self.len - 1).all(|i| {
                let (a, b) = (&self.vertices[i], &other.vertices[i]);
                a.material == b.material && a.kind == b.kind && a.eta == b.eta
            })
    }

    fn jacobian(&self) -> ChainJacobian<N> {
        ChainJacobian::new(&self.vertices, self.len, FORM)
    }

    fn options(&self, tables: &Tables<'_>) -> WalkOptions {
        let length: f32 = (1..self.len)
            .map(|i| (self.vertices[i].position - self.vertices[i - 1].position).length())
            .sum();
        let radius = tables.info.radius;
        WalkOptions::new(length.max(0.02 * radius).min(radius))
    }

    /// The chain with other half vectors.
    pub fn with<T: Traverse>(
        &self,
        view: &SceneView<'_, T>,
        target: &HalfVectors,
    ) -> Option<Interfaces> {
        let options = self.options(&view.tables);
        let jacobian = self.jacobian();
        let found = walk(view, &self.vertices, &jacobian, target, &options);
        // A walk of no steps has looked at the last edge only, and a straight line has looked at all of them.
        found.is_converged().then_some(Interfaces {
            vertices: found.vertices,
            len: self.len,
        })
    }

    /// Half vectors drawn for the rough interfaces, and their density.
    pub fn draw<S: Sampler>(&self, sampler: &mut S) -> (HalfVectors, f32) {
        let mut target = [Vec2::ZERO; N];
        let mut pdf = 1.0;
        for i in 1..self.len - 1 {
            let alpha = self.vertices[i].alpha.x;
            if alpha > 0.0 {
                let u = sampler.next_2d();
                let radius = alpha * sqrt(u.x / (1.0 - u.x).max(1e-7));
                let (s, c) = float::sin_cos_2pi(u.y);
                target[i] = Vec2::new(c, s) * radius;
                pdf *= slope_pdf(target[i], alpha);
            }
        }
        (target, pdf)
    }

    /// Whether the walk from the straight line to the half vectors of this path finds it.
    pub fn is_found_by_walk<T: Traverse>(
        &self,
        view: &SceneView<'_, T>,
        surface: &SurfacePoint,
        bsdf: &mut Bsdf,
    ) -> bool {
        let Some(line) = Interfaces::on_line(view, &self.vertices[0], surface, bsdf) else {
            return false;
        };
        if !self.has_kinds_of(&line) {
            return false;
        }
        let mut chain = *self;
        for i in 1..self.len - 1 {
            // The frames of half vectors are built around the same vectors.
            chain.vertices[i].reference = line.vertices[i].reference;
        }
        let jacobian = chain.jacobian();
        if !jacobian.valid {
            return false;
        }
        let mut target = [Vec2::ZERO; N];
        for i in 1..self.len - 1 {
            if self.vertices[i].alpha.x > 0.0 {
                target[i] = jacobian.h[i];
            }
        }
        let options = self.options(&view.tables);
        line.with(view, &target)
            .is_some_and(|found| is_same_path(&found.vertices, &self.vertices, self.len, &options))
    }

    /// What the chain carries from the light to the surface.
    pub fn throughput(
        &self,
        tables: &Tables<'_>,
        rules: &PathRules,
        bsdf: &mut Bsdf,
    ) -> Option<ChainThroughput> {
        let last = self.len - 1;
        let jacobian = self.jacobian();
        let mut measure = generalized_geometry_term(&self.vertices, &jacobian);
        let mut value = Rgb::ONE;
        let towards = |from: usize, to: usize| {
            (self.vertices[to].position - self.vertices[from].position).normalize_or_zero()
        };
        for i in 1..last {
            let x = &self.vertices[i];
            let point = looked_up::<{ detail::TANGENTS }>(tables, x);
            let (to_sensor, to_light) = (towards(i, i + 1), towards(i, i - 1));
            let (wc, wl) = (
                point.frame.to_local(to_sensor),
                point.frame.to_local(to_light),
            );
            let passes = wc.z * wl.z < 0.0
                && rules.allows(&point, to_sensor, wc.z)
                && rules.allows(&point, to_light, wl.z);
            if !passes {
                return None;
            }
            bsdf.look_up(tables, &point, wc, mode::RADIANCE);
            if x.alpha.x > 0.0 {
                value *= bsdf.eval_cosine(tables.data, wc, wl);
                let [previous, next] = [i - 1, i + 1].map(|j| &self.vertices[j]);
                let m = scattering_measure(previous, x, next, FORM) / x.cosine(to_light);
                measure = measure.times(m);
            } else {
                let wanted = event::TRANSMISSION | event::DELTA;
                let there = discrete(bsdf, tables, wc, wl, wanted);
                value *= there.value;
                bsdf.look_up(tables, &point, wl, mode::RADIANCE);
                let back = discrete(bsdf, tables, wl, wc, wanted);
                let ratio = sqr(there.eta) * back.exchange;
                measure = measure.times(ratio * x.cosine(to_sensor) / x.cosine(to_light));
            }
        }
        let direction = towards(last, last - 1);
        let cosine = abs(self.vertices[last].geometric_normal.dot(direction));
        let value = value * measure.times(1.0 / cosine).value();
        let is_some = value.max_element() > 0.0 && value.is_finite();
        is_some.then_some(ChainThroughput {
            value,
            direction,
            outgoing: towards(0, 1),
        })
    }
}

/// p(h) of the header.
fn slope_pdf(h: Vec2, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let x = 1.0 + h.length_squared() / a2;
    1.0 / (core::f32::consts::PI * a2 * x * x)
}
