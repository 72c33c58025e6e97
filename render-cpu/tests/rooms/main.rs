//! The order of the house: no two files of a crate import each other, directly or by way of others, the rooms of the kernel
//! import those before them only (README, "How to read the code"), and a file has one concept and at most [`MOST_LINES`] lines, or
//! says in its header why it is longer ([`REASON`]).
//!
//! Files are parsed, not searched for words, so comments, strings and inline modules do not count. An arrow goes from a file to the
//! one that defines the item that it names, whatever re-exports lie between. Methods are called without a path and do not count.

mod graph;
mod names;

use graph::Graph;
use std::fs;
use std::path::{Path, PathBuf};

/// The kernel's rooms, each of which may import those before it.
const ROOMS: [&str; 9] = [
    "math",
    "simd",
    "sampler",
    "scene",
    "bsdf",
    "regularize",
    "manifold",
    "path",
    "transport",
];

/// Most lines of a file.
const MOST_LINES: usize = 400;

/// What the module comment of a longer file says, followed by the reason.
const REASON: &str = "//! Longer than 400 lines, because ";

/// Folders with files in Rust, tests and programs included.
const FOLDERS: [&str; 5] = ["kernel", "render-cpu", "render-spirv", "fuzz", "benches"];

/// Looks at all files in Rust below a folder but those that builds leave; returns their number.
fn for_files(folder: &Path, look: &mut impl FnMut(&Path, &str)) -> usize {
    let mut files = 0;
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let is_left_by_builds = ["target", "node_modules"]
            .iter()
            .any(|name| path.ends_with(name));
        if path.is_dir() && !is_left_by_builds {
            files += for_files(&path, look);
        } else if path.extension().is_some_and(|e| e == "rs") {
            look(&path, &fs::read_to_string(&path).expect("a file"));
            files += 1;
        }
    }
    files
}

/// Whether a file is longer than it says why.
fn is_too_long(text: &str) -> bool {
    let mut header = text.lines().take_while(|line| line.starts_with("//!"));
    text.lines().count() > MOST_LINES && !header.any(|line| line.starts_with(REASON))
}

fn of_crate(folder: &str) -> Graph {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    Graph::read(&root.join(folder).join("src"))
}

/// A crate of files with their text.
fn fixture(files: &[(&str, &str)]) -> (tempfile::TempDir, Graph) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let path: PathBuf = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    let graph = Graph::read(folder.path());
    (folder, graph)
}

#[test]
fn no_two_files_import_each_other() {
    for (folder, least) in [("kernel", 200), ("render-cpu", 200), ("render-spirv", 20)] {
        let graph = of_crate(folder);
        assert!(graph.len() >= least, "{folder}: {} files", graph.len());
        assert!(graph.arrows() > graph.len(), "{folder}: hardly any arrows");
        let circles = graph.circles();
        assert!(circles.is_empty(), "{folder}: {circles:#?}");
    }
}

#[test]
fn rooms_of_the_kernel_import_those_before_them_only() {
    let up = of_crate("kernel").arrows_up(&ROOMS);
    assert!(up.is_empty(), "{up:#?}");
}

#[test]
fn long_files_say_why() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (mut files, mut found) = (0, Vec::new());
    for folder in FOLDERS {
        files += for_files(&root.join(folder), &mut |path, text| {
            if is_too_long(text) {
                found.push(format!(
                    "{} ({} lines)",
                    path.display(),
                    text.lines().count()
                ));
            }
        });
    }
    assert!(files > 700, "{files} files");
    assert!(found.is_empty(), "more than {MOST_LINES} lines: {found:#?}");
}

#[test]
fn a_long_file_without_a_reason_is_found() {
    let lines = |header: &str, count: usize| format!("{header}\n{}", "\n".repeat(count - 1));
    let reason = format!("//! A table.\n//!\n{REASON}it is one table.");
    assert!(is_too_long(&lines("//! A table.", MOST_LINES + 1)));
    assert!(is_too_long(&lines(
        &reason.replace("//!", "//"),
        MOST_LINES + 1
    )));
    assert!(!is_too_long(&lines("//! A table.", MOST_LINES)));
    assert!(!is_too_long(&lines(&reason, MOST_LINES + 1)));
    // Only its module comment counts.
    assert!(is_too_long(&lines(
        &format!("fn f() {{}}\n{REASON}x"),
        MOST_LINES
    )));
}

#[test]
fn readme_names_the_rooms_in_this_order() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let text = fs::read_to_string(path).expect("README.md");
    let line = text.lines().find(|line| line.starts_with("| `kernel/` |"));
    let names: Vec<&str> = line
        .expect("the kernel")
        .split('`')
        .skip(3)
        .step_by(2)
        .collect();
    assert_eq!(names, ROOMS);
}

