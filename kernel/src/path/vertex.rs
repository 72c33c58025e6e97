//! Vertices of subpaths: as they are stored, and as connections need them.
//!
//! A [`PathVertex`] is plain data, because shaders and caches of light vertices hold it too. It keeps the hit and the ray
//! that found it, not the surface point or the material: both are looked up again ([`PathVertex::look_up`]), which takes less
//! memory and gives the same to the bit. A [`LightEnd`] is a vertex of a light subpath after that look-up.

use super::evaluation::Interaction;
use super::shading_point::ShadingPoint;
use super::specular_chain::SpecularChain;
use super::weight::PartialWeights;
use crate::math::{Ray, Rgb, vec3};
use crate::scene::{Hit, Tables};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A vertex of a subpath, as it is stored.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PathVertex {
    /// Origin of the ray that hit the surface here.
    pub origin: [f32; 3],
    /// Unit direction of that ray.
    pub direction: [f32; 3],
    /// Its intersection.
    pub hit: Hit,
    /// Throughput of the walk before it scatters here.
    pub throughput: [f32; 3],
    /// See [`PartialWeights::d_vcm`].
    pub d_vcm: f32,
    /// See [`PartialWeights::d_vc`].
    pub d_vc: f32,
    /// Number of edges from the start of the subpath.
    pub depth: u32,
    /// What selective regularisation knows up to this vertex.
    pub chain: SpecularChain,
    /// Index of the previous connectable vertex of the same subpath in the caller's storage; [`crate::scene::NONE`] for none.
    pub previous: u32,
    /// Position of the surface point.
    pub position: [f32; 3],
    /// Shading normal on the side from which the walk came, if the surface is opaque; zero if it may transmit.
    pub facing: [f32; 3],
}

impl PathVertex {
    /// Looks the surface point and its BSDF up again; returns the direction of the walk.
    #[inline]
    pub fn look_up(&self, tables: &Tables<'_>, site: &mut ShadingPoint) -> Vec3 {
        let direction = vec3(self.direction);
        site.find(tables, &Ray::new(vec3(self.origin), direction), &self.hit);
        site.look_up(tables, direction);
        direction
    }

    /// The partial sums of the weights up to this vertex.
    #[inline]
    pub fn weights(&self) -> PartialWeights {
        PartialWeights {
            d_vcm: self.d_vcm,
            d_vc: self.d_vc,
        }
    }
}

/// The last vertex of a light subpath that is connected to a camera subpath.
#[derive(Clone, Copy)]
pub struct LightEnd<'a> {
    /// Surface point, BSDF and incident direction.
    pub at: Interaction<'a>,
    /// Throughput of the light walk before it scatters here.
    pub throughput: Rgb,
    /// Partial sums of the weights over shorter light subpaths.
    pub weights: PartialWeights,
    /// Number of edges from the emitter.
    pub edges: u32,
    /// What selective regularisation knows up to this vertex.
    pub chain: SpecularChain,
}

impl<'a> LightEnd<'a> {
    /// Of a stored vertex and its interaction.
    #[inline]
    pub fn new(vertex: &PathVertex, at: Interaction<'a>) -> LightEnd<'a> {
        LightEnd {
            at,
            throughput: vec3(vertex.throughput),
            weights: vertex.weights(),
            edges: vertex.depth,
            chain: vertex.chain,
        }
    }
}
