//! A full path as a chain of half vectors, and vertices of chains back into the path.
//!
//! The frames of all half vectors are built around one vector that is fixed in space ([`crate::manifold::vertex`]). A mutation draws it
//! anew, so that no direction of normals is singular for good; both directions of the mutation use the same.
//!
//! A vertex at infinity becomes a point on a plane across its direction, outside of the scene: so is a sensor of parallel rays.

use super::super::veach::{ChainPath, MAX_VERTICES};
use super::settings::roughness_kind;
use crate::bsdf::{Bsdf, event, local_beckmann_roughness, mode};
use crate::manifold::ChainVertex;
use crate::manifold::constraint::inner_half_vector;
use crate::manifold::step_size::DIFFUSE_ALPHA;
use crate::math::Ray;
use crate::path::full_path::vertex::Vertex;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, SurfacePoint, Tables, camera_kind, emitter_kind, lobe_kind};
use core::ops::Range;
use glam::{Vec2, Vec3};

/// The vertices of a path as those of a chain.
#[derive(Clone, Debug)]
pub struct PathChain {
    /// From the light to the sensor.
    pub vertices: [ChainVertex; MAX_VERTICES],
    /// Their number.
    pub len: usize,
}

impl PathChain {
    /// No path.
    pub const EMPTY: PathChain = PathChain {
        vertices: [ChainVertex::NONE; MAX_VERTICES],
        len: 0,
    };

    /// Takes the vertices of `path`; frames are built around `reference`, roughness is one of [`roughness_kind`].
    pub fn set(
        &mut self,
        tables: &Tables<'_>,
        path: &ChainPath,
        reference: Vec3,
        roughness: u32,
        bsdf: &mut Bsdf,
    ) {
        let k = path.edges();
        self.len = k + 1;
        self.vertices[0] = light_end(tables, path);
        for i in 1..k {
            self.vertices[i] = inner_vertex(tables, path, i, reference, roughness, bsdf);
        }
        self.vertices[k] = sensor_end(tables, path);
    }

    /// Hangs the frames of all half vectors on another vector.
    pub fn set_frame_reference(&mut self, reference: Vec3) {
        for i in 1..self.len.saturating_sub(1) {
            self.vertices[i].reference = reference;
        }
    }

    /// Becomes the chain of `path`: vertices in `kept` are those of `old`, of those in `known` all but the scattering is here already,
    /// vertices in `looked_up` are looked up again, and all others are where they were in `old`.
    pub fn follow(
        &mut self,
        tables: &Tables<'_>,
        path: &ChainPath,
        old: &PathChain,
        reference: Vec3,
        scattering: &[Scattering; MAX_VERTICES],
        [kept, known, looked_up]: [Range<usize>; 3],
    ) {
        let k = path.edges();
        self.len = k + 1;
        for i in 1..k {
            if kept.contains(&i) {
                self.vertices[i] = old.vertices[i];
                continue;
            }
            let mut vertex = if known.contains(&i) {
                self.vertices[i]
            } else if looked_up.contains(&i) {
                let point = curved(tables, &path.vertices[i].point);
                ChainVertex::from_surface_with(&point, reference)
            } else {
                old.vertices[i]
            };
            vertex.reference = reference;
            self.vertices[i] = scattering[i].applied_to(vertex);
        }
        self.vertices[0] = light_end(tables, path);
        self.vertices[k] = sensor_end(tables, path);
    }

    /// The half vector of an inner vertex, in one of [`crate::manifold::half_vector_form`]; nothing where there is none.
    pub fn half_vector(&self, i: usize, form: u32) -> Option<Vec2> {
        let [previous, next] = [i - 1, i + 1].map(|j| self.vertices[j].position);
        let found = inner_half_vector(previous, &self.vertices[i], next, form);
        found.valid.then_some(found.h)
    }

