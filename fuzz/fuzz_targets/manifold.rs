//! Half-vector chains where they have poles: see the module that the kernel's own test shares.
#![no_main]

#[path = "../../kernel/tests/common/hostile_chains.rs"]
mod hostile_chains;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    hostile_chains::check(bytes);
});
