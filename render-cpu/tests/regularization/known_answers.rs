//! Images with closed forms: a point light by a mirror on a floor, and a point light behind a mirror, a slab and a ball lens.

use crate::scenes::{mean, mollified, regularized, render_film, scene};

/// A floor seen from above, a mirror beside it that stands on the plane x = 1, and a point light.
pub fn floor_by_a_mirror() -> &'static str {
    r#"<sensor type="perspective"><float name="fov" value="2"/>
    <transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="9"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.5, 0.5"/></bsdf></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="-90"/><translate x="1"/>
    </transform><bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf></shape>
    <emitter type="point"><point name="position" value="0.3, 0, 1"/><rgb name="intensity" value="1, 1, 1"/></emitter>"#
}

/// The share of [`floor_radiance`] that comes by the mirror.
pub fn floor_share_of_mirror() -> f64 {
    let lit = |x: f64| (x * x + 1.0).powf(-1.5);
    lit(1.7) / (lit(0.3) + lit(1.7))
}

/// Radiance of the floor at the origin, lit by the light and by its image.
fn floor_radiance() -> f64 {
    let lit = |x: f64| (x * x + 1.0).powf(-1.5);
    0.5 / std::f64::consts::PI * (lit(0.3) + lit(1.7))
}

#[test]
fn the_image_of_a_light_in_a_mirror_lights_a_floor() {
    let truth = floor_radiance();
    for (name, samples) in [("path", 8192), ("bdpt", 1024), ("vcm", 256)] {
        let mut plain = scene(name, floor_by_a_mirror());
        plain.settings.rules.max_depth = 3;
        plain.settings.photon.initial_radius = 0.05;
        plain.settings.photon.photon_count = 10_000;
        let error = |text: &str| {
            let (mean, sigma) = mean(&render_film(&regularized(plain.clone(), text), samples));
            (mean / truth - 1.0, sigma / truth)
        };
        let (blurred, _) = error("tau=30,constant");
        let (sharp, sigma) = error("tau=1e5,constant");
        println!("{name}: {blurred:.4} at tau 30, {sharp:.4} +- {sigma:.4} at tau 1e5");
        assert!(sigma < 0.02, "{name}: noise of {sigma} hides everything");
        assert!(
            sharp.abs() < 4.0 * sigma + 0.015,
            "{name}: {sharp} +- {sigma}"
        );
        for heuristics in ["quality", "diffusion", "fade=0.1,diffusion"] {
            // Bidirectionally the light image makes the mirror's caustic, and quality leaves it to that, which sees few
            // light walks in a view as narrow as this.
            if name != "path" && heuristics != "diffusion" {
                continue;
            }
            let (adaptive, sigma) = error(&format!("tau=1e5,constant,{heuristics}"));
            println!("{name}: {adaptive:.4} +- {sigma:.4} at tau 1e5 with {heuristics}");
            assert!(sigma < 0.03, "{name}: noise of {sigma} hides everything");
            assert!(
                adaptive.abs() < 4.0 * sigma + 0.015,
                "{name}, {heuristics}: {adaptive} +- {sigma}"
            );
        }
        if name == "path" {
            // The mirror's share is there with any tau, and it is a large one.
            let (without, _) = error("tau=inf");
            let (merged, sigma) = error("tau=200,constant,virtual");
            println!("{name}: {merged:.4} +- {sigma:.4} by virtual merges");
            assert!(sigma < 0.05, "{name}: noise of {sigma} hides everything");
            assert!(merged.abs() < 4.0 * sigma + 0.01, "{merged} +- {sigma}");
            assert!(
                without < -0.12 && blurred > without + 0.1,
                "{without} {blurred}"
            );
        }
    }
}

/// A pinhole on the z axis that looks up, with a square view of a given angle in degrees.
fn camera(z: f64, fov: f64) -> String {
    format!(
        r#"<sensor type="perspective"><float name="fov" value="{fov}"/>
        <transform name="to_world"><lookat origin="0, 0, {z}" target="0, 0, 100" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film>
        </sensor>"#
    )
}

/// A point light of intensity 1.
fn light(z: f64) -> String {
    format!(
        r#"<emitter type="point"><point name="position" value="0, 0, {z}"/><rgb name="intensity" value="1, 1, 1"/></emitter>"#
    )
}

