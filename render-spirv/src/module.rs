//! The committed SPIR-V modules, and stamps of the sources from which they were compiled.
//!
//! | module | purpose |
//! |---|---|
//! | `halflight` | rendering; part of the program |
//! | `probes` | tests, which compare functions and layouts |
//! | `example` | the shader of `render-spirv/examples/shader` |
//!
//! A stamp is a text of three lines: a hash over the names and bytes of every source file that the shader compiler
//! reads (FNV-1a, 64 bits), the compiler's version, and a hash of the module itself. [`Committed::stamp`] is what
//! `build-shaders` writes and what a test recomputes.

use halflight::source_stamp::{FNV, fnv, source_hash};
use std::io;
use std::path::{Path, PathBuf};

/// The module of rendering, as committed.
const BYTES: &[u8] = include_bytes!("../spirv/halflight.spv");

/// A committed module.
#[derive(Clone, Copy, Debug)]
pub struct Committed {
    /// Its name: `spirv/NAME.spv` and `spirv/NAME.stamp`.
    pub name: &'static str,
    /// Files and folders that it is made from beside the kernel, below the workspace's folder.
    sources: &'static [&'static str],
}

/// What all modules are made from.
const KERNEL: [&str; 2] = ["kernel/Cargo.toml", "kernel/src"];

/// All modules.
pub const MODULES: [Committed; 3] = [
    Committed {
        name: "halflight",
        sources: &["render-spirv/shaders", "render-spirv/src/interface.rs"],
    },
    Committed {
        name: "probes",
        sources: &[
            "render-spirv/shaders",
            "render-spirv/src/interface.rs",
            "render-spirv/src/probe",
        ],
    },
    Committed {
        name: "example",
        sources: &["render-spirv/examples/shader"],
    },
];

impl Committed {
    /// The module's file below the workspace's folder.
    pub fn path(&self, root: &Path) -> PathBuf {
        root.join("render-spirv/spirv")
            .join(self.name)
            .with_extension("spv")
    }

    /// The stamp's file.
    pub fn stamp_path(&self, root: &Path) -> PathBuf {
        self.path(root).with_extension("stamp")
    }

    /// The stamp that belongs to the sources and the module as they are, compiled by `compiler`.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn stamp(&self, root: &Path, compiler: &str) -> io::Result<String> {
        let module = std::fs::read(self.path(root))?;
        Ok(format!(
            "sources {:016x}\ncompiler {compiler}\nmodule {:016x}\n",
            source_hash(root, &[&KERNEL, self.sources].concat(), is_source)?,
            fnv(FNV, &module)
        ))
    }
}

/// Rust files, manifests and locks.
fn is_source(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e == "rs" || e == "toml" || e == "lock")
}

/// A module is older than the program that uses it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the compiled module has no entry point {0}; run render-spirv/build-shaders")]
pub struct StaleModule(pub String);

/// Whether a module with the entry points `known` can be used for `entry`.
///
/// # Errors
/// If it has no such entry point.
pub fn require(known: &[String], entry: &str) -> Result<(), StaleModule> {
    if known.iter().any(|name| name == entry) {
        Ok(())
    } else {
        Err(StaleModule(entry.to_owned()))
    }
}

/// The words of a module's bytes.
pub fn words_of(bytes: &[u8]) -> Vec<u32> {
    // A file need not be aligned in memory, and SPIR-V files are little-endian here.
    bytes
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// The words of the module of rendering.
pub fn words() -> Vec<u32> {
    words_of(BYTES)
}

/// The capabilities that the module declares (`OpCapability`), by number.
pub fn capabilities(words: &[u32]) -> Vec<u32> {
    const OP_CAPABILITY: u32 = 17;
    instructions(words)
        .take_while(|i| i[0] & 0xffff == OP_CAPABILITY)
        .map(|i| i[1])
        .collect()
}

/// The instructions of a module, each with its first word (length and opcode).
pub fn instructions(words: &[u32]) -> impl Iterator<Item = &[u32]> {
    const HEADER: usize = 5;
    let mut at = HEADER;
    std::iter::from_fn(move || {
        let length = (*words.get(at)? >> 16) as usize;
        let instruction = words.get(at..at + length.max(1))?;
        at += length.max(1);
        Some(instruction)
    })
}

/// The names of the module's entry points (`OpEntryPoint`).
pub fn entry_points(words: &[u32]) -> Vec<String> {
    const OP_ENTRY_POINT: u32 = 15;
    instructions(words)
        .filter(|i| i[0] & 0xffff == OP_ENTRY_POINT)
        .map(|i| {
            let bytes = i[3..].iter().flat_map(|w| w.to_le_bytes());
            let name: Vec<u8> = bytes.take_while(|&b| b != 0).collect();
            String::from_utf8_lossy(&name).into_owned()
        })
        .collect()
}
