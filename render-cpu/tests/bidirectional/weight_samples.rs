//! Samples whose weights are compared with those of the densities of all strategies, path by path.

use crate::densities::{FullPath, LightEndPoint};
use crate::scenes::{View, with_view};
use crate::weight_counts::{Checked, Weighting, reference, weight};
use glam::{Vec2, Vec3};
use halflight::scene::build::Scene;
use halflight_kernel::bsdf::mode;
use halflight_kernel::path::rules::step;
use halflight_kernel::path::{
    Connector, Contribution, Interaction, LightEnd, PhotonDensity, ShadingPoint, Walk,
};
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::emitter::emission::EmissionSample;
use halflight_kernel::scene::{Hit, NONE, SurfacePoint, Traverse, camera, emitter};
use halflight_kernel::transport::bidirectional::Bidirectional;
use halflight_kernel::transport::camera_ray;
use halflight_kernel::transport::photon::merging::{merging_share, merging_weight};
use halflight_kernel::transport::settings::integrator_kind;

/// Vertices of a walk at most.
const VERTICES: usize = 5;

/// Where a walk has arrived.
#[derive(Clone)]
struct Arrived {
    walk: Walk,
    site: ShadingPoint,
    hit: Hit,
}

impl Arrived {
    fn interaction(&self) -> Interaction<'_> {
        self.site.interaction(self.walk.subpath.ray.direction)
    }
}

/// A sample's walks, and what its weights are compared with.
struct Sample<'a> {
    view: &'a View<'a>,
    algorithm: Bidirectional<'a>,
    number: u32,
    weighting: Weighting,
    checked: Checked,
}

