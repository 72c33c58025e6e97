//! Checkpoints: the checksum is made to agree, so that what it guards is reached.
#![no_main]

use halflight::film::checkpoint::{read_checkpoint, write_checkpoint};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("fuzz.checkpoint");
    let _ = read_checkpoint(&mut &bytes[..], bytes.len() as u64, file);
    let Some(content) = bytes.len().checked_sub(4).map(|end| &bytes[..end]) else {
        return;
    };
    // CRC-32 (IEEE), bit by bit.
    let mut checksum = u32::MAX;
    for byte in content {
        checksum ^= u32::from(*byte);
        for _ in 0..8 {
            checksum = (checksum >> 1) ^ (0xedb8_8320 & (checksum & 1).wrapping_neg());
        }
    }
    let sealed = [content, &(!checksum).to_le_bytes()].concat();
    if let Ok((mut progress, film)) = read_checkpoint(&mut &sealed[..], sealed.len() as u64, file) {
        // What is accepted survives another round, bit for bit; the decimal number of the time need not.
        progress.render_seconds = 0.0;
        let mut first = Vec::new();
        write_checkpoint(&mut first, &progress, &film).expect("memory takes everything");
        let (progress, film) =
            read_checkpoint(&mut &first[..], first.len() as u64, file).expect("our own checkpoint");
        let mut second = Vec::new();
        write_checkpoint(&mut second, &progress, &film).expect("memory takes everything");
        assert_eq!(first, second);
    }
});
