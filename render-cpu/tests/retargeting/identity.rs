//! Edits that change nothing.

use crate::scenes::{PLASTIC, room};
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use halflight_kernel::transport::integrator_kind;

const KINDS: [u32; 3] = [
    integrator_kind::PATH,
    integrator_kind::BIDIRECTIONAL,
    integrator_kind::LIGHT_TRACING,
];

fn film(scene: &Scene) -> Film {
    let options = RenderOptions {
        goal: Goal::Samples(4),
        seed: 3,
        first_sample: 0,
        adaptive: false,
    };
    render_film(scene, &options, AovSet::NONE).unwrap()
}

#[test]
fn an_identity_leaves_images_as_they_are_to_the_bit() {
    let place =
        r#"<scale x="2" y="1" z="0.1"/><rotate x="1" angle="-90"/><translate x="0.3" y="0.7"/>"#;
    let edit = format!(
        r#"<edit type="retarget"><string name="selection" value="L X+ X"/>
        <transform name="source">{place}</transform><transform name="target">{place}</transform></edit>"#
    );
    for kind in KINDS {
        let mut plain = room(PLASTIC, "");
        let mut edited = room(PLASTIC, &edit);
        assert!(edited.edits.is_empty());
        plain.settings.kind = kind;
        edited.settings.kind = kind;
        assert_eq!(film(&plain), film(&edited), "{kind}");
    }
}

#[test]
fn a_selection_that_matches_nothing_changes_nothing() {
    // Nothing is transparent.
    for selection in ["L S^T X", "X S^T E", "L D^T+ X"] {
        let edit = format!(
            r#"<edit type="retarget"><string name="selection" value="{selection}"/>
            <transform name="map"><rotate y="1" angle="30"/></transform></edit>"#
        );
        for kind in KINDS {
            let mut plain = room(PLASTIC, "");
            let mut edited = room(PLASTIC, &edit);
            assert!(!edited.edits.is_empty());
            plain.settings.kind = kind;
            edited.settings.kind = kind;
            let (plain, edited) = (film(&plain), film(&edited));
            if kind == integrator_kind::PATH {
                assert_eq!(plain, edited, "{selection}: to the bit");
                continue;
            }
            // The same samples, whose sums are rounded in another order.
            for (a, b) in plain.mean().iter().zip(edited.mean()) {
                for c in 0..3 {
                    let error = (a[c] - b[c]).abs();
                    assert!(
                        error <= 1e-4 * a[c] + 1e-6,
                        "{kind} {selection}: {a:?} {b:?}"
                    );
                }
            }
        }
    }
}
