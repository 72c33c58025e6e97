//! Parts of images.

use crate::scenes::scene;
use halflight::accel::Accel;
use halflight::expression::{PartsRequest, PathParts};
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSet};
use halflight::film::checkpoint::{Progress, read_checkpoint, write_checkpoint};
use halflight::render::{Goal, RenderOptions, Shape, render_film, shape};
use halflight::scene::build::Scene;
use halflight_kernel::glam::Vec3;
use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::scene::SceneView;
use halflight_kernel::transport::divided::sample_divided_pixel;
use halflight_kernel::transport::integrator_kind;

/// A room with a floor that is diffuse and glossy, a ball of glass, one of rough metal and one of smooth plastic, a lamp and
/// light from all around.
const ROOM: &str = r#"
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective"><float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, 1.4, 4.5" target="0, 0.6, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="10"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle" id="floor"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="roughplastic" id="wood"><rgb name="diffuse_reflectance" value="0.5, 0.3, 0.2"/><float name="alpha" value="0.3"/></bsdf></shape>
    <shape type="rectangle" id="wall"><transform name="to_world"><scale value="3"/><translate z="-2"/></transform>
        <bsdf type="blendbsdf" id="paint"><float name="weight" value="0.4"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.3, 0.6, 0.4"/></bsdf>
            <bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf></bsdf></shape>
    <shape type="sphere" id="ball"><point name="center" value="-0.9, 0.7, 0"/><float name="radius" value="0.6"/>
        <bsdf type="dielectric" id="glass"/></shape>
    <shape type="sphere" id="ring"><point name="center" value="0.6, 0.5, -0.4"/><float name="radius" value="0.5"/>
        <bsdf type="roughconductor" id="gold"><float name="alpha" value="0.2"/></bsdf></shape>
    <shape type="sphere" id="bead"><point name="center" value="0.3, 0.3, 1"/><float name="radius" value="0.3"/>
        <bsdf type="plastic" id="plastic"><rgb name="diffuse_reflectance" value="0.2, 0.2, 0.7"/></bsdf></shape>
    <shape type="rectangle" id="lamp"><transform name="to_world"><scale value="0.7"/><rotate x="1" angle="90"/><translate y="2.6"/></transform>
        <emitter type="area" id="key"><rgb name="radiance" value="9, 8, 7"/></emitter></shape>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.2, 0.25, 0.3"/></emitter>"#;

/// Classes that partition all paths.
const CLASSES: [(&str, &str); 8] = [
    ("seen", "CL"),
    ("diffuse", "CDL"),
    ("glossy", "CGL"),
    ("mirrored", "CSX*L"),
    ("diffuse-caustics", "L S+ D E"),
    ("glossy-caustics", "L S+ G E"),
    ("indirect-diffuse", "CDS*[DG]X*L"),
    ("indirect-glossy", "L X* [DG] S* G E"),
];

fn divided(kind: u32, layers: &[(&str, &str)], only: Option<&str>) -> Scene {
    let mut scene = scene(ROOM);
    scene.settings.kind = kind;
    scene.settings.photon.photon_count = 20_000;
    scene.settings.photon.initial_radius = 0.06;
    scene.settings.chains.mutations = 400;
    scene.settings.chains.direct_samples = 16;
    let named = |(name, text): &(&str, &str)| ((*name).to_owned(), (*text).to_owned());
    let request = PartsRequest {
        layers: layers.iter().map(named).collect(),
        only: only.map(str::to_owned),
    };
    scene.parts = PathParts::new(&request, &scene.tables.view(), &scene.names).unwrap();
    scene
}

fn options(samples: u32, seed: u32) -> RenderOptions {
    RenderOptions {
        goal: Goal::Samples(samples),
        seed,
        first_sample: 0,
        adaptive: false,
    }
}

fn film(scene: &Scene, samples: u32, seed: u32) -> Film {
    render_film(scene, &options(samples, seed), AovSet::NONE).unwrap()
}

