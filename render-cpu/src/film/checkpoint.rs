//! Checkpoints: a film in progress in a file, from which a run continues to the bit-identical image.
//!
//! Layout, little endian:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `HLFILM\r\n`; the line end catches transfers that rewrite text |
//! | 4 | version of the layout: 1, or 2 where samples are pending |
//! | 4 | length of the header |
//! | ... | header, JSON: settings of the run, progress, layout of the film |
//! | 64 per pixel | count u32, rejected u32, then mean (3), m2 (3) and luminance m2 as f64 |
//! | 8 per sum | sums of the output variables and of the parts by path expressions, f64 |
//! | 4 per pixel | in version 2: samples that a pass which was cut still owes, u32 |
//! | 4 | CRC-32 of everything before |
//!
//! Adaptive sampling keeps no other state of its own: it is a function of the film between passes.
//!
//! A reader validates everything: the length of the file must be the one that the header implies before anything of
//! that size is allocated, the checksum must agree, and every number must be one that a film can hold. A run with other
//! settings is refused by name and value of what differs, because its samples would not be those of the same image.

use crate::atomic_file::{WriteError, write_atomically};
use crate::film::aov::AovSet;
use crate::film::chain_counts::{ChainCounts, KeptCounts};
use crate::film::pending_samples::PendingSamples;
use crate::film::{Film, FilmError, PixelStatistics};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"HLFILM\r\n";
const VERSION: u32 = 1;
const VERSION_WITH_OWED: u32 = 2;
const FIXED_LENGTH: u64 = 16;
const CHECKSUM_LENGTH: u64 = 4;
const PIXEL_LENGTH: usize = 64;
const SUM_LENGTH: usize = 8;
const OWED_LENGTH: usize = 4;
const MAX_HEADER_LENGTH: u32 = 1 << 20;
/// Pixels or sums that are converted at a time.
const BATCH: usize = 4096;

/// Name of the setting with the path of the scene.
const SCENE: &str = "scene";

/// End of the names of settings that are not read.
pub(crate) const DIGEST: &str = " (digest)";

/// What decides the numbers of an image, by name: scene and its hash, size, seed, integrator, sampler, version ...
pub type Settings = BTreeMap<String, String>;

/// The contents of a checkpoint beside its film.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The settings that decide the numbers of the image.
    pub settings: Settings,
    /// Passes that are complete.
    pub passes: u32,
    /// Index of the next sample of a pixel in a run that samples uniformly.
    pub next_sample: u32,
    /// Seconds spent rendering so far.
    pub render_seconds: f64,
}

#[derive(Serialize, Deserialize)]
struct Header {
    progress: Progress,
    width: u32,
    height: u32,
    crop_offset: [u32; 2],
    aovs: Vec<String>,
    /// Names of the parts by path expressions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    parts: Vec<String>,
    /// Samples per pixel of a pass that was cut.
    #[serde(default)]
    owed_per_pixel: u32,
    #[serde(flatten)]
    chains: KeptCounts,
}

/// Why a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file could not be opened or read.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The bytes are no checkpoint, or a damaged one.
    #[error("{}: {what}", file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The film does not fit.
    #[error("{}: {source}", file.display())]
    Film {
        /// The file.
        file: PathBuf,
        /// Why.
        source: FilmError,
    },
    /// The checkpoint is of another image.
    #[error("{}: the checkpoint is of another render: {differences}", file.display())]
    OtherSettings {
        /// The file.
        file: PathBuf,
        /// Names and values of what differs.
        differences: String,
    },
}

/// Writes a checkpoint, atomically.
///
/// # Errors
/// If the file cannot be written; the previous checkpoint is still there then.
pub fn save_checkpoint(path: &Path, progress: &Progress, film: &Film) -> Result<(), WriteError> {
    write_atomically(path, |file| write_checkpoint(file, progress, film))
}

