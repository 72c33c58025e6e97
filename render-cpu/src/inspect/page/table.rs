//! Tables of numbers as text of an element of a page.

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Write};

/// Writes bytes, which are little-endian words, as the element `blob-NAME`.
pub(super) fn write_table(stream: &mut impl Write, name: &str, bytes: &[u8]) -> io::Result<()> {
    const { assert!(cfg!(target_endian = "little")) };
    write!(stream, "<script type=\"text/plain\" id=\"blob-{name}\">")?;
    let mut encoder = EncoderWriter::new(&mut *stream, &STANDARD);
    let mut deflate = ZlibEncoder::new(&mut encoder, Compression::fast());
    deflate.write_all(bytes)?;
    deflate.finish()?;
    encoder.finish()?;
    drop(encoder);
    writeln!(stream, "</script>")
}
