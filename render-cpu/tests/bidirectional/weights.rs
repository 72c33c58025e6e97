//! Weights by recursion against densities of all strategies that are multiplied out, path by path.

use crate::scenes::{LAMP, PINHOLE, View, room, scene, with_view};
use glam::Vec3;
use halflight::scene::build::Scene;
use halflight_kernel::bsdf::{Bsdf, mode};
use halflight_kernel::path::rules::step;
use halflight_kernel::path::{
    Connector, Contribution, Interaction, LightEnd, PathVertex, PhotonDensity, ShadingPoint, Walk,
};
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::emitter;
use halflight_kernel::scene::emitter::emission::{self, EmissionSample};
use halflight_kernel::scene::{NONE, SurfacePoint, Tables, camera};
use halflight_kernel::transport::bidirectional::{Bidirectional, VertexStore};
use halflight_kernel::transport::camera_ray;
use halflight_kernel::transport::photon::merging::{merging_share, merging_weight};
use halflight_kernel::transport::settings::integrator_kind;

#[derive(Default)]
struct Store(Vec<PathVertex>);

impl VertexStore for Store {
    fn push(&mut self, vertex: &PathVertex) -> u32 {
        self.0.push(*vertex);
        self.0.len() as u32 - 1
    }

    fn get(&self, index: u32) -> PathVertex {
        self.0[index as usize]
    }
}

/// Density per solid angle of the smooth part of the material between two neighbours.
fn pdf(tables: &Tables<'_>, at: &SurfacePoint, from: &SurfacePoint, to: &SurfacePoint) -> f64 {
    let local = |p: &SurfacePoint| at.frame.to_local((p.position - at.position).normalize());
    let bsdf = Bsdf::at(tables, at, local(from), mode::RADIANCE);
    f64::from(bsdf.pdf(tables.data, local(from), local(to)))
}

/// Solid angle at `from` per area at `to`.
fn per_area(from: &SurfacePoint, to: &SurfacePoint) -> f64 {
    let d = to.position - from.position;
    f64::from(to.geometric_normal.dot(d.normalize()).abs() / d.length_squared())
}

/// Densities of the strategies s = 0 ... k of a path, and of merging at its vertices 1 ... k - 1, each with
/// `eta` of its position as the area of a photon, of smooth vertices from an area light (the first point) to a pinhole (the last).
fn densities(tables: &Tables<'_>, path: &[SurfacePoint], eta: impl Fn(Vec3) -> f64) -> Vec<f64> {
    let k = path.len() - 1;
    let direction = (path[1].position - path[0].position).normalize();
    let emitted = emission::density(tables, path[0].emitter, &path[0], direction);
    let mut forward = vec![0.0; k];
    forward[0] = f64::from(emitted.position);
    if k > 1 {
        forward[1] = f64::from(emitted.direction) * per_area(&path[0], &path[1]);
    }
    for i in 2..k {
        forward[i] =
            pdf(tables, &path[i - 1], &path[i - 2], &path[i]) * per_area(&path[i - 1], &path[i]);
    }
    let to_lens = path[k].position - path[k - 1].position;
    let cosine = path[k - 1].geometric_normal.dot(to_lens.normalize()).abs();
    let mut reverse = vec![0.0; k];
    reverse[k - 1] = f64::from(
        camera::pdf_perpendicular_area(tables, path[k - 1].position, to_lens.length()) * cosine,
    );
    for i in 0..k - 1 {
        reverse[i] =
            pdf(tables, &path[i + 1], &path[i + 2], &path[i]) * per_area(&path[i + 1], &path[i]);
    }
    let direct = f64::from(emitter::pdf_direct(tables, path[1].position, &path[0]))
        * per_area(&path[1], &path[0]);
    let connected: Vec<f64> = (0..=k)
        .map(|s| {
            let start = match s {
                0 => 1.0,
                1 if k > 1 => direct,
                _ => forward[0],
            };
            let light: f64 = forward[..s].iter().skip(1).product();
            start * light * reverse[s..].iter().product::<f64>()
        })
        .collect();
    // Sampled from both ends: light walks emit their first vertex, whatever next event estimation would do.
    let merged = (1..k).map(|i| {
        let light: f64 = forward[..=i].iter().product();
        eta(path[i].position) * light * reverse[i..].iter().product::<f64>()
    });
    connected.iter().copied().chain(merged).collect()
}

/// The share of a strategy by the power or balance heuristic.
fn reference(densities: &[f64], s: usize, is_power: bool) -> f64 {
    let h = |x: f64| if is_power { x * x } else { x };
    1.0 / densities.iter().map(|p| h(p / densities[s])).sum::<f64>()
}

/// The weight that a contribution was made with.
fn weight(make: impl Fn(bool) -> Contribution) -> Option<f64> {
    let (weighted, plain) = (make(false), make(true));
    let value = f64::from(plain.value.max_element());
    (value > 0.0).then(|| f64::from(weighted.value.max_element()) / value)
}

