//! What the page computes itself, against the command: expressions, clusters, bundles, voxels.

use crate::browser::Browser;
use crate::matcher::{Vertex, matched, path, tree};
use crate::scenes::{NAMED, scene};
use crate::{BALL, browser, write_page};
use halflight::expression::compile;
use halflight::inspect::paths::Places;
use halflight::inspect::paths::bundle::bundles;
use halflight::inspect::paths::cluster::{ClusterBy, ClusterFrom, ClusterTree};
use halflight::inspect::record_file::PathRecord;
use halflight_kernel::glam::Vec3;
use halflight_kernel::transport::recorded::vertex_kind;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use std::process::Command;

/// Paths as columns of the page.
fn columns(paths: &[Vec<Vertex>]) -> String {
    let mut starts = vec![0];
    let (mut kinds, mut objects, mut positions) = (Vec::new(), Vec::new(), Vec::new());
    for path in paths {
        // From the sensor.
        for vertex in path.iter().rev() {
            let (kind, object, x) = match vertex {
                Vertex::Sensor => (vertex_kind::SENSOR, u32::MAX, 0.0),
                Vertex::Light(2) => (vertex_kind::LIGHT_AT_INFINITY, 2, 0.0),
                Vertex::Light(i) => (vertex_kind::LIGHT, *i as u32, 0.0),
                Vertex::Surface {
                    kind,
                    shape,
                    in_door,
                } => (*kind, *shape as u32, if *in_door { 4.5 } else { 0.0 }),
            };
            kinds.push(kind);
            objects.push(object);
            positions.extend([x, -1.5, 1.9]);
        }
        starts.push(kinds.len());
    }
    format!(
        "{{count: {}, starts: new Uint32Array({}), kinds: new Uint8Array({}), objects: new Uint32Array({}), positions: new Float32Array({})}}",
        paths.len(),
        json!(starts),
        json!(kinds),
        json!(objects),
        json!(positions)
    )
}

#[test]
fn expressions_mean_in_the_page_what_they_mean_in_the_command() {
    let Some(mut browser) = browser() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    write_page(folder.path(), NAMED, &["--spp", "1", "--record-count", "4"]);
    browser.open(&folder.path().join("page.html"), "");
    let mut runner = TestRunner::deterministic();
    let mut draw =
        |strategy: &BoxedStrategy<String>| strategy.new_tree(&mut runner).unwrap().current();
    let expressions = (tree(), any::<bool>()).prop_map(|(tree, from_camera)| {
        let inner = tree.text(from_camera);
        if from_camera {
            format!("C {inner} L")
        } else {
            format!("L {inner} E")
        }
    });
    let garbage = r#"[LCE]?[LCEDGSXRTOB.<>\[\]{}()^'|*+?,0-9 dor\u{e9}]{0,40}"#;
    let strategies = [expressions.boxed(), garbage.prop_map(String::from).boxed()];
    let mut texts: Vec<String> = (0..900).map(|i| draw(&strategies[i % 2])).collect();
    texts.extend(
        [
            "",
            "L Q E",
            "L D C",
            "C D E",
            "L (D E",
            "L D) E",
            "L [DG E",
            "L [] E",
            "L (* D) E",
            "L D{3,2} E",
            "L D{99} E",
            "L D{} E",
            "L D {} E",
            "L D^X E",
            "L R^T E",
            "L D[rign] E",
            "L D[] E",
            "L D['a E",
            "L D{window} E",
            "L{door} D E",
            "L D E[cam]",
            "C<>L",
            "L * E",
            "L ** E",
            "L D E+",
            "L[key]* E",
            "C.* [BO]{2,}",
            "L X[material:ring] E",
            "L X[foo:bar] E",
            "L X[^ring, ^ball] E",
            "L X[nosuch*] E",
            "C<RQ>L",
            "C<RDL",
            "C<RD",
            "C<VD>L",
            "C<Ts>L",
            "L D****** E",
            "L (((D{64}){64}){64}) E",
            "L X[^ring, material:wo*] E",
            "L X{'door'} E",
        ]
        .map(String::from),
    );
    let paths: Vec<Vec<Vertex>> = (0..150)
        .map(|_| path().new_tree(&mut runner).unwrap().current())
        .collect();
    let answers = browser.value(&format!(
        "halflight.match({}, {})",
        json!(texts),
        columns(&paths)
    ));
    let scene = scene(NAMED);
    let tables = scene.tables.view();
    let (mut agreed, mut matches, mut mistakes) = (0, 0, 0);
    for (text, answer) in texts.iter().zip(answers.as_array().unwrap()) {
        match compile(&[text], false, &tables, &scene.names) {
            Ok(compiled) => {
                let own: Vec<u32> = paths
                    .iter()
                    .map(|p| matched(&compiled.view(), &tables, p)[0])
                    .collect();
                matches += own.iter().sum::<u32>();
                agreed += 1;
                assert_eq!(answer, &json!(own), "{text}");
            }
            // What no path matches has no meaning in the command; the page shows that there is none.
            Err(error) if error.message.contains("no path of this scene") => {
                assert_eq!(answer, &json!(vec![0; paths.len()]), "{text}");
            }
            // The page has no table of all states, which are too many here.
            Err(error)
                if ["complex", "too many orders", "more than 1024"]
                    .iter()
                    .any(|m| error.message.contains(m)) => {}
            Err(error) => {
                mistakes += 1;
                let expected = json!({"position": error.position, "message": error.message});
                assert_eq!(answer, &expected, "{text}");
            }
        }
    }
    assert!(
        agreed > 200 && matches > 2000 && mistakes > 200,
        "{agreed} {matches} {mistakes}"
    );
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
}

