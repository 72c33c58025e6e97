//! Scene files as text with line numbers, and how file names in them are resolved.
//!
//! A text is UTF-8 unless a byte order mark or an XML declaration at its start names another encoding, or its first character
//! shows that it is UTF-16; what is none of these is Windows-1252.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::lenient::repair;
use crate::bytes::{image_format, mistaken};
use crate::scene::error::{Location, SceneError};

/// The text of a file and where its lines start.
pub struct Source {
    /// The file, as named in messages.
    pub path: Arc<Path>,
    /// Its text.
    pub text: String,
    /// What of it is not read as it stands, each with its line.
    pub notes: Vec<Note>,
    line_starts: Vec<usize>,
}

impl Source {
    /// A text under a file name, repaired to well-formed XML where that is possible.
    pub fn new(path: &Path, text: &str) -> Source {
        let repaired = repair(text);
        let mut source = Source::of_lines(path, repaired.text.into_owned());
        let notes = repaired.notes.into_iter();
        source.notes = notes.map(|(line, what)| (line, what.to_owned())).collect();
        source
    }

    /// A text that needs no decoding, under a file name.
    fn of_lines(path: &Path, text: String) -> Source {
        let line_starts = std::iter::once(0)
            .chain(text.match_indices('\n').map(|(at, _)| at + 1))
            .collect();
        Source {
            path: path.into(),
            text,
            notes: Vec::new(),
            line_starts,
        }
    }

    /// Reads a scene file of at most `budget` bytes, which is reduced by its size.
    pub fn read(path: &Path, budget: &mut u64) -> Result<Source, SceneError> {
        let (text, note) = decode(path, read_bytes(path, *budget)?)?;
        *budget = budget.saturating_sub(text.len() as u64);
        let mut source = Source::new(path, &text);
        source.notes.extend(note);
        Ok(source)
    }

    /// The location of a byte.
    pub fn location(&self, byte: usize) -> Location {
        let line = self.line_starts.partition_point(|&start| start <= byte) - 1;
        let start = self.line_starts[line];
        let column = self
            .text
            .get(start..byte)
            .map_or(byte - start, |before| before.chars().count());
        Location {
            file: self.path.clone(),
            line: (line + 1) as u32,
            column: (column + 1) as u32,
        }
    }
}

/// Finds a file or folder: by its absolute path, or in the search paths in order.
///
/// Files written on Windows name folders with backslashes; where such a file does not exist, slashes are tried.
pub fn find(search_paths: &[PathBuf], name: &str) -> Option<PathBuf> {
    find_as_written(search_paths, name).or_else(|| {
        name.contains('\\')
            .then(|| find_as_written(search_paths, &name.replace('\\', "/")))
            .flatten()
    })
}

fn find_as_written(search_paths: &[PathBuf], name: &str) -> Option<PathBuf> {
    // An embedded zero byte makes `exists` fail, which is what is wanted.
    if name.is_empty() {
        return None;
    }
    let path = Path::new(name);
    if path.is_absolute() {
        return path.exists().then(|| path.to_path_buf());
    }
    search_paths
        .iter()
        .map(|folder| folder.join(path))
        .find(|path| path.exists())
}

/// The search paths with one more in front.
pub fn prepended(search_paths: &[PathBuf], folder: PathBuf) -> Arc<[PathBuf]> {
    std::iter::once(folder)
        .chain(search_paths.iter().cloned())
        .collect()
}

/// What is said of an image instead of a scene.
fn is_an_image(format: &str) -> String {
    format!("is no scene file, but an image of the format {format}")
}

/// Whether a file instead of a scene is an image, which is an error in the words of [`Source::read`]. Files that cannot be read
/// are none.
pub fn refuse_image(path: &Path) -> Result<(), SceneError> {
    /// More than what tells formats.
    const START: u64 = 64;
    let mut start = Vec::new();
    let is_file = path.metadata().is_ok_and(|metadata| metadata.is_file());
    let read = |file: File| file.take(START).read_to_end(&mut start);
    if !is_file || File::open(path).and_then(read).is_err() {
        return Ok(());
    }
    match image_format(&start) {
        Some(format) => Err(SceneError::file(path, is_an_image(&format))),
        None => Ok(()),
    }
}

