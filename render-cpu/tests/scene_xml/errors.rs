//! What is wrong is named with file, line and element.

use glam::DVec3;
use halflight::scene::error::suggestion;
use halflight::scene::xml::ObjectKind;
use halflight::scene::xml::unused::warn_unused;

use super::*;

#[test]
fn wrong_values_name_file_line_and_element() {
    for (element, wanted) in [
        (
            "<float name=\"a\" value=\"rough\"/>",
            "<float name=\"a\">: expected a number, found \"rough\"",
        ),
        (
            "<float name=\"a\" value=\"\"/>",
            "<float name=\"a\">: expected a number, found \"\"",
        ),
        (
            "<float name=\"a\" value=\"nan\"/>",
            "<float name=\"a\">: the number \"nan\" is not finite in 32 bits",
        ),
        (
            "<float name=\"a\" value=\"1e39\"/>",
            "<float name=\"a\">: the number \"1e39\" is not finite in 32 bits",
        ),
        (
            "<float name=\"a\"/>",
            "<float name=\"a\">: the attribute \"value\" is missing",
        ),
        (
            "<float value=\"1\"/>",
            "<float>: the attribute \"name\" is missing",
        ),
        (
            "<float name=\"\" value=\"1\"/>",
            "<float name=\"\">: the name is empty",
        ),
        (
            "<integer name=\"a\" value=\"1.5\"/>",
            "<integer name=\"a\">: expected an integer, found \"1.5\"",
        ),
        (
            "<integer name=\"a\" value=\"99999999999999999999\"/>",
            "<integer name=\"a\">: expected an integer, found \"99999999999999999999\"",
        ),
        (
            "<boolean name=\"a\" value=\"1\"/>",
            "<boolean name=\"a\">: expected true or false, found \"1\"",
        ),
        (
            "<point name=\"a\" value=\"1 2\"/>",
            "<point name=\"a\">: expected one or three numbers, found 2",
        ),
        (
            "<point name=\"a\"/>",
            "<point name=\"a\">: needs \"x\", \"y\" and \"z\"",
        ),
        (
            "<point name=\"a\" value=\"1 2 3\" x=\"1\"/>",
            "<point name=\"a\">: takes either \"value\" or \"x\", \"y\", \"z\"",
        ),
        (
            "<rgb name=\"a\" value=\"1 2\"/>",
            "<rgb name=\"a\">: expected one or three numbers, found 2",
        ),
        (
            "<rgb name=\"a\" value=\"#12345\"/>",
            "<rgb name=\"a\">: expected a colour of the form #rrggbb, found \"#12345\"",
        ),
        (
            "<srgb name=\"a\" value=\"1e30\"/>",
            "<srgb name=\"a\">: the colour is too large",
        ),
        (
            "<spectrum name=\"a\"/>",
            "<spectrum name=\"a\">: needs \"value\" or \"filename\"",
        ),
        (
            "<spectrum name=\"a\" value=\"1 2\"/>",
            "<spectrum name=\"a\">: expected one number or a list of wavelength:value, found 2 numbers",
        ),
        (
            "<spectrum name=\"a\" value=\"400:1, 2\"/>",
            "<spectrum name=\"a\">: expected wavelength:value, found \"2\"",
        ),
        (
            "<spectrum name=\"a\" value=\"400:1 400:2\"/>",
            "<spectrum name=\"a\">: the wavelengths must increase, but 400 follows 400",
        ),
        (
            "<spectrum name=\"a\" value=\"400:1\"/>",
            "<spectrum name=\"a\">: a spectrum needs two or more wavelengths",
        ),
        (
            "<blackbody name=\"a\" temperature=\"0\"/>",
            "<blackbody name=\"a\">: the temperature must be positive, found 0 K",
        ),
        (
            "<scale value=\"1\"/>",
            "<scale>: belongs inside of a <transform>",
        ),
        (
            "<float name=\"a\" value=\"1\"><bsdf type=\"x\"/></float>",
            "<float name=\"a\">: cannot hold other elements, but holds <bsdf>",
        ),
        ("<bsdf/>", "<bsdf>: the attribute \"type\" is missing"),
        (
            "<scene/>",
            "<scene>: a scene cannot stand inside of another; use <include>",
        ),
        (
            "<transform><scale value=\"1\"/></transform>",
            "<transform>: the attribute \"name\" is missing",
        ),
    ] {
        let text =
            format!("<scene version=\"3.0.0\">\n  <bsdf type=\"t\">\n    {element}</bsdf></scene>");
        assert_eq!(error_of(&text), format!("scene.xml:3:5: {wanted}"));
    }
    for (element, wanted) in [
        (
            "<rotate angle=\"1\"/>",
            "<rotate>: the axis of a rotation must not be zero",
        ),
        (
            "<rotate x=\"1\"/>",
            "<rotate>: the attribute \"angle\" is missing",
        ),
        (
            "<matrix value=\"1 2 3\"/>",
            "<matrix>: expected 9 or 16 numbers, found 3",
        ),
        (
            "<lookat origin=\"1 2 3\" target=\"1 2 3\"/>",
            "<lookat>: the view direction or the up vector is degenerate",
        ),
        (
            "<lookat origin=\"0 0 0\" target=\"0 0 1\" up=\"0 0 2\"/>",
            "<lookat>: the view direction or the up vector is degenerate",
        ),
        (
            "<float name=\"a\" value=\"1\"/>",
            "<float name=\"a\">: is not a part of a transform",
        ),
    ] {
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"t\"><transform name=\"t\">\n{element}</transform></shape></scene>"
        );
        assert_eq!(error_of(&text), format!("scene.xml:2:1: {wanted}"));
    }
}

