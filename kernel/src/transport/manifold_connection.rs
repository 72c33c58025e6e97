//! The connections that manifold next event estimation makes, and the paths that are left to them (Hanika, Droske and Fascione 2015).
//!
//! A vertex that is rough, an *anchor*, is connected to a point of a light, chosen uniformly over its surface, through the interfaces
//! that the straight line between both meets ([`crate::path::through_interfaces`]). Paths that this finds are left to it by every
//! other technique: those along which an anchor scatters into a chain of interfaces that ends at a light, and for which the
//! connection of these two ends leads to these interfaces. This depends on the path alone, so whatever finds the other
//! paths keeps its mean.
//!
//! Hosts only, as the connections.

use crate::bsdf::Bsdf;
use crate::manifold::ChainVertex;
use crate::math::affine::translation;
use crate::math::{Ray, Rgb};
use crate::path::PathRules;
use crate::path::through_interfaces::{Interfaces, interface};
use crate::sampler::Sampler;
use crate::scene::emitter::position::sample_position;
use crate::scene::emitter::{self, area_radiance, delta, select_emitter};
use crate::scene::surface::{detail, surface_with};
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse, emitter_kind};
use glam::Vec3;

/// Roughness from which a vertex is connected: narrower lobes find their lights by themselves.
const ANCHOR_ROUGHNESS: f32 = 0.25;

/// Whether a vertex of this material is connected.
#[inline]
pub fn is_anchor(bsdf: &Bsdf) -> bool {
    interface(bsdf).is_none() && bsdf.roughness() > ANCHOR_ROUGHNESS
}

/// Whether a path that arrives in one direction and goes on in another passes to the other side of a surface.
#[inline]
pub fn passes(point: &SurfacePoint, before: Vec3, after: Vec3) -> bool {
    point.frame.n.dot(before) * point.frame.n.dot(after) > 0.0
}

/// An anchor, and the interfaces that a path passes from there on.
#[derive(Clone, Copy)]
pub struct Anchor {
    point: SurfacePoint,
    /// From the anchor on; the vertex of the light is not set.
    chain: Interfaces,
}

impl Anchor {
    /// With nothing behind it.
    pub fn new(point: &SurfacePoint) -> Anchor {
        Anchor {
            point: *point,
            chain: Interfaces::between(ChainVertex::NONE, point),
        }
    }

    /// Adds the next interface on the way to the light; returns whether there was space.
    #[inline]
    pub fn push(&mut self, interface: ChainVertex) -> bool {
        self.chain.push(interface)
    }

    /// Whether the connection from the anchor finds the path that ends at a point of a light.
    pub fn is_found_by_walk<T: Traverse>(
        mut self,
        view: &SceneView<'_, T>,
        light: ChainVertex,
        scratch: &mut Bsdf,
    ) -> bool {
        self.chain.vertices[0] = light;
        self.chain.len > 2 && self.chain.is_found_by_walk(view, &self.point, scratch)
    }
}

/// The point of an emitter at a finite distance that is seen along a ray.
pub fn light_point<T: Traverse>(
    view: &SceneView<'_, T>,
    ray: &Ray,
    emitter: u32,
) -> Option<ChainVertex> {
    let record = &view.tables.emitters[emitter as usize];
    if record.kind != emitter_kind::AREA {
        return has_position(record.kind)
            .then(|| ChainVertex::point(translation(&record.to_world)));
    }
    let hit = view.traverse.closest_hit(ray);
    if !hit.is_hit() {
        return None;
    }
    let point = surface_with::<{ detail::TANGENTS }>(&view.tables, ray, &hit);
    (point.emitter == emitter).then(|| ChainVertex::from_surface(&point))
}

/// Whether emitters of a kind are single points that are connected.
#[inline]
pub fn has_position(kind: u32) -> bool {
    kind == emitter_kind::POINT || kind == emitter_kind::SPOT || kind == emitter_kind::PROJECTOR
}

/// The light that an anchor scatters back along `wi`, in its local frame, from a point of a light behind interfaces; `depth` edges of the path
/// lead to the anchor.
pub fn connect<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    rules: &PathRules,
    at: (&SurfacePoint, &Bsdf, Vec3),
    depth: u32,
    sampler: &mut S,
    scratch: &mut Bsdf,
) -> Rgb {
    let tables = &view.tables;
    let (at, bsdf, wi) = at;
    let u_select = sampler.next_1d();
    let u = sampler.next_2d();
    let emitter = select_emitter(tables, u_select);
    if emitter == NONE {
        return Rgb::ZERO;
    }
    let record = &tables.emitters[emitter as usize];
    let mut pdf = record.selection_pdf;
    let mut point = SurfacePoint::ZERO;
    let light = if record.kind == emitter_kind::AREA {
        let (sampled, density) = sample_position(tables, emitter, u);
        point = sampled;
        pdf *= density;
        ChainVertex::from_surface(&sampled)
    } else {
        let sampled = emitter::sample_emitter(tables, emitter, at.position, u);
        if !(sampled.distance < f32::MAX) {
            return Rgb::ZERO;
        }
        ChainVertex::point(sampled.target)
    };
    let Some(line) = Interfaces::on_line(view, &light, at, scratch) else {
        return Rgb::ZERO;
    };
    // Edges to the anchor, and those of the chain.
    let edges = depth as usize + line.len;
    if edges > rules.max_depth as usize {
        return Rgb::ZERO;
    }
    let (target, density) = line.draw(sampler);
    let carried = line
        .with(view, &target)
        .and_then(|found| found.throughput(tables, rules, scratch));
    let Some(carried) = carried else {
        return Rgb::ZERO;
    };
    let wo = at.frame.to_local(carried.direction);
    if !rules.allows(at, carried.direction, wo.z) {
        return Rgb::ZERO;
    }
    let scattered = bsdf.eval_cosine(tables.data, wi, wo);
    let emitted = if record.kind == emitter_kind::AREA {
        area_radiance(tables, &point, carried.outgoing)
    } else {
        delta::intensity(tables, emitter, carried.outgoing)
    };
    let value = scattered * carried.value * emitted / (pdf * density);
    if value.is_finite() { value } else { Rgb::ZERO }
}