/// The text of a scene file of at most `limit` bytes, repaired to well-formed XML where that is possible.
///
/// # Errors
/// If it cannot be read, is no text, or an image.
pub fn read_repaired(path: &Path, limit: u64) -> Result<String, SceneError> {
    let mut budget = limit;
    Ok(Source::read(path, &mut budget)?.text)
}

/// Reads a text file of at most `limit` bytes.
pub fn read_text(path: &Path, limit: u64) -> Result<String, SceneError> {
    Ok(decode(path, read_bytes(path, limit)?)?.0)
}

fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, SceneError> {
    let fail = |error: std::io::Error| SceneError::file(path, format!("cannot be read: {error}"));
    let file = File::open(path).map_err(fail)?;
    // Opening a folder succeeds on some systems; a device or a pipe may never end.
    if !file.metadata().map_err(fail)?.is_file() {
        return Err(SceneError::file(path, "is not a regular file"));
    }
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > limit {
        return Err(SceneError::file(
            path,
            format!("is larger than the limit of {limit} bytes"),
        ));
    }
    if let Some(what) = mistaken(path, &bytes) {
        return Err(SceneError::file(path, what));
    }
    if let Some(format) = image_format(&bytes) {
        return Err(SceneError::file(path, is_an_image(&format)));
    }
    Ok(bytes)
}

/// A line, and what is to be said of it.
pub type Note = (u32, String);

/// The text of a file, decoded from the encoding that it declares, or that its bytes show; and what is wrong with its declaration.
pub fn decode(path: &Path, bytes: Vec<u8>) -> Result<(String, Option<Note>), SceneError> {
    let mut note = None;
    let (encoding, mark) = match (Encoding::for_bom(&bytes), &bytes[..]) {
        (Some(found), _) => found,
        (None, [b'<', 0, ..]) => (UTF_16LE, 0),
        (None, [0, b'<', ..]) => (UTF_16BE, 0),
        (None, _) => match declared_encoding(&bytes) {
            Ok(encoding) => (encoding, 0),
            Err(label) => {
                let what =
                    format!("the encoding \"{label}\" is not known; the file is read as UTF-8");
                note = Some((1, what));
                (UTF_8, 0)
            }
        },
    };
    if encoding != UTF_8 {
        let (text, had_errors) = encoding.decode_without_bom_handling(&bytes[mark..]);
        if had_errors {
            let message = format!("is not text in the encoding {}", encoding.name());
            return Err(SceneError::file(path, message));
        }
        return Ok((text.into_owned(), note));
    }
    let mut bytes = bytes;
    bytes.drain(..mark);
    Ok(match String::from_utf8(bytes) {
        Ok(text) => (text, note),
        Err(error) if error.as_bytes().contains(&0) => {
            return Err(SceneError::file(path, "is no text"));
        }
        Err(error) => {
            let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
            let line = valid.iter().filter(|&&b| b == b'\n').count() + 1;
            let what = "no UTF-8, and no other encoding is named; the file is read as Windows-1252";
            let (text, _) = WINDOWS_1252.decode_without_bom_handling(error.as_bytes());
            (text.into_owned(), Some((line as u32, what.to_owned())))
        }
    })
}

/// The encoding of an XML declaration, or UTF-8; the label of one that is not known is the error.
fn declared_encoding(bytes: &[u8]) -> Result<&'static Encoding, String> {
    /// Longer than any declaration.
    const MAX_DECLARATION: usize = 256;
    let start = bytes.trim_ascii_start();
    let start = String::from_utf8_lossy(&start[..start.len().min(MAX_DECLARATION)]);
    let label = start
        .strip_prefix("<?xml")
        .and_then(|rest| rest.split_once("?>"))
        .and_then(|(declaration, _)| declaration.split_once("encoding"))
        .and_then(|(_, value)| {
            let value = value.trim_start().strip_prefix('=')?.trim_start();
            let quote = value.chars().next().filter(|c| matches!(c, '"' | '\''))?;
            value[1..].split(quote).next()
        });
    let Some(label) = label else {
        return Ok(UTF_8);
    };
    // A declaration that can be read as bytes cannot be in UTF-16: such files were converted, and kept their label.
    if label.to_ascii_lowercase().starts_with("utf-16") {
        return Ok(UTF_8);
    }
    Encoding::for_label(label.as_bytes()).ok_or_else(|| label.to_owned())
}
