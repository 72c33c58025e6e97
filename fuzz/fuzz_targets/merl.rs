//! Measured reflectance of the MERL database. Run with `cargo fuzz run merl`, see `Cargo.toml`.
//!
//! What can be read must give a table whose every number is finite. The input is also read behind a small valid header,
//! since random lengths hardly ever agree with random headers.
#![no_main]

use halflight::measured::merl::Merl;

fn read(bytes: &[u8]) {
    if let Ok(measured) = Merl::read(bytes) {
        assert!(measured.table().iter().all(|x| x.is_finite() && *x >= 0.0));
    }
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    read(data);
    let mut bytes: Vec<u8> = [2_i32, 3, 4].iter().flat_map(|n| n.to_le_bytes()).collect();
    bytes.extend(data);
    bytes.resize(12 + 24 * 24, 0);
    read(&bytes);
});
