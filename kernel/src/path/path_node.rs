//! Vertices of subpaths whose regularisation depends on the full path: what each keeps so that a connection can go along both
//! subpaths without a look at surfaces that are not shiny.
//!
//! Heuristics of Jendersie and Grosch 2019, section 3.5 need bounds of the BSDF and the mean curvature at each vertex; weights
//! ([`super::path_weights`]) need densities in both directions. All of these are kept. Only where a material may be regularised
//! is it looked up again, for the tau that the rest of the path leaves it.
//!
//! Hosts only, because it takes storage for every vertex of both subpaths.

use super::connection::Connector;
use super::evaluation::Interaction;
use super::path_weights::{InnerVertex, LightStart};
use super::shading_point::ShadingPoint;
use super::spread::{emission_bound, mean_curvature};
use super::strategies::Strategies;
use super::vertex::PathVertex;
use super::walk::Walk;
use crate::bsdf::{event, lobe, mode};
use crate::regularize::bandwidth::TAU_MAX;
use crate::regularize::both_ways;
use crate::regularize::heuristic::SamplerQuality;
use crate::regularize::regularized_bsdf::mixture_bound;
use crate::regularize::settings::Regularization;
use crate::scene::emitter::emission::{self, is_delta, is_infinite, light_cosine};
use crate::scene::{Hit, SurfacePoint, Tables};
use glam::Vec3;

/// What a subpath has behind it where it arrives.
#[derive(Clone, Copy, Debug)]
pub struct SubpathSummary {
    /// Quality of the edges before the last.
    pub quality: SamplerQuality,
    /// Bound at the start of the last edge: of the BSDF there, of the light's emission, or of the sensor's response.
    pub bound: f32,
    /// Length of the last edge.
    pub edge: f32,
    /// Bound at the first vertex, for lights at infinity; zero at that vertex itself.
    pub first_bound: f32,
    /// Whether some vertex may be regularised.
    pub any_raised: bool,
}

/// A vertex of a subpath.
#[derive(Clone, Copy, Debug)]
pub struct PathNode {
    /// How it is looked up again.
    pub vertex: PathVertex,
    /// Geometric normal.
    pub normal: Vec3,
    /// Before it.
    pub summary: SubpathSummary,
    /// Whether its material may be regularised.
    pub is_raised: bool,
    /// Bounds of its BSDF for reflection and for transmission.
    pub bounds: [f32; 2],
    /// Mean curvature.
    pub curvature: f32,
    /// The light's end, of a light subpath.
    pub start: LightStart,
    /// Bound of the emission, times the bound at the first vertex the quality of a path from a light at infinity.
    pub emission_bound: f32,
    /// Whether the light is at infinity.
    pub is_infinite: bool,
    /// Largest value of the BSDF, of a camera subpath.
    pub tau: f32,
    /// Density of the first vertex per area perpendicular to the ray, of a camera subpath.
    pub first: f32,
    /// Whether a walk has left it.
    pub has_scattered: bool,
    /// How.
    pub scattering: ScatteringRecord,
}

/// How a walk has left a vertex.
#[derive(Clone, Copy, Debug)]
pub struct ScatteringRecord {
    /// Unit direction.
    pub direction: Vec3,
    /// Densities of the model, and of a camera subpath those of regularisation: to the light, and to the sensor.
    pub pdf: [f32; 2],
    /// Bound of the BSDF on the side to which it left.
    pub bound: f32,
    /// Whether that was a discrete event.
    pub is_discrete: bool,
    /// Whether light walks end here.
    pub is_one_way: bool,
}

impl ScatteringRecord {
    /// Not at all.
    const NONE: ScatteringRecord = ScatteringRecord {
        direction: Vec3::Z,
        pdf: [1.0; 2],
        bound: 0.0,
        is_discrete: false,
        is_one_way: false,
    };
}

