//! Edits that change nothing.

use crate::scenes::{PLASTIC, read_room, room};
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::markov::primary_space::technique;

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

/// An algorithm, and how it makes paths of primary samples.
const ALL: [(u32, u32); 8] = [
    (integrator_kind::PATH, 0),
    (integrator_kind::BIDIRECTIONAL, 0),
    (integrator_kind::LIGHT_TRACING, 0),
    (integrator_kind::VERTEX_MERGING, 0),
    (integrator_kind::VEACH_MLT, 0),
    (integrator_kind::PRIMARY_SAMPLE_MLT, technique::PATH),
    (
        integrator_kind::PRIMARY_SAMPLE_MLT,
        technique::BIDIRECTIONAL,
    ),
    (integrator_kind::PRIMARY_SAMPLE_MLT, technique::MULTIPLEXED),
];

#[test]
fn a_selection_that_matches_nothing_changes_nothing_to_the_bit() {
    // Nothing is transparent, nor is a surface diffuse and specular at once.
    for selection in ["L S^T X", "X S^T E", "L D^T+ X", "L D X* D[mirror] X"] {
        let edit = format!(
            r#"<edit type="retarget"><string name="selection" value="{selection}"/>
            <transform name="map"><rotate y="1" angle="30"/></transform></edit>"#
        );
        let mut plain = room(PLASTIC, "");
        let mut edited = read_room(PLASTIC, &edit, false).unwrap();
        let warnings: Vec<String> = edited.warnings.iter().map(ToString::to_string).collect();
        assert!(
            matches!(&warnings[..], [one] if one.contains(selection) && one.contains("changes nothing")),
            "{warnings:?}"
        );
        for (kind, technique) in ALL {
            for scene in [&mut plain, &mut edited] {
                scene.settings.kind = kind;
                scene.settings.chains.technique = technique;
                scene.settings.chains.mutations = 8;
                scene.settings.chains.manifold_weight = 1.0;
                scene.settings.photon.photon_count = 500;
                scene.settings.photon.initial_radius = 0.1;
            }
            assert_eq!(
                film(&plain),
                film(&edited),
                "{kind} {technique} {selection}"
            );
        }
    }
}

#[test]
fn an_edit_beside_one_that_matches_nothing_is_as_it_is_alone() {
    let edit = |selection: &str| {
        format!(
            r#"<edit type="retarget"><string name="selection" value="{selection}"/>
            <transform name="map"><rotate y="1" angle="30"/></transform></edit>"#
        )
    };
    let alone = room(PLASTIC, &edit("L S^R X"));
    let both = read_room(PLASTIC, &[edit("L S^T X"), edit("L S^R X")].concat(), false).unwrap();
    assert_eq!(film(&alone), film(&both));
    assert_ne!(film(&alone), film(&room(PLASTIC, "")));
}
