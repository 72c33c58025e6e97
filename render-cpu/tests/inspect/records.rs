//! Records of paths.

use crate::{ABOVE, SKY, parts, scene, with_view};
use halflight::expression::PartsRequest;
use halflight::film::aov::AovSet;
use halflight::inspect::record::{Choice, record};
use halflight::inspect::record_file::PathRecord;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::Scene;
use std::process::Command;

/// A diffuse floor, a ball of glass and a lamp.
pub fn lit_ball() -> Scene {
    scene(&lit_ball_text())
}

pub fn lit_ball_text() -> String {
    format!(
        r#"{}<shape type="sphere" id="ball"><point name="center" value="0.3, 0, 0.6"/><float name="radius" value="0.5"/>
        <bsdf type="dielectric" id="glass"/></shape>
        <shape type="rectangle" id="panel"><transform name="to_world"><scale value="0.8"/><rotate x="1" angle="180"/><translate x="-1.5" z="3"/></transform>
        <emitter type="area" id="lamp"><rgb name="radiance" value="9, 8, 7"/></emitter></shape>{SKY}"#,
        ABOVE
            .replace("roughconductor", "diffuse")
            .replace("metal", "paint")
            .replace(r#"<float name="alpha" value="0.1"/>"#, "")
    )
}

pub fn recorded(scene: &Scene, only: Option<&str>, choice: &Choice) -> PathRecord {
    with_view(scene, |view| {
        record(view, scene, &parts(scene, only), choice)
    })
}

pub const CHOICE: Choice = Choice {
    most: 4000,
    samples: 256,
    seed: 4,
    first_sample: 0,
    pixels: None,
};

#[test]
fn recorded_paths_are_those_of_the_image() {
    let mut scene = lit_ball();
    let found = recorded(&scene, None, &CHOICE);
    let layers = [
        ("direct", "L D E"),
        ("seen", "L S* E"),
        ("caustic", "L S+ D E"),
    ];
    scene
        .divide(&PartsRequest {
            layers: layers.map(|(n, t)| (n.to_owned(), t.to_owned())).to_vec(),
            only: None,
        })
        .unwrap();
    let options = RenderOptions {
        goal: Goal::Samples(256),
        seed: 4,
        first_sample: 0,
        adaptive: false,
    };
    let film = render_film(&scene, &options, AovSet::NONE).unwrap();
    let luminance = |p: [f64; 3]| halflight::film::luminance(p);
    let whole: f64 = film.mean().iter().map(|p| luminance(*p)).sum::<f64>() * 256.0;
    assert!((found.header.luminance / whole - 1.0).abs() < 1e-4);
    assert_eq!((found.header.count, found.paths.len()), (4000, 4000));
    // What the paths that are kept stand for.
    for (part, (name, _)) in layers.iter().enumerate() {
        let pixels = film.statistics().len();
        let of_part = |i| [0, 1, 2].map(|c| film.part_mean(part, c, i));
        let sum: f64 = (0..pixels).map(|i| luminance(of_part(i))).sum();
        let expected = sum * 256.0 / whole;
        let is_own = |word: &str| match *name {
            "direct" => word == "L D^R E",
            "seen" => !word.contains('D') && !word.contains('G'),
            _ => word.ends_with("D^R E") && word.matches('D').count() == 1 && word.contains('S'),
        };
        let own = found.paths.iter().filter(|p| is_own(&found.word(p)));
        let share = own.map(|p| f64::from(p.weight)).sum::<f64>() / whole;
        // Weights are at most some thousandths of the whole each.
        assert!(
            (share - expected).abs() < 0.02,
            "{name}: {share} {expected}"
        );
        assert!(expected > 0.005, "{name}: {expected}");
    }
    for path in &found.paths {
        let (first, last) = (&path.vertices[0], &path.vertices[path.vertices.len() - 1]);
        assert_eq!(first.position, [0.0, 0.0, 4.0]);
        assert_eq!(last.throughput, path.light);
        let name = &found.header.emitters[last.object as usize];
        assert!(name == "sky" || (name == "lamp" && (last.position[2] - 3.0).abs() < 1e-2));
        for vertex in &path.vertices[1..path.vertices.len() - 1] {
            let index = vertex.object as usize;
            let material = &found.header.materials[index];
            let is_specular = vertex.kind >= 4;
            assert_eq!(is_specular, material == "glass", "{:?}", found.word(path));
        }
    }
}

#[test]
fn records_hold_what_was_asked_for() {
    let scene = lit_ball();
    let choice = Choice {
        most: 50,
        pixels: Some([3, 1, 2, 2]),
        ..CHOICE
    };
    for path in &recorded(&scene, None, &choice).paths {
        assert!((3..5).contains(&path.pixel[0]) && (1..3).contains(&path.pixel[1]));
    }
    let choice = Choice { most: 50, ..CHOICE };
    let found = recorded(&scene, Some("L[sky] S^T{2} D E"), &choice);
    assert_eq!(found.paths.len(), 50);
    for path in &found.paths {
        assert_eq!(found.word(path), "L S^T S^T D^R E");
    }
    let mut bytes = Vec::new();
    found.write_bytes(&mut bytes).unwrap();
    let mut read = PathRecord::read_bytes(&mut bytes.as_slice()).unwrap();
    // JSON keeps all but the last digit.
    assert!((read.header.luminance / found.header.luminance - 1.0).abs() < 1e-12);
    read.header.luminance = found.header.luminance;
    assert!(read == found);
    for length in [0, 7, 30, bytes.len() - 1] {
        assert!(PathRecord::read_bytes(&mut &bytes[..length]).is_err());
    }
    // What no walk makes is no path: a sensor among surfaces, a place that is no number, a single vertex.
    let spoilt = |change: &dyn Fn(&mut PathRecord)| {
        let mut record = found.clone();
        change(&mut record);
        let mut bytes = Vec::new();
        record.write_bytes(&mut bytes).unwrap();
        PathRecord::read_bytes(&mut bytes.as_slice()).is_err()
    };
    assert!(!spoilt(&|_| {}));
    assert!(spoilt(&|r| r.paths[3].vertices[1].kind = 8));
    assert!(spoilt(&|r| r.paths[0].vertices[0].kind = 99));
    assert!(spoilt(&|r| r.paths[9].vertices[2].position[1] = f32::NAN));
    assert!(spoilt(&|r| r.paths[1].vertices.truncate(1)));
    assert!(spoilt(&|r| r.paths[1].weight = -1.0));
    let mut lines = Vec::new();
    found.write_lines(&mut lines).unwrap();
    let lines = String::from_utf8(lines).unwrap();
    let lines: Vec<serde_json::Value> = lines
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    assert_eq!(lines.len(), 51);
    assert_eq!(lines[0]["count"], 50);
    assert_eq!(lines[1]["vertices"][1]["material"], "paint");
    assert_eq!(lines[1]["vertices"][4]["object"], "sky");
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| recorded(&scene, None, &CHOICE))
    };
    assert_eq!(of(1), of(3));
}

