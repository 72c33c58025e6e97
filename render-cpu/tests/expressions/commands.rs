//! Path expressions on the command line: layers of files, farms, and refusals.

use std::path::Path;
use std::process::{Command, Output};

const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective"><transform name="to_world"><lookat origin="0, 1, 4" target="0, 0.5, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="18"/></film></sensor>
    <shape type="rectangle" id="floor"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform></shape>
    <shape type="sphere" id="ball"><point name="center" value="0, 0.6, 0"/><float name="radius" value="0.5"/>
        <bsdf type="conductor" id="mirror"/></shape>
    <emitter type="constant"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
</scene>"#;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    std::fs::write(folder.join("scene.xml"), SCENE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
    command.args(arguments).current_dir(folder);
    command.output().unwrap()
}

fn succeed(folder: &Path, arguments: &[&str]) {
    let output = run(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
}

fn channels(folder: &Path, name: &str) -> Vec<(String, Vec<u32>)> {
    let image = halflight::image::read_exr(folder.join(name)).unwrap();
    let bits =
        |(name, values): (String, Vec<f32>)| (name, values.into_iter().map(f32::to_bits).collect());
    image.channels.into_iter().map(bits).collect()
}

const LAYERS: [&str; 4] = ["--lpe", "direct=C[DG]L", "--lpe", "mirror=C<.. 'mirror'>.*"];

#[test]
fn layers_are_in_the_file_and_the_same_from_a_farm_and_from_a_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let whole = [
        "render",
        "scene.xml",
        "--spp",
        "6",
        "--seed",
        "2",
        "-o",
        "one.exr",
    ];
    succeed(folder, &[&whole[..], &LAYERS].concat());
    let one = channels(folder, "one.exr");
    for name in ["R", "direct.R", "direct.B", "mirror.G"] {
        let values = &one.iter().find(|(n, _)| n == name).expect(name).1;
        assert!(values.iter().any(|v| f32::from_bits(*v) > 0.0), "{name}");
    }
    // Without layers, the image is the same.
    succeed(
        folder,
        &[
            "render",
            "scene.xml",
            "--spp",
            "6",
            "--seed",
            "2",
            "-o",
            "plain.exr",
        ],
    );
    let plain = channels(folder, "plain.exr");
    for (name, values) in &plain {
        assert!(one.iter().any(|(n, v)| n == name && v == values), "{name}");
    }
    assert_eq!(one.len(), plain.len() + 6);

    let farm = [
        "farm",
        "plan",
        "scene.xml",
        "-o",
        "farm.exr",
        "--tasks",
        "3",
    ];
    let farm = [
        &farm[..],
        &["--spp", "6", "--seed", "2", "--divide", "pixels"],
        &LAYERS,
    ]
    .concat();
    succeed(folder, &farm);
    for task in ["0", "1", "2"] {
        succeed(folder, &["farm", "task", "farm.farm", task]);
    }
    succeed(folder, &["farm", "merge", "farm.farm"]);
    assert_eq!(channels(folder, "farm.exr"), one);

    let begun = [
        "render",
        "scene.xml",
        "--spp",
        "2",
        "--seed",
        "2",
        "--checkpoint",
        "c",
    ];
    succeed(folder, &[&begun[..], &["-o", "two.exr"], &LAYERS].concat());
    let more = [
        "render",
        "scene.xml",
        "--spp",
        "6",
        "--seed",
        "2",
        "--checkpoint",
        "c",
    ];
    succeed(folder, &[&more[..], &["-o", "six.exr"], &LAYERS].concat());
    assert_eq!(channels(folder, "six.exr"), one);
    let other = run(
        folder,
        &[&more[..], &["-o", "six.exr", "--lpe", "direct=C[DG]L"]].concat(),
    );
    assert_eq!(other.status.code(), Some(1), "a checkpoint of other layers");
}

#[test]
fn bad_requests_end_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &str); 9] = [
        (&["--integrator", "ao", "--only", "C.*L"], "vcm, vm"),
        (
            &["--integrator", "ao", "--lpe", "a=C.*L"],
            "mlt, memlt, hslt, erpt, meerpt, sppm",
        ),
        (&["--lpe", "a=C(DL"], "character 2: this ( is not closed"),
        (&["--only", "C<RD>L['x']"], "none of L O B"),
        (
            &["--lpe", "a=C.*L", "--lpe", "a=CL"],
            "two layers named \"a\"",
        ),
        (&["--lpe", "a=CD"], "no path of this scene"),
        (&["--integrator", "ao", "--only", "C.*L"], "not for ao"),
        (
            &["--integrator", "mcppm", "--lpe", "a=C.*L"],
            "not for mcppm",
        ),
        (
            &[
                "--integrator",
                "bdpt",
                "--regularize",
                "tau=20",
                "--only",
                "C.*L",
            ],
            "regularisation has spread",
        ),
    ];
    for (arguments, message) in cases {
        let render = ["render", "scene.xml", "--spp", "1", "-o", "bad.exr"];
        let output = run(folder.path(), &[&render[..], arguments].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?} {text}");
        assert!(text.contains(message), "{arguments:?}: {text}");
        assert_eq!(
            text.lines().filter(|l| l.starts_with("error")).count(),
            1,
            "{text}"
        );
        assert!(!folder.path().join("bad.exr").exists());
    }
    for layer in ["CDL", "=CDL", "a.b=CDL", "normal=CDL"] {
        let output = run(folder.path(), &["render", "scene.xml", "--lpe", layer]);
        assert_eq!(output.status.code(), Some(2), "{layer}");
    }
}
