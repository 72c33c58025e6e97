//! Every element has its value, in both generations of names.

use glam::{DMat4, DVec3};
use halflight::scene::xml::{Color, ColorSource, FloatSource, Object, ObjectKind, Spectrum, Value};

use super::*;

#[test]
fn degenerate_inputs_are_named() {
    for (text, wanted) in [
        ("", "scene.xml:1:1: malformed XML: "),
        (" \n ", "scene.xml:1:1: malformed XML: "),
        (
            "<scene version=\"3.0.0\">",
            "scene.xml:1:1: malformed XML: ",
        ),
        (
            "<scene\nversion=\"3.0.0\"><a></b></scene>",
            "scene.xml:2:20: malformed XML: ",
        ),
        ("not XML", "scene.xml:1:1: malformed XML: "),
        (
            "<bsdf version=\"3.0.0\" type=\"t\"/>",
            "scene.xml:1:1: <bsdf type=\"t\">: the outermost element must be <scene>",
        ),
        (
            "<html/>",
            "scene.xml:1:1: <html>: the outermost element must be <scene>",
        ),
    ] {
        let message = error_of(text);
        assert!(message.starts_with(wanted), "{text:?}: {message}");
    }
    let empty = parse("<scene version=\"3.0.0\"/>").expect("an empty scene is one");
    assert_eq!(empty.root.kind, ObjectKind::Scene);
    assert!(empty.root.properties.is_empty());
}

#[test]
fn plain_values_have_their_types() {
    assert!(
        matches!(value("<float name=\"p\" value=\" 1.5e-3 \"/>"), Value::Float(x) if x == 1.5e-3)
    );
    assert!(matches!(
        value("<float name=\"p\" value=\".5\"/>"),
        Value::Float(0.5)
    ));
    assert!(matches!(
        value("<integer name=\"p\" value=\"-7\"/>"),
        Value::Int(-7)
    ));
    assert!(matches!(
        value("<boolean name=\"p\" value=\"TRUE\"/>"),
        Value::Bool(true)
    ));
    assert!(matches!(
        value("<boolean name=\"p\" value=\"false\"/>"),
        Value::Bool(false)
    ));
    assert!(
        matches!(value("<string name=\"p\" value=\"a &lt; b\"/>"), Value::String(s) if s == "a < b")
    );
    assert!(matches!(
        value("<point name=\"p\" x=\"1\" y=\"2\" z=\"3\"/>"),
        Value::Point([1.0, 2.0, 3.0])
    ));
    assert!(matches!(
        value("<vector name=\"p\" value=\"1, 2,3\"/>"),
        Value::Vector([1.0, 2.0, 3.0])
    ));
    assert!(matches!(
        value("<point name=\"p\" x=\"1\"/>"),
        Value::Point([1.0, 0.0, 0.0])
    ));
    let rgb = |x| Color {
        rgb: x,
        was_encoded: false,
    };
    assert!(
        matches!(value("<rgb name=\"p\" value=\"1 2 3\"/>"), Value::Rgb(c) if c == rgb([1.0, 2.0, 3.0]))
    );
    assert!(matches!(
        value("<spectrum name=\"p\" value=\"2\"/>"),
        Value::Spectrum(Spectrum::Uniform(2.0))
    ));
    let Value::Spectrum(Spectrum::Samples(samples)) =
        value("<spectrum name=\"p\" value=\"400:1, 500 : 2 600:3\"/>")
    else {
        panic!("not samples");
    };
    assert_eq!(*samples, [(400.0, 1.0), (500.0, 2.0), (600.0, 3.0)]);
    let Value::Blackbody { temperature, scale } =
        value("<blackbody name=\"p\" temperature=\"5000K\" scale=\"2\"/>")
    else {
        panic!("not a blackbody");
    };
    assert_eq!((temperature, scale), (5000.0, 2.0));
}

#[test]
fn every_transform_element_makes_its_matrix() {
    assert_same(transform(""), DMat4::IDENTITY);
    assert_same(
        transform("<translate x=\"1\" z=\"3\"/>"),
        DMat4::from_translation(DVec3::new(1.0, 0.0, 3.0)),
    );
    assert_same(
        transform("<translate value=\"1, 2, 3\"/>"),
        DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)),
    );
    assert_same(
        transform("<scale value=\"2\"/>"),
        DMat4::from_scale(DVec3::splat(2.0)),
    );
    assert_same(
        transform("<scale x=\"2\" y=\"3\"/>"),
        DMat4::from_scale(DVec3::new(2.0, 3.0, 1.0)),
    );
    // A quarter turn about z takes x to y.
    let turn = transform("<rotate z=\"2\" angle=\"90\"/>");
    assert!(
        turn.transform_vector3(DVec3::X)
            .abs_diff_eq(DVec3::Y, 1e-12)
    );
    let matrix = transform("<matrix value=\"1 2 3 4, 5 6 7 8, 9 10 11 12, 0 0 0 1\"/>");
    assert_eq!(matrix.row(0).to_array(), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(matrix.row(2).to_array(), [9.0, 10.0, 11.0, 12.0]);
    let linear = transform("<matrix value=\"1 2 3 4 5 6 7 8 9\"/>");
    assert_eq!(linear.row(1).to_array(), [4.0, 5.0, 6.0, 0.0]);
    assert_eq!(linear.row(3).to_array(), [0.0, 0.0, 0.0, 1.0]);
    // x points to the left of a viewer who looks along z with y up.
    let camera = transform("<lookat origin=\"1 2 3\" target=\"1 2 8\" up=\"0 2 0.5\"/>");
    assert_same(camera, DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)));
    assert_same(
        camera,
        transform("<lookAt origin=\"1 2 3\" target=\"1 2 8\" up=\"0 1 0\"/>"),
    );
    let any_up = transform("<lookat origin=\"0 0 0\" target=\"0 5 0\"/>");
    assert!((any_up.determinant() - 1.0).abs() < 1e-12);
    assert!(any_up.z_axis.truncate().abs_diff_eq(DVec3::Y, 1e-12));
}

