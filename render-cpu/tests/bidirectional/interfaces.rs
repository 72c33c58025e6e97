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
        let both = settings_of(&scene, integrator_kind::MANIFOLD_BIDIRECTIONAL);
        let both = Batches::render(what, &mut scene, both, 64);
        println!(
            "{what}: noise {:.4}, of path tracing {:.4}, from both ends {:.4}, {:.4}",
            own.relative_error(),
            plain.relative_error(),
            both.relative_error(),
            truth.relative_error(),
        );
        results.push(compare(&format!("{what}, path"), &truth, &plain));
        results.push(compare(what, &truth, &own));
        results.push(compare(&format!("{what}, both ends"), &truth, &both));
        results.push(compare(&format!("{what}, both ends, path"), &plain, &both));
    }
    report(results);
}

/// Light of a point arrives through a pane that is wider than the room and reflects nothing: each straight line meets both of its faces, and
/// each has one path. Through a ball or the edge of a slab there is light where no straight line to the point meets an interface, and
/// what interfaces reflect is found by no walk through them: some of the light of points is lost there.
#[test]
fn point_lights_behind_panes_keep_the_image() {
    let point = r#"<emitter type="point"><point name="position" value="0.3, 1.7, -0.2"/><rgb name="intensity" value="3, 2, 1"/></emitter>"#;
    let clear = r#"<bsdf type="dielectric"><rgb name="specular_reflectance" value="0"/></bsdf>"#;
    let mut results = Vec::new();
    for (what, transform) in [
        ("level pane", r#"<scale x="9" y="0.1" z="9"/>"#),
        (
            "tilted pane",
            r#"<scale x="9" y="0.05" z="9"/><rotate z="1" angle="8"/><rotate x="1" angle="5"/>"#,
        ),
    ] {
        let pane = format!(
            r#"<shape type="cube"><transform name="to_world">{transform}<translate y="1.3"/></transform>{clear}</shape>"#
        );
        let mut scene = scene(&[PINHOLE, &room(DIFFUSE), point, &pane].concat(), &[]);
        // What the lens sees through the glass again, no connection of two walks finds.
        scene.settings.rules.max_depth = 4;
        let truth = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
        let truth = Batches::render(what, &mut scene, truth, 512);
        for kind in [
            integrator_kind::MANIFOLD_PATH,
            integrator_kind::MANIFOLD_BIDIRECTIONAL,
        ] {
            let own = settings_of(&scene, kind);
            let own = Batches::render(what, &mut scene, own, 128);
            results.push(compare(&format!("{what}, {kind}"), &truth, &own));
        }
    }
    report(results);
}