#[test]
fn the_render_command_writes_a_record() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("<scene version=\"3.0.0\">{ABOVE}{SKY}</scene>");
    std::fs::write(folder.path().join("s.xml"), text).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
        command.args(["render", "s.xml", "--spp", "4", "-o", "out.exr"]);
        command.args(arguments).current_dir(folder.path());
        command.output().unwrap()
    };
    let output = run(&[
        "--record",
        "paths.bin",
        "--record-where",
        "L G E",
        "--record-count",
        "20",
    ]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut file = std::fs::File::open(folder.path().join("paths.bin")).unwrap();
    let found = PathRecord::read_bytes(&mut file).unwrap();
    assert!(found.paths.len() == 20 && found.paths.iter().all(|p| found.word(p) == "L G^R E"));
    assert_eq!(found.header.expression.as_deref(), Some("L G E"));
    // Together with --only, what both match.
    let both = [
        "--record",
        "paths.bin",
        "--only",
        "L G G* E",
        "--record-where",
        "L X X E",
    ];
    let output = run(&both);
    assert!(output.status.success());
    let mut file = std::fs::File::open(folder.path().join("paths.bin")).unwrap();
    let found = PathRecord::read_bytes(&mut file).unwrap();
    assert_eq!(
        found.header.expression.as_deref(),
        Some("L G G* E and L X X E")
    );
    assert!(found.paths.iter().all(|p| found.word(p) == "L G^R G^R E"));
    let output = run(&["--record", "paths.bin", "--only", "L G E"]);
    assert!(output.status.success());
    let mut file = std::fs::File::open(folder.path().join("paths.bin")).unwrap();
    let found = PathRecord::read_bytes(&mut file).unwrap();
    assert!(!found.paths.is_empty() && found.paths.iter().all(|p| found.word(p) == "L G^R E"));
    let output = run(&["--record", "paths.bin", "--record-where", "L Q E"]);
    assert_eq!(output.status.code(), Some(1));
}