/// The files and functions that README's path of one sample names, in the folder that its text is in.
#[test]
fn readme_names_files_and_functions_that_there_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = fs::read_to_string(root.join("README.md")).expect("README.md");
    let section = text
        .split("\n## ")
        .find(|s| s.starts_with("How to read the code"));
    let quoted: Vec<&str> = section.expect("the section").split('`').collect();
    let (mut folder, mut files, mut functions) = (root.clone(), 0, 0);
    for i in (1..quoted.len()).step_by(2) {
        let name = quoted[i];
        if name == "render-cpu/src" || name == "kernel/src" {
            folder = root.join(name);
        }
        if !name.ends_with(".rs") {
            continue;
        }
        let file = [root.join(name), folder.join(name)];
        let file = file.iter().find(|file| file.is_file());
        let code = fs::read_to_string(file.unwrap_or_else(|| panic!("{name}"))).expect("a file");
        files += 1;
        if quoted[i + 1].trim_start_matches(char::is_whitespace) == "(" {
            let function = quoted[i + 2];
            let is_defined = |c| code.contains(&format!("fn {function}{c}"));
            assert!(
                is_defined('(') || is_defined('<'),
                "{name} has no {function}"
            );
            functions += 1;
        }
    }
    assert!(
        files > 30 && functions > 12,
        "{files} files, {functions} functions"
    );
}

#[test]
fn circles_by_every_kind_of_import_are_found() {
    let both_ways = [
        (
            "use crate::b::B; pub struct A(pub B);",
            "use crate::a::A; pub struct B(pub Box<A>);",
        ),
        (
            "use super::b::*; pub struct A(pub B);",
            "pub struct B(pub Box<crate::a::A>);",
        ),
        (
            "use crate::Renamed; pub fn f(_: Renamed) {}",
            "pub struct B; pub fn g() { crate::a::f(B) }",
        ),
        (
            "use crate::b; pub fn f() { b::g() }",
            "pub fn g() { assert!(crate::a::f() == ()) }",
        ),
        (
            "pub fn f() {} fn h() { super::b::g() }",
            "pub fn g() {} mod inner { fn h() { super::super::a::f() } }",
        ),
        (
            "pub const A: u32 = crate::b::B;",
            "use crate::{a::{self as other}}; pub const B: u32 = other::A;",
        ),
    ];
    for (a, b) in both_ways {
        let (_folder, graph) = fixture(&[
            ("lib.rs", "mod a; mod b; pub use b::B as Renamed;"),
            ("a.rs", a),
            ("b.rs", b),
        ]);
        assert_eq!(graph.circles().len(), 1, "{a}\n{b}");
    }
}

#[test]
fn circles_of_three_and_of_a_folder_with_its_files_are_found() {
    let (_folder, graph) = fixture(&[
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "pub fn f() { crate::b::f() }"),
        ("b.rs", "pub fn f() { crate::c::f() }"),
        ("c/mod.rs", "mod d; pub fn f() { d::f() } pub struct C;"),
        ("c/d.rs", "pub fn f() { let _ = super::C; crate::a::f() }"),
    ]);
    let circles = graph.circles();
    assert_eq!(circles.len(), 1, "{circles:#?}");
    assert!(
        ["a.rs", "b.rs", "c/mod.rs", "c/d.rs"]
            .iter()
            .all(|name| circles[0].contains(name))
    );
}

#[test]
fn what_is_no_import_is_no_circle() {
    let (_folder, graph) = fixture(&[
        ("lib.rs", "mod a; mod b; pub use a::A; pub use b::f;"),
        (
            "a.rs",
            "//! See crate::b::f.\npub struct A; const _: &str = \"crate::b::f\"; mod tests { use super::*; fn g(_: A) {} }",
        ),
        ("b.rs", "use crate::A; pub fn f(_: A) {}"),
    ]);
    assert!(graph.circles().is_empty());
    assert_eq!(graph.arrows(), 1);
}

#[test]
fn an_arrow_up_is_found() {
    let rooms = ["low", "high"];
    let files = [
        ("lib.rs", "mod low; mod high; pub use high::f;"),
        ("low/mod.rs", "mod x;"),
        ("low/x.rs", "fn g() { crate::f() }"),
        ("high.rs", "pub fn f() {}"),
    ];
    assert_eq!(fixture(&files).1.arrows_up(&rooms).len(), 1);
    let down = [
        files[0],
        files[1],
        ("low/x.rs", "pub fn f() {}"),
        ("high.rs", "pub use crate::low::x::f; fn g() { f() }"),
    ];
    assert!(fixture(&down).1.arrows_up(&rooms).is_empty());
}
