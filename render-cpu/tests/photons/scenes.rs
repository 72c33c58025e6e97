//! Scenes from text, and their films.

use halflight::accel::Accel;
use halflight::film::Film;
use halflight::render::{Goal, NoObserver, RenderOptions, RunState, own_layers, render};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A camera above the floor z = 0 that looks down on the square from -1/4 to 1/4, 4 by 4 pixels.
pub const CAMERA: &str = r#"<sensor type="perspective"><float name="fov" value="14.25"/>
    <transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film>
    </sensor>"#;

/// A scene with an integrator and the given content.
pub fn scene(integrator: &str, content: &str) -> Scene {
    let text = format!("<scene version=\"3.0.0\">{integrator}{content}</scene>");
    let parsed = parse_scene_from_str(&text, Path::new("test.xml"), &[], true).expect("a scene");
    build_scene(&parsed, &BuildOptions::default()).expect("tables")
}

/// An integrator with properties.
pub fn integrator(plugin: &str, properties: &[(&str, f64)]) -> String {
    let mut text = format!("<integrator type=\"{plugin}\">");
    for (name, value) in properties {
        let kind = match *name {
            "photon_count" | "nearest" | "max_depth" | "rr_depth" => "integer",
            _ => "float",
        };
        text += &format!("<{kind} name=\"{name}\" value=\"{value}\"/>");
    }
    text + "</integrator>"
}

/// The passes from `first` on, `count` of them, added to `film`.
pub fn add_passes(scene: &Scene, film: &mut Film, seed: u32, first: u32, count: u32) {
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let options = RenderOptions {
        goal: Goal::Samples(count),
        seed,
        first_sample: first,
        adaptive: false,
    };
    let mut state = RunState::default();
    let never = AtomicBool::new(false);
    render(
        scene,
        &accel,
        &options,
        film,
        &mut state,
        &never,
        &mut NoObserver,
    )
    .expect("a film");
    assert_eq!(film.total_rejected(), 0, "values that are not finite");
}

/// A film of some passes.
pub fn film(scene: &Scene, seed: u32, first: u32, count: u32) -> Film {
    let [width, height] = scene.tables.camera.crop_size;
    let layers = own_layers(scene.settings.kind);
    let mut film = Film::new(width, height, [0; 2], layers).expect("a film");
    add_passes(scene, &mut film, seed, first, count);
    film
}

/// Mean of the whole image and its standard error, per channel, from `runs` films of different passes.
pub fn mean(scene: &Scene, seed: u32, runs: u32, passes: u32) -> ([f64; 3], [f64; 3]) {
    let means: Vec<[f64; 3]> = (0..runs)
        .map(|run| {
            let film = film(scene, seed.wrapping_add(run), 0, passes);
            let pixels = film.mean();
            std::array::from_fn(|c| pixels.iter().map(|p| p[c]).sum::<f64>() / pixels.len() as f64)
        })
        .collect();
    let n = f64::from(runs);
    let mean: [f64; 3] = std::array::from_fn(|c| means.iter().map(|m| m[c]).sum::<f64>() / n);
    let error = std::array::from_fn(|c| {
        let squares: f64 = means.iter().map(|m| (m[c] - mean[c]).powi(2)).sum();
        (squares / (n * (n - 1.0))).sqrt()
    });
    (mean, error)
}
