//! The manifold on hostile chains: no panic, nothing that is not finite. The fuzz target `manifold` runs the same body.

#[path = "common/mod.rs"]
mod common;
#[path = "common/hostile_chains.rs"]
mod hostile_chains;

use common::Random;

/// Number of random chains.
const HOSTILE: usize = 40_000;

/// Random bytes, and the same with few different values, which makes coincidences.
#[test]
fn hostile_chains_stay_finite() {
    let mut random = Random(99);
    let (mut regular, mut moved) = (0, 0);
    for round in 0..HOSTILE {
        let mask = [0xff, 0x0f, 0x1f, 0x83][round % 4];
        let bytes: Vec<u8> = (0..640).map(|_| random.bits() as u8 & mask).collect();
        let reached = hostile_chains::check(&bytes);
        regular += usize::from(reached.0);
        moved += usize::from(reached.1);
    }
    println!("{regular} of {HOSTILE} chains are regular, {moved} could be mutated");
    assert!(regular * 6 > HOSTILE && moved * 20 > HOSTILE);
}

#[test]
fn short_inputs_stay_finite() {
    for length in 0..6 {
        for value in 0..=255u8 {
            hostile_chains::check(&vec![value; 40 * length]);
        }
    }
}
