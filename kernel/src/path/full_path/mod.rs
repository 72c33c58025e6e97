//! Full paths, vertex by vertex: what they carry, and the density of every strategy that can make them.
//!
//! A path x_0 ... x_k goes from a light to a lens. Its contribution is written in the measure in which a camera walk would have
//! sampled it: a film position, a lens point, and at each vertex that is no discrete event the solid angle of the direction
//! to the vertex before,
//!
//! ```text
//! f = Le(x_0 -> x_1) prod_(i=1)^(k-1) f_i |cos_i| prod_edges transmittance,
//! ```
//!
//! with f_i |cos_i| the number that [`crate::path::evaluation`] defines; at a discrete event it is the event's weight times its
//! probability. A vertex that the light walk samples has its density in the same measure, by the conservation of etendue
//!
//! ```text
//! dA_j dw_j n_j^2 cos_j = dA_m dw_m n_m^2 cos_m
//! ```
//!
//! between vertices j and m that are connected by discrete events alone: so a light subpath x_0 ... x_(s-1) has the density
//!
//! ```text
//! p_A(x_0) p_w(x_0 -> x_1) prod_(i=1)^(s-2) p_i(-> x_(i+1)) r_i  *  cos_(s-1) / cos_0,
//! ```
//!
//! r_i the ratio of the geometric cosines of arriving and leaving at x_i, which at a discrete event is multiplied by the squared
//! relative index from the side of x_(i-1) to that of x_(i+1) and divided by the same ratio for the normal that the event knows, so
//! that only the index is left where the two normals are one; the edge that joins it to the camera subpath adds d^2 / cos. Lights without an
//! extent or without a direction have formal densities, which no strategy but those that start on them or choose
//! them can have, so that they cancel.
//!
//! Every strategy's estimate of the path is then f / p_s, whatever the measure (`full_path::densities.rs`).
//! Invariant (tests): paths weighted by f / sum_s p_s have the image of bidirectional path tracing, block by block.
//!
//! With [`Blurring`], one vertex of a path that nothing samples may be specular and connected all the same (`full_path::blurred.rs`).
//! Where edits turn directions, vertices have labels (`full_path::edited.rs`).
//!
//! Hosts only: a path holds its surface points, because chains come back to them many times.

mod blurred;
mod densities;
pub mod edited;
mod shares;
pub mod vertex;

use self::vertex::{BLURRED, Vertex};
use crate::bsdf::{Bsdf, mode};
use crate::math::{Rgb, float, luminance, vec3};
use crate::path::retarget_states::Edits;
use crate::path::rules::PathRules;
use crate::path::specular::discrete;
use crate::scene::emitter::emission::is_infinite;
use crate::scene::emitter::{area_radiance, delta, environment_radiance};
use crate::scene::{NONE, Tables, camera, emitter_kind};
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

/// How discrete events are blurred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blurring {
    /// Radius at the far end of the edge, zero for none.
    pub radius: f32,
    /// One of the kernels of [`crate::regularize::mollifier`].
    pub kernel: u32,
}

impl Blurring {
    /// None.
    pub const NONE: Blurring = Blurring {
        radius: 0.0,
        kernel: 0,
    };
}

/// A full path of at most `N` vertices.
#[derive(Debug)]
pub struct Path<const N: usize> {
    /// From the light to the lens; that of a light at infinity stands for its direction alone.
    pub vertices: ArrayVec<Vertex, N>,
    /// The emitter of the first vertex.
    pub emitter: u32,
    /// Unit direction from the second vertex to the first.
    pub to_light: Vec3,
    /// Film position in pixels of the whole film.
    pub film: Vec2,
    /// Numbers that choose the lens point.
    pub u_lens: Vec2,
    /// Density of the film position per perpendicular area at the vertex before the lens.
    pub importance: f32,
    /// Unit direction from that vertex to the lens.
    pub to_lens: Vec3,
    /// f of the header.
    pub value: Rgb,
    /// How a vertex may be blurred.
    pub blurring: Blurring,
    /// The only strategy s that can make the path if a vertex is blurred, zero if none is.
    pub(super) joined: usize,
}

/// Copies only the vertices that there are; `clone_from` writes nothing twice.
impl<const N: usize> Clone for Path<N> {
    fn clone(&self) -> Path<N> {
        let mut out = Path::empty();
        out.clone_from(self);
        out
    }

    fn clone_from(&mut self, other: &Path<N>) {
        let Path {
            vertices,
            emitter,
            to_light,
            film,
            u_lens,
            importance,
            to_lens,
            value,
            blurring,
            joined,
        } = self;
        vertices.clear();
        vertices.extend(other.vertices.iter().copied());
        *emitter = other.emitter;
        *to_light = other.to_light;
        *film = other.film;
        *u_lens = other.u_lens;
        *importance = other.importance;
        *to_lens = other.to_lens;
        *value = other.value;
        *blurring = other.blurring;
        *joined = other.joined;
    }
}

