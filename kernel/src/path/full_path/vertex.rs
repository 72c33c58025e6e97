//! A vertex of a full path ([`super`]).
//!
//! Hosts only, as full paths are.

use crate::bsdf::null_transmittance;
use crate::math::{Ray, Rgb};
use crate::path::visibility::has_masks;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, NONE, SurfacePoint, Tables};
use glam::Vec3;

/// Marks a vertex that is no discrete event.
pub const SMOOTH: u32 = 0;

/// Marks a vertex whose discrete events are blurred ([`crate::path::mollified`]), so that it may be connected.
pub const BLURRED: u32 = u32::MAX;

/// A vertex of a full path.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The surface point; of a point light and of the lens only the position means anything.
    pub point: SurfacePoint,
    /// Bits of [`crate::bsdf::event`] of a discrete event, [`SMOOTH`] for none, [`BLURRED`] for one that is blurred.
    pub event: u32,
    /// Whether the material has one direction only for that kind of event.
    pub is_unique: bool,
    /// f |cos| from the next vertex to the one before.
    pub value: Rgb,
    /// Density of the direction to the one before, sampled by a camera walk.
    pub pdf_to_light: f32,
    /// Density of the direction to the next, sampled by a light walk.
    pub pdf_to_sensor: f32,
    /// Of a discrete event: the squared relative index, from the side of the one before to that of the next, over the ratio of
    /// cosines with the normal that the event knows, of the direction to the one before and that to the next.
    pub ratio: f32,
    /// Probability that a walk which meets the surface stands there, if light may pass straight through.
    pub stop: f32,
    /// The edge to the next vertex.
    pub edge: Edge,
    /// By the flow of edits, one of [`crate::path::retarget::flow`]: one more than the number of the edit that has turned the direction
    /// which leads on with it, of light to the next vertex and of importance to the one before; zero for none.
    pub labels: [u32; 2],
    /// By the flow with which a walk goes: probability that it guesses the label of the other.
    pub guesses: [f32; 2],
}

/// What lies along an edge of a full path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Transmittance.
    pub transmittance: Rgb,
    /// Probability that a walk passes all that lies there.
    pub pass: f32,
    /// Unit direction towards the sensor if a walk sampled it, zero if it follows from the positions of the vertices: the
    /// difference of positions that lie close together has lost most of its digits, and a perturbation of such a direction
    /// would not lead back through the same specular vertices.
    pub direction: Vec3,
}

impl Edge {
    /// Nothing lies there.
    pub const CLEAR: Edge = Edge {
        transmittance: Vec3::ONE,
        pass: 1.0,
        direction: Vec3::ZERO,
    };
}

impl Vertex {
    /// A vertex that is no surface: a point light, a light at infinity, a lens.
    pub fn without_surface(tables: &Tables<'_>, position: Vec3) -> Vertex {
        let point = SurfacePoint {
            position,
            material: NONE,
            ..SurfacePoint::ZERO
        };
        Vertex::new(tables, &point)
    }

    /// A vertex at a surface point.
    pub fn new(tables: &Tables<'_>, point: &SurfacePoint) -> Vertex {
        Vertex {
            point: *point,
            event: SMOOTH,
            is_unique: true,
            value: Vec3::ZERO,
            pdf_to_light: 0.0,
            pdf_to_sensor: 0.0,
            ratio: 1.0,
            stop: 1.0 - p_through(tables, point).max_element().min(1.0),
            edge: Edge::CLEAR,
            labels: [0; 2],
            guesses: [1.0; 2],
        }
    }

    /// Looks up all of the surface again: points of emitters are sampled without the tangents that scattering reads.
    pub fn complete(&mut self, tables: &Tables<'_>) {
        let point = &self.point;
        let hit = Hit {
            t: 0.0,
            b1: point.barycentric.x,
            b2: point.barycentric.y,
            primitive: point.primitive,
            instance: point.instance,
        };
        let ray = Ray::new(point.position, point.geometric_normal);
        self.point = surface_with::<{ detail::TANGENTS }>(tables, &ray, &hit);
    }

    /// Whether it may be connected.
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.event == SMOOTH || self.event == BLURRED
    }
}

/// What light passes straight through a surface.
#[inline]
pub fn p_through(tables: &Tables<'_>, point: &SurfacePoint) -> Rgb {
    if has_masks(tables, point) {
        null_transmittance(tables, point)
    } else {
        Vec3::ZERO
    }
}
