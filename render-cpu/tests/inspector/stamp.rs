//! The committed page and its sources.

use halflight::inspect::page::{MARK, TEMPLATE};
use halflight::source_stamp::{FNV, fnv, source_hash};
use std::path::Path;

/// Fails when the sources of the page are newer than the page: run `npm ci && npm run build` in `render-cpu/inspector`.
#[test]
fn the_page_is_as_new_as_its_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("inspector");
    let sources = [
        "build.mjs",
        "package-lock.json",
        "package.json",
        "tsconfig.json",
        "src",
    ];
    let hash = source_hash(&folder, &sources, |_| true).unwrap();
    let page = fnv(FNV, TEMPLATE.as_bytes());
    let stamp = std::fs::read_to_string(folder.join("dist/inspector.stamp")).unwrap();
    let expected = format!("sources {hash:016x}\npage {page:016x}\n");
    assert_eq!(
        stamp.lines().collect::<Vec<_>>(),
        expected.lines().collect::<Vec<_>>(),
        "stale page: run npm ci && npm run build in render-cpu/inspector"
    );
}

/// One place for data, nothing that is loaded from elsewhere, and the licence of what is in it.
#[test]
fn the_page_is_complete_in_itself() {
    assert_eq!(TEMPLATE.matches(MARK).count(), 1);
    for loaded in [
        "src=\"http",
        "href=\"http",
        "@import",
        "url(http",
        "import(\"http",
        "from\"http",
    ] {
        assert!(!TEMPLATE.contains(loaded), "{loaded}");
    }
    assert!(
        TEMPLATE.contains("three.js authors") && TEMPLATE.contains("Permission is hereby granted")
    );
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("inspector/package-lock.json");
    assert!(
        !std::fs::read_to_string(lock)
            .unwrap()
            .contains("\"resolved\"")
    );
}