/// Labels, numbers and weights; weights to the precision of sums in different orders.
fn assert_same_tree(a: &Value, b: &Value) {
    assert_eq!((&a["labels"], &a["paths"]), (&b["labels"], &b["paths"]));
    let weight = |v: &Value| v["weight"].as_f64().unwrap();
    assert!(
        (weight(a) / weight(b) - 1.0).abs() < 1e-9,
        "{} {}",
        a["weight"],
        b["weight"]
    );
    let children = |v: &Value| v["children"].as_array().unwrap().clone();
    assert_eq!(children(a).len(), children(b).len());
    for (a, b) in children(a).iter().zip(children(b)) {
        assert_same_tree(a, &b);
    }
}

/// The length of the way through a box.
fn length_in_box(a: Vec3, b: Vec3, low: Vec3, high: Vec3) -> f32 {
    let d = b - a;
    let (t0, t1) = ((low - a) / d, (high - a) / d);
    let from = t0.min(t1).max_element().max(0.0);
    let to = t0.max(t1).min_element().min(1.0);
    d.length() * (to - from).max(0.0)
}

#[test]
fn clusters_bundles_and_voxels_are_those_of_the_command() {
    let Some(mut browser) = browser() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("s.xml"),
        format!("<scene version=\"3.0.0\">{BALL}</scene>"),
    )
    .unwrap();
    let mut render = Command::new(env!("CARGO_BIN_EXE_halflight"));
    render.args([
        "render",
        "s.xml",
        "--spp",
        "16",
        "--record",
        "p.bin",
        "--record-count",
        "2000",
        "-o",
        "s.exr",
    ]);
    assert!(
        render
            .current_dir(folder.path())
            .output()
            .unwrap()
            .status
            .success()
    );
    write_page(
        folder.path(),
        BALL,
        &["--paths", "p.bin", "--image", "s.exr"],
    );
    let mut file = std::fs::File::open(folder.path().join("p.bin")).unwrap();
    let record = PathRecord::read_bytes(&mut file).unwrap();
    let places = Places::of(&record);
    browser.open(&folder.path().join("page.html"), "");
    let all: Vec<u32> = (0..record.paths.len() as u32).collect();
    for (by, by_name) in [
        (ClusterBy::Expression, "expression"),
        (ClusterBy::Object, "object"),
    ] {
        for (from, from_name) in [
            (ClusterFrom::Light, "light"),
            (ClusterFrom::Sensor, "sensor"),
        ] {
            let own = ClusterTree::of(&record, all.clone(), by, from).json();
            let found = browser.value(&format!("halflight.tree({by_name:?}, {from_name:?})"));
            assert_same_tree(&found, &own);
        }
    }
    // Of all paths as one group only those of the same length share all vertices: the first few cuts suffice.
    let own = bundles(&record, &places, vec![all], 6);
    let found = browser.value("halflight.bundles(6)");
    assert_eq!(found.as_array().unwrap().len(), own.len());
    for (a, b) in found.as_array().unwrap().iter().zip(&own) {
        assert_eq!(
            (&a["representative"], &a["paths"]),
            (&json!(b.representative), &json!(b.paths.len()))
        );
        assert!((a["weight"].as_f64().unwrap() / b.weight - 1.0).abs() < 1e-9);
        for (a, b) in a["spread"].as_array().unwrap().iter().zip(&b.spread) {
            assert!((a.as_f64().unwrap() - b).abs() < 1e-4 * (1.0 + b));
        }
    }
    // The sum over all voxels is the length of all ways through the box by weight, over a voxel's volume.
    let (center, size) = (Vec3::new(0.1, 0.2, 0.9), Vec3::new(2.0, 1.5, 1.2));
    let (low, high) = (center - 0.5 * size, center + 0.5 * size);
    let ways = record
        .paths
        .iter()
        .zip(&places.paths)
        .map(|(path, places)| {
            let inside = places[1..]
                .windows(2)
                .map(|pair| length_in_box(pair[0], pair[1], low, high));
            f64::from(path.weight) * f64::from(inside.sum::<f32>())
        });
    let voxels = [20.0, 15.0, 12.0];
    let expected =
        ways.sum::<f64>() * voxels.iter().product::<f64>() / f64::from(size.element_product());
    let sum = browser.value("(halflight.set({tool: 'volume', box: [0.1, 0.2, 0.9, 2, 1.5, 1.2], voxels: 20}), halflight.voxelSum())");
    let sum = sum.as_f64().unwrap();
    assert!(
        expected > 0.0 && (sum / expected - 1.0).abs() < 1e-3,
        "{sum} {expected}"
    );
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
}

