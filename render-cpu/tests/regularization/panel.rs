//! The panel of point lights in a mirror (Kaplanyan 2017, figures 6.1 and 6.5), a scene of our own: there with mollification,
//! missing without, as bright as its closed form, and sharper the more samples are taken.

use crate::scenes::{mollified, render_film};
use glam::{DVec3, Vec3, dvec3};
use halflight::film::Film;
use halflight::scene::build::{BuildOptions, Crop, FilmOverride, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::scene::camera;
use std::collections::HashSet;
use std::path::Path;

/// The part of the image where the mirror shows the panel and nothing behind it, at 192 pixels of width.
const WINDOW: Crop = Crop {
    offset: [64, 44],
    size: [52, 44],
};

/// z of the mirror and of the panel.
const PLANES: [f64; 2] = [-1.55, 2.0];

/// Reflectance of the scene's silver by the mean of the channels, at the angles of the panel.
fn reflectance(scene: &Scene) -> f64 {
    use halflight_kernel::bsdf::fresnel::fresnel_conductor;
    let lobe = scene
        .tables
        .lobes
        .iter()
        .find(|l| l.kind == halflight_kernel::scene::lobe_kind::CONDUCTOR)
        .unwrap();
    let of = |p: [f32; 3]| Vec3::from_array(p);
    let f = fresnel_conductor(0.997, of(lobe.eta.value), of(lobe.k.value));
    f64::from(f.y)
}

fn panel() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/mirror-panel.xml");
    let options = BuildOptions {
        film: FilmOverride {
            width: Some(192),
            crop: Some(WINDOW),
            ..FilmOverride::default()
        },
        ..BuildOptions::default()
    };
    let mut scene = build_scene(&parse_scene(&path, &[], true).unwrap(), &options).unwrap();
    // From the sensor to the mirror to a light.
    scene.settings.rules.max_depth = 2;
    scene
}

/// Images of the lights behind the mirror.
fn images(scene: &Scene) -> Vec<DVec3> {
    let lights = scene.tables.emitters.iter();
    lights
        .map(|e| {
            let at = halflight_kernel::math::affine::translation(&e.to_world).as_dvec3();
            dvec3(at.x, at.y, 2.0 * PLANES[0] - at.z)
        })
        .collect()
}

/// Sum of the green channel over some pixels of the window.
fn sum(film: &Film, is_counted: impl Fn(u32, u32) -> bool) -> f64 {
    let means = film.mean();
    let mut sum = 0.0;
    for y in 0..film.height() {
        for x in 0..film.width() {
            if is_counted(x, y) {
                sum += means[(y * film.width() + x) as usize][1];
            }
        }
    }
    sum
}

#[test]
fn a_panel_of_point_lights_is_seen_in_a_mirror() {
    let scene = panel();
    let off = mollified(scene.clone(), "r0=0");
    assert!(
        sum(&render_film(&off, 4), |_, _| true) == 0.0,
        "seen without"
    );
    let few = render_film(&scene, 2);
    let many = render_film(&scene, 64);
    let tables = scene.tables.view();
    // The sum over all pixels of a mean radiance is that over the film's area, over the area of a pixel.
    let eye = dvec3(0.0, 1.2, 2.4);
    let axis = (dvec3(0.0, 1.15, -1.0) - eye).normalize();
    let side = 2.0 * 25.0_f64.to_radians().tan() / 192.0;
    let mut truth = 0.0;
    let mut pixels = HashSet::new();
    for image in images(&scene) {
        let to = image - eye;
        let cosine = to.normalize().dot(axis);
        truth += 0.26 * reflectance(&scene) / (to.length_squared() * cosine.powi(3) * side * side);
        let seen = camera::film_position(&tables, image.as_vec3(), glam::Vec2::ZERO);
        let pixel = [seen.film.x, seen.film.y].map(|v| v as u32);
        pixels.insert([pixel[0] - WINDOW.offset[0], pixel[1] - WINDOW.offset[1]]);
    }
    let error = sum(&many, |_, _| true) / truth - 1.0;
    let share = |film: &Film| sum(film, |x, y| pixels.contains(&[x, y])) / sum(film, |_, _| true);
    let (blurred, sharp) = (share(&few), share(&many));
    println!(
        "error {error:.4}; in the lights' own pixels {blurred:.3} of 2 samples, {sharp:.3} of 64"
    );
    assert!(error.abs() < 0.02, "{error}");
    assert!(sharp > 1.15 * blurred, "{blurred} {sharp}");
}
