//! The bounces of walks from both ends, and what is connected there.

use super::reuse::SharedWalks;
use super::vertex_store::VertexStore;
use crate::math::{Rgb, vec3};
use crate::path::rules::step;
use crate::path::{
    Connector, Contribution, Contributions, Heuristic, Interaction, LightEnd, PathVertex,
    PhotonDensity, ShadingPoint, Strategies, Walk,
};
use crate::regularize::settings::Regularization;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::{self, EmissionSample};
use crate::scene::emitter::{self, DirectSample};
use crate::scene::{Hit, NONE, SurfacePoint, Tables, camera};
use crate::transport::photon::merging::merging_share;
use crate::transport::settings::{IntegratorSettings, integrator_kind};
use glam::{Vec2, Vec3};

/// A light subpath, to whose vertices those of a camera walk are connected.
#[derive(Clone, Copy)]
pub struct LightSubpath<'a, V> {
    /// Where its vertices are kept.
    pub store: &'a V,
    /// The index of the last of them, [`NONE`] without any.
    pub last: u32,
    /// Its start.
    pub start: &'a EmissionSample,
    /// The walks of all vertices in the store, where connections go to any of them.
    pub shared: SharedWalks,
}

/// Storage for the two ends of a connection.
#[derive(Clone, Copy)]
pub struct ConnectedPoints {
    /// Where the camera walk has arrived, or a light walk alone.
    pub arrived: ShadingPoint,
    /// The vertex of the light walk.
    pub light: ShadingPoint,
}

impl ConnectedPoints {
    /// Nothing yet.
    pub const NONE: ConnectedPoints = ConnectedPoints {
        arrived: ShadingPoint::NONE,
        light: ShadingPoint::NONE,
    };
}

/// The algorithm over a scene.
#[derive(Clone, Copy)]
pub struct Bidirectional<'a> {
    /// What connections have in common.
    pub connector: Connector<'a>,
    /// Whether there are camera walks.
    pub has_camera_walks: bool,
    /// Connections of a camera vertex with vertices of shared light walks, zero for all of its own.
    pub connections: u32,
}

