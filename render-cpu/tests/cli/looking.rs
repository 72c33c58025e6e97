//! Commands that tell: `info`, `list`, `completions`, `manual`; and the short ways to a render.

use super::{Place, SCENE, skip};
use serde_json::Value;
use std::io::Write;
use std::process::{Command, Stdio};

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// The scene with two cameras, a named material, and a parameter that nothing uses.
fn scene() -> String {
    let second = SCENE
        .split("</sensor>")
        .next()
        .and_then(|start| start.split("<sensor").nth(1))
        .expect("a sensor");
    SCENE
        .replace(
            "<integrator",
            "<default name=\"idle\" value=\"7\"/><integrator",
        )
        .replace(
            "</sensor>",
            &format!("</sensor><sensor id=\"side\"{second}</sensor>"),
        )
        .replace("<bsdf type=\"dielectric\"/>", "<ref id=\"glass\"/>")
        .replace(
            "</scene>",
            "<bsdf type=\"dielectric\" id=\"glass\"/></scene>",
        )
}

#[test]
fn info_names_what_the_command_line_can_choose() {
    let place = Place::with_scene();
    place.write("two.xml", scene());
    let text = place.succeed(&["info", "two.xml", "-D", "spp=9", "--sensor", "1"]);
    for part in [
        "spp = 4, 9 here",
        "idle = 7\n",
        "1  side (perspective), in use",
        "glass (dielectric)",
        "million samples per second",
        "9 samples per pixel",
    ] {
        assert!(text.contains(part), "\"{part}\" is missing in {text}");
    }
    let report = json(&place.succeed(&["info", "two.xml", "--json"]));
    assert_eq!(report["parameters"][0]["name"], "spp");
    assert_eq!(report["sensors"][1]["id"], "side");
    assert_eq!(report["bsdfs"][0]["plugin"], "dielectric");
    assert_eq!(
        (&report["triangles"], &report["size"][0]),
        (&4.into(), &24.into())
    );
    assert!(
        report["cost"]["samples_per_second"]
            .as_f64()
            .is_some_and(|r| r > 0.0)
    );
    for (integrator, unit) in [
        ("bdpt", "samples"),
        ("vcm", "samples"),
        ("sppm", "samples"),
        ("appm", "samples"),
        ("mmlt", "mutations"),
        ("mlt", "mutations"),
    ] {
        let words = [
            "info",
            "two.xml",
            "--json",
            "--width",
            "400",
            "--integrator",
            integrator,
        ];
        let report = json(&place.succeed(&words));
        let cost = &report["cost"];
        assert_eq!(cost["unit"], unit, "{integrator}");
        let number = |name: &str| cost[name].as_f64().unwrap_or(0.0);
        let (rate, seconds) = (number("samples_per_second"), number("seconds"));
        assert!(rate > 0.0 && seconds > 0.0, "{integrator}: {cost}");
        // The image that was asked for, not the small one of the trial.
        assert_eq!(report["size"][0], 400);
    }
}

#[test]
fn unused_definitions_are_not_unknown_ones() {
    let place = Place::with_scene();
    place.write("two.xml", scene());
    let render = |define: &str| place.run(&["render", "two.xml", "-o", "a.exr", "-D", define]);
    let unused = render("idle=3");
    let text = String::from_utf8_lossy(&unused.stderr).into_owned();
    assert!(
        unused.status.success() && text.contains("uses it nowhere"),
        "{text}"
    );
    let unknown = render("spq=3");
    let text = String::from_utf8_lossy(&unknown.stderr).into_owned();
    assert_eq!(unknown.status.code(), Some(1));
    assert!(
        text.contains("no parameter \"spq\" (did you mean \"spp\"?)"),
        "{text}"
    );
}

