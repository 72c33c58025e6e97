//! Materials with directions exchanged: what a walk from the light asks is what a walk from the sensor would have found.

use crate::scenes::{View, ripples, scene, with_view};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Bsdf, mode};
use halflight_kernel::math::Ray;
use halflight_kernel::path::rules::step;
use halflight_kernel::path::{Heuristic, Interaction, PathRules, Walk};
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::camera::CameraSample;
use halflight_kernel::scene::surface::surface_at;
use halflight_kernel::scene::{SurfacePoint, Traverse};
use std::f32::consts::TAU;

const GOLD: &str = r#"<bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf>"#;

/// Materials of all kinds of lobes, alone, mixed, coated, under maps, on one side and on both.
fn materials() -> Vec<String> {
    let map = |inner: &str| {
        format!(
            r#"<bsdf type="bumpmap"><texture type="bitmap"><string name="filename" value="ripples.exr"/>
            <boolean name="raw" value="true"/></texture><float name="scale" value="0.5"/>{inner}</bsdf>"#
        )
    };
    let normals = |inner: &str| {
        format!(
            r#"<bsdf type="normalmap"><texture name="normalmap" type="bitmap"><string name="filename" value="ripples.exr"/>
            <boolean name="raw" value="true"/></texture>{inner}</bsdf>"#
        )
    };
    let coated = |kind: &str, inner: &str| format!(r#"<bsdf type="{kind}">{inner}</bsdf>"#);
    let diffuse = r#"<bsdf type="diffuse"/>"#;
    let glass = r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#;
    let two_sided = |inner: &str| format!(r#"<bsdf type="twosided">{inner}</bsdf>"#);
    let blend = |a: &str, b: &str| {
        format!(r#"<bsdf type="blendbsdf"><float name="weight" value="0.3"/>{a}{b}</bsdf>"#)
    };
    let mask = |inner: &str| {
        format!(r#"<bsdf type="mask"><float name="opacity" value="0.6"/>{inner}</bsdf>"#)
    };
    let alone = [
        diffuse,
        r#"<bsdf type="roughdiffuse"><float name="alpha" value="0.4"/></bsdf>"#,
        GOLD,
        r#"<bsdf type="roughconductor"><string name="distribution" value="beckmann"/><float name="alpha_u" value="0.1"/>
            <float name="alpha_v" value="0.4"/></bsdf>"#,
        glass,
        r#"<bsdf type="plastic"/>"#,
        r#"<bsdf type="roughplastic"><float name="alpha" value="0.2"/><boolean name="nonlinear" value="true"/></bsdf>"#,
    ];
    let mut all: Vec<String> = alone.iter().map(ToString::to_string).collect();
    all.extend(alone.iter().map(|inner| map(inner)));
    all.extend(alone.iter().map(|inner| normals(inner)));
    all.push(two_sided(GOLD));
    all.push(two_sided(&map(GOLD)));
    all.push(blend(diffuse, GOLD));
    all.push(blend(glass, diffuse));
    all.push(blend(glass, &two_sided(diffuse)));
    all.push(mask(GOLD));
    all.push(map(&mask(&blend(GOLD, diffuse))));
    all.push(coated("coating", GOLD));
    all.push(coated("roughcoating", diffuse));
    all.push(map(&coated("coating", GOLD)));
    all.push(coated("coating", &normals(GOLD)));
    all.push(two_sided(&coated("coating", &blend(diffuse, GOLD))));
    all
}

fn direction(sampler: &mut IndependentSampler) -> Vec3 {
    let u = sampler.next_2d();
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = (TAU * u.y).sin_cos();
    Vec3::new(r * c, r * s, z)
}

/// Calls `test` with points of a smooth sphere of the material.
fn with_points(
    material: &str,
    mut test: impl FnMut(&View<'_>, &SurfacePoint, &mut IndependentSampler),
) {
    let text = format!(
        r#"<sensor type="perspective"/><emitter type="constant"/>
        <shape type="sphere">{material}</shape>"#
    );
    let scene = scene(&text, &[("ripples.exr", &ripples)]);
    with_view(&scene, |view| {
        let mut sampler = IndependentSampler::new(1, 2, 3);
        for _ in 0..40 {
            let ray = Ray::new(Vec3::ZERO, direction(&mut sampler));
            let hit = view.traverse.closest_hit(&ray);
            let point = surface_at(&view.tables, &ray, &hit);
            test(view, &point, &mut sampler);
        }
    });
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-7
}

#[test]
fn exchanged_directions_are_looked_up_as_if_known_from_the_other_end() {
    for material in materials() {
        let mut seen = 0;
        with_points(&material, |view, point, sampler| {
            let tables = &view.tables;
            for _ in 0..50 {
                let (wi, wo) = (direction(sampler), direction(sampler));
                let bsdf = Bsdf::at(tables, point, wi, mode::RADIANCE);
                let other = Bsdf::at(tables, point, wo, mode::RADIANCE);
                let (value, pdf) = bsdf.eval_cosine_pdf_reverse(tables, point, wi, wo);
                let (expected, expected_pdf) = other.eval_cosine_pdf(tables.data, wo, wi);
                let alone = bsdf.pdf_reverse(tables, point, wi, wo);
                assert!(
                    close(pdf, expected_pdf) && close(alone, expected_pdf),
                    "{material}: {pdf}, {alone} instead of {expected_pdf}"
                );
                for c in 0..3 {
                    assert!(
                        close(value[c], expected[c]),
                        "{material}: {value} instead of {expected}"
                    );
                }
                seen += u32::from(expected_pdf > 0.0 && expected.max_element() > 0.0);
            }
        });
        assert!(seen > 50, "{material}: {seen} pairs scatter");
    }
}

#[test]
fn both_modes_give_one_value_but_for_the_geometric_cosines() {
    let rules = PathRules {
        max_depth: 10,
        rr_depth: 10,
        hide_emitters: 0,
        strict_normals: 0,
    };
    for material in materials() {
        with_points(&material, |view, point, sampler| {
            let tables = &view.tables;
            for _ in 0..50 {
                let (to_camera, to_light) = (direction(sampler), direction(sampler));
                let local = |w: Vec3| point.frame.to_local(w);
                let from_camera = Bsdf::at(tables, point, local(to_camera), mode::RADIANCE);
                let from_light = Bsdf::at(tables, point, local(to_light), mode::RADIANCE);
                let seen = Interaction::new(point, &from_camera, -to_camera).evaluate(
                    tables,
                    &rules,
                    mode::RADIANCE,
                    to_light,
                );
                let sent = Interaction::new(point, &from_light, -to_light).evaluate(
                    tables,
                    &rules,
                    mode::IMPORTANCE,
                    to_camera,
                );
                let cos = |w: Vec3| point.geometric_normal.dot(w).abs();
                let expected = seen.value * (cos(to_camera) / cos(to_light));
                for c in 0..3 {
                    let (a, b) = (sent.value[c], expected[c]);
                    assert!(
                        (a - b).abs() <= 1e-3 * a.max(b) + 1e-6,
                        "{material}: {a}, {b}"
                    );
                }
                if seen.is_some() {
                    assert!(
                        close(sent.pdf_reverse, seen.pdf),
                        "{material}: {sent:?}, {seen:?}"
                    );
                    assert!(
                        close(sent.pdf, seen.pdf_reverse),
                        "{material}: {sent:?}, {seen:?}"
                    );
                }
            }
        });
    }
}

/// Numbers that are given.
struct Numbers {
    one: Vec<f32>,
    two: Vec2,
}

impl Sampler for Numbers {
    fn next_1d(&mut self) -> f32 {
        self.one.remove(0)
    }

    fn next_2d(&mut self) -> Vec2 {
        self.two
    }
}

#[test]
fn roulette_undoes_the_scaling_of_refracted_radiance() {
    let rules = PathRules {
        max_depth: 10,
        rr_depth: 1,
        hide_emitters: 0,
        strict_normals: 0,
    };
    let glass = r#"<bsdf type="dielectric"><float name="int_ior" value="2"/></bsdf>"#;
    with_points(glass, |view, point, _| {
        let tables = &view.tables;
        // Straight into the glass: radiance is divided by 4, the throughput 0.32 becomes 0.08, and survives as 0.32 would.
        for (number, next) in [(0.3, step::TRACE), (0.34, step::END)] {
            let ray = Ray::new(point.position * 3.0, -point.position);
            let mut walk = Walk::from_sensor(&CameraSample::along(&ray));
            walk.subpath.throughput = Vec3::splat(0.32);
            let wi = point.frame.to_local(point.position);
            let bsdf = Bsdf::at(tables, point, wi, mode::RADIANCE);
            let at = Interaction::new(point, &bsdf, ray.direction);
            let mut numbers = Numbers {
                one: vec![0.999, number],
                two: Vec2::splat(0.5),
            };
            let h = Heuristic::POWER;
            assert_eq!(walk.scatter(tables, &rules, h, &mut numbers, &at), next);
            assert!(
                (walk.subpath.eta - 2.0).abs() < 1e-3,
                "{}",
                walk.subpath.eta
            );
        }
    });
}

#[test]
fn strict_normals_end_walks_that_sample_a_direction_through_the_surface() {
    for (strict, next) in [(0, step::TRACE), (1, step::END)] {
        let rules = PathRules {
            max_depth: 10,
            rr_depth: 10,
            hide_emitters: 0,
            strict_normals: strict,
        };
        with_points(r#"<bsdf type="conductor"/>"#, |view, point, _| {
            let tables = &view.tables;
            // A shading normal 60 degrees off: a mirror sends what comes along the geometric normal below the surface.
            let mut point = *point;
            let tangent = point.geometric_normal.any_orthonormal_vector();
            let normal = 0.5 * point.geometric_normal + 0.75_f32.sqrt() * tangent;
            point.frame = halflight_kernel::math::Frame::from_normal(normal.normalize());
            let ray = Ray::new(point.position * 3.0, -point.geometric_normal);
            let mut walk = Walk::from_sensor(&CameraSample::along(&ray));
            let wi = point.frame.to_local(point.geometric_normal);
            let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
            let at = Interaction::new(&point, &bsdf, ray.direction);
            let mut numbers = Numbers {
                one: vec![0.5],
                two: Vec2::splat(0.5),
            };
            let h = Heuristic::POWER;
            assert_eq!(walk.scatter(tables, &rules, h, &mut numbers, &at), next);
            // The same of path tracing.
            let mut path = halflight_kernel::transport::path::Path::new(&ray);
            let mut numbers = Numbers {
                one: vec![0.5],
                two: Vec2::splat(0.5),
            };
            let sample = bsdf.sample(tables.data, wi, 0.5, Vec2::splat(0.5));
            let found = path.scatter(&rules, &mut numbers, &point, &sample);
            assert_eq!(found, next);
        });
    }
}
