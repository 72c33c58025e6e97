//! Light transport on scenes whose radiance is known, and the equality of techniques that must agree.

use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use std::path::Path;

/// A camera at `z = 3` that looks at the origin with a small field of view, and `content`.
fn scene(integrator: &str, content: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0">{integrator}
        <sensor type="perspective"><float name="fov" value="10"/>
            <transform name="to_world"><lookat origin="0, 0, 3" target="0, 0, 0" up="0, 1, 0"/></transform>
            <sampler type="independent"/>
            <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
                <rfilter type="box"/></film>
        </sensor>{content}</scene>"#
    );
    let parsed = parse_scene_from_str(&text, Path::new("test.xml"), &[], true).expect("a scene");
    build_scene(&parsed, &BuildOptions::default()).expect("tables")
}

fn film(scene: &Scene, spp: u32, seed: u32) -> Film {
    let options = RenderOptions {
        goal: Goal::Samples(spp),
        seed,
        first_sample: 0,
        adaptive: false,
    };
    render_film(scene, &options, AovSet::NONE).expect("a film")
}

/// Mean over all pixels and its standard error, per channel.
fn mean(film: &Film) -> ([f64; 3], [f64; 3]) {
    let n = film.statistics().len() as f64;
    let mut sum = [0.0; 3];
    let mut variance = [0.0; 3];
    for p in film.statistics() {
        let v = p.variance_of_mean();
        for c in 0..3 {
            sum[c] += p.mean[c] / n;
            variance[c] += v[c] / (n * n);
        }
    }
    (sum, variance.map(f64::sqrt))
}

/// Insists that the mean is `expected` within 4.5 standard errors (2e-5 of false alarms over all calls) and 1e-4 for
/// the rounding of f32.
fn expect(what: &str, scene: &Scene, spp: u32, expected: [f64; 3]) {
    let (found, error) = mean(&film(scene, spp, 5));
    for c in 0..3 {
        let tolerance = 4.5 * error[c] + 1e-4 * expected[c].abs();
        assert!(
            (found[c] - expected[c]).abs() <= tolerance,
            "{what}, channel {c}: {} instead of {}, standard error {}",
            found[c],
            expected[c],
            error[c]
        );
    }
}

const PATH: &str = r#"<integrator type="path"/>"#;

fn path(max_depth: i32, rr_depth: i32) -> String {
    format!(
        r#"<integrator type="path"><integer name="max_depth" value="{max_depth}"/>
        <integer name="rr_depth" value="{rr_depth}"/></integrator>"#
    )
}

const SKY: &str = r#"<emitter type="constant"><rgb name="radiance" value="1, 2, 3"/></emitter>"#;

