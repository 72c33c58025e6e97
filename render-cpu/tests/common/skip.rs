//! Tests of what a machine may lack: skipped there, with a reason that is said at the end of the run.
//!
//! The test harness hides what passing tests print and knows no skipping at run time. So a skipped test writes its reason to
//! standard error past the harness, and leaves a record in the target folder; the last test target of the workspace,
//! `what_was_skipped` of `halflight-spirv`, lists the records and removes them. Where the environment variable of a
//! requirement is set, as in CI, what is missing is an error instead.

// Every test target uses a part of this file.
#![allow(dead_code)]

use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;

/// What a test needs, or `None` where it must be skipped: then the test returns at once.
///
/// # Panics
/// If it is missing and the environment variable `requirement` is set.
pub fn available<T, E: Display>(needed: Result<T, E>, requirement: &str) -> Option<T> {
    let reason = match needed {
        Ok(found) => {
            let _ = std::fs::remove_file(folder().join(test()));
            return Some(found);
        }
        Err(reason) => reason.to_string(),
    };
    assert!(
        std::env::var_os(requirement).is_none(),
        "{requirement} is set, but {reason}"
    );
    // Not `eprintln!`, which the harness captures.
    let _ = writeln!(std::io::stderr(), "skipped {}: {reason}", test());
    let record = || {
        std::fs::create_dir_all(folder())?;
        std::fs::write(folder().join(test()), &reason)
    };
    record().unwrap_or_else(|error: std::io::Error| panic!("{}: {error}", folder().display()));
    None
}

/// The folder with a file for each skipped test, which holds the reason.
pub fn folder() -> PathBuf {
    // target/debug/deps/program
    let program = std::env::current_exe().expect("a program file");
    let target = program.ancestors().nth(3).expect("a target folder");
    target.join("tmp").join("skipped-tests")
}

/// The name of the running test behind that of its target, as a file name.
fn test() -> String {
    let program = std::env::current_exe().expect("a program file");
    let stem = program.file_stem().unwrap_or_default().to_string_lossy();
    let target = stem.rsplit_once('-').map_or(&*stem, |(name, _)| name);
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("main").replace("::", ".");
    format!("{target}.{name}")
}
