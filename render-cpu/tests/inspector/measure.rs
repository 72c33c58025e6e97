//! How long the page takes, for `benches/README.md`.

use crate::{browser, write_page};
use std::io::Write;
use std::path::Path;

/// A plane of waves of 999 698 triangles, as a PLY file.
fn write_waves(path: &Path) {
    const SIDE: u32 = 708;
    let mut file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let (vertices, faces) = (SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1));
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .unwrap();
    let at = |i: u32| 2.0 * i as f32 / (SIDE - 1) as f32 - 1.0;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let z = 0.05 * (13.0 * at(i)).sin() * (11.0 * at(j)).cos()
                + 0.005 * (201.0 * at(i)).sin() * (190.0 * at(j)).sin();
            [at(i), at(j), z]
                .iter()
                .for_each(|v| file.write_all(&v.to_le_bytes()).unwrap());
        }
    }
    for i in 0..SIDE - 1 {
        for j in 0..SIDE - 1 {
            let v = i * SIDE + j;
            for corners in [[v, v + SIDE, v + 1], [v + 1, v + SIDE, v + SIDE + 1]] {
                file.write_all(&[3]).unwrap();
                corners
                    .iter()
                    .for_each(|c| file.write_all(&c.to_le_bytes()).unwrap());
            }
        }
    }
}

const WAVES: &str = r#"<integrator type="path"/>
    <sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, -2.4, 1.4" target="0, 0, 0" up="0, 0, 1"/></transform>
    <film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>
    <emitter type="constant"/>
    <shape type="ply" id="waves"><string name="filename" value="waves.ply"/><bsdf type="diffuse" id="grey"/></shape>"#;

const FILTERS: [&str; 5] = [
    "L D E",
    "L D+ E",
    "L .* G+ .* E",
    "L X* X[w*, grey*] E",
    "L D D{2,} E",
];

#[test]
#[ignore = "prints times and asserts nothing"]
fn times_of_the_page() {
    let Some(mut browser) = browser() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    write_waves(&folder.path().join("waves.ply"));
    let room = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.xml"),
    )
    .unwrap();
    let begin = room.find("<scene").unwrap();
    let room = &room[begin + room[begin..].find('>').unwrap() + 1..room.rfind("</scene>").unwrap()];
    for (name, scene, count, size) in [
        ("a million triangles", WAVES, "10000", "400x300"),
        (
            "a million triangles, 100 000 paths",
            WAVES,
            "100000",
            "400x300",
        ),
        ("cornell-box, 100 000 paths", room, "100000", "400x400"),
    ] {
        write_page(
            folder.path(),
            scene,
            &["--spp", "16", "--record-count", count, "--size", size],
        );
        let page = folder.path().join("page.html");
        let bytes = page.metadata().unwrap().len();
        let mut opened = Vec::new();
        for _ in 0..3 {
            browser.open(&page, "");
            let drawn = browser.value("Math.round(halflight.drawn())");
            opened.push(drawn.as_u64().unwrap());
        }
        let mut filtered = Vec::new();
        for text in FILTERS {
            let script = format!(
                "(() => {{ const t = performance.now(); halflight.set({{expression: {text:?}}}); const set = performance.now() - t; return [set, halflight.drawn() - t, halflight.summary.selected].map(Math.round); }})()"
            );
            filtered.push(browser.value(&script).to_string());
        }
        println!(
            "{name}: {:.1} MB; opened after {opened:?} ms; filtered, and drawn, in ms, with the paths left: {}",
            bytes as f64 * 1e-6,
            filtered.join(" ")
        );
    }
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
}