#[test]
fn a_measured_volume_is_that_of_the_tool() {
    let Some(mut browser) = browser() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let own = [
        "--spp",
        "1",
        "--box",
        "-1,-1,0,1,0.5,1.4",
        "--voxels",
        "16",
        "--walks",
        "20000",
        "--seed",
        "5",
    ];
    write_page(
        folder.path(),
        BALL,
        &[&own[..], &["--record-count", "100"]].concat(),
    );
    let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
    command.args([
        "inspect",
        "scene.xml",
        "--tool",
        "volume",
        "-o",
        "v.png",
        "--json",
    ]);
    let output = command
        .args(own)
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success());
    let tool: Value = serde_json::from_slice(&output.stdout).unwrap();
    browser.open(&folder.path().join("page.html"), "#tool=volume&medium=1");
    let in_page = |of: &str, browser: &mut Browser| {
        let volume = "halflight.volume()";
        browser.value(&format!("(v => {of})({volume})"))
    };
    assert_eq!(in_page("v.size", &mut browser), tool["voxels"]);
    for (of, key) in [
        (
            "v.values.reduce((a, b) => a + b, 0) / v.values.length",
            "mean",
        ),
        ("v.values.reduce((a, b) => Math.max(a, b), 0)", "most"),
    ] {
        let (page, tool) = (
            in_page(of, &mut browser).as_f64().unwrap(),
            tool[key].as_f64().unwrap(),
        );
        assert!(
            tool > 0.0 && (page - tool).abs() < 1e-5 * tool,
            "{key}: {page} {tool}"
        );
    }
    let measured = browser.picture("#space");
    let volume = "halflight.set({medium: false})";
    browser.value(volume);
    browser.settle();
    let recorded = browser.picture("#space");
    assert!(
        measured != recorded,
        "the source of the volume changes what is seen"
    );
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
}
