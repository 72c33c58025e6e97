//! Rays that leave emitters: their densities, their distribution, and their mean weight.
//!
//! Positions are tested by moments against quadrature over a parametrisation of the shape whose area element comes from
//! differences in f64, not from the kernel's stretch; directions by Pearson's chi-square. Deviations of means are held
//! against 5 standard errors: 6e-7 of false alarms each, about 100 of them. Random numbers are fixed.

#[path = "../common/mod.rs"]
mod common;
mod positions;
mod surfaces;

use common::Random;
use common::chi_square::ChiSquare;
use common::light_scene::{Scene, emitter, rows};
use common::lit_scenes::{mesh_scene, sky, turned};
use glam::{Vec2, Vec3};
use halflight_kernel::math::{Frame, luminance, vec3};
use halflight_kernel::scene::emitter::emission::{self, EmissionSample};
use halflight_kernel::scene::emitter::{
    area_radiance, delta, environment_radiance, position, power,
};
use halflight_kernel::scene::{NONE, RgbParameter, SurfacePoint, emitter_kind};
use std::f64::consts::{PI, TAU};
use surfaces::{QUADRICS, over_triangles, sheared, surface_integrals};

const SAMPLES: u32 = 1 << 16;

/// Mean and variance of the mean.
#[derive(Default)]
struct Mean {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    fn add(&mut self, x: f64) {
        self.count += 1.0;
        self.sum += x;
        self.squares += x * x;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count
    }

    #[track_caller]
    fn assert_is(&self, what: &str, expected: f64) {
        let variance = (self.squares / self.count - self.mean().powi(2)).max(0.0) / self.count;
        // Rounding of f32 records and of quadrature.
        let tolerance = 5.0 * variance.sqrt() + 2e-4 * expected.abs() + 1e-9;
        assert!(
            (self.mean() - expected).abs() < tolerance,
            "{what}: {} +- {} instead of {expected}",
            self.mean(),
            variance.sqrt()
        );
    }
}

fn draw(scene: &Scene, random: &mut Random) -> EmissionSample {
    let u_select = random.next_1d();
    let u_position = random.next_2d();
    emission::sample(&scene.tables(), u_select, u_position, random.next_2d())
}

/// Every emitter alone, by name, with its power in luminance by quadrature or closed form.
fn emitters() -> Vec<(String, Scene, f64)> {
    let mut all = Vec::new();
    let color = RgbParameter::constant([1.0, 2.0, 3.0]);
    let light = f64::from(luminance(Vec3::new(1.0, 2.0, 3.0)));
    for (name, kind, at) in QUADRICS {
        let mut scene = Scene::new();
        scene.add_quadric_light(kind, sheared(), 0, color);
        let area = surface_integrals(sheared(), at)[0];
        all.push((name.to_string(), scene, PI * area * light));
    }
    let mesh = mesh_scene();
    let mut flux = 0.0;
    over_triangles(&mesh, |point, area| {
        let radiance = area_radiance(&mesh.tables(), point, point.geometric_normal);
        flux += PI * area * f64::from(luminance(radiance));
    });
    all.push(("textured mesh".into(), mesh, flux));
    let place = turned(Vec3::ONE, Vec3::new(0.3, 0.2, 0.1));
    for (name, kind, parameters) in [
        ("point", emitter_kind::POINT, [0.0; 4]),
        ("spot", emitter_kind::SPOT, [0.3, 0.6, 0.0, 0.0]),
        ("wide spot", emitter_kind::SPOT, [1.0, 3.0, 0.0, 0.0]),
        ("projector", emitter_kind::PROJECTOR, [0.7, 0.4, 0.0, 0.0]),
        ("directional", emitter_kind::DIRECTIONAL, [0.0; 4]),
        ("collimated", emitter_kind::COLLIMATED, [0.0; 4]),
    ] {
        let mut scene = Scene::new();
        scene.info.center = [0.5, -0.25, 0.75];
        let mut record = emitter(kind, color);
        if kind == emitter_kind::PROJECTOR || kind == emitter_kind::SPOT {
            let filter = halflight_kernel::scene::filter_mode::BILINEAR;
            record.radiance.texture =
                scene.add_bitmap(3, 2, filter, |i, j| [0.5 + i as f32, 0.3 + j as f32, 1.0]);
        }
        record.to_world = rows(place);
        record.to_local = rows(place.inverse());
        record.parameters = parameters;
        scene.emitters.push(record);
        let flux = if kind == emitter_kind::DIRECTIONAL {
            light * PI * 100.0
        } else if kind == emitter_kind::COLLIMATED {
            light
        } else {
            over_directions(|w| luminance(delta::intensity(&scene.tables(), 0, w)))
        };
        all.push((name.to_string(), scene, flux));
    }
    let mut scene = Scene::new();
    scene.emitters.push(emitter(emitter_kind::CONSTANT, color));
    scene.info.environment = 0;
    all.push(("constant".into(), scene, 400.0 * PI * PI * light));
    let mut scene = Scene::new();
    scene.add_environment(8, 5, place, 1.5, sky);
    let mean = over_directions(|w| luminance(environment_radiance(&scene.tables(), w)));
    all.push(("environment".into(), scene, mean * PI * 100.0));
    for (_, scene, _) in &mut all {
        scene.select();
    }
    all
}

