//! What files before version 2 mean otherwise.

use crate::{Files, assert_mean};

#[test]
fn a_property_said_twice_is_the_last_one_before_version_2() {
    let files = Files::new(&[]);
    let twice = [
        (
            r#"<shape type="sphere"><boolean name="flipNormals" value="true"/></shape>"#,
            r#"<shape type="sphere"><boolean name="flipNormals" value="false"/><boolean name="flipNormals" value="true"/></shape>"#,
        ),
        (
            r#"<shape type="rectangle"><transform name="toWorld"><scale value="2"/></transform></shape>"#,
            r#"<shape type="rectangle"><transform name="toWorld"><scale value="3"/></transform><transform name="toWorld"><scale value="2"/></transform></shape>"#,
        ),
        (
            r#"<shape type="rectangle"><bsdf type="diffuse"><rgb name="reflectance" value="0.25"/></bsdf></shape>"#,
            r#"<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard"/><rgb name="reflectance" value="0.25"/></bsdf></shape>"#,
        ),
        (
            r#"<shape type="sphere"><float name="radius" value="0.5"/></shape>"#,
            r#"<shape type="sphere"><integer name="radius" value="2"/><float name="radius" value="0.5"/></shape>"#,
        ),
    ];
    for (once, twice) in twice {
        let tables = files.warned("0.6.0", twice, "the last one counts");
        assert_eq!(tables, files.clean("0.6.0", once), "{twice}");
        assert!(
            files
                .error("2.0.0", twice)
                .contains("has this property already")
        );
    }
}

#[test]
fn a_medium_without_a_surface_is_a_boundary_before_version_2() {
    let files = Files::new(&[]);
    let nothing = r#"<bsdf type="null"/>"#;
    for shape in ["sphere", "cube", "rectangle"] {
        for name in ["interior", "exterior"] {
            let medium = |bsdf: &str| {
                format!(
                    r#"<shape type="{shape}"><medium type="homogeneous" name="{name}"><spectrum name="sigmaS" value="0"/></medium>{bsdf}</shape>"#
                )
            };
            let old = files.scene("0.6.0", &medium("")).unwrap();
            assert_eq!(old.warnings.len(), 1, "{:?}", old.warnings);
            assert_mean(&old, 1, 1.0, 1e-6);
            let said = files.scene("0.6.0", &medium(nothing)).unwrap();
            assert_eq!(said.tables.fingerprint(), old.tables.fingerprint());
            // Later versions give it the surface of any other shape.
            let new = files.scene("3.0.0", &medium("")).unwrap();
            assert_ne!(new.tables.fingerprint(), old.tables.fingerprint());
        }
    }
    // A medium that several shapes share is named once.
    let shared = r#"<medium type="heterogeneous" id="smoke"/>
        <shape type="sphere"><ref name="interior" id="smoke"/></shape><shape type="cube"><ref name="interior" id="smoke"/></shape>"#;
    files.warned("0.6.0", shared, "media are not supported");
}

#[test]
fn texture_coordinates_are_scaled_before_they_are_moved() {
    let files = Files::new(&[]);
    let texture = |properties: &str| {
        format!(
            r#"<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard">{properties}</texture></bsdf></shape>"#
        )
    };
    let old = texture(
        r#"<float name="uscale" value="4"/><float name="vscale" value="2"/><float name="uoffset" value="0.5"/><float name="voffset" value="0.25"/>"#,
    );
    let order = |transforms: &str| {
        texture(&format!(
            r#"<transform name="to_uv">{transforms}</transform>"#
        ))
    };
    let scale = r#"<scale x="4" y="2"/>"#;
    let translate = r#"<translate x="0.5" y="0.25"/>"#;
    assert_eq!(
        files.clean("0.6.0", &old),
        files.clean("0.6.0", &order(&format!("{scale}{translate}")))
    );
    assert_eq!(
        files.clean("3.0.0", &old),
        files.clean("3.0.0", &order(&format!("{translate}{scale}")))
    );
    // One scale for both, and one of its own.
    let both = texture(
        r#"<float name="uvscale" value="2"/><float name="uscale" value="4"/><float name="uoffset" value="0.5"/><float name="voffset" value="0.25"/>"#,
    );
    assert_eq!(files.clean("0.6.0", &both), files.clean("0.6.0", &old));
}

#[test]
fn one_number_for_a_light_is_white_and_a_metal_is_copper_before_version_2() {
    let files = Files::new(&[]);
    let lamp = |value: &str| {
        format!(r#"<shape type="sphere"><emitter type="area">{value}</emitter></shape>"#)
    };
    let number = lamp(r#"<spectrum name="radiance" value="2"/>"#);
    let white = lamp(r#"<rgb name="radiance" value="2"/>"#);
    assert_eq!(files.clean("0.6.0", &number), files.clean("0.6.0", &white));
    assert_ne!(files.clean("3.0.0", &number), files.clean("3.0.0", &white));
    let metal = |properties: &str| {
        format!(r#"<shape type="sphere"><bsdf type="conductor">{properties}</bsdf></shape>"#)
    };
    let copper = metal(r#"<string name="material" value="Cu"/>"#);
    let mirror = metal(r#"<string name="material" value="none"/>"#);
    assert_eq!(
        files.clean("0.6.0", &metal("")),
        files.clean("0.6.0", &copper)
    );
    assert_eq!(
        files.clean("3.0.0", &metal("")),
        files.clean("3.0.0", &mirror)
    );
}
