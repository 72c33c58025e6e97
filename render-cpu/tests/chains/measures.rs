//! What paths carry per half vectors, on paths that walks find in real scenes: against densities per area, and against
//! differences.

use crate::brightness::{BALL, GLOSSY, POINT, SKY, camera};
use crate::scenes::{LAMP, NamedFile, PINHOLE, faceted_sphere, room, scene, sky};
use crate::tracing::{with_lit_paths, with_tracer};
use glam::{Vec2, Vec3};
use halflight::scene::build::Scene;
use halflight_kernel::bsdf::Bsdf;
use halflight_kernel::manifold::half_vector::half_vector;
use halflight_kernel::manifold::half_vector_form::{PROJECTED, SLOPE};
use halflight_kernel::manifold::mutation::density_factor;
use halflight_kernel::manifold::vertex_kind;
use halflight_kernel::transport::markov::half_vector::measure::{
    segment_factor, towards_light, vertex_factor,
};
use halflight_kernel::transport::markov::half_vector::path_chain::PathChain;
use halflight_kernel::transport::markov::half_vector::reconnection::Segment;
use halflight_kernel::transport::markov::half_vector::settings::roughness_kind;
use halflight_kernel::transport::markov::half_vector::tracing::scatter_at;
use halflight_kernel::transport::markov::veach::{ChainPath, MAX_VERTICES};

const ROUGH_SHEET: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/>
    <rotate y="1" angle="20"/><translate x="-0.3" y="1" z="1"/></transform>
    <bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>"#;
const FACETS: &str = r#"<shape type="obj"><string name="filename" value="sphere.obj"/>
    <transform name="to_world"><scale value="0.4"/><rotate x="1" angle="15"/><translate x="0.6" y="0.45" z="0.2"/></transform>
    <bsdf type="roughplastic"><float name="alpha" value="0.15"/></bsdf></shape>"#;

/// Calls `test` with paths that carry light and their chains.
fn with_paths(scene: &Scene, mut test: impl FnMut(&ChainPath, &PathChain)) {
    with_tracer(scene, |tracer| {
        let mut bsdf = Bsdf::BLACK;
        let mut chain = PathChain::EMPTY;
        let reference = Vec3::new(0.36, 0.48, 0.8);
        with_lit_paths(tracer, 1500, |path, _| {
            if path.edges() >= 2 && path.edges() <= 6 {
                let tables = &tracer.view.tables;
                chain.set(tables, path, reference, roughness_kind::LOCAL, &mut bsdf);
                test(path, &chain);
            }
        });
    });
}