/// Integral over the sphere of directions.
fn over_directions(f: impl Fn(Vec3) -> f32) -> f64 {
    const N: usize = 800;
    let mut sum = 0.0;
    for i in 0..N {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / N as f64;
        let r = (1.0 - z * z).sqrt();
        for j in 0..N {
            let phi = TAU * (j as f64 + 0.5) / N as f64;
            let w = Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32);
            sum += f64::from(f(w.normalize()));
        }
    }
    sum * 4.0 * PI / (N * N) as f64
}

#[test]
fn the_density_of_a_sampled_ray_is_the_sampled_density() {
    for (name, scene, _) in emitters() {
        let mut random = Random(0x77);
        let mut differing = 0;
        for _ in 0..20_000 {
            let sample = draw(&scene, &mut random);
            if sample.emitter == NONE {
                continue;
            }
            let direction = sample.ray.direction;
            assert!((direction.length() - 1.0).abs() < 1e-5);
            let found =
                emission::density(&scene.tables(), sample.emitter, &sample.point, direction);
            let ratios = [
                found.position / sample.density.position,
                found.direction / sample.density.direction,
            ];
            // Beside a cell's border of an environment rounding may find the neighbour.
            differing += u32::from(ratios.iter().any(|r| (r - 1.0).abs() > 2e-3));
        }
        assert!(differing < 20, "{name}: {differing} densities differ");
    }
}

#[test]
fn directions_follow_their_density() {
    let mut failures = Vec::new();
    let all = emitters();
    let family = all.len() as u32;
    for (name, scene, _) in &all {
        let tables = scene.tables();
        let record = &tables.emitters[0];
        if matches!(
            record.kind,
            emitter_kind::DIRECTIONAL | emitter_kind::COLLIMATED
        ) {
            continue;
        }
        // On area lights relative to the normal, whose density no position changes.
        let (point, frame) = if record.kind == emitter_kind::AREA {
            let (point, _) = position::sample_position(&tables, 0, Vec2::new(0.3, 0.6));
            (point, Frame::from_normal(point.frame.n))
        } else {
            (SurfacePoint::ZERO, Frame::from_normal(Vec3::Z))
        };
        let test = ChiSquare {
            samples: 100_000,
            pole: Vec3::new(0.3, 0.2, 0.9),
            family,
            seed: 11,
        };
        let result = test.run(
            |random| {
                let sample = draw(scene, random);
                let direction = sample.ray.direction;
                (sample.emitter != NONE).then(|| {
                    if record.kind == emitter_kind::AREA {
                        Frame::from_normal(sample.point.frame.n).to_local(direction)
                    } else {
                        frame.to_local(direction)
                    }
                })
            },
            |local| emission::density(&tables, 0, &point, frame.to_world(local)).direction,
        );
        if let Err(reason) = result {
            failures.push(format!("{name}: {reason}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn light_from_infinity_passes_a_disk_evenly() {
    for (name, scene, _) in emitters() {
        let kind = scene.emitters[0].kind;
        if !emission::is_infinite(kind) {
            continue;
        }
        let center = vec3(scene.info.center);
        let radius = scene.info.radius;
        let mut random = Random(0x99);
        let mut area = [0_u32; 16];
        let n = 40_000;
        for _ in 0..n {
            let sample = draw(&scene, &mut random);
            let offset = sample.ray.origin - center;
            let along = offset.dot(sample.ray.direction);
            assert!(along <= -radius, "{name}: a ray starts inside the scene");
            let across = offset - sample.ray.direction * along;
            let r = across.length() / radius;
            assert!(r <= 1.0 + 1e-5, "{name}: {r} radii off");
            area[((r * r * 16.0) as usize).min(15)] += 1;
        }
        let expected = f64::from(n) / 16.0;
        let statistic: f64 = area
            .iter()
            .map(|count| (f64::from(*count) - expected).powi(2) / expected)
            .sum();
        // The chi-square of 15 degrees of freedom exceeds 50 once in 80 000.
        assert!(statistic < 50.0, "{name}: {area:?}");
    }
}

#[test]
fn the_mean_weight_is_the_power() {
    let mut sum = 0.0;
    let mut whole = Scene::new();
    for (name, scene, expected) in emitters() {
        let mut mean = Mean::default();
        let mut random = Random(0x1234);
        for _ in 0..4 * SAMPLES {
            mean.add(f64::from(luminance(draw(&scene, &mut random).weight)));
        }
        mean.assert_is(&name, expected);
        let stated = f64::from(power(&scene.tables(), 0));
        // Textures and sheared shapes are estimated, for choosing emitters.
        let tolerance = match scene.emitters[0].kind {
            emitter_kind::POINT
            | emitter_kind::DIRECTIONAL
            | emitter_kind::COLLIMATED
            | emitter_kind::CONSTANT => 1e-4,
            _ => 0.3,
        };
        assert!(
            (stated / expected - 1.0).abs() < tolerance,
            "{name}: power {stated} instead of {expected}"
        );
        // Emitters without tables can stand beside each other.
        let record = scene.emitters[0];
        if record.radiance.texture == NONE && record.kind != emitter_kind::AREA {
            whole.emitters.push(record);
            sum += expected;
        }
    }
    whole.info.environment = whole.emitters.len() as u32 - 1;
    assert_eq!(whole.emitters.len(), 4);
    whole.select();
    let mut mean = Mean::default();
    let mut random = Random(0x4321);
    for _ in 0..4 * SAMPLES {
        mean.add(f64::from(luminance(draw(&whole, &mut random).weight)));
    }
    mean.assert_is("several", sum);
}