/// Writes a checkpoint to a stream.
///
/// # Errors
/// If the stream does not take it.
pub fn write_checkpoint(
    stream: &mut impl Write,
    progress: &Progress,
    film: &Film,
) -> io::Result<()> {
    let header = Header {
        progress: progress.clone(),
        width: film.width(),
        height: film.height(),
        crop_offset: film.crop_offset(),
        aovs: film
            .aovs()
            .iter()
            .map(|aov| aov.name().to_owned())
            .collect(),
        parts: film.parts().to_vec(),
        owed_per_pixel: film.pending().map_or(0, |pending| pending.per_pixel),
        chains: film.chain_counts().kept(),
    };
    let version = match film.pending() {
        Some(_) => VERSION_WITH_OWED,
        None => VERSION,
    };
    let header = serde_json::to_vec(&header)?;
    let header_length = u32::try_from(header.len())
        .ok()
        .filter(|&length| length <= MAX_HEADER_LENGTH);
    let header_length = header_length
        .ok_or_else(|| io::Error::other("the settings are too long for a checkpoint"))?;

    let mut checksum = flate2::Crc::new();
    let mut put = |bytes: &[u8]| {
        checksum.update(bytes);
        stream.write_all(bytes)
    };
    put(&MAGIC)?;
    put(&version.to_le_bytes())?;
    put(&header_length.to_le_bytes())?;
    put(&header)?;
    let mut buffer = Vec::with_capacity(BATCH * PIXEL_LENGTH);
    for batch in film.statistics().chunks(BATCH) {
        buffer.clear();
        for p in batch {
            buffer.extend_from_slice(&p.count.to_le_bytes());
            buffer.extend_from_slice(&p.rejected.to_le_bytes());
            for v in p.mean.iter().chain(&p.m2).chain([&p.luminance_m2]) {
                buffer.extend_from_slice(&v.to_le_bytes());
            }
        }
        put(&buffer)?;
    }
    for batch in film.aov_sums().chunks(BATCH) {
        buffer.clear();
        for v in batch {
            buffer.extend_from_slice(&v.to_le_bytes());
        }
        put(&buffer)?;
    }
    for batch in film
        .pending()
        .map_or(&[][..], |pending| &pending.counts)
        .chunks(BATCH)
    {
        buffer.clear();
        for count in batch {
            buffer.extend_from_slice(&count.to_le_bytes());
        }
        put(&buffer)?;
    }
    let checksum = checksum.sum();
    stream.write_all(&checksum.to_le_bytes())
}

/// Reads a checkpoint and makes sure that it is of the run that `settings` describe.
///
/// # Errors
/// If the file cannot be read, is damaged, or is a checkpoint of another image.
pub fn load_checkpoint(
    path: &Path,
    settings: &Settings,
) -> Result<(Progress, Film), CheckpointError> {
    let io_error = |source| CheckpointError::Io {
        file: path.to_owned(),
        source,
    };
    let file = File::open(path).map_err(io_error)?;
    let length = file.metadata().map_err(io_error)?.len();
    let (progress, film) = read_checkpoint(&mut BufReader::new(file), length, path)?;
    let differences = settings_differences(&progress.settings, settings);
    if !differences.is_empty() {
        return Err(CheckpointError::OtherSettings {
            file: path.to_owned(),
            differences,
        });
    }
    Ok((progress, film))
}

/// What differs between the settings of a checkpoint and those of a run, in words; empty if nothing does. The path of the scene
/// does not count: its content does. Digests are named where nothing else distinguishes the two.
pub fn settings_differences(checkpoint: &Settings, run: &Settings) -> String {
    let mut differences = Vec::new();
    let mut digests = Vec::new();
    let names: std::collections::BTreeSet<&String> = checkpoint.keys().chain(run.keys()).collect();
    for name in names {
        match (checkpoint.get(name), run.get(name)) {
            (Some(a), Some(b)) if a == b || name == SCENE => {}
            (None, None) => {}
            _ if name.ends_with(DIGEST) => {
                digests.push(format!(
                    "they differ in the {}",
                    name.trim_end_matches(DIGEST)
                ));
            }
            (Some(a), Some(b)) => differences.push(format!("{name} is {a} there and {b} here")),
            (Some(a), None) => differences.push(format!("{name} is {a} there and not set here")),
            (None, Some(b)) => differences.push(format!("{name} is not set there and {b} here")),
        }
    }
    if differences.is_empty() {
        differences = digests;
    }
    differences.join("; ")
}

