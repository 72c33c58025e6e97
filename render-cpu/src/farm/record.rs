//! Records of finished films: length and SHA-256 of a file, and of the files that it was made from.
//!
//! A record is written after its film, both atomically, and lies beside it as `NAME.json`. A film without a record is not
//! finished; one whose bytes do not agree with its record is *torn*: cut off by a full disk, damaged in transfer, replaced.

use super::error::FarmError;
use crate::atomic_file::write_atomically;
use crate::bytes::read_file;
use crate::film::Film;
use crate::film::checkpoint::{CheckpointError, Progress, read_checkpoint};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Longest record that is read.
const MAX_RECORD_BYTES: u64 = 1 << 20;

/// What is known of a finished film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Length of the file.
    pub bytes: u64,
    /// Samples per pixel.
    pub samples: u32,
    /// Seconds spent rendering.
    pub seconds: f64,
    /// Digests of the films that it was merged from; empty for a task's.
    pub inputs: Vec<String>,
}

/// Where the record of a film is.
pub fn record_file(film: &Path) -> PathBuf {
    film.with_extension("json")
}

impl Record {
    /// Reads the record of a film; `None` when there is none.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read(film: &Path) -> Result<Option<Record>, FarmError> {
        let file = record_file(film);
        match read_file(&file, MAX_RECORD_BYTES) {
            // A malformed record counts as a missing one: its film is made again.
            Ok(bytes) => Ok(serde_json::from_slice(&bytes).ok()),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(FarmError::Io { file, source }),
        }
    }

    /// Writes the record of a film that is there, from its bytes.
    ///
    /// # Errors
    /// When the film cannot be read or the record cannot be written.
    pub fn write(
        film: &Path,
        samples: u32,
        seconds: f64,
        inputs: Vec<String>,
    ) -> Result<Record, FarmError> {
        let io = |source| FarmError::Io {
            file: film.to_owned(),
            source,
        };
        let mut reader = Hashing::new(File::open(film).map_err(io)?);
        io::copy(&mut reader, &mut io::sink()).map_err(io)?;
        let (sha256, bytes) = reader.finish();
        let record = Record {
            sha256,
            bytes,
            samples,
            seconds,
            inputs,
        };
        write_atomically(&record_file(film), |file| {
            serde_json::to_writer_pretty(&mut *file, &record)?;
            file.write_all(b"\n")
        })?;
        Ok(record)
    }

    /// Whether the film has the recorded length, which needs no reading.
    pub fn has_length(&self, film: &Path) -> bool {
        std::fs::metadata(film).is_ok_and(|m| m.is_file() && m.len() == self.bytes)
    }

    /// Reads the film and compares its bytes with the record; `None` if they differ.
    ///
    /// # Errors
    /// When the file cannot be read although its bytes are those of the record.
    pub fn load(&self, film: &Path) -> Result<Option<(Progress, Film)>, FarmError> {
        if !self.has_length(film) {
            return Ok(None);
        }
        let io = |source| FarmError::Io {
            file: film.to_owned(),
            source,
        };
        let mut reader = Hashing::new(BufReader::new(File::open(film).map_err(io)?));
        match read_checkpoint(&mut reader, self.bytes, film) {
            Ok(content) => Ok((reader.finish().0 == self.sha256).then_some(content)),
            Err(CheckpointError::Io { source, .. }) => Err(io(source)),
            Err(error) => {
                // Torn, or written by another version: the digest tells.
                if self.is_of(film)? {
                    Err(error.into())
                } else {
                    Ok(None)
                }
            }
        }
    }

    /// Whether the film's bytes are those of the record.
    ///
    /// # Errors
    /// When the file is there but cannot be read.
    pub fn is_of(&self, film: &Path) -> Result<bool, FarmError> {
        if !self.has_length(film) {
            return Ok(false);
        }
        let io = |source| FarmError::Io {
            file: film.to_owned(),
            source,
        };
        let mut reader = Hashing::new(File::open(film).map_err(io)?);
        io::copy(&mut reader, &mut io::sink()).map_err(io)?;
        Ok(reader.finish().0 == self.sha256)
    }
}

/// A reader that digests what it reads.
struct Hashing<R> {
    inner: R,
    digest: Sha256,
    bytes: u64,
}

impl<R: Read> Hashing<R> {
    fn new(inner: R) -> Hashing<R> {
        Hashing {
            inner,
            digest: Sha256::new(),
            bytes: 0,
        }
    }

    /// The digest, hexadecimal, and the number of bytes.
    fn finish(self) -> (String, u64) {
        let digest = self.digest.finalize();
        let hex = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        (hex, self.bytes)
    }
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.digest.update(&buffer[..read]);
        self.bytes += read as u64;
        Ok(read)
    }
}
