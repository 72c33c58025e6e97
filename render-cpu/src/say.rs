//! Lines for people and programs that may not be readable any more.
//!
//! The macros of the standard library end the program where a line cannot be written: a full disk, or a pipe whose reader has
//! gone. A failed message must not cost the image.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

/// Writes a line on standard error; where that cannot be done, nothing happens.
pub fn note(line: impl Display) {
    // In one piece, so that lines of two threads do not mix.
    let _ = io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// Writes text on standard output. Who has closed it has read enough: that is no error.
///
/// # Errors
/// When the text cannot be written, on a full disk for instance.
pub fn print(text: impl Display) -> io::Result<()> {
    let mut output = io::stdout().lock();
    let written = output
        .write_all(text.to_string().as_bytes())
        .and_then(|()| output.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(io::Error::new(
            error.kind(),
            format!("cannot write to standard output: {error}"),
        )),
        _ => Ok(()),
    }
}

/// Writes a line on standard output; see [`print()`].
///
/// # Errors
/// When the line cannot be written.
pub fn print_line(line: impl Display) -> io::Result<()> {
    print(format_args!("{line}\n"))
}

/// Standard error for those who would complain where it cannot be written.
#[derive(Clone, Copy, Debug, Default)]
pub struct Notes;

impl Write for Notes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = io::stderr().write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
