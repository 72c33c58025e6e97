//! The committed SPIR-V module and the stamp that says what it was made from.
//!
//! The stamp is a text of three lines: a hash over the names and bytes of every source file that the shader compiler
//! reads (FNV-1a, 64 bits), the compiler's version, and a hash of the module itself. [`source_hash`] is what
//! `build-shaders` writes and what the test recomputes.

use std::io;
use std::path::Path;

/// The module, as committed.
const BYTES: &[u8] = include_bytes!("../spirv/halflight.spv");

/// What it was made from.
pub const STAMP: &str = include_str!("../spirv/halflight.stamp");

/// The words of the module.
pub fn words() -> Vec<u32> {
    // The file need not be aligned in memory, and SPIR-V files are little-endian here.
    BYTES
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
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

/// FNV-1a over bytes, continued from `hash`.
fn fnv(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// The start of [`fnv`].
const FNV: u64 = 0xcbf2_9ce4_8422_2325;

/// A hash of bytes, as in the stamp.
pub fn bytes_hash(bytes: &[u8]) -> u64 {
    fnv(FNV, bytes)
}

/// The hash of the committed module.
pub fn module_hash() -> u64 {
    bytes_hash(BYTES)
}

/// A line of the stamp: `sources`, `compiler` or `module`.
pub fn stamp(line: &str) -> &'static str {
    STAMP
        .lines()
        .find_map(|l| l.strip_prefix(line)?.strip_prefix(' '))
        .unwrap_or("")
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

/// A hash of everything that the module is made from, below the workspace's folder `root`: the kernel's and the shaders'
/// sources and manifests, and the files that the shaders share with the host. Line ends do not count.
///
/// # Errors
/// If a file cannot be read.
pub fn source_hash(root: &Path) -> io::Result<u64> {
    let mut files = vec![
        root.join("kernel/Cargo.toml"),
        root.join("render-spirv/shaders/Cargo.toml"),
        root.join("render-spirv/shaders/Cargo.lock"),
        root.join("render-spirv/src/interface.rs"),
    ];
    collect(&root.join("kernel/src"), &mut files)?;
    collect(&root.join("render-spirv/shaders/src"), &mut files)?;
    // The order of reading a folder is the file system's.
    files.sort();
    let mut hash = FNV;
    for file in files {
        let name = file.strip_prefix(root).unwrap_or(&file);
        for part in name {
            hash = fnv(hash, part.as_encoded_bytes());
            hash = fnv(hash, b"/");
        }
        let mut bytes = std::fs::read(&file)?;
        bytes.retain(|&b| b != b'\r');
        hash = fnv(hash, &bytes);
    }
    Ok(hash)
}

/// All Rust files of a folder.
fn collect(folder: &Path, files: &mut Vec<std::path::PathBuf>) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