fn cameras() -> [(&'static str, String); 3] {
    let thin =
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="3"/>"#;
    let parallel = PINHOLE
        .replace("perspective", "orthographic")
        .replace(r#"<float name="fov" value="60"/>"#, "");
    [
        ("pinhole", PINHOLE.to_string()),
        ("thin lens", camera("thinlens", thin)),
        ("parallel rays", parallel),
    ]
}

/// M(l..h) is the product of d w / d A over the edges, over |det J| of the vertices between the ends.
#[test]
fn factors_of_segments_are_those_of_areas_over_the_determinant() {
    let files: &[NamedFile<'_>] = &[("sky.exr", &sky), ("sphere.obj", &faceted_sphere)];
    let mut checked = [0; 2];
    for (name, camera) in &cameras() {
        for light in [LAMP, POINT, SKY] {
            let content = [camera, &room(GLOSSY), light, ROUGH_SHEET, FACETS].concat();
            let scene = scene(&content, files);
            let tables = scene.tables.view();
            with_paths(&scene, |path, chain| {
                let k = path.edges();
                // Edges within a surface are nothing but rounding.
                let leaves_surfaces = |i: usize| {
                    let (before, after) = (&chain.vertices[i - 1], &chain.vertices[i]);
                    let w = (after.position - before.position).normalize();
                    before.cosine(w).min(after.cosine(w)) > 1e-3
                };
                for form in [SLOPE, PROJECTED] {
                    for low in 0..k - 1 {
                        for high in low + 2..=k {
                            if !(low + 1..high).all(|i| path.vertices[i].is_smooth()) {
                                continue;
                            }
                            let segment = Segment::<MAX_VERTICES>::new(chain, low, high, form);
                            let Some(segment) = segment else { continue };
                            let j = &segment.jacobian;
                            if j.condition() > 3e3 || !(low + 1..=high).all(leaves_surfaces) {
                                continue;
                            }
                            let got = segment_factor(
                                &tables,
                                path,
                                chain,
                                &segment.vertices,
                                j,
                                low,
                                form,
                            );
                            let areas: f64 = (low..high)
                                .map(|i| f64::from(path.solid_angle_per_area(&tables, i)).ln())
                                .sum();
                            let expected = -areas - f64::from(density_factor(j).ln_abs());
                            let error = (f64::from(got.ln_abs()) - expected).abs();
                            // Positions of ends at infinity are rounded.
                            assert!(error < 0.02, "{name}, {low} to {high} of {k}: {error}");
                            checked[form as usize] += 1;
                        }
                    }
                }
            });
        }
    }
    println!("{checked:?} segments");
    assert!(checked.iter().all(|n| *n > 3000));
}

/// At discrete events what is left is the exchange of solid angles by the half vector.
#[test]
fn factors_of_discrete_events_are_those_of_the_half_vector() {
    let content = [PINHOLE, &room(GLOSSY), LAMP, BALL].concat();
    let scene = scene(&content, &[]);
    let mut checked = [0; 2];
    with_paths(&scene, |path, chain| {
        for i in 1..path.edges() {
            let x = &chain.vertices[i];
            if path.vertices[i].is_smooth() {
                continue;
            }
            let (wi, wo) = (path.previous_direction(i), path.next_direction(i));
            let h = half_vector(wi, wo, x.eta, x.normal).h;
            let cosines = |w: Vec3| h.dot(w).abs() / x.geometric_normal.dot(w).abs();
            let expected = cosines(wi) / (cosines(wo) * x.eta * x.eta);
            let got = vertex_factor(path, chain, i, SLOPE);
            assert!((got / expected - 1.0).abs() < 2e-3, "{got}, not {expected}");
            checked[usize::from(x.kind == vertex_kind::REFRACTION)] += 1;
        }
    });
    println!("{checked:?} events");
    assert!(checked.iter().all(|n| *n >= 30));
}

/// Walks go on with the half vector that they are given, and directions towards the light have the density that is claimed of
/// them: against differences.
#[test]
fn directions_follow_half_vectors() {
    let files: &[NamedFile<'_>] = &[("sphere.obj", &faceted_sphere)];
    let content = [PINHOLE, &room(GLOSSY), LAMP, ROUGH_SHEET, FACETS].concat();
    let scene = scene(&content, files);
    let mut checked = [0; 2];
    with_paths(&scene, |path, chain| {
        for i in 1..path.edges() {
            let (vertex, x) = (&path.vertices[i], &chain.vertices[i]);
            if !vertex.is_smooth() {
                continue;
            }
            for form in [SLOPE, PROJECTED] {
                let Some(h) = chain.half_vector(i, form) else {
                    continue;
                };
                let (wi, wo) = (path.previous_direction(i), path.next_direction(i));
                let to_light =
                    |h: Vec2| scatter_at(vertex, x, wo, true, h, form).map(|ray| ray.direction);
                let to_sensor = scatter_at(vertex, x, wi, false, h, form).map(|ray| ray.direction);
                let near_rim = h.length() > 3.0 || form == PROJECTED && h.length() > 0.9;
                if near_rim || wi.dot(x.normal).abs() < 0.1 || wo.dot(x.normal).abs() < 0.1 {
                    continue;
                }
                let back = to_light(h).unwrap_or(Vec3::ZERO);
                assert!((back - wi).length() < 2e-3, "{back}, not {wi}");
                let there = to_sensor.unwrap_or(Vec3::ZERO);
                assert!((there - wo).length() < 2e-3, "{there}, not {wo}");
                let e = 2e-3;
                let column = |d: Vec2| -> Option<Vec3> {
                    Some((to_light(h + d * e)? - to_light(h - d * e)?) / (2.0 * e))
                };
                let (Some(u), Some(v)) = (column(Vec2::X), column(Vec2::Y)) else {
                    continue;
                };
                let expected = u.cross(v).length();
                let got = towards_light(path, chain, i, form);
                let kind = usize::from(x.kind == vertex_kind::REFRACTION);
                // Grazing half vectors bend the map within the difference.
                if expected > 1e-2 && expected < 30.0 {
                    assert!((got / expected - 1.0).abs() < 0.03, "{got}, not {expected}");
                    checked[kind] += 1;
                }
            }
        }
    });
    println!("{checked:?} directions");
    assert!(checked.iter().all(|n| *n > 100));
}
