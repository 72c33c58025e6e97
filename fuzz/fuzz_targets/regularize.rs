//! Regularised scattering where it has poles: see the module that the kernel's own test shares.
#![no_main]

#[path = "../../kernel/tests/common/hostile_regularization.rs"]
mod hostile_regularization;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    hostile_regularization::check(bytes);
});