impl Sample<'_> {
    fn connector(&self, unweighted: bool) -> Connector<'_> {
        let mut connector = self.algorithm.connector;
        connector.strategies.unweighted = unweighted;
        connector
    }

    /// Compares a weight with that of strategy `s`; whether there was one.
    fn compare(&self, found: Option<f64>, path: &FullPath, s: usize) -> u32 {
        let tables = &self.view.tables;
        let Some(found) = found.filter(|_| path.is_well_conditioned(tables)) else {
            return 0;
        };
        let Weighting {
            is_power,
            radius,
            emitted,
        } = self.weighting;
        let n_area = f64::from(merging_share(radius, emitted));
        let photons = self.algorithm.connector.photons;
        let eta = |position: Vec3| n_area / (1.0 + n_area * f64::from(photons.at(position)));
        let p = path.densities(tables, eta);
        let expected = reference(&p, s, is_power);
        assert!(
            (found - expected).abs() < 1e-3 * expected + 1e-5,
            "sample {}, s = {s} of {} edges: {found} instead of {expected}, densities {p:?}",
            self.number,
            path.inner.len() + 1
        );
        1
    }

    /// Follows a walk; calls `at_ray` with each of its rays and what they hit. Returns where it arrived, and as what it left the
    /// scene if it did.
    fn follow(
        &self,
        mut walk: Walk,
        sampler: &mut IndependentSampler,
        mut at_ray: impl FnMut(&Walk, &Hit, &[Arrived]),
    ) -> (Vec<Arrived>, Option<Walk>) {
        let connector = self.connector(false);
        let mut arrived = Vec::new();
        while arrived.len() < VERTICES {
            let hit = self.view.traverse.closest_hit(&walk.subpath.ray);
            at_ray(&walk, &hit, &arrived);
            if !hit.is_hit() {
                return (arrived, Some(walk));
            }
            let mut site = ShadingPoint::NONE;
            let (_, next) = connector.arrive(&mut walk, &hit, &mut site);
            if next != step::SCATTER {
                break;
            }
            arrived.push(Arrived { walk, site, hit });
            let at = site.interaction(walk.subpath.ray.direction);
            let h = connector.heuristic_at(site.point.position);
            if walk.scatter(connector.tables, &connector.rules, h, sampler, &at) != step::TRACE {
                break;
            }
        }
        (arrived, None)
    }

    fn check(&mut self) {
        let tables = &self.view.tables;
        let mut sampler = IndependentSampler::new(3, 0, self.number);
        let start = self.algorithm.emit(&mut sampler);
        let mut light = Vec::new();
        let mut checked = Checked::default();
        let end = LightEndPoint {
            emitter: start.emitter,
            point: start.point,
            direction: start.ray.direction,
        };
        if start.is_some() {
            let walk = Walk::from_emitter(&start);
            (light, _) = self.follow(walk, &mut sampler, |walk, hit, arrived| {
                let met = weight(|plain| self.connector(plain).lens_hit(walk, hit.t));
                let lens = camera::intersect_lens(&tables.camera, &walk.subpath.ray);
                let path = FullPath {
                    light: end,
                    inner: arrived.iter().map(|a| a.site.point).collect(),
                    lens: walk.subpath.ray.at(lens.t),
                };
                checked.lens_hit += self.compare(met, &path, arrived.len() + 2);
            });
        }
        let pixel = [self.number % 8, self.number / 8 % 6];
        let seen = camera_ray(tables, &mut sampler, pixel);
        let (cameras, escaped) = self.follow(Walk::from_sensor(&seen), &mut sampler, |_, _, _| {});
        self.checked.lens_hit += checked.lens_hit;

        self.start_to_lens(&start, end, &mut sampler);
        for i in 0..light.len() {
            self.light_vertex(&light[..=i], end, &cameras, seen.ray.origin, &mut sampler);
        }
        for j in 0..cameras.len() {
            self.camera_vertex(&cameras[..=j], &start, seen.ray.origin, &mut sampler);
        }
        if let Some(walk) = escaped {
            let left = weight(|plain| Contribution {
                value: self.connector(plain).escaped(&walk),
                ..Contribution::NONE
            });
            let path = FullPath {
                light: LightEndPoint {
                    emitter: tables.info.environment,
                    point: SurfacePoint::ZERO,
                    direction: -walk.subpath.ray.direction,
                },
                inner: cameras.iter().rev().map(|c| c.site.point).collect(),
                lens: seen.ray.origin,
            };
            if left.is_some() {
                self.checked.emitted += self.compare(left, &path, 0);
            }
        }
    }

    /// Numbers for a lens point.
    fn lens_numbers(&self, sampler: &mut IndependentSampler) -> Vec2 {
        sampler.next_2d()
    }

    /// The lens point that a position is connected to.
    fn lens_point(&self, position: Vec3, u: Vec2) -> Vec3 {
        let seen = camera::film_position(&self.view.tables, position, u);
        position + seen.direction * seen.distance
    }

    /// s = 1, t = 1.
    fn start_to_lens(
        &mut self,
        start: &EmissionSample,
        end: LightEndPoint,
        sampler: &mut IndependentSampler,
    ) {
        let u = self.lens_numbers(sampler);
        let seen = weight(|plain| self.connector(plain).start_to_lens(start, u));
        let lens = self.lens_point(start.point.position, u);
        let path = FullPath {
            light: LightEndPoint {
                direction: (lens - start.point.position).normalize_or_zero(),
                ..end
            },
            inner: Vec::new(),
            lens,
        };
        self.checked.to_lens += self.compare(seen, &path, 1);
    }

    /// The last vertex of a light walk, seen by the lens, connected to those of a camera walk, and merged there.
    fn light_vertex(
        &mut self,
        light: &[Arrived],
        end: LightEndPoint,
        cameras: &[Arrived],
        lens: Vec3,
        sampler: &mut IndependentSampler,
    ) {
        let last = &light[light.len() - 1];
        let at = last.interaction();
        if !at.bsdf.has_smooth() {
            return;
        }
        let s = light.len() + 1;
        let surfaces = || light.iter().map(|l| l.site.point);
        let u = self.lens_numbers(sampler);
        let (beta, weights) = (last.walk.subpath.throughput, last.walk.arrived);
        let seen = weight(|plain| {
            self.connector(plain)
                .to_lens(beta, weights, light.len() as u32, &at, u)
        });
        let path = FullPath {
            light: end,
            inner: surfaces().collect(),
            lens: self.lens_point(at.point.position, u),
        };
        self.checked.to_lens += self.compare(seen, &path, s);
        let vertex = last.walk.vertex(&last.hit, &at, NONE);
        let connected = LightEnd::new(&vertex, at);
        for (j, camera) in cameras.iter().enumerate() {
            let other = camera.interaction();
            if !other.bsdf.has_smooth() {
                continue;
            }
            let joined = weight(|plain| {
                self.connector(plain)
                    .inner(&connected, &camera.walk, &other)
            });
            let behind = cameras[..=j].iter().rev().map(|c| c.site.point);
            let path = FullPath {
                light: end,
                inner: surfaces().chain(behind).collect(),
                lens,
            };
            self.checked.inner += self.compare(joined, &path, s);
            // The same path, merged at the camera's vertex by a light walk that had been scattered there.
            let between = other.point.position - at.point.position;
            let direction = between.normalize();
            let connector = self.connector(false);
            let rules = &connector.rules;
            let sent = at.evaluate(connector.tables, rules, mode::IMPORTANCE, direction);
            let cosines = [at.point, other.point].map(|p| p.geometric_normal.dot(direction).abs());
            let h = connector.heuristic_at(at.point.position);
            let photon = weights
                .scatter(h, sent.pdf, sent.pdf_reverse, cosines[0])
                .arrive(h, between.length_squared(), cosines[1]);
            let seen = other.evaluate(connector.tables, rules, mode::RADIANCE, -direction);
            let merges = self.weighting.radius > 0.0 && sent.is_some() && seen.is_some();
            let merged = merges.then(|| {
                f64::from(merging_weight(
                    &connector,
                    photon,
                    &camera.walk,
                    seen.pdf,
                    seen.pdf_reverse,
                    other.point.position,
                ))
            });
            let i = light.len() + 1;
            self.checked.merged += self.compare(merged, &path, path.merged_at(i));
        }
    }

    /// The last vertex of a camera walk: light that is sampled there, photons straight from it, and emission that is met.
    fn camera_vertex(
        &mut self,
        cameras: &[Arrived],
        start: &EmissionSample,
        lens: Vec3,
        sampler: &mut IndependentSampler,
    ) {
        let tables = &self.view.tables;
        let last = &cameras[cameras.len() - 1];
        let point = last.site.point;
        let emitted = weight(|plain| Contribution {
            value: self.connector(plain).emitted(&last.walk, &point),
            ..Contribution::NONE
        });
        if emitted.is_some() {
            let path = FullPath {
                light: LightEndPoint {
                    emitter: point.emitter,
                    point,
                    direction: -last.walk.subpath.ray.direction,
                },
                inner: cameras[..cameras.len() - 1]
                    .iter()
                    .rev()
                    .map(|c| c.site.point)
                    .collect(),
                lens,
            };
            self.checked.emitted += self.compare(emitted, &path, 0);
        }
        let at = last.interaction();
        if !at.bsdf.has_smooth() {
            return;
        }
        let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
        let (light, light_point) =
            emitter::sample_direct_with_point(tables, point.position, u_select, u);
        if !light.is_some() {
            return;
        }
        // Lights without a surface have a position all the same.
        let light_point = if light_point.emitter == NONE {
            SurfacePoint {
                position: light.target,
                ..SurfacePoint::ZERO
            }
        } else {
            light_point
        };
        let path = FullPath {
            light: LightEndPoint {
                emitter: light.emitter,
                point: light_point,
                direction: -light.direction,
            },
            inner: cameras.iter().rev().map(|c| c.site.point).collect(),
            lens,
        };
        let lit = weight(|plain| {
            self.connector(plain)
                .next_event(&last.walk, &at, u_select, u)
        });
        self.checked.lit += self.compare(lit, &path, 1);
        // Light straight from the emitter, merged.
        if light_point.emitter == NONE || !(self.weighting.radius > 0.0) {
            return;
        }
        let direction = -light.direction;
        let emission = EmissionSample {
            ray: light_point.spawn(direction),
            point: light_point,
            emitter: light.emitter,
            ..*start
        };
        let mut photon = Walk::from_emitter(&emission);
        let connector = self.connector(false);
        photon.update_weights(tables, &connector.rules, &connector.strategies, &point);
        let seen = at.evaluate(tables, &connector.rules, mode::RADIANCE, -direction);
        let is_lit = seen.is_some() && light_point.frame.n.dot(direction) > 0.0;
        let merged = is_lit.then(|| {
            f64::from(merging_weight(
                &connector,
                photon.arrived,
                &last.walk,
                seen.pdf,
                seen.pdf_reverse,
                point.position,
            ))
        });
        self.checked.merged += self.compare(merged, &path, path.merged_at(1));
    }
}

/// The weights of all strategies that complete the subpaths of some samples.
pub fn check(scene: &Scene, samples: u32, weighting: Weighting) -> Checked {
    let mut settings = scene.settings;
    settings.kind = integrator_kind::BIDIRECTIONAL;
    settings.rules.max_depth = 2 * VERTICES as u32 + 2;
    settings.rules.rr_depth = 100;
    settings.bidirectional.power_heuristic = weighting.is_power.into();
    // Any function of the position does.
    let counts: Vec<u32> = (0..64).map(|i| i * i % 61).collect();
    let density = PhotonDensity {
        counts: &counts,
        entries: 64,
        cells_per_length: 4.0,
        per_count: 0.05,
    };
    let mut checked = Checked::default();
    with_view(scene, |view| {
        let algorithm = Bidirectional::new(&view.tables, &settings);
        let algorithm = algorithm.merging(weighting.radius, weighting.emitted, density);
        for number in 0..samples {
            let mut sample = Sample {
                view,
                algorithm,
                number,
                weighting,
                checked,
            };
            sample.check();
            checked = sample.checked;
        }
    });
    checked
}
