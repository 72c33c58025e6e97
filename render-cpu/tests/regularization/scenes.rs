//! Scenes from text, and their films.

use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Goal, NoObserver, RenderOptions, RunState, render};
use halflight::scene::build::regularization::{parse_mollify, parse_regularize};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The algorithms that can be regularised.
pub const ALGORITHMS: [&str; 3] = ["path", "bdpt", "vcm"];

/// A scene of the given XML, without the outermost element, for an algorithm.
pub fn scene(integrator: &str, content: &str) -> Scene {
    let photons = if integrator == "vcm" {
        r#"<integer name="photon_count" value="500"/>"#
    } else {
        ""
    };
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="{integrator}"><integer name="max_depth" value="6"/>{photons}</integrator>
        {content}</scene>"#
    );
    let parsed = parse_scene_from_str(&text, Path::new("test.xml"), &[], true).expect("a scene");
    build_scene(&parsed, &BuildOptions::default()).expect("tables")
}

/// The scene with microfacets regularised.
pub fn regularized(mut scene: Scene, text: &str) -> Scene {
    scene.settings.regularization = parse_regularize(text).unwrap();
    scene
}

/// The scene with path space regularised.
pub fn mollified(mut scene: Scene, text: &str) -> Scene {
    scene.settings.regularization = parse_mollify(text).unwrap();
    scene
}

/// An empty film of the scene.
pub fn film(scene: &Scene) -> Film {
    film_with(scene, AovSet::NONE)
}

/// The same with layers.
pub fn film_with(scene: &Scene, layers: AovSet) -> Film {
    let camera = &scene.tables.camera;
    let [width, height] = camera.crop_size;
    Film::new(width, height, camera.crop_offset, layers).unwrap()
}

/// Brings the film to `samples` samples per pixel, of which the first has the index `first`.
pub fn add(scene: &Scene, film: &mut Film, first: u32, samples: u32) {
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let options = RenderOptions {
        goal: Goal::Samples(samples),
        seed: 7,
        first_sample: first,
        adaptive: false,
    };
    let mut state = RunState {
        samples: film.pixel(0, 0).count,
        ..RunState::default()
    };
    let never = AtomicBool::new(false);
    let observer = &mut NoObserver;
    render(scene, &accel, &options, film, &mut state, &never, observer).expect("a film");
    assert_eq!(film.total_rejected(), 0, "values that are not finite");
}

/// The film of the first samples.
pub fn render_film(scene: &Scene, samples: u32) -> Film {
    let mut film = film(scene);
    add(scene, &mut film, 0, samples);
    film
}

/// Bits of all means.
pub fn bits(film: &Film) -> Vec<u64> {
    let means = film.mean();
    means.iter().flatten().map(|v| v.to_bits()).collect()
}

/// Mean of the green channel over the image, and its standard error by the variance of the pixels.
pub fn mean(film: &Film) -> (f64, f64) {
    let sum: f64 = film.mean().iter().map(|c| c[1]).sum();
    let variance: f64 = film.variance_of_mean().iter().map(|c| c[1]).sum();
    let n = f64::from(film.width() * film.height());
    (sum / n, variance.sqrt() / n)
}

/// A diffuse material.
pub const DIFFUSE: &str =
    r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf>"#;

/// A mirror.
pub const MIRROR: &str = r#"<bsdf type="conductor"/>"#;

/// A pinhole of 12 by 8 pixels into the room.
pub const CAMERA: &str = r#"<sensor type="perspective"><float name="fov" value="50"/>
    <transform name="to_world"><lookat origin="0.2, 1.2, 3.4" target="0, 0.7, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="8"/><rfilter type="box"/></film>
    </sensor>"#;

/// A floor and two walls of a material, with a lamp and a point light.
pub fn room(material: &str, object: &str) -> String {
    format!(
        r#"{CAMERA}<bsdf type="twosided" id="wall">{material}</bsdf>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate x="1" angle="-90"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><translate z="-1.5"/></transform>
            <ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate y="1" angle="90"/>
            <translate x="-1.5"/></transform><ref id="wall"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="90"/>
            <translate y="1.8"/></transform><emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>
        <emitter type="point"><point name="position" value="0.8, 1.4, 0.6"/><rgb name="intensity" value="1, 2, 1"/></emitter>
        {object}"#
    )
}

/// A sphere of a material in the room.
pub fn ball(material: &str) -> String {
    format!(
        r#"<shape type="sphere"><point name="center" value="-0.2, 0.5, -0.2"/><float name="radius" value="0.45"/>
        {material}</shape>"#
    )
}