/// Reads a checkpoint of `length` bytes from a stream; `file` is for messages only.
///
/// # Errors
/// If the stream ends early, or its content is not what [`write_checkpoint`] writes.
pub fn read_checkpoint(
    stream: &mut impl Read,
    length: u64,
    file: &Path,
) -> Result<(Progress, Film), CheckpointError> {
    let malformed = |what: String| CheckpointError::Malformed {
        file: file.to_owned(),
        what,
    };
    let damaged = |what: &str| malformed(format!("damaged checkpoint: {what}"));
    let read_error = |source: io::Error| match source.kind() {
        io::ErrorKind::UnexpectedEof => damaged("it ends too early"),
        _ => CheckpointError::Io {
            file: file.to_owned(),
            source,
        },
    };
    let mut checksum = flate2::Crc::new();
    let mut take = |buffer: &mut [u8]| {
        stream.read_exact(buffer).map_err(read_error)?;
        checksum.update(buffer);
        Ok::<(), CheckpointError>(())
    };

    let mut magic = [0; 8];
    take(&mut magic)?;
    if magic != MAGIC {
        return Err(malformed("this is no checkpoint of Halflight".into()));
    }
    let mut word = [0; 4];
    take(&mut word)?;
    let version = u32::from_le_bytes(word);
    if version != VERSION && version != VERSION_WITH_OWED {
        return Err(malformed(format!(
            "the checkpoint has layout {version}, this program reads {VERSION} and {VERSION_WITH_OWED}"
        )));
    }
    take(&mut word)?;
    let header_length = u32::from_le_bytes(word);
    if header_length > MAX_HEADER_LENGTH || u64::from(header_length) > length {
        return Err(damaged("its header is too long"));
    }
    let mut header = vec![0; header_length as usize];
    take(&mut header)?;
    let header: Header =
        serde_json::from_slice(&header).map_err(|e| damaged(&format!("its header: {e}")))?;
    if !header.progress.render_seconds.is_finite() {
        return Err(damaged("its time is not finite"));
    }
    let aovs: AovSet = header
        .aovs
        .iter()
        .map(|name| name.parse())
        .collect::<Result<_, crate::film::aov::UnknownAov>>()
        .map_err(|e| damaged(&e.to_string()))?;

    // Nothing of the film's size is allocated before the file is known to hold it.
    let pixels = u64::from(header.width) * u64::from(header.height);
    let owes = version == VERSION_WITH_OWED;
    let mut bytes_per_pixel =
        (PIXEL_LENGTH + aovs.sums_per_pixel(header.parts.len()) * SUM_LENGTH) as u64;
    if owes {
        bytes_per_pixel += OWED_LENGTH as u64;
    }
    let expected = pixels.checked_mul(bytes_per_pixel).and_then(|bytes| {
        bytes.checked_add(FIXED_LENGTH + u64::from(header_length) + CHECKSUM_LENGTH)
    });
    if expected != Some(length) {
        return Err(damaged(&format!(
            "{} x {} pixels do not fill its {length} bytes",
            header.width, header.height
        )));
    }
    let [width, height] = [header.width, header.height];
    let film = Film::with_parts(width, height, header.crop_offset, aovs, header.parts);
    let mut film = film.map_err(|source| CheckpointError::Film {
        file: file.to_owned(),
        source,
    })?;

    let (statistics, sums) = film.buffers_mut();
    let mut buffer = vec![0; BATCH * PIXEL_LENGTH];
    for batch in statistics.chunks_mut(BATCH) {
        let bytes = &mut buffer[..batch.len() * PIXEL_LENGTH];
        take(bytes)?;
        for (p, bytes) in batch.iter_mut().zip(bytes.chunks_exact(PIXEL_LENGTH)) {
            *p = pixel_from_bytes(bytes)
                .ok_or_else(|| damaged("a pixel holds numbers that no samples have"))?;
        }
    }
    for batch in sums.chunks_mut(BATCH) {
        let bytes = &mut buffer[..batch.len() * SUM_LENGTH];
        take(bytes)?;
        for (v, bytes) in batch.iter_mut().zip(bytes.chunks_exact(SUM_LENGTH)) {
            *v = f64_at(bytes, 0);
            if !v.is_finite() {
                return Err(damaged("an output variable is not finite"));
            }
        }
    }
    if owes {
        let mut counts = vec![0; film.statistics().len()];
        for batch in counts.chunks_mut(BATCH) {
            let bytes = &mut buffer[..batch.len() * OWED_LENGTH];
            take(bytes)?;
            for (count, bytes) in batch.iter_mut().zip(bytes.chunks_exact(OWED_LENGTH)) {
                *count = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            }
        }
        *film.pending_mut() = Some(PendingSamples {
            per_pixel: header.owed_per_pixel,
            counts,
        });
    }
    *film.chain_counts_mut() = ChainCounts::of_kept(&header.chains);
    let computed = checksum.sum();
    stream.read_exact(&mut word).map_err(read_error)?;
    if u32::from_le_bytes(word) != computed {
        return Err(damaged("its checksum does not agree with its content"));
    }
    Ok((header.progress, film))
}

/// A pixel from its record; `None` for numbers that no samples have.
fn pixel_from_bytes(bytes: &[u8]) -> Option<PixelStatistics> {
    let p = PixelStatistics {
        count: u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        rejected: u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]),
        mean: [f64_at(bytes, 8), f64_at(bytes, 16), f64_at(bytes, 24)],
        m2: [f64_at(bytes, 32), f64_at(bytes, 40), f64_at(bytes, 48)],
        luminance_m2: f64_at(bytes, 56),
    };
    let finite = p.mean.iter().chain(&p.m2).all(|v| v.is_finite()) && p.luminance_m2.is_finite();
    (finite && p.rejected <= p.count).then_some(p)
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}