#[test]
fn getters_name_the_property_of_a_wrong_type() {
    let text = "<scene version=\"3.0.0\"><bsdf type=\"t\">\n<string name=\"s\" value=\"x\"/><integer name=\"i\" value=\"3\"/>\n<float name=\"f\" value=\"1.5\"/></bsdf></scene>";
    let object = first(text);
    assert_eq!(
        object.get_float("i", 0.0),
        Ok(3.0),
        "integers pass for floats"
    );
    assert_eq!(object.get_float("absent", 0.25), Ok(0.25));
    let message = object
        .get_float("s", 0.0)
        .expect_err("a string")
        .to_string();
    assert_eq!(
        message,
        "scene.xml:2:1: <string name=\"s\">: <bsdf type=\"t\"> needs a float for \"s\", found a string"
    );
    let message = object.get_int("f", 0).expect_err("a float").to_string();
    assert_eq!(
        message,
        "scene.xml:3:1: <float name=\"f\">: <bsdf type=\"t\"> needs an integer for \"f\", found a float"
    );
    let message = object
        .require_string("absent")
        .expect_err("absent")
        .to_string();
    assert_eq!(
        message,
        "scene.xml:1:24: <bsdf type=\"t\">: \"absent\" is missing; a string is needed"
    );
    let message = object
        .get_float_in("f", 0.0, 0.0, 1.0)
        .expect_err("too large")
        .to_string();
    assert_eq!(
        message,
        "scene.xml:3:1: <float name=\"f\">: 1.5 is outside of [0, 1]"
    );
    assert!(object.get_int_in("i", 0, 4, 5).is_err());
    assert!(object.get_bool("s", true).is_err());
    assert!(object.get_transform("s").is_err());
    assert!(object.get_vector("s", [0.0; 3]).is_err());
    assert!(object.opt_object("s").is_err());
    let usage = halflight::scene::color::ColorUse::Reflectance;
    assert!(object.get_rgb("s", usage, [0.0; 3]).is_err());
}

#[test]
fn odd_elements_are_warned_about_or_refused() {
    let text = "<scene version=\"3.0.0\">\n<blob/>\n<intgrator type=\"path\"/>\n<bsdf type=\"t\" colour=\"red\"/>\n\
        <shape type=\"s\">\n<animation name=\"toWorld\"><transform time=\"0\"><scale value=\"2\"/></transform>\
        <transform time=\"1\"/></animation></shape></scene>";
    let scene = parse_leniently(text);
    let warnings: Vec<String> = scene.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        [
            "scene.xml:2:1: <blob>: the element is not known and is ignored",
            "scene.xml:3:1: <intgrator type=\"path\">: the element is not known and is ignored (did you mean <integrator>?)",
            "scene.xml:4:1: <bsdf type=\"t\">: the attribute \"colour\" is not known here and is ignored",
            "scene.xml:6:1: <animation name=\"toWorld\">: animation is not supported; the first transform is used",
        ]
    );
    let shapes: Vec<_> = scene.root.children_of(ObjectKind::Shape).collect();
    assert_same(
        shapes[0].object.get_transform("to_world").expect("one"),
        DMat4::from_scale(DVec3::splat(2.0)),
    );
    assert_eq!(error_of(text), warnings[0]);
    let unversioned = parse_leniently("<scene/>");
    assert_eq!(unversioned.warnings().len(), 1);
}

#[test]
fn properties_given_twice_are_refused() {
    let message = error_of(
        "<scene version=\"3.0.0\"><bsdf type=\"t\">\n<float name=\"toWorld\" value=\"1\"/>\n<float name=\"to_world\" value=\"1\"/></bsdf></scene>",
    );
    assert_eq!(
        message,
        "scene.xml:3:1: <float name=\"to_world\">: <bsdf type=\"t\"> has this property already, at scene.xml:2:1"
    );
}

#[test]
fn unused_properties_are_found() {
    let scene = parse_leniently(
        "<scene version=\"3.0.0\">\n<bsdf type=\"built\"><float name=\"used\" value=\"1\"/>\n<float name=\"alhpa\" value=\"1\"/>\
         <bsdf type=\"inner\">\n<float name=\"lost\" value=\"1\"/></bsdf></bsdf>\n\
         <bsdf type=\"not_built\"><float name=\"silent\" value=\"1\"/></bsdf>\n<phase type=\"odd\"/></scene>",
    );
    let materials: Vec<_> = scene.root.children_of(ObjectKind::Bsdf).collect();
    materials[0].object.get_float("used", 0.0).expect("a float");
    for inner in materials[0].object.children_of(ObjectKind::Bsdf) {
        inner.object.touch();
    }
    warn_unused(&scene.root).expect("not strict");
    let mut warnings: Vec<String> = scene.warnings().iter().map(ToString::to_string).collect();
    warnings.sort();
    assert_eq!(
        warnings,
        [
            "scene.xml:3:1: <float name=\"alhpa\">: <bsdf type=\"built\"> does not use this; it is ignored",
            "scene.xml:4:1: <float name=\"lost\">: <bsdf type=\"inner\"> does not use this; it is ignored",
            "scene.xml:6:1: <phase>: <scene type=\"scene\"> does not use this; it is ignored",
        ]
    );
}

#[test]
fn suggestions_are_near() {
    assert_eq!(
        suggestion("rougness", ["roughness", "reflectance"]),
        Some("roughness")
    );
    assert_eq!(suggestion("x", ["eta", "k"]), Some("k"));
    assert_eq!(suggestion("specular", ["eta", "k"]), None);
}
