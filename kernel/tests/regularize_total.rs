//! Regularisation on hostile parameters: no panic, nothing that is not finite. The fuzz target `regularize` runs the same
//! body.

#[path = "common/hostile_regularization.rs"]
mod hostile_regularization;
#[path = "common/primitives.rs"]
mod primitives;

use primitives::runner;
use proptest::prelude::*;
use std::cell::Cell;

#[test]
fn hostile_parameters_stay_finite() {
    let counts = Cell::new([0_u32; 2]);
    let bytes = (
        prop::collection::vec(any::<u8>(), 0..220),
        prop::sample::select(vec![0xff_u8, 0x0f, 0x83, 0x81]),
    );
    runner(20_000)
        .run(&bytes, |(mut bytes, mask)| {
            // Few different values, many of them extreme, in three quarters of the cases.
            for b in &mut bytes {
                *b &= mask;
            }
            let reached = hostile_regularization::check(&bytes);
            let [rougher, positive] = counts.get();
            counts.set([
                rougher + u32::from(reached.rougher),
                positive + u32::from(reached.positive),
            ]);
            Ok(())
        })
        .unwrap();
    let [rougher, positive] = counts.get();
    println!("{rougher} of 20000 cases made a lobe rougher, {positive} had a value");
    assert!(rougher > 4000 && positive > 2000);
}
