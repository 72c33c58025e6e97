//! Images of photon mapping against what is known of them, and against path tracing where that finds the light.

use crate::scenes::{CAMERA, film, integrator, mean, scene};
use halflight::film::Film;

/// A floor of a material, lit by a point light.
fn floor(material: &str) -> String {
    format!(
        r#"{CAMERA}<shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>{material}</shape>
        <emitter type="point"><point name="position" x="0.3" y="0" z="1"/><rgb name="intensity" value="3, 2, 1"/></emitter>"#
    )
}

/// A mirror at x = 0.36, upright, that reflects everything.
const MIRROR: &str = r#"<shape type="rectangle">
    <transform name="to_world"><scale value="3"/><rotate y="1" angle="-90"/><translate x="0.36"/></transform>
    <bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>"#;

/// The light that the mirror makes of the other.
const IMAGE_OF_LIGHT: &str = r#"<emitter type="point"><point name="position" x="0.42" y="0" z="1"/>
    <rgb name="intensity" value="3, 2, 1"/></emitter>"#;

const DIFFUSE: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>"#;
const GLOSSY: &str = r#"<bsdf type="roughconductor"><string name="material" value="none"/>
    <float name="alpha" value="0.1"/></bsdf>"#;
const ROUGH: &str = r#"<bsdf type="roughconductor"><string name="material" value="none"/>
    <float name="alpha" value="0.4"/></bsdf>"#;

/// Insists that pixels are as expected within 5 standard errors and the two percent of what the radius blurs.
fn expect_pixels(what: &str, film: &Film, expected: &[[f64; 3]]) {
    for (i, (found, expected)) in film.mean().iter().zip(expected).enumerate() {
        let variance = film.statistics()[i].variance_of_mean();
        for c in 0..3 {
            let tolerance = 5.0 * variance[c].sqrt() + 0.02 * expected[c];
            assert!(
                (found[c] - expected[c]).abs() < tolerance,
                "{what}, pixel {i}, channel {c}: {} instead of {} +- {}",
                found[c],
                expected[c],
                variance[c].sqrt()
            );
        }
    }
}

/// A point light by way of a mirror is light that only photons find: on rough surfaces, where walks gather, and on glossy ones,
/// where they go on. It is that of a light behind the mirror, which next event estimation knows.
#[test]
fn light_by_way_of_a_mirror_is_that_of_its_image() {
    for (name, material) in [("diffuse", DIFFUSE), ("glossy", GLOSSY), ("rough", ROUGH)] {
        let depth = ("max_depth", 3.0);
        let known = scene(
            &integrator("path", &[("max_depth", 2.0)]),
            &(floor(material) + IMAGE_OF_LIGHT),
        );
        let expected = film(&known, 1, 0, 256).mean();
        let photons = [
            depth,
            ("photon_count", 200_000.0),
            ("initial_radius", 0.06),
            ("max_radius", 0.02),
        ];
        for plugin in ["sppm", "mcppm", "appm", "vcm", "vm"] {
            let mirrored = scene(&integrator(plugin, &photons), &(floor(material) + MIRROR));
            expect_pixels(
                &format!("{plugin}, {name}"),
                &film(&mirrored, 7, 0, 20),
                &expected,
            );
        }
        // The test can tell: without the mirror a good part of the light is missing.
        let alone = scene(&integrator("path", &[depth]), &floor(material));
        let without = film(&alone, 1, 0, 64).mean();
        let sum = |pixels: &[[f64; 3]]| pixels.iter().map(|p| p[0]).sum::<f64>();
        assert!(sum(&without) < 0.9 * sum(&expected), "{name}");
    }
}