#[test]
fn a_scene_in_the_place_of_a_command_is_rendered() {
    let place = Place::with_scene();
    place.succeed(&["scene.xml", "-o", "short.exr"]);
    place.succeed(&["render", "scene.xml", "-o", "long.exr"]);
    assert_eq!(place.channels("short.exr"), place.channels("long.exr"));
    // From standard input.
    let mut child = place
        .command(&["-", "-o", "piped.exr", "-D", "spp=4"])
        .stdin(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut input = child.stdin.take().expect("a pipe");
    input.write_all(SCENE.as_bytes()).expect("a reader");
    drop(input);
    assert!(child.wait().expect("a status").success());
    assert_eq!(place.channels("piped.exr"), place.channels("long.exr"));
}

#[test]
fn everything_that_is_listed_is_known() {
    let place = Place::with_scene();
    let names = |what: &str| -> Vec<String> {
        let list = json(&place.succeed(&["list", what, "--json"]));
        let entries = list.as_array().expect("a list").clone();
        let text = place.succeed(&["list", what]);
        assert_eq!(text.lines().count(), entries.len());
        entries
            .iter()
            .map(|e| e["name"].as_str().expect("a name").to_owned())
            .collect()
    };
    for name in names("integrators") {
        let render = [
            "render",
            "scene.xml",
            "-o",
            "a.exr",
            "--spp",
            "1",
            "--integrator",
        ];
        place.succeed(&[&render[..], &[&name]].concat());
    }
    for name in names("samplers") {
        place.succeed(&["info", "scene.xml", "--sampler", &name]);
    }
    assert_eq!(names("metals").len(), 72);
    // A plugin that the reader does not know is named in a warning of these words.
    let unknown = |element: &str, plugin: &str| {
        let object = format!("<{element} type=\"{plugin}\"/>");
        let scene = match element {
            "sensor" => SCENE.replace("type=\"perspective\"", &format!("type=\"{plugin}\"")),
            "bsdf" => SCENE.replace("<bsdf type=\"dielectric\"/>", &object),
            "texture" => SCENE.replace(
                "<rgb name=\"diffuse_reflectance\" value=\"0.4, 0.3, 0.2\"/>",
                &format!("<texture name=\"diffuse_reflectance\" type=\"{plugin}\"/>"),
            ),
            _ => SCENE.replace("</scene>", &format!("{object}</scene>")),
        };
        place.write("one.xml", scene);
        let output = place.run(&["info", "one.xml"]);
        let text = [output.stdout, output.stderr].concat();
        String::from_utf8_lossy(&text).contains("not supported;")
    };
    for (what, element) in [
        ("sensors", "sensor"),
        ("bsdfs", "bsdf"),
        ("emitters", "emitter"),
        ("shapes", "shape"),
        ("textures", "texture"),
    ] {
        assert!(
            unknown(element, "nonsense"),
            "{element}: the words have changed"
        );
        for name in names(what) {
            assert!(!unknown(element, &name), "{element} {name}");
        }
    }
}

#[test]
fn completions_are_there_for_every_shell() {
    let place = Place::with_scene();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = place.succeed(&["completions", shell]);
        assert!(
            script.contains("render") && script.contains("halflight"),
            "{shell}"
        );
    }
}

/// What a program prints, which a machine may lack.
fn printed(place: &Place, program: &str, arguments: &[&str]) -> Option<(String, String)> {
    let run = Command::new(program)
        .args(arguments)
        .env("MANWIDTH", "100")
        .current_dir(place.path("."))
        .output();
    let missing = run.map_err(|error| format!("there is no {program}: {error}"));
    let output = skip::available(missing, "HALFLIGHT_REQUIRE_SHELLS")?;
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{program}: {errors}");
    Some((String::from_utf8_lossy(&output.stdout).into_owned(), errors))
}

#[test]
fn bash_loads_the_completions() {
    let place = Place::with_scene();
    place.write("script", place.succeed(&["completions", "bash"]));
    let line = "source ./script; COMP_WORDS=(halflight rend); COMP_CWORD=1; _halflight halflight rend halflight; echo ${COMPREPLY[@]}";
    if let Some((text, errors)) = printed(&place, "bash", &["-c", line]) {
        assert_eq!(text.trim(), "render", "{errors}");
    }
}

#[test]
fn zsh_loads_the_completions() {
    let place = Place::with_scene();
    place.write("script", place.succeed(&["completions", "zsh"]));
    let line = "autoload -U compinit; compinit -u -d ./dump; source ./script; print -r -- ${_comps[halflight]}";
    if let Some((text, errors)) = printed(&place, "zsh", &["-f", "-c", line]) {
        assert_eq!(text.trim(), "_halflight", "{errors}");
    }
}

#[test]
fn the_manual_is_a_page_that_man_renders() {
    let place = Place::with_scene();
    let page = place.succeed(&["manual"]);
    assert!(page.contains(".SH NAME") && page.contains("halflight"));
    std::fs::create_dir(place.path("man")).expect("a folder");
    place.succeed(&["manual", "--output", "man"]);
    for name in ["halflight.1", "halflight-render.1", "halflight-farm-task.1"] {
        assert!(place.path("man").join(name).is_file(), "{name}");
    }
    if let Some((text, errors)) = printed(&place, "man", &["-l", "man/halflight-render.1"]) {
        assert!(
            text.contains("--checkpoint") && text.contains("SYNOPSIS"),
            "{text}"
        );
        assert!(!errors.contains("warning"), "{errors}");
    }
}

#[test]
fn help_is_grouped_by_purpose() {
    let place = Place::with_scene();
    let text = place.succeed(&["render", "--help"]);
    for heading in [
        "Scene:",
        "Pixels:",
        "Algorithm:",
        "Samples:",
        "Image:",
        "Going on later:",
        "Machine:",
    ] {
        assert!(
            text.contains(&format!("\n{heading}\n")),
            "{heading} is missing in {text}"
        );
    }
}
