//! Along whole random paths: what regularisation does to values and densities at each vertex, and the weights of all strategies,
//! which recursion along subpaths and the sum for each path anew must agree about.

use crate::scenes::{ball, regularized, render_film, room, scene};
use crate::vertices::Vertices;
use crate::view::with_view;
use glam::vec3;
use halflight_kernel::bsdf::event;
use halflight_kernel::path::rules::step;
use halflight_kernel::path::{Contribution, Interaction, ShadingPoint, Walk};
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::bidirectional::adaptive::{Adaptive, AdaptiveWorkspace};
use halflight_kernel::transport::bidirectional::{Bidirectional, Unshadowed, sample_observed};
use halflight_kernel::transport::camera_ray;

const ROUGH_METAL: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.1"/>
    <string name="distribution" value="ggx"/></bsdf>"#;
const ROUGH_GLASS: &str =
    r#"<bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf>"#;
const GLASS: &str = r#"<bsdf type="dielectric"/>"#;
const PLASTIC: &str = r#"<bsdf type="plastic"/>"#;

fn of_tau(tau: f32) -> Regularization {
    Regularization {
        tau,
        ..Regularization::NONE
    }
}

fn numbers(pixel: u32, sample: u32, stream: u32) -> IndependentSampler {
    IndependentSampler::new(17 + stream, pixel, sample)
}

#[test]
fn sums_for_each_path_are_the_weights_of_the_recursion() {
    let mut compared = 0;
    for (walls, object) in [
        (ROUGH_METAL, ROUGH_GLASS),
        (ROUGH_METAL, GLASS),
        (PLASTIC, GLASS),
    ] {
        let scene = scene("bdpt", &room(walls, &ball(object)));
        with_view(&scene, |view| {
            let algorithm =
                Bidirectional::new(&view.tables, &scene.settings).regularized(of_tau(30.0));
            let adaptive = Adaptive::new(&algorithm);
            let mut room = Box::new(AdaptiveWorkspace::new());
            for pixel in 0..96 {
                for sample in 0..12 {
                    let at = [pixel % 12, pixel / 12];
                    let mut found = [Vec::new(), Vec::new()];
                    for (kind, found) in found.iter_mut().enumerate() {
                        let mut camera = numbers(pixel, sample, 0);
                        let mut light = numbers(pixel, sample, 1);
                        let seen = camera_ray(&view.tables, &mut camera, at);
                        let add = |c: Contribution| {
                            if c.is_some() {
                                found.push(c);
                            }
                        };
                        if kind == 0 {
                            let mut watcher = Unshadowed::new(view, scene.settings.rules, add);
                            let store = &mut Vertices::default();
                            sample_observed(
                                view,
                                &algorithm,
                                &mut light,
                                &mut camera,
                                &seen,
                                store,
                                &mut watcher,
                            );
                        } else {
                            let numbers = (&mut light, &mut camera);
                            adaptive.sample(view, None, numbers, &seen, &mut room, add);
                        }
                    }
                    for found in &mut found {
                        found.sort_by_key(|c| (c.s, c.t, c.value.x.to_bits()));
                    }
                    let [recursion, sums] = &found;
                    let of =
                        |list: &[Contribution]| list.iter().map(|c| (c.s, c.t)).collect::<Vec<_>>();
                    assert_eq!(of(recursion), of(sums), "pixel {pixel}, sample {sample}");
                    for (a, b) in recursion.iter().zip(sums) {
                        let error = (a.value - b.value).abs().max_element();
                        let scale = a.value.max_element();
                        assert!(
                            error <= 2e-3 * scale,
                            "{walls} {object}: ({}, {}): {} and {}",
                            a.s,
                            a.t,
                            a.value,
                            b.value
                        );
                        compared += 1;
                    }
                }
            }
        });
    }
    println!("{compared} strategies");
    assert!(compared > 8000, "{compared}");
}

/// The relative difference of two positive numbers.
fn difference(a: f32, b: f32) -> f32 {
    (a - b).abs() / a.abs().max(b.abs())
}

/// The index by whose square radiance is scaled on the way to a direction of height `z`.
fn radiance_index(at: &Interaction<'_>, z: f32) -> f32 {
    let eta = at.bsdf.lobe(0).eta.x;
    match (at.wi.z > 0.0, at.wi.z * z >= 0.0) {
        (_, true) => 1.0,
        (true, false) => eta,
        (false, false) => 1.0 / eta,
    }
}

/// Shares of the light from `wi` that are reflected and transmitted, by the midpoints of 96 by 96 cells of cos and angle, below tau.
fn albedo(at: &Interaction<'_>, scene: &SceneView<'_, impl Traverse>) -> [f32; 2] {
    let mut sums = [0.0; 2];
    let (rows, columns) = (96, 96);
    for i in 0..rows {
        let z = 2.0 * (i as f32 + 0.5) / rows as f32 - 1.0;
        let r = (1.0 - z * z).sqrt();
        for j in 0..columns {
            let phi = std::f32::consts::TAU * (j as f32 + 0.5) / columns as f32;
            let wo = vec3(r * phi.cos(), r * phi.sin(), z);
            let (f, _) = at.eval_cosine_pdf(&scene.tables, wo);
            // Radiance is scaled where it is refracted, flux is not.
            let eta = radiance_index(at, z);
            sums[usize::from(at.wi.z * z < 0.0)] += f.y * eta * eta;
        }
    }
    sums.map(|sum| sum * 4.0 * std::f32::consts::PI / (rows * columns) as f32)
}