/// A point light that a pinhole on the axis sees through specular surfaces alone.
struct Axis {
    name: &'static str,
    content: String,
    edges: u32,
    /// Field of view in degrees.
    fov: f64,
    /// Irradiance at the pinhole, perpendicular to the axis.
    irradiance: f64,
    /// Radius of the blur.
    radius: f64,
}

/// A mirror at z = 2 that faces down.
const MIRROR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/><rotate x="1" angle="180"/>
    <translate z="2"/></transform><bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>"#;

/// Fresnel transmittance of one boundary at normal incidence.
fn passed(eta: f64) -> f64 {
    1.0 - ((eta - 1.0) / (eta + 1.0)).powi(2)
}

/// A point light in a mirror, seen by a pinhole.
pub fn mirror_on_axis() -> String {
    mirror_of(r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#)
}

/// The same with another material.
pub fn mirror_of(bsdf: &str) -> String {
    let conductor = r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#;
    camera(0.0, 30.0) + &light(1.0) + &MIRROR.replace(conductor, bsdf)
}

fn axes() -> [Axis; 4] {
    let eta: f64 = 1.5;
    let slab = |z: f64, flip: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/>{flip}<translate z="{z}"/></transform>
            <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#
        )
    };
    let radius: f64 = 0.5;
    // A ray from the light at an angle of one: where it passes the pinhole, by the matrices of paraxial optics, with
    // distances of 3 before the ball and 0.2 behind it: far enough from the image of the light, where rays by the rim meet too.
    let power = (eta - 1.0) / radius;
    let (mut y, mut angle) = (3.0, 1.0);
    angle = (angle - power * y) / eta;
    y += 2.0 * radius * angle;
    angle = eta * angle - power * y;
    y += 0.2 * angle;
    [
        Axis {
            name: "mirror",
            content: camera(0.0, 6.0) + &light(-1.0) + MIRROR,
            edges: 2,
            fov: 6.0,
            irradiance: 1.0 / 25.0,
            radius: 0.02,
        },
        Axis {
            name: "mirror, whose longest edge is that to the lens",
            content: camera(0.0, 30.0) + &light(1.0) + MIRROR,
            edges: 2,
            fov: 30.0,
            irradiance: 1.0 / 9.0,
            radius: 0.2,
        },
        Axis {
            name: "slab",
            content: camera(0.0, 6.0)
                + &light(3.5)
                + &slab(1.0, r#"<rotate x="1" angle="180"/>"#)
                + &slab(2.0, ""),
            edges: 3,
            fov: 6.0,
            irradiance: passed(eta).powi(2) / (1.0 + 1.0 / eta + 1.5_f64).powi(2),
            radius: 0.02,
        },
        Axis {
            name: "lens",
            content: camera(0.0, 6.0)
                + &light(0.2 + 2.0 * radius + 3.0)
                + &format!(
                    r#"<shape type="sphere"><point name="center" value="0, 0, {}"/><float name="radius" value="{radius}"/>
                    <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#,
                    0.2 + radius
                ),
            edges: 3,
            fov: 6.0,
            irradiance: passed(eta).powi(2) / (y * y),
            radius: 0.02,
        },
    ]
}

#[test]
fn a_point_light_is_seen_in_a_mirror_and_through_a_slab_and_a_lens() {
    for axis in axes() {
        // The mean radiance of the film over its area at distance 1.
        let side = 2.0 * (0.5 * axis.fov.to_radians()).tan();
        let truth = axis.irradiance / (side * side);
        for (name, samples) in [("path", 32768), ("bdpt", 65536), ("vcm", 32768)] {
            let mut plain = scene(name, &axis.content);
            plain.settings.rules.max_depth = axis.edges;
            plain.settings.photon.photon_count = 1;
            assert!(
                mean(&render_film(&plain, 16)).0 == 0.0,
                "{name} finds the {}",
                axis.name
            );
            let text = format!("r0={},constant", axis.radius);
            let film = render_film(&mollified(plain, &text), samples);
            let (mean, sigma) = mean(&film);
            let (error, sigma) = (mean / truth - 1.0, sigma / truth);
            println!("{}, {name}: {error:.4} +- {sigma:.4}", axis.name);
            assert!(sigma < 0.1, "{name}: noise of {sigma} hides everything");
            assert!(
                error.abs() < 4.0 * sigma + 0.005,
                "{}, {name}: {error} +- {sigma}",
                axis.name
            );
        }
    }
}
