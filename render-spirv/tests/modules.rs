//! The committed modules: as new as their sources, valid, and no more demanding than the host provides.

#[path = "../../render-cpu/tests/common/skip.rs"]
mod skip;

use halflight_spirv::module::{self, MODULES};
use halflight_spirv::no_contraction;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Fails when the kernel or the shaders are newer than a module: run `render-spirv/build-shaders`.
#[test]
fn modules_are_as_new_as_their_sources() {
    for m in MODULES {
        let stamp = std::fs::read_to_string(m.stamp_path(&root())).expect("a stamp");
        let compiler = stamp
            .lines()
            .find_map(|l| l.strip_prefix("compiler "))
            .expect("a compiler");
        let expected = m.stamp(&root(), compiler).expect("sources");
        assert_eq!(
            stamp.lines().collect::<Vec<_>>(),
            expected.lines().collect::<Vec<_>>(),
            "stale module {}: run render-spirv/build-shaders",
            m.name
        );
    }
}

/// A module is stale as soon as a byte of its sources or of itself changes, and not when a line ends differently.
#[test]
fn stamps_notice_changes() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    write("kernel/Cargo.toml", "[package]");
    write("kernel/src/lib.rs", "fn f() {}\n");
    write("render-spirv/examples/shader/src/lib.rs", "fn g() {}\n");
    write("render-spirv/spirv/example.spv", "module");
    let example = MODULES[2];
    let stamp = || example.stamp(folder.path(), "a compiler").expect("a stamp");
    let first = stamp();
    write("kernel/src/lib.rs", "fn f() {}\r\n");
    assert_eq!(stamp(), first);
    write("kernel/src/lib.rs", "fn f() { }\n");
    let second = stamp();
    assert_ne!(second, first);
    write("render-spirv/examples/shader/src/more.rs", "");
    let third = stamp();
    assert_ne!(third, second);
    write("render-spirv/spirv/example.spv", "another");
    assert_ne!(stamp(), third);
}

/// A module without the entry point that the program asks for is refused by name before a driver sees it.
#[test]
fn a_stale_module_is_refused() {
    let bytes = std::fs::read(MODULES[2].path(&root())).expect("a module");
    let known = module::entry_points(&module::words_of(&bytes));
    assert!(!known.is_empty());
    assert_eq!(module::require(&known, &known[0]), Ok(()));
    let refused = module::require(&known, "occlusion").expect_err("another module's");
    assert_eq!(
        refused.to_string(),
        "the compiled module has no entry point occlusion; run render-spirv/build-shaders"
    );
    let own = module::entry_points(&module::words());
    assert_eq!(module::require(&own, "occlusion"), Ok(()));
}

/// Modules are valid for Vulkan 1.2 with records packed as on the host (the feature `scalarBlockLayout`).
#[test]
fn modules_are_valid() {
    for m in MODULES {
        let path = m.path(&root());
        let run = Command::new("spirv-val")
            .args(["--target-env", "vulkan1.2", "--scalar-block-layout"])
            .arg(&path)
            .output();
        let run = run.map_err(|error| {
            format!("spirv-val does not run ({error}); Debian has it in spirv-tools")
        });
        let Some(output) = skip::available(run, "HALFLIGHT_REQUIRE_VULKAN") else {
            return;
        };
        assert!(
            output.status.success(),
            "{}: {}{}",
            path.display(),
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

/// No driver may fuse or reorder arithmetic; what `build-shaders` adds for that loses nothing else.
#[test]
fn arithmetic_is_exact() {
    for m in MODULES {
        let words = module::words_of(&std::fs::read(m.path(&root())).expect("a module"));
        assert!(
            no_contraction::contractible(&words).is_empty(),
            "{}",
            m.name
        );
        assert_eq!(no_contraction::decorated(&words), words, "{}", m.name);
    }
    // Two results are computed, the second is decorated already.
    let instruction = |opcode: u32, operands: &[u32]| {
        let mut words = vec![(operands.len() as u32 + 1) << 16 | opcode];
        words.extend(operands);
        words
    };
    let words = [
        vec![0x0723_0203, 0x0001_0300, 0, 9, 0],
        instruction(17, &[1]),
        instruction(71, &[6, 42]),
        instruction(129, &[1, 5, 2, 2]),
        instruction(133, &[1, 6, 2, 2]),
        instruction(128, &[1, 7, 2, 2]),
    ]
    .concat();
    assert_eq!(no_contraction::contractible(&words), [5]);
    let after = no_contraction::decorated(&words);
    assert_eq!(after[..7], words[..7]);
    assert_eq!(after[7..10], instruction(71, &[5, 42]));
    assert_eq!(after[10..], words[7..]);
}

/// Modules declare nothing that the host does not enable: Shader (1) and VulkanMemoryModel (5345).
#[test]
fn modules_need_what_the_host_enables() {
    for m in MODULES {
        let words = module::words_of(&std::fs::read(m.path(&root())).expect("a module"));
        let capabilities = module::capabilities(&words);
        assert!(
            capabilities.iter().all(|c| [1, 5345].contains(c)),
            "{}: {capabilities:?}",
            m.name
        );
    }
    let entries = module::entry_points(&module::words());
    for entry in [
        "paths::scatter",
        "occlusion",
        "surface_features",
        "canary::canary",
    ] {
        assert!(entries.iter().any(|e| e == entry), "{entry}");
    }
}

/// No file of the shaders is longer than 150 lines: they hold bindings and calls, what they call is in the kernel.
#[test]
fn shaders_are_short() {
    let mut files = 0;
    for folder in [
        "render-spirv/shaders/src",
        "render-spirv/examples/shader/src",
    ] {
        for entry in std::fs::read_dir(root().join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            let lines = std::fs::read_to_string(&path)
                .expect("text")
                .lines()
                .count();
            let most = if folder.contains("examples") { 60 } else { 150 };
            assert!(lines <= most, "{}: {lines} lines", path.display());
            files += 1;
        }
    }
    assert!(files >= 4, "{files}");
}