/// The weights of all strategies that complete the subpaths of some samples.
fn check(scene: &Scene, samples: u32, is_power: bool, photons: (f32, u32)) -> u32 {
    let mut checked = 0;
    with_view(scene, |view| {
        for sample in 0..samples {
            checked += check_sample(view, scene, sample, is_power, photons);
        }
    });
    checked
}

/// A camera walk where it has arrived.
struct CameraVertex {
    walk: Walk,
    point: SurfacePoint,
    bsdf: Bsdf,
}

fn check_sample(
    view: &View<'_>,
    scene: &Scene,
    sample: u32,
    is_power: bool,
    (radius, emitted): (f32, u32),
) -> u32 {
    let n_area = f64::from(merging_share(radius, emitted));
    // Any function of the position does.
    let counts: Vec<u32> = (0..64).map(|i| i * i % 61).collect();
    let density = PhotonDensity {
        counts: &counts,
        cells_per_length: 4.0,
        per_count: 0.05,
    };
    let eta = |position: Vec3| n_area / (1.0 + n_area * f64::from(density.at(position)));
    let tables = &view.tables;
    let mut settings = scene.settings;
    settings.kind = integrator_kind::BIDIRECTIONAL;
    settings.rules.max_depth = 7;
    settings.rules.rr_depth = 100;
    settings.bidirectional.power_heuristic = is_power.into();
    let algorithm = Bidirectional::new(tables, &settings).merging(radius, emitted, density);
    let connector = |unweighted: bool| {
        let mut strategies = algorithm.connector.strategies;
        strategies.unweighted = unweighted;
        Connector {
            strategies,
            ..algorithm.connector
        }
    };
    let mut sampler = IndependentSampler::new(3, 0, sample);
    let (store, start) = light_walk(view, &algorithm, &mut sampler);
    let cameras = camera_walk(view, &algorithm, &mut sampler, sample);
    let lens = SurfacePoint {
        position: camera::ray_through(&tables.camera, glam::Vec2::ONE, glam::Vec2::ZERO).origin,
        ..SurfacePoint::ZERO
    };
    let light_sites: Vec<ShadingPoint> = store
        .0
        .iter()
        .map(|vertex| {
            let mut site = ShadingPoint::NONE;
            vertex.look_up(tables, &mut site);
            site
        })
        .collect();
    let mut checked = 0;
    let mut compare = |found: Option<f64>, path: &[SurfacePoint], s: usize| {
        // Directions of shorter edges differ between positions and rays by more than the tolerance.
        let is_short = path
            .windows(2)
            .any(|edge| edge[0].position.distance(edge[1].position) < 0.02);
        if let Some(found) = found
            && !is_short
        {
            let p = densities(tables, path, eta);
            let expected = reference(&p, s, is_power);
            assert!(
                (found - expected).abs() < 1e-3 * expected + 1e-5,
                "sample {sample}, s = {s} of {}: {found} instead of {expected}, densities {p:?}",
                path.len() - 1
            );
            checked += 1;
        }
    };
    for (i, vertex) in store.0.iter().enumerate() {
        let at = light_sites[i].interaction(Vec3::from_array(vertex.direction));
        let mut path = vec![start.point];
        path.extend(light_sites[..=i].iter().map(|site| site.point));
        let end = LightEnd::new(vertex, at);
        let seen = weight(|plain| {
            let end_at = (end.throughput, end.weights);
            connector(plain).to_lens(end_at.0, end_at.1, end.edges, &at, glam::Vec2::ZERO)
        });
        compare(seen, &[path.as_slice(), &[lens]].concat(), i + 2);
        for (j, other) in cameras.iter().enumerate() {
            let at = Interaction::new(&other.point, &other.bsdf, other.walk.subpath.ray.direction);
            let joined = weight(|plain| connector(plain).inner(&end, &other.walk, &at));
            let mut whole = path.clone();
            whole.extend(cameras[..=j].iter().rev().map(|c| c.point));
            whole.push(lens);
            compare(joined, &whole, i + 2);
            // The same path, merged at the camera's vertex by a light walk that had been scattered there.
            let between = other.point.position - end.at.point.position;
            let direction = between.normalize();
            let rules = &connector(false).rules;
            let sent = end.at.evaluate(tables, rules, mode::IMPORTANCE, direction);
            let cosines =
                [end.at.point, &other.point].map(|p| p.geometric_normal.dot(direction).abs());
            let h = connector(false).heuristic_at(end.at.point.position);
            let photon = end
                .weights
                .scatter(h, sent.pdf, sent.pdf_reverse, cosines[0])
                .arrive(h, between.length_squared(), cosines[1]);
            if sent.is_some() {
                let seen = at.evaluate(tables, rules, mode::RADIANCE, -direction);
                let weight = seen.is_some().then(|| {
                    let w = merging_weight(
                        &connector(false),
                        photon,
                        &other.walk,
                        seen.pdf,
                        seen.pdf_reverse,
                        other.point.position,
                    );
                    f64::from(w)
                });
                let k = whole.len() - 1;
                compare(weight.filter(|_| n_area > 0.0), &whole, k + 1 + (i + 2) - 1);
            }
        }
    }
    for (j, vertex) in cameras.iter().enumerate() {
        let at = Interaction::new(
            &vertex.point,
            &vertex.bsdf,
            vertex.walk.subpath.ray.direction,
        );
        let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
        let (_, point) =
            emitter::sample_direct_with_point(tables, vertex.point.position, u_select, u);
        let lit = weight(|plain| connector(plain).next_event(&vertex.walk, &at, u_select, u));
        let mut path = vec![point];
        path.extend(cameras[..=j].iter().rev().map(|c| c.point));
        path.push(lens);
        compare(lit, &path, 1);
        // Light straight from a point of the emitter, merged.
        let direction = (vertex.point.position - point.position).normalize();
        let emission = EmissionSample {
            ray: point.spawn(direction),
            point,
            ..start
        };
        let mut photon = Walk::from_emitter(&emission);
        let rules = &connector(false).rules;
        photon.update_weights(tables, rules, &connector(false).strategies, &vertex.point);
        let seen = at.evaluate(tables, rules, mode::RADIANCE, -direction);
        let is_lit = seen.is_some() && point.frame.n.dot(direction) > 0.0;
        let merged = is_lit.then(|| {
            let w = merging_weight(
                &connector(false),
                photon.arrived,
                &vertex.walk,
                seen.pdf,
                seen.pdf_reverse,
                vertex.point.position,
            );
            f64::from(w)
        });
        compare(merged.filter(|_| n_area > 0.0), &path, path.len());
        let emitted = weight(|plain| Contribution {
            value: connector(plain).emitted(&vertex.walk, &vertex.point),
            ..Contribution::NONE
        });
        compare(emitted, &path[1..], 0);
    }
    checked
}