#[test]
fn later_transforms_are_applied_after_earlier_ones() {
    let both = transform("<scale value=\"2\"/><translate x=\"1\"/>");
    assert_eq!(both.transform_point3(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
    let both = transform("<translate x=\"1\"/><scale value=\"2\"/>");
    assert_eq!(both.transform_point3(DVec3::X), DVec3::new(4.0, 0.0, 0.0));
}

#[test]
fn nested_objects_are_found_by_name_and_by_kind() {
    let shape = first(
        r#"<scene version="3.0.0"><shape type="obj" id="s">
            <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
            <emitter type="area" name="light"/>
            <texture type="bitmap" name="alpha"/>
        </shape></scene>"#,
    );
    assert_eq!(
        (shape.kind, shape.plugin.as_str(), shape.id.as_deref()),
        (ObjectKind::Shape, "obj", Some("s"))
    );
    let kinds: Vec<_> = shape
        .children()
        .map(|child| (child.name(), child.object.kind))
        .collect();
    assert_eq!(
        kinds,
        [
            ("", ObjectKind::Bsdf),
            ("light", ObjectKind::Emitter),
            ("alpha", ObjectKind::Texture)
        ]
    );
    let material = shape
        .single_child_of(ObjectKind::Bsdf)
        .expect("one")
        .expect("there");
    assert_eq!(material.plugin, "twosided");
    let inner = material
        .single_child_of(ObjectKind::Bsdf)
        .expect("one")
        .expect("there");
    assert_eq!(inner.plugin, "diffuse");
    assert!(
        shape
            .single_child_of(ObjectKind::Medium)
            .expect("none")
            .is_none()
    );
    assert!(
        matches!(shape.get_float_or_texture("alpha", 0.1), Ok(FloatSource::Texture(t)) if t.plugin == "bitmap")
    );
    assert!(matches!(
        shape.get_float_or_texture("absent", 0.1),
        Ok(FloatSource::Constant(0.1))
    ));
    let usage = halflight::scene::color::ColorUse::Reflectance;
    assert!(matches!(
        shape.get_rgb_or_texture("alpha", usage, [0.5; 3]),
        Ok(ColorSource::Texture(_))
    ));
    assert_eq!(
        shape
            .opt_object("light")
            .expect("an object")
            .expect("there")
            .plugin,
        "area"
    );
    let two = bsdf("<bsdf type=\"a\"/><bsdf type=\"b\"/>");
    let message = two
        .single_child_of(ObjectKind::Bsdf)
        .expect_err("two")
        .to_string();
    assert!(
        message.ends_with("<bsdf>: <bsdf type=\"t\"> takes only one bsdf"),
        "{message}"
    );
}

#[test]
fn a_scene_of_0_6_is_the_same_as_one_of_3() {
    let old = parse(
        r#"<scene version="0.6.0">
            <sensor type="perspective">
                <transform name="toWorld"><lookAt origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/></transform>
                <float name="fov" value="35"/> <string name="fovAxis" value="smaller"/>
                <float name="nearClip" value="0.1"/>
                <sampler type="independent"><integer name="sampleCount" value="16"/></sampler>
                <film type="hdrfilm"><boolean name="attachLog" value="false"/></film>
            </sensor>
            <shape type="obj">
                <bsdf type="diffuse">
                    <texture type="bitmap" name="diffuseReflectance">
                        <float name="uscale" value="2"/> <integer name="voffset" value="3"/>
                    </texture>
                </bsdf>
                <bsdf type="roughplastic" name="other">
                    <rgb name="diffuseReflectance" value="0.1"/> <float name="intIOR" value="1.5"/>
                    <float name="alphaU" value="0.1"/>
                </bsdf>
            </shape>
        </scene>"#,
    )
    .expect("reads 0.6");
    let new = parse(
        r#"<scene version="3.0.0">
            <sensor type="perspective">
                <transform name="to_world"><lookat origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/></transform>
                <float name="fov" value="35"/> <string name="fov_axis" value="smaller"/>
                <float name="near_clip" value="0.1"/>
                <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
                <film type="hdrfilm"><boolean name="attach_log" value="false"/></film>
            </sensor>
            <shape type="obj">
                <bsdf type="diffuse">
                    <texture type="bitmap" name="reflectance">
                        <transform name="to_uv"><translate y="3"/><scale x="2"/></transform>
                    </texture>
                </bsdf>
                <bsdf type="roughplastic" name="other">
                    <rgb name="diffuse_reflectance" value="0.1"/> <float name="int_ior" value="1.5"/>
                    <float name="alpha_u" value="0.1"/>
                </bsdf>
            </shape>
        </scene>"#,
    )
    .expect("reads 3");
    assert_eq!(outline(&old.root), outline(&new.root));
    assert!(outline(&old.root).contains("to_uv"));
}

/// Everything of a tree but its places.
fn outline(object: &Object) -> String {
    let properties: Vec<String> = object
        .properties
        .iter()
        .map(|property| match &property.value {
            Value::Object(child) => format!("{}={}", property.name, outline(child)),
            value => format!("{}={value:?}", property.name),
        })
        .collect();
    format!(
        "{} {}({})",
        object.kind,
        object.plugin,
        properties.join(", ")
    )
}
