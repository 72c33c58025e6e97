//! Manifold next event estimation: the image of other algorithms through smooth and rough interfaces.

use crate::agreement::{Batches, compare, report, settings_of};
use crate::scenes::{LAMP, PINHOLE, room, scene};
use halflight_kernel::transport::settings::integrator_kind;

const DIFFUSE: &str =
    r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf>"#;

/// A material that is diffuse under a coat, and one that is too glossy to be connected.
const COATED: &str = r#"<bsdf type="plastic"/>"#;
const GLOSSY: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.15"/></bsdf>"#;

const SMALL_LAMP: &str = r#"<shape type="sphere"><point name="center" value="0, 1.6, 0"/><float name="radius" value="0.15"/>
    <emitter type="area"><rgb name="radiance" value="40, 30, 20"/></emitter></shape>"#;

fn ball(material: &str) -> String {
    format!(
        r#"<shape type="sphere"><point name="center" value="0.2, 0.6, 0"/><float name="radius" value="0.45"/>{material}</shape>"#
    )
}

fn slab(material: &str) -> String {
    format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="0.9" y="0.1" z="0.9"/><rotate z="1" angle="12"/>
        <translate y="1.1"/></transform>{material}</shape>"#
    )
}

const GLASS: &str = r#"<bsdf type="dielectric"/>"#;

fn frosted(alpha: f32) -> String {
    format!(r#"<bsdf type="roughdielectric"><float name="alpha" value="{alpha}"/></bsdf>"#)
}

#[test]
fn lamps_behind_interfaces_keep_the_image() {
    let mut results = Vec::new();
    for (what, wall, light, glass) in [
        ("ball", DIFFUSE, SMALL_LAMP, ball(GLASS)),
        ("ball on coats", COATED, SMALL_LAMP, ball(GLASS)),
        ("slab", DIFFUSE, LAMP, slab(GLASS)),
        ("slab and ball", DIFFUSE, LAMP, slab(GLASS) + &ball(GLASS)),
        ("rough slab", DIFFUSE, LAMP, slab(&frosted(0.1))),
        ("rougher ball", DIFFUSE, SMALL_LAMP, ball(&frosted(0.25))),
        ("glossy walls", GLOSSY, LAMP, slab(GLASS)),
    ] {
        let mut scene = scene(&[PINHOLE, &room(wall), light, &glass].concat(), &[]);
        scene.settings.rules.max_depth = 6;
        let truth = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
        let truth = Batches::render(what, &mut scene, truth, 256);
        let plain = settings_of(&scene, integrator_kind::PATH);
        let plain = Batches::render(what, &mut scene, plain, 192);
        let own = settings_of(&scene, integrator_kind::MANIFOLD_PATH);
        let own = Batches::render(what, &mut scene, own, 192);
        println!(
            "{what}: noise {:.4}, of path tracing {:.4}",
            own.relative_error(),
            plain.relative_error()
        );
        results.push(compare(&format!("{what}, path"), &truth, &plain));
        results.push(compare(what, &truth, &own));
    }
    report(results);
}

/// Light of a point arrives through a ball, whose reflections are too faint to be seen. Straight lines through the edges of a slab are no
/// start for what passes its faces: there some of the light of points is lost.
#[test]
fn point_lights_behind_interfaces_keep_the_image() {
    let point = r#"<emitter type="point"><point name="position" value="0, 1.7, 0"/><rgb name="intensity" value="3, 2, 1"/></emitter>"#;
    let faint = r#"<bsdf type="dielectric"><float name="int_ior" value="1.15"/></bsdf>"#;
    let what = "point light, ball";
    let mut scene = scene(
        &[PINHOLE, &room(DIFFUSE), point, &ball(faint)].concat(),
        &[],
    );
    // What the lens sees through the glass again, no connection of two walks finds.
    scene.settings.rules.max_depth = 4;
    let truth = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
    let truth = Batches::render(what, &mut scene, truth, 512);
    let own = settings_of(&scene, integrator_kind::MANIFOLD_PATH);
    let own = Batches::render(what, &mut scene, own, 64);
    report([compare(what, &truth, &own)]);
}