/// The vertices of a light walk, and its start.
fn light_walk(
    view: &View<'_>,
    algorithm: &Bidirectional<'_>,
    sampler: &mut IndependentSampler,
) -> (Store, EmissionSample) {
    use halflight_kernel::scene::Traverse;
    let mut store = Store::default();
    let mut last = NONE;
    let start = algorithm.emit(sampler);
    let mut walk = Walk::from_emitter(&start);
    let mut site = ShadingPoint::NONE;
    let mut next = if start.is_some() {
        step::TRACE
    } else {
        step::END
    };
    while next == step::TRACE {
        let hit = view.traverse.closest_hit(&walk.subpath.ray);
        next = algorithm.light_bounce(
            &mut walk,
            sampler,
            &hit,
            &mut site,
            &mut store,
            &mut last,
            |_| {},
        );
    }
    (store, start)
}

/// The places where a camera walk arrives.
fn camera_walk(
    view: &View<'_>,
    algorithm: &Bidirectional<'_>,
    sampler: &mut IndependentSampler,
    sample: u32,
) -> Vec<CameraVertex> {
    use halflight_kernel::scene::Traverse;
    use halflight_kernel::scene::surface::surface_at;
    let tables = &view.tables;
    let connector = &algorithm.connector;
    let mut vertices = Vec::new();
    let pixel = [sample % 8, sample / 8 % 6];
    let mut walk = Walk::from_sensor(&camera_ray(tables, sampler, pixel).ray);
    for _ in 0..5 {
        let hit = view.traverse.closest_hit(&walk.subpath.ray);
        if !hit.is_hit() {
            break;
        }
        let point = surface_at(tables, &walk.subpath.ray, &hit);
        walk.update_weights(tables, &connector.rules, &connector.strategies, &point);
        let wi = point.frame.to_local(-walk.subpath.ray.direction);
        let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
        vertices.push(CameraVertex { walk, point, bsdf });
        let at = Interaction::new(&point, &bsdf, walk.subpath.ray.direction);
        let h = connector.heuristic_at(point.position);
        if walk.scatter(tables, &connector.rules, h, sampler, &at) != step::TRACE {
            break;
        }
    }
    vertices
}

#[test]
fn weights_are_those_of_the_densities() {
    let materials = [
        r#"<bsdf type="diffuse"/>"#,
        r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>"#,
        r#"<bsdf type="roughplastic"><float name="alpha" value="0.2"/></bsdf>"#,
    ];
    for material in materials {
        for (is_power, photons) in [
            (false, (0.0, 0)),
            (true, (0.0, 0)),
            (false, (0.05, 1000)),
            (true, (0.02, 1000)),
        ] {
            let scene = scene(&format!("{PINHOLE}{LAMP}{}", room(material)), &[]);
            let checked = check(&scene, 2000, is_power, photons);
            assert!(checked > 5000, "{checked} weights");
        }
    }
}