#[test]
fn lossless_surfaces_vanish_in_a_white_furnace() {
    let materials = [
        (
            "diffuse",
            r#"<bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf>"#,
        ),
        ("mirror", r#"<bsdf type="conductor"/>"#),
        ("glass", r#"<bsdf type="dielectric"/>"#),
        ("thin glass", r#"<bsdf type="thindielectric"/>"#),
        (
            "plastic",
            r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="1"/><boolean name="nonlinear" value="true"/></bsdf>"#,
        ),
        ("null", r#"<bsdf type="null"/>"#),
        (
            "mask",
            r#"<bsdf type="mask"><float name="opacity" value="0.3"/><bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></bsdf></bsdf>"#,
        ),
        (
            "blend",
            r#"<bsdf type="blendbsdf"><float name="weight" value="0.4"/><bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf><bsdf type="conductor"/></bsdf>"#,
        ),
    ];
    for (name, material) in materials {
        let content = format!(r#"{SKY}<shape type="sphere">{material}</shape>"#);
        expect(name, &scene(&path(-1, 50), &content), 64, [1.0, 2.0, 3.0]);
    }
}

#[test]
fn a_lambertian_plane_reflects_its_albedo() {
    let content = format!(
        r#"{SKY}<shape type="rectangle"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.5, 0.8"/></bsdf></shape>"#
    );
    expect("plane", &scene(PATH, &content), 256, [0.2, 1.0, 2.4]);
}

#[test]
fn a_closed_diffuse_sphere_is_a_geometric_series() {
    // Inside a sphere of albedo a that emits e everywhere: L = e / (1 - a).
    let content = r#"<shape type="sphere"><float name="radius" value="10"/><boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.3, 0.5, 0.8"/></bsdf>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#;
    expect(
        "integrating sphere",
        &scene(&path(-1, 5), content),
        512,
        [1.0 / 0.7, 2.0, 5.0],
    );
    // Cut off after d edges it is the partial sum.
    let partial = |a: f64| (0..4).map(|k| a.powi(k)).sum::<f64>();
    expect(
        "four edges",
        &scene(&path(4, 100), content),
        512,
        [partial(0.3), partial(0.5), partial(0.8)],
    );
}

#[test]
fn a_point_light_obeys_the_inverse_square() {
    // Facing plane at distance 2 with albedo 1: L = I / (pi d^2); the field of view is narrow, but not a point.
    let content = r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></shape>
        <emitter type="point"><point name="position" x="0" y="0" z="200"/><rgb name="intensity" value="40000"/></emitter>"#;
    let l = 1.0 / std::f64::consts::PI;
    let found = mean(&film(&scene(PATH, content), 16, 1)).0;
    for v in found {
        assert!((v - l).abs() < 2e-4 * l, "{v} instead of {l}");
    }
}

#[test]
fn techniques_agree() {
    let content = r#"<shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>
        <bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="0.5" y="0.3" z="1.2"/><float name="radius" value="0.4"/>
        <emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>"#;
    let direct = |emitter: u32, bsdf: u32| {
        format!(
            r#"<integrator type="direct"><integer name="emitter_samples" value="{emitter}"/>
            <integer name="bsdf_samples" value="{bsdf}"/></integrator>"#
        )
    };
    let (reference, error) = mean(&film(&scene(&path(2, 100), content), 2048, 3));
    for (e, b) in [(1, 0), (0, 1), (1, 1), (3, 2)] {
        let (found, other) = mean(&film(&scene(&direct(e, b), content), 2048, 4));
        for c in 0..3 {
            let sigma = (error[c] * error[c] + other[c] * other[c]).sqrt();
            assert!(
                (found[c] - reference[c]).abs() < 4.5 * sigma,
                "{e} emitter and {b} BSDF samples: {} instead of {}",
                found[c],
                reference[c]
            );
        }
    }
}

#[test]
fn russian_roulette_changes_nothing_but_noise() {
    let content = format!(
        r#"{SKY}<shape type="sphere"><bsdf type="roughdielectric"><float name="alpha" value="0.2"/></bsdf></shape>"#
    );
    let (a, ea) = mean(&film(&scene(&path(-1, 1), &content), 2048, 1));
    let (b, eb) = mean(&film(&scene(&path(-1, 60), &content), 2048, 2));
    for c in 0..3 {
        let sigma = (ea[c] * ea[c] + eb[c] * eb[c]).sqrt();
        assert!(
            (a[c] - b[c]).abs() < 4.5 * sigma,
            "{} against {}",
            a[c],
            b[c]
        );
    }
}

#[test]
fn light_passes_masks_in_both_techniques() {
    // A half-transparent sheet between a plane and its lamp halves the lamp's light and reflects none.
    let lamp = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="180"/><translate z="2" x="2"/></transform>
        <emitter type="area"><rgb name="radiance" value="10"/></emitter></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="1"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></shape>"#;
    let sheet = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><translate z="1"/></transform>
        <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></bsdf></shape>"#;
    let (open, _) = mean(&film(&scene(PATH, lamp), 1024, 1));
    // The sheet is passed twice: by the light and by the view.
    let expected = open.map(|v| v * 0.25);
    let (found, error) = mean(&film(&scene(PATH, &format!("{lamp}{sheet}")), 4096, 2));
    for c in 0..3 {
        assert!(
            (found[c] - expected[c]).abs() < 5.0 * error[c] + 5e-3 * expected[c],
            "{} instead of {}",
            found[c],
            expected[c]
        );
    }
}

#[test]
fn hidden_emitters_light_but_are_not_seen() {
    let content = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value="0.5"/>
        <emitter type="area"><rgb name="radiance" value="4"/></emitter></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="4"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>"#;
    let seen = mean(&film(&scene(PATH, content), 64, 1)).0;
    assert!(
        (seen[0] - 4.0).abs() < 1e-3,
        "the lamp fills the image: {}",
        seen[0]
    );
    let hidden =
        r#"<integrator type="path"><boolean name="hide_emitters" value="true"/></integrator>"#;
    // The value of Mitsuba 3.9.1 on the same scene, whose standard error is below 5e-4.
    let (lit, error) = mean(&film(&scene(hidden, content), 1024, 1));
    assert!(
        (lit[0] - 0.4683).abs() < 4.5 * error[0] + 2e-3,
        "{}",
        lit[0]
    );
}

#[test]
fn the_power_heuristic_is_that_of_exponent_two() {
    use halflight_kernel::transport::connection::power_heuristic;
    for (a, b, expected) in [
        (1.0, 1.0, 0.5),
        (3.0, 1.0, 0.9),
        (1.0, 2.0, 0.2),
        (0.0, 1.0, 0.0),
    ] {
        let weight = power_heuristic(a, b);
        assert!((weight - expected).abs() < 1e-6, "{a}, {b}: {weight}");
    }
}

#[test]
fn roulette_of_paths_undoes_the_scaling_of_refracted_radiance() {
    use glam::{Vec2, Vec3};
    use halflight_kernel::bsdf::{BsdfSample, event};
    use halflight_kernel::math::Ray;
    use halflight_kernel::path::PathRules;
    use halflight_kernel::sampler::Sampler;
    use halflight_kernel::scene::SurfacePoint;
    use halflight_kernel::transport::path::{Path, step};
    struct Always(f32);
    impl Sampler for Always {
        fn next_1d(&mut self) -> f32 {
            self.0
        }
        fn next_2d(&mut self) -> Vec2 {
            Vec2::splat(self.0)
        }
    }
    // Refracted into an index of 2 radiance is divided by 4: the throughput 0.08 survives as 0.32 would.
    let sample = BsdfSample {
        wo: -Vec3::Z,
        weight: Vec3::splat(0.25),
        pdf: 1.0,
        event: event::DELTA,
        eta: 2.0,
    };
    let rules = PathRules {
        rr_depth: 1,
        ..PathRules::DEFAULT
    };
    for (number, next) in [(0.31, step::TRACE), (0.33, step::END)] {
        let mut path = Path::new(&Ray::new(Vec3::Z, -Vec3::Z));
        path.subpath.throughput = Vec3::splat(0.32);
        let mut sampler = Always(number);
        let found = path.scatter(&rules, &mut sampler, &SurfacePoint::ZERO, &sample);
        assert_eq!(found, next, "{number}");
        if found == step::TRACE {
            assert!(
                (path.subpath.throughput.x - 0.25).abs() < 1e-5,
                "{}",
                path.subpath.throughput
            );
        }
    }
}
