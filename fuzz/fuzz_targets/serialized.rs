//! Mitsuba's `.serialized`. Run with `cargo fuzz run serialized`, see `Cargo.toml`.
//!
//! The input is read twice: as a whole file, and as what the zlib stream of a file with one mesh decompresses to, since
//! random changes of compressed bytes hardly ever get past the checksum.
#![no_main]

use halflight::mesh::serialized;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let file = Path::new("fuzz.serialized");
    let _ = serialized::read(data, 0, file);
    // zlib with stored blocks.
    let mut bytes = vec![0x1c, 0x04, 0x04, 0x00, 0x78, 0x01];
    let mut blocks = data.chunks(0xffff).peekable();
    while let Some(block) = blocks.next() {
        bytes.push(u8::from(blocks.peek().is_none()));
        bytes.extend((block.len() as u16).to_le_bytes());
        bytes.extend((!(block.len() as u16)).to_le_bytes());
        bytes.extend(block);
    }
    bytes.extend([0; 8]);
    bytes.extend(1_u32.to_le_bytes());
    let _ = serialized::read(&bytes, 0, file);
});
