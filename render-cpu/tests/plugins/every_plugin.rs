//! Every plugin of `halflight list` in a scene of either version, loaded strictly: a file of ours each.

use crate::pixels;
use halflight::commands::list::Listed;
use halflight::measured::synthetic::{brushed, nickel};
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene;
use std::io::Write;
use std::path::Path;

const TEXTURE: &str =
    r#"<texture type="bitmap"><string name="filename" value="picture.exr"/></texture>"#;

/// What a plugin needs to be said inside it.
fn inside(kind: Listed, name: &str) -> String {
    let file = |file: &str| format!(r#"<string name="filename" value="{file}"/>"#);
    let bsdf = r#"<bsdf type="diffuse"/>"#;
    match (kind, name) {
        (Listed::Bsdfs, "merl") => file("nickel.binary"),
        (Listed::Bsdfs, "measured") => file("brushed.bsdf"),
        (Listed::Bsdfs, "coating" | "roughcoating" | "mask" | "twosided") => bsdf.into(),
        (Listed::Bsdfs, "blendbsdf") => format!("{bsdf}{bsdf}"),
        (Listed::Bsdfs, "mixturebsdf") => {
            format!(r#"<string name="weights" value="0.3, 0.5"/>{bsdf}{bsdf}"#)
        }
        (Listed::Bsdfs, "bumpmap" | "normalmap") => format!("{TEXTURE}{bsdf}"),
        (Listed::Emitters, "envmap") => file("picture.exr"),
        (Listed::Emitters, "projector") => {
            TEXTURE.replace("<texture ", r#"<texture name="irradiance" "#)
        }
        (Listed::Shapes, "obj") => file("shape.obj"),
        (Listed::Shapes, "ply") => file("shape.ply"),
        (Listed::Shapes, "serialized") => file("shape.serialized"),
        (Listed::Shapes, "heightfield") => file("picture.exr"),
        (Listed::Shapes, "instance") => {
            r#"<shape type="shapegroup"><shape type="sphere"/></shape>"#.into()
        }
        (Listed::Shapes, "shapegroup" | "merge") => r#"<shape type="sphere"/>"#.into(),
        (Listed::Textures, "bitmap") => file("picture.exr"),
        (Listed::Textures, "mesh_attribute") => {
            r#"<string name="name" value="vertex_color"/>"#.into()
        }
        (Listed::Textures, "scale") => format!(r#"{TEXTURE}<float name="scale" value="0.5"/>"#),
        _ => String::new(),
    }
}

/// A scene with the plugin.
fn scene(kind: Listed, name: &str, is_old: bool) -> String {
    let own = inside(kind, name);
    let to_world = if is_old { "toWorld" } else { "to_world" };
    let film = r#"<film type="hdrfilm"><integer name="width" value="6"/><integer name="height" value="4"/></film>"#;
    let place = format!(
        r#"<transform name="{to_world}"><lookat origin="0.3, 0.4, 5" target="0, 0, 0" up="0, 1, 0"/></transform>"#
    );
    let mut integrator = r#"<integrator type="path"/>"#.to_owned();
    let mut sensor = format!(r#"<sensor type="perspective">{place}{film}</sensor>"#);
    let mut light = r#"<emitter type="constant"/>"#.to_owned();
    let mut shape = r#"<shape type="rectangle"/>"#.to_owned();
    match kind {
        Listed::Integrators => integrator = format!(r#"<integrator type="{name}"/>"#),
        Listed::Sensors if name == "irradiancemeter" => {
            sensor = String::new();
            shape =
                format!(r#"<shape type="rectangle"><sensor type="{name}">{film}</sensor></shape>"#);
        }
        Listed::Sensors => sensor = format!(r#"<sensor type="{name}">{place}{film}</sensor>"#),
        Listed::Bsdfs => {
            shape = format!(r#"<shape type="rectangle"><bsdf type="{name}">{own}</bsdf></shape>"#);
        }
        Listed::Emitters if name == "area" => {
            shape = r#"<shape type="sphere"><emitter type="area"/></shape>"#.into();
            light = String::new();
        }
        Listed::Emitters => {
            light = match name {
                // Its rays lead to the square.
                "collimated" => {
                    integrator = r#"<integrator type="ptracer"/>"#.into();
                    format!(r#"<emitter type="{name}">{place}</emitter>"#)
                }
                "spot" | "projector" => format!(r#"<emitter type="{name}">{own}{place}</emitter>"#),
                "point" => {
                    format!(r#"<emitter type="point"><transform name="{to_world}"><translate z="3"/></transform></emitter>"#)
                }
                "directional" => {
                    r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/></emitter>"#.into()
                }
                _ => format!(r#"<emitter type="{name}">{own}</emitter>"#),
            };
        }
        Listed::Shapes if name == "shapegroup" => {
            shape = format!(
                r#"<shape type="shapegroup" id="g">{own}</shape><shape type="instance"><ref id="g"/></shape>"#
            );
        }
        Listed::Shapes => shape = format!(r#"<shape type="{name}">{own}</shape>"#),
        Listed::Textures => {
            let texture = format!(r#"<texture type="{name}" name="reflectance">{own}</texture>"#);
            shape = format!(
                r#"<shape type="ply"><string name="filename" value="shape.ply"/><bsdf type="diffuse">{texture}</bsdf></shape>"#
            );
        }
        Listed::Samplers | Listed::Metals => {}
    }
    let version = if is_old { "0.6.0" } else { "3.0.0" };
    format!(r#"<scene version="{version}">{integrator}{sensor}{light}{shape}</scene>"#)
}

/// The files that the scenes name.
fn write_files(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.join(name), bytes).expect("a writable folder");
    };
    exr::prelude::write_rgb_file(folder.join("picture.exr"), 8, 4, |x, y| {
        (0.2 + 0.05 * x as f32, 0.1 + 0.1 * y as f32, 0.5)
    })
    .expect("a picture");
    write("nickel.binary", &nickel());
    write("brushed.bsdf", &brushed().expect("a measurement"));
    write("shape.obj", b"v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    write(
        "shape.ply",
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
          property float r\nproperty float g\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\n\
          end_header\n-1 -1 0 1 0 0\n1 -1 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2\n",
    );
    // A mesh of single precision, and the dictionary of its one shape.
    let mut content = 0x1000_u32.to_le_bytes().to_vec();
    content.extend(b"shape\0");
    content.extend(3_u64.to_le_bytes());
    content.extend(1_u64.to_le_bytes());
    for x in [-1.0_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0] {
        content.extend(x.to_le_bytes());
    }
    for i in [0_u32, 1, 2] {
        content.extend(i.to_le_bytes());
    }
    let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    zip.write_all(&content).expect("memory");
    let mut file = vec![0x1c, 0x04, 4, 0];
    file.extend(zip.finish().expect("memory"));
    file.extend(0_u64.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    write("shape.serialized", &file);
}

#[test]
fn every_plugin_loads_strictly_in_either_version() {
    let folder = tempfile::tempdir().expect("a folder");
    write_files(folder.path());
    let mut failures = Vec::new();
    let mut count = 0;
    for kind in [
        Listed::Integrators,
        Listed::Sensors,
        Listed::Bsdfs,
        Listed::Emitters,
        Listed::Shapes,
        Listed::Textures,
    ] {
        for (name, _) in kind.entries() {
            for is_old in [true, false] {
                let file = folder.path().join(format!("{name}-{is_old}.xml"));
                std::fs::write(&file, scene(kind, name, is_old)).expect("a writable folder");
                let built = parse_scene(&file, &[], true)
                    .and_then(|parsed| build_scene(&parsed, &BuildOptions::default()));
                count += 1;
                match built {
                    Err(error) => failures.push(error.to_string()),
                    // Chains and photons are at work elsewhere, and take their time.
                    Ok(_) if matches!(kind, Listed::Integrators) => {}
                    Ok(scene) => {
                        let sum: f64 = pixels(&scene, 4).as_flattened().iter().sum();
                        if !(sum > 0.0) {
                            failures.push(format!("{kind:?} {name}, old {is_old}: {sum}"));
                        }
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(count > 130, "{count}");
}