/// A box whose inside is all diffuse, lit by a part of its ceiling, with a rough and a glossy block in it.
fn room() -> String {
    let wall = |transform: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world">{transform}</transform>
            <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.6, 0.5"/></bsdf></bsdf></shape>"#
        )
    };
    let walls = [
        r#"<rotate x="1" angle="-90"/><translate y="-1"/>"#,
        r#"<rotate x="1" angle="90"/><translate y="1"/>"#,
        r#"<translate z="-1"/>"#,
        r#"<rotate y="1" angle="90"/><translate x="-1"/>"#,
        r#"<rotate y="1" angle="-90"/><translate x="1"/>"#,
    ];
    let walls: String = walls.iter().map(|w| wall(w)).collect();
    format!(
        r#"<sensor type="thinlens"><float name="fov" value="35"/><float name="aperture_radius" value="0.05"/>
            <float name="focus_distance" value="4"/>
            <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="6"/><integer name="height" value="6"/><rfilter type="tent"/></film>
        </sensor>{walls}
        <shape type="rectangle"><transform name="to_world"><scale value="0.4"/><rotate x="1" angle="90"/>
            <translate y="0.98"/></transform><emitter type="area"><rgb name="radiance" value="6, 5, 4"/></emitter></shape>
        <shape type="cube"><transform name="to_world"><scale value="0.3"/><translate x="-0.4" y="-0.7" z="0.1"/></transform>
            <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="0.4" y="-0.6" z="0"/><float name="radius" value="0.35"/>
            <bsdf type="roughconductor"><float name="alpha" value="0.08"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="0.1" y="0.2" z="-0.4"/><float name="radius" value="0.2"/>
            <bsdf type="plastic"/></shape>"#
    )
}

/// Whole images: two estimators that share no more than surfaces and materials.
#[test]
fn mean_is_that_of_path_tracing() {
    let depth = ("max_depth", 6.0);
    let traced = scene(&integrator("path", &[depth]), &room());
    let (expected, error) = mean(&traced, 100, 8, 512);
    let algorithms = [
        ("sppm", 0.01, 0.03),
        ("sppm", 0.15, 0.03),
        ("sppm", 0.5, 0.03),
        // Radii of their own, of the nearest photons.
        ("sppm", 0.15, 0.0),
        ("mcppm", 0.15, 0.03),
        ("vcm", 0.0, 0.03),
        ("vm", 0.0, 0.03),
        ("appm", 0.15, 0.03),
    ];
    for (plugin, gather_roughness, initial_radius) in algorithms {
        let properties = [
            depth,
            ("photon_count", 40_000.0),
            ("initial_radius", initial_radius),
            ("gather_roughness", gather_roughness),
            ("max_radius", 0.02),
            ("nearest", 10.0),
        ];
        let scene = scene(&integrator(plugin, &properties), &room());
        let (found, noise) = mean(&scene, 3, 8, 16);
        for c in 0..3 {
            // The disks at edges miss what lies around the corner: radius over distance between edges.
            let tolerance = 5.0 * (error[c].hypot(noise[c])) + 0.015 * expected[c];
            assert!(
                (found[c] - expected[c]).abs() < tolerance,
                "{plugin}, roughness {gather_roughness}, radius {initial_radius}, channel {c}: {} +- {} instead of {} +- {}",
                found[c],
                noise[c],
                expected[c],
                error[c]
            );
        }
    }
}

/// With nothing to merge, vertex connection and merging is bidirectional path tracing, to the bit.
#[test]
fn without_a_radius_it_is_bidirectional() {
    let properties = [
        ("max_depth", 6.0),
        ("photon_count", 1000.0),
        ("initial_radius", 1e-12),
    ];
    let mut connected = scene(&integrator("bdpt", &properties[..1]), &room());
    let mut merged = scene(&integrator("vcm", &properties), &room());
    // With its own light walk, and with those of many samples.
    for connections in [0, 2] {
        for scene in [&mut connected, &mut merged] {
            scene.settings.bidirectional.connections = connections;
        }
        assert_eq!(film(&merged, 9, 0, 4), film(&connected, 9, 0, 4));
    }
}