impl PathNode {
    /// Where a walk has arrived behind `last`, its vertex before, if there is one; `sensor_bound` bounds the response of the sensor
    /// where light walks reach it.
    pub fn new(
        connector: &Connector<'_>,
        regularization: &Regularization,
        walk: &Walk,
        hit: &Hit,
        at: &Interaction<'_>,
        (previous, last): (u32, Option<&PathNode>),
        sensor_bound: f32,
    ) -> PathNode {
        let vertex = walk.vertex(hit, at, previous);
        let edge = (at.point.position - walk.subpath.position).length();
        let mut node = PathNode {
            vertex,
            normal: at.point.geometric_normal,
            summary: SubpathSummary {
                quality: SamplerQuality::EMPTY,
                bound: sensor_bound,
                edge,
                first_bound: 0.0,
                any_raised: false,
            },
            is_raised: both_ways::is_raised(at.bsdf, regularization.tau),
            bounds: [false, true].map(|transmits| mixture_bound(at.bsdf, transmits)),
            curvature: mean_curvature(at.point),
            start: LightStart::NONE,
            emission_bound: 0.0,
            is_infinite: false,
            tau: TAU_MAX,
            first: 0.0,
            has_scattered: false,
            scattering: ScatteringRecord::NONE,
        };
        if let Some(last) = last {
            node.start = last.start;
            node.emission_bound = last.emission_bound;
            node.is_infinite = last.is_infinite;
            node.first = last.first;
            let before = &last.summary;
            node.summary.first_bound = if before.first_bound > 0.0 {
                before.first_bound
            } else {
                last.scattering.bound
            };
            node.summary.bound = last.scattering.bound;
            node.summary.quality = before.quality;
            node.summary
                .quality
                .add(before.bound, last.scattering.bound, before.edge);
            node.summary.any_raised = before.any_raised || last.is_raised;
        } else if walk.mode == mode::IMPORTANCE {
            let point = walk.start_point(connector.tables);
            node.start_at(
                connector.tables,
                &connector.strategies,
                walk.emitter,
                &point,
                walk.subpath.ray.direction,
            );
        }
        node.summary.any_raised |= node.is_raised;
        node
    }

    /// The light's end, for the first vertex behind an emitter's point.
    fn start_at(
        &mut self,
        tables: &Tables<'_>,
        strategies: &Strategies,
        emitter: u32,
        point: &SurfacePoint,
        direction: Vec3,
    ) {
        let position = Vec3::from_array(self.vertex.position);
        self.start = light_start(tables, strategies, emitter, point, position, direction);
        self.emission_bound = emission_bound(tables, emitter);
        self.is_infinite = is_infinite(tables.emitters[emitter as usize].kind);
        self.summary.bound = self.emission_bound;
    }

    /// The walk has scattered here and is on its next ray.
    pub fn record_scattering(
        &mut self,
        tables: &Tables<'_>,
        regularization: &Regularization,
        at: &Interaction<'_>,
        walk: &Walk,
    ) {
        let direction = walk.subpath.ray.direction;
        let wo = at.point.frame.to_local(direction);
        let is_light_walk = walk.mode == mode::IMPORTANCE;
        let is_discrete = walk.event & event::DELTA != 0;
        self.has_scattered = true;
        self.scattering = ScatteringRecord {
            direction,
            pdf: [1.0; 2],
            bound: self.bound_towards(at, direction),
            is_discrete,
            is_one_way: is_discrete && has_one_way(tables, at, wo),
        };
        let hat = at.regularized(self.tau, regularization.flags);
        let is_regularized = !is_light_walk && hat.is_regularized();
        if is_regularized || !is_discrete {
            let evaluated = if is_regularized { hat } else { *at };
            let both = evaluated.eval_cosine_pdf_both(tables, wo, is_light_walk);
            self.scattering.pdf = if is_light_walk {
                [both.pdf_reverse, both.pdf]
            } else {
                [both.pdf, both.pdf_reverse]
            };
            self.scattering.is_discrete = is_discrete && !is_regularized;
        }
    }