#[test]
fn classes_that_partition_all_paths_add_up_to_the_image() {
    for kind in [
        integrator_kind::PATH,
        integrator_kind::BIDIRECTIONAL,
        integrator_kind::LIGHT_TRACING,
        integrator_kind::PROGRESSIVE_PHOTONS,
        integrator_kind::ADAPTIVE_PHOTONS,
        integrator_kind::VERTEX_MERGING,
        integrator_kind::VEACH_MLT,
        integrator_kind::PRIMARY_SAMPLE_MLT,
    ] {
        let scene = divided(kind, &CLASSES, None);
        let samples = if shape(kind) == Shape::Pixels { 16 } else { 4 };
        let film = film(&scene, samples, 3);
        let mut lit = [false; CLASSES.len()];
        for (i, whole) in film.mean().iter().enumerate() {
            for c in 0..3 {
                let parts = (0..CLASSES.len()).map(|part| film.part_mean(part, c, i));
                let sum: f64 = parts.clone().sum();
                let error = (sum - whole[c]).abs();
                assert!(
                    error <= 1e-5 * whole[c] + 1e-8,
                    "{kind} {i}: {sum} {whole:?}"
                );
                parts.zip(&mut lit).for_each(|(p, lit)| *lit |= p > 0.0);
            }
        }
        let traces_light = kind == integrator_kind::LIGHT_TRACING;
        for ((name, _), lit) in CLASSES.iter().zip(lit) {
            // No walk from a light finds the pinhole behind a discrete event, and the lamp is out of sight.
            let is_lost = traces_light && ["mirrored", "seen"].contains(name);
            assert!(lit || is_lost, "{kind}: {name} is black");
        }
    }
}

#[test]
fn the_image_is_the_one_without_parts() {
    let plain = film(&divided(integrator_kind::PATH, &[], None), 8, 4);
    let parts = film(&divided(integrator_kind::PATH, &CLASSES, None), 8, 4);
    assert_eq!(plain.statistics(), parts.statistics(), "to the bit");
    for kind in [
        integrator_kind::BIDIRECTIONAL,
        integrator_kind::PROGRESSIVE_PHOTONS,
        integrator_kind::ADAPTIVE_PHOTONS,
        integrator_kind::VERTEX_MERGING,
        integrator_kind::VEACH_MLT,
    ] {
        let plain = film(&divided(kind, &[], None), 2, 4).mean();
        let parts = film(&divided(kind, &CLASSES, None), 2, 4).mean();
        for (a, b) in plain.iter().zip(&parts) {
            assert!(
                (a[1] - b[1]).abs() < 1e-4 * a[1] + 1e-6,
                "{kind}: {a:?} {b:?}"
            );
        }
    }
}

/// Mean and variance of the mean of each class over an image's halves, by channel, from independent runs.
fn statistics(kind: u32, samples: u32, runs: u32) -> Vec<(f64, f64)> {
    let scene = divided(kind, &CLASSES, None);
    let numbers: Vec<Vec<f64>> = (0..runs)
        .map(|run| {
            let film = film(&scene, samples, 100 + run);
            let mut numbers = Vec::new();
            for part in 0..CLASSES.len() {
                for half in 0..2 {
                    for channel in 0..3 {
                        let own = (0..film.statistics().len()).filter(|i| i % 16 / 8 == half);
                        numbers.push(own.map(|i| film.part_mean(part, channel, i)).sum());
                    }
                }
            }
            numbers
        })
        .collect();
    let n = f64::from(runs);
    (0..numbers[0].len())
        .map(|i| {
            let mean = numbers.iter().map(|v| v[i]).sum::<f64>() / n;
            let square = numbers.iter().map(|v| (v[i] - mean).powi(2)).sum::<f64>();
            (mean, square / (n - 1.0) / n)
        })
        .collect()
}