#[test]
fn ratios_of_values_and_of_densities_are_equal_along_whole_paths() {
    let (mut vertices, mut raised, mut longest) = (0, 0, 0);
    let mut most = [0.0_f32; 3];
    for (walls, object) in [(ROUGH_METAL, ROUGH_GLASS), (ROUGH_METAL, ROUGH_METAL)] {
        let scene = scene("path", &room(walls, &ball(object)));
        with_view(&scene, |view| {
            let algorithm = Bidirectional::new(&view.tables, &scene.settings);
            let connector = &algorithm.connector;
            let mut site = ShadingPoint::NONE;
            for pixel in 0..96 {
                for sample in 0..24 {
                    let mut camera = numbers(pixel, sample, 2);
                    let tau = 10.0_f32.powf(1.0 + 3.0 * camera.next_1d());
                    let seen = camera_ray(&view.tables, &mut camera, [pixel % 12, pixel / 12]);
                    let mut walk = Walk::from_sensor(&seen);
                    let (mut values, mut densities) = (1.0_f32, 1.0_f32);
                    let mut next = step::TRACE;
                    while next == step::TRACE {
                        let hit = view.traverse.closest_hit(&walk.subpath.ray);
                        let direction = walk.subpath.ray.direction;
                        next = connector.arrive(&mut walk, &hit, &mut site).1;
                        if next != step::SCATTER {
                            continue;
                        }
                        let at = site.interaction(direction);
                        let h = connector.strategies.heuristic;
                        next = walk.scatter(&view.tables, &connector.rules, h, &mut camera, &at);
                        if next != step::TRACE {
                            continue;
                        }
                        assert_eq!(walk.event & event::DELTA, 0);
                        let wo = at.point.frame.to_local(walk.subpath.ray.direction);
                        let hat = at.regularized(tau, 0);
                        let plain = at.eval_cosine_pdf_both(&view.tables, wo, false);
                        let both = hat.eval_cosine_pdf_both(&view.tables, wo, false);
                        let value = both.value.y / plain.value.y;
                        let density = both.pdf / plain.pdf;
                        assert!(
                            difference(value, density) < 5e-3,
                            "{object}: f {value}, p {density}"
                        );
                        // The same for the way back, whose value is another one by the squared index.
                        let way_back = both.pdf_reverse / plain.pdf_reverse;
                        assert!(
                            difference(value, way_back) < 5e-3,
                            "{object}: f {value}, p of the way back {way_back}"
                        );
                        values *= value;
                        densities *= density;
                        // Reciprocity: f_hat / eta^2 of both ways.
                        let exchanged = hat.eval_cosine_pdf_both(&view.tables, wo, true);
                        let eta = radiance_index(&at, wo.z);
                        let there = both.value.y / wo.z.abs() * eta * eta;
                        let back = exchanged.value.y / at.wi.z.abs();
                        assert!(
                            difference(there, back) < 5e-3
                                || difference(there, back * eta * eta) < 5e-3,
                            "{object}: {there} there, {back} back, eta {eta}"
                        );
                        // What is sharper needs more cells.
                        if sample == 0 && tau < 300.0 {
                            let scattered = albedo(&hat, view);
                            let [reflected, transmitted] = scattered;
                            let parts = [reflected, transmitted, reflected + transmitted];
                            for (most, part) in most.iter_mut().zip(parts) {
                                *most = most.max(part);
                            }
                        }
                        vertices += 1;
                        raised += u32::from(hat.is_regularized());
                        longest = longest.max(walk.subpath.depth);
                    }
                    assert!(
                        difference(values, densities) < 2e-2,
                        "{values} and {densities} along a path"
                    );
                }
            }
        });
    }
    let [reflected, transmitted, both] = most;
    println!(
        "{vertices} vertices, {raised} below tau, depth {longest}; {reflected:.3} is reflected at most, {transmitted:.3} is \
         transmitted, {both:.3} both"
    );
    // Reflection and refraction have an alpha each, so that near the critical angle what one loses is not what the other gains.
    for part in [reflected, transmitted] {
        assert!(part > 0.3 && part < 1.01, "{part}");
    }
    assert!(both < 1.2, "{both}");
    assert!(vertices > 5000 && 2 * raised > vertices && longest > 4);
}

/// Photons as well: where the quality of no path is good enough, all of each is regularised.
#[test]
fn sums_for_each_path_give_the_image_of_the_recursion() {
    for (name, radius) in [("bdpt", 1.0), ("vcm", 0.01)] {
        let mut scene = scene(name, &room(ROUGH_METAL, &ball(GLASS)));
        scene.settings.photon.initial_radius = radius;
        scene.settings.photon.photon_count = 20_000;
        let [recursion, sums] = ["tau=0.16,constant", "tau=0.16,constant,quality"]
            .map(|options| render_film(&regularized(scene.clone(), options), 4).mean());
        let mut most: f64 = 0.0;
        for (a, b) in recursion.iter().flatten().zip(sums.iter().flatten()) {
            most = most.max((a - b).abs() / a);
        }
        println!("{name}: {most:.1e}");
        // A photon is merged beside the vertex, and the recursion knows where it was.
        assert!(most < 3e-3, "{name}: {most}");
    }
}