impl<const N: usize> Path<N> {
    /// No path.
    pub fn empty() -> Path<N> {
        Path {
            vertices: ArrayVec::new(),
            emitter: NONE,
            to_light: Vec3::Z,
            film: Vec2::ZERO,
            u_lens: Vec2::ZERO,
            importance: 0.0,
            to_lens: Vec3::Z,
            value: Vec3::ZERO,
            blurring: Blurring::NONE,
            joined: 0,
        }
    }

    /// k.
    #[inline]
    pub fn edges(&self) -> usize {
        self.vertices.len().saturating_sub(1)
    }

    /// Luminance of f.
    #[inline]
    pub fn luminance(&self) -> f32 {
        luminance(self.value)
    }

    /// Unit direction from vertex `i` to the next.
    pub fn next_direction(&self, i: usize) -> Vec3 {
        if i + 2 == self.vertices.len() {
            self.to_lens
        } else if i == 0 {
            -self.to_light
        } else if self.vertices[i].edge.direction != Vec3::ZERO {
            self.vertices[i].edge.direction
        } else {
            let between = self.vertices[i + 1].point.position - self.vertices[i].point.position;
            between.normalize()
        }
    }

    /// Unit direction from vertex `i` to the one before.
    pub fn previous_direction(&self, i: usize) -> Vec3 {
        if i == 1 {
            self.to_light
        } else {
            -self.next_direction(i - 1)
        }
    }

    /// Whether the light is at infinity.
    pub fn is_infinite(&self, tables: &Tables<'_>) -> bool {
        is_infinite(tables.emitters[self.emitter as usize].kind)
    }

    /// Looks up what the sensor and the light say of the path's ends, and all of its vertices; returns whether it carries light.
    /// Positions, discrete events, labels of edits, the emitter, the lens numbers, transmittances and `to_light` of lights at infinity
    /// are given.
    pub fn evaluate(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        edits: Option<&Edits<'_>>,
        bsdf: &mut Bsdf,
    ) -> bool {
        self.evaluate_and(tables, rules, edits, 1, bsdf, |_, _, _, _| {})
    }

    /// The same, where vertices before `first`, one at least, are what they were when the path was evaluated last, and so are both
    /// of their directions; nothing may be blurred then. Calls `visit` with the index of each other inner vertex, the local directions
    /// to the sensor and to the light as the BSDF knows them, and the BSDF: of a discrete event that looked up for the latter, else
    /// for the former.
    pub fn evaluate_and(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        edits: Option<&Edits<'_>>,
        first: usize,
        bsdf: &mut Bsdf,
        mut visit: impl FnMut(&Path<N>, usize, [Vec3; 2], &Bsdf),
    ) -> bool {
        self.value = Vec3::ZERO;
        let k = self.edges();
        if k == 0 || k > rules.max_depth as usize || self.emitter == NONE {
            return false;
        }
        if k > 1 || !self.is_infinite(tables) {
            let seen =
                camera::film_position(tables, self.vertices[k - 1].point.position, self.u_lens);
            if !seen.is_valid {
                return false;
            }
            self.film = seen.film;
            self.to_lens = seen.direction;
            self.importance = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        } else {
            self.to_lens = -self.to_light;
        }
        if !self.is_infinite(tables) {
            self.to_light = if k == 1 {
                -self.to_lens
            } else {
                (self.vertices[0].point.position - self.vertices[1].point.position).normalize()
            };
        }
        let hides = rules.hide_emitters != 0;
        let is_hidden = |vertex: &Vertex| vertex.point.emitter != NONE;
        if hides && (k == 1 || is_hidden(&self.vertices[k - 1])) {
            return false;
        }
        if !self.find_joined(tables, rules) {
            return false;
        }
        let mut value = self.emitted(tables);
        for i in 1..k {
            if !(value.max_element() > 0.0)
                || i >= first && !self.look_up(tables, rules, edits, i, bsdf, &mut visit)
            {
                return false;
            }
            value *= self.vertices[i].value;
        }
        for vertex in &self.vertices[..k] {
            value *= vertex.edge.transmittance;
        }
        if let Some(edits) = edits
            && value.max_element() > 0.0
        {
            value *= self.share_of_labels(tables, edits, bsdf);
        }
        if !(value.max_element() > 0.0) || !value.is_finite() {
            return false;
        }
        self.value = value;
        true
    }

    /// Le: radiance, or intensity, or irradiance, of the first vertex towards the second.
    fn emitted(&self, tables: &Tables<'_>) -> Rgb {
        let record = &tables.emitters[self.emitter as usize];
        let outgoing = -self.to_light;
        match record.kind {
            emitter_kind::AREA => area_radiance(tables, &self.vertices[0].point, outgoing),
            emitter_kind::DIRECTIONAL => vec3(record.radiance.value),
            kind if is_infinite(kind) => environment_radiance(tables, self.to_light),
            _ => delta::intensity(tables, self.emitter, outgoing),
        }
    }