    /// Whether the half vectors of the inner vertices from `first` to `last` are of the same kind as those of another.
    pub fn has_kinds_of(&self, other: &PathChain, first: usize, last: usize) -> bool {
        (first..=last).all(|i| {
            let (a, b) = (&self.vertices[i], &other.vertices[i]);
            a.kind == b.kind && a.eta == b.eta
        })
    }

    /// Length of all edges that are not to infinity.
    pub fn length(&self, is_from_infinity: bool) -> f32 {
        let first = if is_from_infinity { 2 } else { 1 };
        (first..self.len)
            .map(|i| (self.vertices[i].position - self.vertices[i - 1].position).length())
            .sum()
    }
}

/// The chains of the path where a Markov chain is and of the one that it proposes, kept from step to step.
#[derive(Clone, Debug)]
pub struct ChainPair {
    chains: [PathChain; 2],
    /// The roughness of each, plus one; 0 if it is not that of the path.
    kinds: [u32; 2],
    current: usize,
}

impl ChainPair {
    /// Of no paths.
    pub const EMPTY: ChainPair = ChainPair {
        chains: [PathChain::EMPTY; 2],
        kinds: [0; 2],
        current: 0,
    };

    /// The chain of the current path `x`, and storage for that of the proposed one.
    pub fn begin(
        &mut self,
        tables: &Tables<'_>,
        x: &ChainPath,
        reference: Vec3,
        roughness: u32,
        bsdf: &mut Bsdf,
    ) -> (&PathChain, &mut PathChain) {
        let kind = &mut self.kinds[self.current];
        let [first, second] = &mut self.chains;
        let (of_x, of_y) = if self.current == 0 {
            (first, second)
        } else {
            (second, first)
        };
        if *kind == roughness + 1 {
            of_x.set_frame_reference(reference);
        } else {
            *kind = roughness + 1;
            of_x.set(tables, x, reference, roughness, bsdf);
        }
        (of_x, of_y)
    }

    /// Says of which roughness the chain of the proposed path is.
    pub fn proposed(&mut self, roughness: u32) {
        self.kinds[1 - self.current] = roughness + 1;
    }

    /// Forgets that of the path proposed before.
    pub fn forget_proposed(&mut self) {
        self.kinds[1 - self.current] = 0;
    }

    /// The proposed path becomes the current one.
    pub fn accept(&mut self) {
        self.current = 1 - self.current;
    }
}

/// The surface point with the derivatives of its normal.
pub fn curved(tables: &Tables<'_>, point: &SurfacePoint) -> SurfacePoint {
    surface_again::<{ detail::CURVATURE }>(
        tables,
        point.position,
        point.geometric_normal,
        point.barycentric,
        [point.primitive, point.instance],
    )
}

/// Looks up a surface where it was met before.
fn surface_again<const DETAIL: u32>(
    tables: &Tables<'_>,
    position: Vec3,
    normal: Vec3,
    barycentric: Vec2,
    [primitive, instance]: [u32; 2],
) -> SurfacePoint {
    let hit = Hit {
        t: 0.0,
        b1: barycentric.x,
        b2: barycentric.y,
        primitive,
        instance,
    };
    surface_with::<DETAIL>(tables, &Ray::new(position, normal), &hit)
}

/// Puts a vertex of a path where a walk has found it; its event stays.
pub fn set_vertex(tables: &Tables<'_>, vertex: &mut Vertex, found: &ChainVertex) {
    let point = surface_again::<{ detail::TANGENTS }>(
        tables,
        found.position,
        found.geometric_normal,
        found.barycentric,
        [found.primitive, found.instance],
    );
    let event = vertex.event;
    *vertex = Vertex::new(tables, &point);
    vertex.event = event;
}