#[test]
fn algorithms_agree_on_every_class() {
    let path = statistics(integrator_kind::PATH, 128, 12);
    for (kind, samples, bias) in [
        (integrator_kind::BIDIRECTIONAL, 32, 1e-3),
        (integrator_kind::LIGHT_TRACING, 96, 1e-3),
        (integrator_kind::VEACH_MLT, 2, 1e-3),
        (integrator_kind::PRIMARY_SAMPLE_MLT, 2, 1e-3),
        // Photons are gathered from around a point.
        (integrator_kind::VERTEX_MERGING, 16, 0.01),
        (integrator_kind::PROGRESSIVE_PHOTONS, 16, 0.02),
    ] {
        let other = statistics(kind, samples, 12);
        for (i, (a, b)) in path.iter().zip(&other).enumerate() {
            let (name, _) = CLASSES[i / 6];
            if kind == integrator_kind::LIGHT_TRACING && (name == "mirrored" || name == "seen") {
                // What the pinhole sees of specular surfaces and of light from infinity, no light walk finds.
                continue;
            }
            let deviation = (a.1 + b.1).sqrt();
            // Of a t distribution of about twenty degrees, 5.5 in none of a thousand suites.
            let z = (a.0 - b.0) / deviation.max(bias * a.0);
            assert!(z.abs() < 5.5, "{kind} {name} {}: {a:?} {b:?} z {z}", i % 6);
        }
    }
}

#[test]
fn nothing_counts_but_the_paths_of_one_expression() {
    for kind in [integrator_kind::PATH, integrator_kind::BIDIRECTIONAL] {
        let all = film(&divided(kind, &CLASSES, None), 8, 5);
        for (part, (name, text)) in CLASSES.iter().enumerate() {
            let layers = [
                ("same", *text),
                ("others", CLASSES[(part + 1) % 8].1),
                ("all", "L.*E"),
            ];
            let alone = film(&divided(kind, &layers, Some(text)), 8, 5);
            for (i, mean) in alone.mean().iter().enumerate() {
                for c in 0..3 {
                    let expected = all.part_mean(part, c, i);
                    let tolerance = 1e-5 * expected + 1e-9;
                    assert!((mean[c] - expected).abs() <= tolerance, "{kind} {name} {i}");
                    let layer = |l| alone.part_mean(l, c, i);
                    assert!(
                        (layer(0) - expected).abs() <= tolerance,
                        "{kind} {name} {i}"
                    );
                    assert_eq!(layer(1), 0.0);
                    assert!(
                        (layer(2) - expected).abs() <= tolerance,
                        "{kind} {name} {i}"
                    );
                }
            }
        }
    }
}

#[test]
fn parts_have_variances_where_the_image_has() {
    // A part that is all there is has those of the image, and those of independent images are as they say.
    let layers = [CLASSES.as_slice(), &[("all", "L .* E")]].concat();
    let scene = divided(integrator_kind::PATH, &layers, None);
    let with_variance = AovSet::NONE.with(Aov::Variance);
    let runs: Vec<Film> = (0..32)
        .map(|seed| render_film(&scene, &options(16, 100 + seed), with_variance).unwrap())
        .collect();
    let all = layers.len() - 1;
    for (i, own) in runs[0].statistics().iter().enumerate() {
        for c in 0..3 {
            let (part, whole) = (runs[0].part_variance(all, c, i), own.variance_of_mean()[c]);
            let error = (part.unwrap() - whole).abs();
            assert!(error <= 1e-5 * whole + 1e-12, "{i}: {part:?} {whole}");
        }
    }
    let n = runs.len() as f64;
    for part in 0..CLASSES.len() {
        let (mut said, mut found) = (0.0, 0.0);
        for i in 0..runs[0].statistics().len() {
            let mean = runs.iter().map(|f| f.part_mean(part, 1, i)).sum::<f64>() / n;
            let squares = runs
                .iter()
                .map(|f| (f.part_mean(part, 1, i) - mean).powi(2));
            found += squares.sum::<f64>() / (n - 1.0);
            let variances = runs.iter().map(|f| f.part_variance(part, 1, i).unwrap());
            said += variances.sum::<f64>() / n;
        }
        // Of thousands of samples, in a few of which most of a variance may lie.
        assert!((said / found - 1.0).abs() < 0.35, "{part}: {said} {found}");
    }
    let film = film(&scene, 1, 1);
    assert!(film.part_variance(0, 0, 0).is_none());
}