    /// Value and densities at an inner vertex; returns whether anything is scattered.
    fn look_up(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        edits: Option<&Edits<'_>>,
        i: usize,
        bsdf: &mut Bsdf,
        visit: &mut impl FnMut(&Path<N>, usize, [Vec3; 2], &Bsdf),
    ) -> bool {
        let (to_sensor, to_light) = (self.next_direction(i), self.previous_direction(i));
        let vertex = &self.vertices[i];
        let point = &vertex.point;
        let (wc, wl) = (
            point.frame.to_local(to_sensor),
            point.frame.to_local(to_light),
        );
        if !rules.allows(point, to_sensor, wc.z) || !rules.allows(point, to_light, wl.z) {
            return false;
        }
        if vertex.event == BLURRED {
            let value = self.blurred_value(tables, rules, i, bsdf);
            let vertex = &mut self.vertices[i];
            vertex.value = value;
            // Nothing samples its directions.
            vertex.pdf_to_light = 0.0;
            vertex.pdf_to_sensor = 0.0;
            vertex.ratio = 1.0;
            return value.max_element() > 0.0 && value.is_finite();
        }
        let Some(turned) = vertex.edited(edits, to_sensor, to_light) else {
            return false;
        };
        let (wc, wl) = (turned.to_sensor, turned.to_light);
        let [of_light, of_importance] = turned.jacobians;
        let vertex = &mut self.vertices[i];
        let point = &vertex.point;
        bsdf.look_up(tables, point, wc, mode::RADIANCE);
        if vertex.is_smooth() {
            let both = bsdf.eval_cosine_pdf_both(tables, point, wc, wl, false);
            vertex.value = both.value * turned.value;
            vertex.pdf_to_light = both.pdf * of_importance;
            vertex.pdf_to_sensor = both.pdf_reverse * of_light;
            vertex.ratio = 1.0;
        } else {
            let forward = discrete(bsdf, tables, wc, wl, vertex.event);
            bsdf.look_up(tables, point, wl, mode::RADIANCE);
            let back = discrete(bsdf, tables, wl, wc, vertex.event);
            vertex.value = forward.value * turned.value;
            vertex.pdf_to_light = forward.pdf;
            vertex.pdf_to_sensor = back.pdf;
            // The relative index of the reverse direction leads from the light's side to the sensor's.
            vertex.ratio = of_light / of_importance / (float::sqr(forward.eta) * back.exchange);
            vertex.is_unique = forward.is_unique && back.is_unique;
        }
        let is_lit = vertex.value.max_element() > 0.0;
        if is_lit {
            visit(self, i, [wc, wl], bsdf);
        }
        is_lit
    }

    /// |cos| at vertex `i` of a direction with the geometric normal; one where there is no surface.
    #[inline]
    pub(super) fn cosine(&self, i: usize, direction: Vec3) -> f32 {
        float::abs(self.vertices[i].point.geometric_normal.dot(direction))
    }

    /// Squared length of the edge to the next vertex.
    #[inline]
    pub(super) fn distance2(&self, i: usize) -> f32 {
        (self.vertices[i + 1].point.position - self.vertices[i].point.position).length_squared()
    }

    /// cos_0 of the header.
    fn light_cosine(&self, tables: &Tables<'_>) -> f32 {
        if tables.emitters[self.emitter as usize].kind == emitter_kind::AREA {
            self.cosine(0, self.to_light)
        } else {
            1.0
        }
    }

    /// Turns the density of vertex `i` per area into one per solid angle at the next, or over the film before the lens: d^2 /
    /// cos, one for directions to lights at infinity.
    pub fn solid_angle_per_area(&self, tables: &Tables<'_>, i: usize) -> f32 {
        let k = self.edges();
        if i + 1 == k {
            let cosine = if i == 0 {
                self.light_cosine(tables)
            } else {
                self.cosine(i, self.to_lens)
            };
            return 1.0 / (self.importance * cosine);
        }
        if i == 0 {
            if self.is_infinite(tables) {
                return 1.0;
            }
            return self.distance2(0) / self.light_cosine(tables);
        }
        self.distance2(i) / self.cosine(i, self.next_direction(i))
    }

    /// The ratio r_i of an inner vertex.
    pub fn light_ratio(&self, i: usize) -> f32 {
        let cosines =
            self.cosine(i, self.previous_direction(i)) / self.cosine(i, self.next_direction(i));
        cosines * self.vertices[i].ratio
    }

    /// cos_i / cos_0 of a light subpath's last vertex `i` >= 1.
    pub fn end_ratio(&self, tables: &Tables<'_>, i: usize) -> f32 {
        self.cosine(i, self.previous_direction(i)) / self.light_cosine(tables)
    }
}