impl<'a> Bidirectional<'a> {
    /// With the strategies that the settings ask for.
    pub fn new(tables: &'a Tables<'a>, settings: &IntegratorSettings) -> Bidirectional<'a> {
        let parameters = &settings.bidirectional;
        let traces_light = settings.kind == integrator_kind::LIGHT_TRACING;
        let merges = settings.kind == integrator_kind::VERTEX_MERGING;
        let connects = !merges || settings.photon.connections != 0;
        Bidirectional {
            connector: Connector {
                tables,
                rules: settings.rules,
                strategies: Strategies {
                    heuristic: Heuristic {
                        is_power: parameters.power_heuristic != 0,
                        merging: 0.0,
                        connects,
                    },
                    light_image: traces_light || connects && parameters.light_image != 0,
                    sample_direct: parameters.sample_direct != 0,
                    only_s: parameters.only_s,
                    only_t: if traces_light { 1 } else { parameters.only_t },
                    unweighted: traces_light || parameters.unweighted != 0,
                    meets_lens: true,
                },
                photons: PhotonDensity::unknown(tables),
                regularization: Regularization::NONE,
            },
            has_camera_walks: !traces_light,
            connections: parameters.connections,
        }
    }

    /// With photons to merge, of a pass of `emitted` light walks that are merged within `radius`, and what is known of how many
    /// are found.
    #[must_use]
    pub fn merging(
        mut self,
        radius: f32,
        emitted: u32,
        photons: PhotonDensity<'a>,
    ) -> Bidirectional<'a> {
        self.connector.strategies.heuristic.merging = merging_share(radius, emitted);
        self.connector.photons = photons;
        self
    }

    /// With the regularisation of a sample.
    #[must_use]
    pub fn regularized(mut self, regularization: Regularization) -> Bidirectional<'a> {
        self.connector.regularization = regularization;
        self
    }

    /// The ray with which a light walk begins.
    #[inline]
    pub fn emit<S: Sampler>(&self, sampler: &mut S) -> EmissionSample {
        let u_select = sampler.next_1d();
        let u_position = sampler.next_2d();
        let u_direction = sampler.next_2d();
        emission::sample(self.connector.tables, u_select, u_position, u_direction)
    }

    /// What the start of a light walk adds itself.
    #[inline]
    pub fn start<S: Sampler>(&self, start: &EmissionSample, sampler: &mut S) -> Contribution {
        if !self.connector.strategies.light_image {
            return Contribution::NONE;
        }
        let u_lens = self.lens_numbers(sampler);
        self.connector.start_to_lens(start, u_lens)
    }

    /// Numbers that choose a lens point, where the lens has more than one.
    #[inline]
    pub(crate) fn lens_numbers<S: Sampler>(&self, sampler: &mut S) -> Vec2 {
        if camera::has_lens_points(&self.connector.tables.camera) {
            sampler.next_2d()
        } else {
            Vec2::ZERO
        }
    }

    /// A sample of light for a surface at `position`, with a point of its emitter: drawn for it, or the `start` of the light walk.
    pub(crate) fn light_sample<S: Sampler>(
        &self,
        position: Vec3,
        start: &EmissionSample,
        sampler: &mut S,
    ) -> (DirectSample, SurfacePoint) {
        let connector = &self.connector;
        if !connector.strategies.sample_direct {
            return (connector.start_sample(position, start), start.point);
        }
        let u_select = sampler.next_1d();
        let u = sampler.next_2d();
        emitter::sample_direct_with_point(connector.tables, position, u_select, u)
    }

    /// The vertex at which a walk has arrived, as it is connected.
    #[inline]
    fn interaction<'p>(&self, site: &'p ShadingPoint, walk: &Walk) -> Interaction<'p> {
        let regularization = &self.connector.regularization;
        site.interaction(walk.subpath.ray.direction)
            .regularized(regularization.tau, regularization.flags)
    }

    /// One bounce of a light walk, from what its ray meets to its next ray: hands what it adds to `found`, keeps the vertex in
    /// `store`, with `last` the index of the walk's vertex before and then of this, and scatters. Returns what is next,
    /// [`step::TRACE`] or [`step::END`]. `site` is a buffer for the surface.
    pub fn light_bounce<S: Sampler, V: VertexStore>(
        &self,
        walk: &mut Walk,
        sampler: &mut S,
        hit: &Hit,
        site: &mut ShadingPoint,
        store: &mut V,
        last: &mut u32,
        mut found: impl Contributions,
    ) -> u32 {
        let connector = &self.connector;
        let met = connector.lens_hit(walk, hit.t);
        if met.is_some() {
            found.add(met);
        }
        let edges = walk.subpath.depth + 1;
        // On the last edge only a lens behind a mask is left to meet.
        let (_, next) = connector.arrive(walk, hit, site);
        if next != step::SCATTER {
            return next;
        }
        let at = self.interaction(site, walk);
        let is_mollified = connector.mollifies(&at);
        if at.is_connectable() || is_mollified {
            if connector.strategies.light_image {
                let u_lens = self.lens_numbers(sampler);
                if is_mollified {
                    let seen = connector.mollified_to_lens(walk, &at, u_lens);
                    add_some(&mut found, seen, &at);
                }
                let seen =
                    connector.to_lens(walk.subpath.throughput, walk.arrived, edges, &at, u_lens);
                if seen.is_some() {
                    found.add_at(seen, &at);
                }
            }
            if self.has_camera_walks {
                *last = store.push(&walk.vertex(hit, &at, *last));
                if *last == NONE {
                    return step::END;
                }
            }
        }
        connector.scatter(walk, &at, sampler)
    }

    /// One bounce of a camera walk, connected to the vertices and to the start of a `light` subpath. `add` takes what may be
    /// shadowed; what the walk found itself is returned with what is next, as [`Bidirectional::light_bounce`] says it.
    /// `points` is a buffer for the surface.
    pub fn camera_bounce<S: Sampler, V: VertexStore>(
        &self,
        walk: &mut Walk,
        sampler: &mut S,
        hit: &Hit,
        points: &mut ConnectedPoints,
        light: &LightSubpath<'_, V>,
        add: impl Contributions,
    ) -> (Rgb, u32) {
        let no_merging = |_: &Walk, _: &Interaction<'_>| Vec3::ZERO;
        self.camera_bounce_merging(walk, sampler, hit, points, light, no_merging, add)
    }

    /// [`Bidirectional::camera_bounce`] with what `merge` finds around the vertex where the walk has arrived.
    pub fn camera_bounce_merging<S: Sampler, V: VertexStore>(
        &self,
        walk: &mut Walk,
        sampler: &mut S,
        hit: &Hit,
        points: &mut ConnectedPoints,
        light: &LightSubpath<'_, V>,
        merge: impl Fn(&Walk, &Interaction<'_>) -> Rgb,
        mut add: impl Contributions,
    ) -> (Rgb, u32) {
        let connector = &self.connector;
        let tables = connector.tables;
        let (mut found, next) = connector.arrive(walk, hit, &mut points.arrived);
        if next != step::SCATTER {
            return (found, next);
        }
        let at = self.interaction(&points.arrived, walk);
        // Merging is none of the strategies that can be shown alone.
        if at.is_connectable() && connector.strategies.shows_all() {
            found += merge(walk, &at);
        }
        let is_mollified = connector.mollifies(&at);
        let is_connected = at.is_connectable() || is_mollified;
        if is_connected && connector.strategies.heuristic.connects {
            let lit = if connector.strategies.sample_direct {
                let u_select = sampler.next_1d();
                let u = sampler.next_2d();
                if is_mollified {
                    let light = emitter::sample_direct(tables, at.point.position, u_select, u);
                    let lit = connector.mollified_next_event(walk, &at, &light);
                    add_some(&mut add, lit, &at);
                }
                connector.next_event(walk, &at, u_select, u)
            } else {
                if is_mollified {
                    let light = connector.start_of(light.start, at.point.position);
                    let lit = connector.mollified_next_event(walk, &at, &light);
                    add_some(&mut add, lit, &at);
                }
                connector.start_event(walk, &at, light.start)
            };
            if lit.is_some() {
                add.add_at(lit, &at);
            }
            let site = &mut points.light;
            // A cone that only few vertices lie in wants all of them.
            if light.shared.vertices > 0 && connector.regularization.radius <= 0.0 {
                self.connect_shared(walk, sampler, &at, site, light, &mut add);
            } else {
                self.connect(walk, &at, site, light, &mut add);
            }
        }
        let next = connector.scatter(walk, &at, sampler);
        (found, next)
    }

    /// Connections between where a camera walk has arrived and the vertices of a light subpath; `site` is a buffer for those.
    fn connect<V: VertexStore>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        site: &mut ShadingPoint,
        light: &LightSubpath<'_, V>,
        add: &mut impl Contributions,
    ) {
        let facing = at.facing();
        let mut index = light.last;
        while index != NONE {
            let vertex = light.store.get(index);
            index = vertex.previous;
            if !self.may_connect(walk, at, facing, &vertex) {
                continue;
            }
            self.connect_to(walk, at, site, &vertex, 1.0, add);
        }
    }

    /// Whether a vertex of a light walk may be connected to where a camera walk has arrived, whose side is `facing`: tests that cost little,
    /// because most pairs do not see each other.
    #[inline]
    pub(crate) fn may_connect(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        facing: Vec3,
        vertex: &PathVertex,
    ) -> bool {
        let edges = vertex.depth.saturating_add(walk.subpath.depth);
        let between = vec3(vertex.position) - at.point.position;
        let is_hidden = facing.dot(between) < 0.0 || vec3(vertex.facing).dot(between) > 0.0;
        self.connector.allows_edges(edges.saturating_add(2)) && !is_hidden
    }

    /// Connections between where a camera walk has arrived and a few vertices of all light walks, see [`SharedWalks`].
    fn connect_shared<S: Sampler, V: VertexStore>(
        &self,
        walk: &Walk,
        sampler: &mut S,
        at: &Interaction<'_>,
        site: &mut ShadingPoint,
        light: &LightSubpath<'_, V>,
        add: &mut impl Contributions,
    ) {
        let connector = &self.connector;
        let share = 1.0 / self.connections as f32;
        let mut k = 0;
        while k < self.connections {
            let u = sampler.next_2d();
            let (index, factor) = light.shared.choose(light.store, connector, walk, at, u);
            if index != NONE {
                let vertex = light.store.get(index);
                self.connect_to(walk, at, site, &vertex, factor * share, add);
            }
            k += 1;
        }
    }

    /// The connection between where a camera walk has arrived and a vertex of a light walk, times `factor`.
    fn connect_to(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        site: &mut ShadingPoint,
        vertex: &PathVertex,
        factor: f32,
        add: &mut impl Contributions,
    ) {
        let connector = &self.connector;
        let regularization = &connector.regularization;
        let direction = vertex.look_up(connector.tables, site);
        connector.sharpen(direction, site);
        let end = LightEnd::new(
            vertex,
            site.interaction(direction)
                .regularized(regularization.tau, regularization.flags),
        );
        let mut joined = connector.inner(&end, walk, at);
        if joined.is_some() {
            joined.value *= factor;
            add.add_between(joined, &end.at, at);
        }
        if connector.mollifies(at) || connector.mollifies(&end.at) {
            let joined = connector.mollified_inner(&end, walk, at);
            if joined.is_some() {
                add.add_between(joined, &end.at, at);
            }
        }
    }
}

#[inline]
fn add_some(add: &mut impl Contributions, contribution: Contribution, at: &Interaction<'_>) {
    if contribution.is_some() {
        add.add_at(contribution, at);
    }
}