    /// Bound of the BSDF for the unit world `direction`.
    pub fn bound_towards(&self, at: &Interaction<'_>, direction: Vec3) -> f32 {
        let wo = at.point.frame.to_local(direction);
        self.bounds[usize::from(at.wi.z * wo.z < 0.0)]
    }

    /// As a vertex of a path which the light subpath has passed, below `tau`; `site` is storage for its surface.
    pub fn inner_vertex_below(
        &self,
        tables: &Tables<'_>,
        regularization: &Regularization,
        tau: f32,
        site: &mut ShadingPoint,
    ) -> InnerVertex {
        let mut vertex = self.inner_vertex();
        if !self.is_raised || !(tau < TAU_MAX) {
            return vertex;
        }
        let direction = self.vertex.look_up(tables, site);
        let at = site
            .interaction(direction)
            .regularized(tau, regularization.flags);
        if at.is_regularized() {
            let wo = at.point.frame.to_local(self.scattering.direction);
            let both = at.eval_cosine_pdf_both(tables, wo, true);
            [vertex.pdf_to_light, vertex.pdf_to_sensor] = [both.pdf_reverse, both.pdf];
            vertex.is_connectable = true;
        }
        vertex
    }

    /// As a vertex of a path which its walk has passed, by the densities that it keeps.
    pub fn inner_vertex(&self) -> InnerVertex {
        InnerVertex {
            position: Vec3::from_array(self.vertex.position),
            normal: self.normal,
            pdf_to_light: self.scattering.pdf[0],
            pdf_to_sensor: self.scattering.pdf[1],
            is_connectable: !self.scattering.is_discrete,
            is_one_way: self.scattering.is_one_way,
        }
    }

    /// As the end of a subpath, with the densities to the light and to the sensor of a connection.
    pub fn end(&self, [pdf_to_light, pdf_to_sensor]: [f32; 2]) -> InnerVertex {
        InnerVertex {
            position: Vec3::from_array(self.vertex.position),
            normal: self.normal,
            pdf_to_light,
            pdf_to_sensor,
            is_connectable: true,
            is_one_way: false,
        }
    }

    /// Quality of all edges up to this vertex, whose BSDF is bounded by `bound` for the rest of the path.
    pub fn quality(&self, bound: f32) -> SamplerQuality {
        let summary = &self.summary;
        let mut quality = summary.quality;
        quality.add(summary.bound, bound, summary.edge);
        quality
    }

    /// Quality of the connection of a light at infinity, which is that of a path from it: of an infinite path all but the first
    /// edge has no length. `bound` is that of this vertex.
    pub fn quality_from_infinity(&self, bound: f32) -> f32 {
        let first = self.summary.first_bound;
        quality_at_infinity(if first > 0.0 { first } else { bound }, self.emission_bound)
    }
}

/// Quality of the connection of a vertex with a light at infinity.
pub fn quality_at_infinity(bound: f32, emission: f32) -> f32 {
    let mut quality = SamplerQuality::EMPTY;
    quality.add(bound, emission, 1.0);
    quality.value()
}

/// The light's end of a path whose first vertex lies at `position`, in the unit `direction` from a point of an emitter.
pub fn light_start(
    tables: &Tables<'_>,
    strategies: &Strategies,
    emitter: u32,
    point: &SurfacePoint,
    position: Vec3,
    direction: Vec3,
) -> LightStart {
    let distance2 = (position - point.position).length_squared();
    LightStart {
        emission: emission::density(tables, emitter, point, direction).product(),
        direct: strategies.pdf_direct(tables, emitter, position, point, direction),
        cosine: light_cosine(tables, emitter, point, direction, distance2),
        direction: -direction,
        is_delta: is_delta(tables.emitters[emitter as usize].kind),
    }
}

/// Whether light walks do not pass a discrete event because its normal is another one for them.
fn has_one_way(tables: &Tables<'_>, at: &Interaction<'_>, wo: Vec3) -> bool {
    (0..at.bsdf.lobe_count()).any(|i| {
        lobe::has_delta(at.bsdf.lobe_at(i)) && !at.bsdf.has_same_frame(tables, at.point, i, wo)
    })
}
