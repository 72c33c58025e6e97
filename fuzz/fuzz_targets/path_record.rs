//! Records of paths, their clusters and bundles. Run with `cargo fuzz run path_record`, see `Cargo.toml`.
#![no_main]

use halflight::inspect::paths::Places;
use halflight::inspect::paths::bundle::bundles;
use halflight::inspect::paths::cluster::{ClusterBy, ClusterFrom, ClusterTree};
use halflight::inspect::record_file::PathRecord;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut stream = data;
    let Ok(record) = PathRecord::read_bytes(&mut stream) else {
        return;
    };
    let all: Vec<u32> = (0..record.paths.len() as u32).collect();
    let tree = ClusterTree::of(&record, all.clone(), ClusterBy::Object, ClusterFrom::Light);
    assert_eq!(tree.order.len(), record.paths.len());
    let places = Places::of(&record);
    let found = bundles(&record, &places, vec![all], 8);
    let paths: usize = found.iter().map(|b| b.paths.len()).sum();
    assert_eq!(paths, record.paths.len());
});