#[test]
fn names_and_regions_select_what_they_say() {
    let layers = [
        ("gold", "C<.. 'gold'>.*"),
        (
            "others",
            "C<.. 'wood'>.* | C<.. 'paint'>.* | C<.. 'glass'>.* | C<.. 'plastic'>.* | CL",
        ),
        ("key", "C.*<L.'key'>"),
        ("sky", "L[sky] X* E"),
        ("near", "L X* X{bead} E"),
        ("far", "L X* X[^bead]? E"),
    ];
    let film = film(&divided(integrator_kind::PATH, &layers, None), 8, 6);
    let sum = |part: usize| -> f64 {
        let pixels = film.statistics().len();
        (0..pixels).map(|i| film.part_mean(part, 1, i)).sum()
    };
    let whole: f64 = film.mean().iter().map(|p| p[1]).sum();
    for pair in [[0, 1], [2, 3]] {
        let [a, b] = pair.map(sum);
        assert!(
            a > 0.0 && b > 0.0 && ((a + b) / whole - 1.0).abs() < 1e-5,
            "{pair:?}"
        );
    }
    // The floor touches the bead's ball, and some of it lies within.
    assert!(sum(4) > 0.0 && sum(4) + sum(5) >= whole * (1.0 - 1e-5));
}

#[test]
fn parts_do_not_depend_on_threads() {
    for kind in [integrator_kind::PATH, integrator_kind::BIDIRECTIONAL] {
        let scene = divided(kind, &CLASSES, None);
        let of = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| film(&scene, 3, 7))
        };
        assert_eq!(of(1), of(3));
    }
}

#[test]
fn checkpoints_keep_parts_beside_other_layers() {
    let scene = divided(integrator_kind::PATH, &CLASSES, None);
    let aovs = AovSet::NONE.with(Aov::Normal).with(Aov::Depth);
    let film = render_film(&scene, &options(2, 8), aovs).unwrap();
    let mut bytes = Vec::new();
    write_checkpoint(&mut bytes, &Progress::default(), &film).unwrap();
    let length = bytes.len() as u64;
    let (_, read) = read_checkpoint(&mut bytes.as_slice(), length, "test".as_ref()).unwrap();
    assert_eq!(read, film);
    assert_eq!(read.parts()[4], "diffuse-caustics");
    let plain = render_film(
        &divided(integrator_kind::PATH, &[], None),
        &options(2, 8),
        aovs,
    );
    for pixel in 0..film.statistics().len() {
        let expected = plain.as_ref().unwrap().aov_mean(Aov::Depth, 0, pixel);
        assert_eq!(film.aov_mean(Aov::Depth, 0, pixel), expected);
    }
}

#[test]
fn wavefronts_give_the_parts_of_single_paths() {
    for only in [None, Some("L X* D E")] {
        let scene = divided(integrator_kind::PATH, &CLASSES, only);
        let film = film(&scene, 1, 9);
        let tables = scene.tables.view();
        let accel = Accel::build(tables, &scene.tables.groups);
        let traverse = accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        let expressions = scene.parts.view().unwrap();
        let first = scene.parts.first_layer();
        for pixel in 0..160 {
            let mut parts = [Vec3::ZERO; 9];
            let whole = sample_divided_pixel(
                &view,
                &scene.settings,
                &expressions,
                &mut IndependentSampler::new(9, pixel, 0),
                [pixel % 16, pixel / 16],
                &mut parts[..first + CLASSES.len()],
            );
            let found = film.pixel(pixel % 16, pixel / 16);
            for c in 0..3 {
                // Of a part, shares are rounded.
                let (found, expected) = (found.mean[c], f64::from(whole[c]));
                let tolerance = if only.is_some() { 1e-6 * expected } else { 0.0 };
                let error = (found - expected).abs();
                assert!(error <= tolerance, "{pixel}: {found} {expected}");
            }
            for part in 0..CLASSES.len() {
                for c in 0..3 {
                    let expected = f64::from(parts[first + part][c]);
                    let mean = film.part_mean(part, c, pixel as usize);
                    let error = (mean - expected).abs();
                    // Shares are rounded; what is left of one is rounded as much.
                    let all = f64::from(whole[c]);
                    assert!(
                        error <= 1e-6 * expected + 1e-6 * all,
                        "{pixel} {part}: {mean} {expected} of {all}"
                    );
                }
            }
        }
    }
}
