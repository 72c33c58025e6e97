//! The end of a run of all tests: lists the tests that were skipped, with the reasons.
//!
//! It has no test of its own. Cargo runs the targets of a workspace by the names of packages and targets, so that this one
//! comes last.

#[path = "../../render-cpu/tests/common/skip.rs"]
mod skip;

use std::collections::BTreeMap;

fn main() {
    // A listing of tests, which some runners ask for first, names none.
    if std::env::args().any(|argument| argument == "--list") {
        return;
    }
    let mut tests: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for record in std::fs::read_dir(skip::folder()).into_iter().flatten() {
        let record = record.expect("an entry of the folder").path();
        let reason = std::fs::read_to_string(&record).expect("a reason");
        let name = record.file_name().unwrap_or_default().to_string_lossy();
        tests.entry(reason).or_default().push(name.into_owned());
        std::fs::remove_file(&record).expect("a file that can be removed");
    }
    if tests.is_empty() {
        println!("no test was skipped");
    }
    for (reason, names) in &mut tests {
        names.sort();
        println!("skipped: {reason}: {}", names.join(", "));
    }
}