fn light_end(tables: &Tables<'_>, path: &ChainPath) -> ChainVertex {
    let point = &path.vertices[0].point;
    if path.is_infinite(tables) {
        let first = path.vertices[1].point.position;
        let outside = first + path.to_light * (2.0 * tables.info.radius);
        return ChainVertex::pinned_direction(outside, -path.to_light);
    }
    if tables.emitters[path.emitter as usize].kind == emitter_kind::AREA {
        ChainVertex::from_surface(point)
    } else {
        ChainVertex::point(point.position)
    }
}

fn sensor_end(tables: &Tables<'_>, path: &ChainPath) -> ChainVertex {
    let k = path.edges();
    if tables.camera.kind == camera_kind::ORTHOGRAPHIC {
        let seen = path.vertices[k - 1].point.position;
        let outside = seen + path.to_lens * (2.0 * tables.info.radius);
        return ChainVertex::pinned_direction(outside, -path.to_lens);
    }
    ChainVertex::point(path.vertices[k].point.position)
}

fn inner_vertex(
    tables: &Tables<'_>,
    path: &ChainPath,
    i: usize,
    reference: Vec3,
    roughness: u32,
    bsdf: &mut Bsdf,
) -> ChainVertex {
    let vertex = &path.vertices[i];
    let point = curved(tables, &vertex.point);
    let frame = &vertex.point.frame;
    let wc = frame.to_local(path.next_direction(i));
    let wl = frame.to_local(path.previous_direction(i));
    bsdf.look_up(tables, &vertex.point, wc, mode::RADIANCE);
    let found = Scattering::new(tables, vertex, [wc, wl], roughness, bsdf);
    found.applied_to(ChainVertex::from_surface_with(&point, reference))
}

/// How an inner vertex scatters.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    transmits: bool,
    /// Index of refraction towards the sensor over that towards the light.
    eta: f32,
    /// Roughness.
    alpha: f32,
}

impl Scattering {
    /// Nothing.
    pub const NONE: Scattering = Scattering {
        transmits: false,
        eta: 1.0,
        alpha: 0.0,
    };

    /// At a vertex with local directions to the sensor and to the light, with its BSDF, which at a smooth vertex must be that for
    /// the former; `roughness` is one of [`roughness_kind`].
    pub fn new(
        tables: &Tables<'_>,
        vertex: &Vertex,
        [wc, wl]: [Vec3; 2],
        roughness: u32,
        bsdf: &Bsdf,
    ) -> Scattering {
        let (transmits, alpha) = if vertex.is_smooth() {
            let alpha = if roughness == roughness_kind::UNIT {
                1.0
            } else if roughness == roughness_kind::GLOBAL {
                bsdf.roughness()
            } else {
                local_beckmann_roughness(bsdf, tables.data, wc, wl)
            };
            // A diffuse vertex has no finite roughness: it steps like a lobe of slope deviation one.
            (wc.z * wl.z < 0.0, alpha.min(DIFFUSE_ALPHA))
        } else {
            (vertex.event & event::TRANSMISSION != 0, 0.0)
        };
        let eta = if transmits {
            index_towards_sensor(bsdf, vertex.is_smooth(), wl.z)
        } else {
            1.0
        };
        Scattering {
            transmits,
            eta,
            alpha,
        }
    }

    fn applied_to(&self, vertex: ChainVertex) -> ChainVertex {
        vertex.scattering(self.transmits, self.eta, Vec2::splat(self.alpha))
    }
}

/// Index of refraction on the side of the sensor over that on the side of the light: of the first lobe that bends what passes.
fn index_towards_sensor(bsdf: &Bsdf, is_smooth: bool, cos_light: f32) -> f32 {
    let bends = |kind: u32| {
        kind == lobe_kind::ROUGH_DIELECTRIC || (!is_smooth && kind == lobe_kind::DIELECTRIC)
    };
    (0..bsdf.lobe_count())
        .map(|i| bsdf.lobe(i))
        .find(|lobe| bends(lobe.kind))
        .map_or(1.0, |lobe| {
            crate::bsdf::fresnel::relative_eta(cos_light, lobe.eta.x)
        })
}
