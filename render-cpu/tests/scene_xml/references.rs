//! Parameters and references.

use std::sync::Arc;

use halflight::scene::xml::ObjectKind;
use halflight::scene::xml::unused::warn_unused;

use super::*;

#[test]
fn parameters_are_put_in() {
    let text = r#"<scene version="3.0.0">
        <default name="res" value="10"/> <default name="resx" value="20"/> <default name="kind" value="path"/>
        <default name="twice" value="$res-$res"/> <default name="spp" value="1"/>
        <integrator type="$kind">
            <integer name="a" value="$res"/> <integer name="b" value="$resx"/>
            <string name="c" value="$res$resx/$kind.obj"/> <string name="d" value="$twice"/>
            <integer name="n_$kind" value="$spp"/>
        </integrator></scene>"#;
    let defined = with(text, &[("spp", "4"), ("kind", "ao"), ("spp", "8")]).expect("parses");
    let child = defined.root.children().next().expect("an integrator");
    let integrator = child.object;
    assert_eq!(integrator.plugin, "ao");
    assert_eq!(integrator.get_int("a", 0), Ok(10));
    assert_eq!(integrator.get_int("b", 0), Ok(20));
    assert_eq!(integrator.get_string("c", ""), Ok("1020/ao.obj"));
    assert_eq!(integrator.get_string("d", ""), Ok("10-10"));
    assert_eq!(
        integrator.get_int("n_ao", 0),
        Ok(8),
        "the last definition wins"
    );
}

#[test]
fn parameters_do_not_expand_further() {
    let text = "<scene version=\"3.0.0\"><bsdf type=\"t\"><string name=\"p\" value=\"$a\"/></bsdf></scene>";
    let scene = with(text, &[("a", "$a$b")]).expect("parses");
    let child = scene.root.children().next().expect("a bsdf");
    assert_eq!(child.object.get_string("p", ""), Ok("$a$b"));
}

#[test]
fn wrong_parameters_are_named() {
    let text = "<scene version=\"3.0.0\">\n <integrator type=\"$integator\"/></scene>";
    let message = with(text, &[("integrator", "path")])
        .expect_err("misspelt")
        .to_string();
    assert_eq!(
        message,
        "scene.xml:2:2: <integrator>: the parameter \"$integator\" is not defined (did you mean \"integrator\"?); \
         give it with -D integator=..."
    );
    let text = "<scene version=\"3.0.0\"><default name=\"spp\" value=\"1\"/></scene>";
    let message = with(text, &[("sppp", "4")])
        .expect_err("unused")
        .to_string();
    assert_eq!(
        message,
        "the scene has no parameter \"sppp\" (did you mean \"spp\"?)"
    );
    assert!(with("<scene version=\"3.0.0\"/>", &[("", "4")]).is_err());
}

#[test]
fn references_share_one_object() {
    let scene = parse(
        r#"<scene version="3.0.0">
            <shape type="a"><ref id="later"/></shape>
            <shape type="b"><ref name="bsdf" id="later"/><ref id="nick"/></shape>
            <bsdf type="diffuse" id="later"><ref name="reflectance" id="tex"/></bsdf>
            <texture type="checkerboard" id="tex"/>
            <bsdf type="other" id="named"/> <alias id="named" as="nick"/>
        </scene>"#,
    )
    .expect("parses");
    let shapes: Vec<_> = scene
        .root
        .children_of(ObjectKind::Shape)
        .map(|child| child.object)
        .collect();
    let first = shapes[0]
        .single_child_of(ObjectKind::Bsdf)
        .expect("one")
        .expect("there");
    let named = shapes[1]
        .opt_object("bsdf")
        .expect("an object")
        .expect("there");
    assert!(Arc::ptr_eq(first, named));
    assert_eq!(
        first.texture("reflectance").expect("a texture").plugin,
        "checkerboard"
    );
    let aliased: Vec<_> = shapes[1]
        .children_of(ObjectKind::Bsdf)
        .map(|child| child.object.plugin.clone())
        .collect();
    assert_eq!(aliased, ["diffuse", "other"]);
}

#[test]
fn broken_references_are_named() {
    let message = error_of(
        "<scene version=\"3.0.0\">\n<bsdf type=\"t\" id=\"matt\"/>\n <shape type=\"s\">\n  <ref id=\"mat\"/></shape></scene>",
    );
    assert_eq!(
        message,
        "scene.xml:4:3: <ref id=\"mat\">: no object has this id (did you mean \"matt\"?)"
    );
    let message = error_of(
        "<scene version=\"3.0.0\">\n<bsdf type=\"t\" id=\"a\"/>\n<bsdf type=\"t\" id=\"a\"/></scene>",
    );
    assert_eq!(
        message,
        "scene.xml:3:1: <bsdf id=\"a\">: the id is taken by scene.xml:2:1"
    );
    let message = error_of(
        "<scene version=\"3.0.0\">\n<bsdf type=\"t\" id=\"a\"><ref id=\"b\"/></bsdf>\n<bsdf type=\"u\" id=\"b\"><ref id=\"a\"/></bsdf></scene>",
    );
    assert_eq!(
        message,
        "scene.xml:3:23: <ref id=\"a\">: the reference is circular"
    );
    let message = error_of("<scene version=\"3.0.0\"><alias id=\"a\" as=\"b\"/></scene>");
    assert!(
        message.ends_with("no object with the id \"a\" stands before this"),
        "{message}"
    );
}

#[test]
fn doubling_references_cost_nothing() {
    // Each object refers twice to the next: 2^50 paths, 50 objects.
    let mut text = String::from("<scene version=\"3.0.0\">");
    for i in 0..50 {
        text += &format!(
            "<bsdf type=\"b\" id=\"b{i}\"><ref id=\"b{}\"/><ref id=\"b{}\"/></bsdf>",
            i + 1,
            i + 1
        );
    }
    text += "<bsdf type=\"b\" id=\"b50\"/></scene>";
    let scene = parse(&text).expect("parses");
    assert_eq!(scene.root.children().count(), 51);
    assert!(warn_unused(&scene.root).is_err());
    let chain: String = (0..100)
        .map(|i| {
            format!(
                "<bsdf type=\"b\" id=\"b{i}\"><ref id=\"b{}\"/></bsdf>",
                i + 1
            )
        })
        .collect();
    let message = error_of(&format!(
        "<scene version=\"3.0.0\">{chain}<bsdf type=\"b\" id=\"b100\"/></scene>"
    ));
    assert!(
        message.ends_with("objects refer to each other in a chain of more than 64"),
        "{message}"
    );
}
