//! Records of paths, and their files.
//!
//! Two formats, by the name of the file. `.jsonl`: a line with what the whole has in common, then a line for each path. Any other
//! name: bytes, little endian:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `HLPATHS\n` |
//! | 4 | version of the layout: 1 |
//! | 4 | length of the header |
//! | ... | header, JSON: see [`RecordHeader`] |
//! | per path: 8 | pixel, x and y in the whole film, u32 each |
//! | 12 | light that it added to the pixel's sample, f32 RGB |
//! | 4 | luminance that it stands for, f32 |
//! | 4 | number of vertices, u32 |
//! | per vertex: 32 | position, 3 f32; kind, u32; object, u32; throughput, 3 f32 ([`RecordedVertex`]) |
//!
//! Vertices go from the sensor to the light.

use crate::atomic_file::{WriteError, write_atomically};
use halflight_kernel::path::expression::scattering;
use halflight_kernel::scene::NONE;
use halflight_kernel::transport::recorded::{RecordedVertex, vertex_kind};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::io::{self, Read, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"HLPATHS\n";
const VERSION: u32 = 1;
/// Longest header that is read.
const MAX_HEADER: u32 = 1 << 28;
/// Most vertices of a path.
pub const MAX_VERTICES: usize = 64;
/// Bytes of a path without its vertices.
const PATH_BYTES: usize = 28;

/// A path that was kept.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedPath {
    /// Its pixel in the whole film.
    pub pixel: [u32; 2],
    /// The light that it added to a sample of the pixel.
    pub light: [f32; 3],
    /// Luminance that it stands for.
    pub weight: f32,
    /// From the sensor to the light.
    pub vertices: Vec<RecordedVertex>,
}

impl RecordedPath {
    /// Whether it leads from a sensor over surfaces to a light, with numbers that are finite.
    fn is_sound(&self) -> bool {
        let is_finite = |v: &RecordedVertex| {
            let numbers = v.position.iter().chain(&v.throughput);
            numbers.copied().all(f32::is_finite)
        };
        let [first, inner @ .., last] = &self.vertices[..] else {
            return false;
        };
        first.kind == vertex_kind::SENSOR
            && inner.iter().all(|v| v.kind < scattering::COUNT)
            && (last.kind == vertex_kind::LIGHT || last.kind == vertex_kind::LIGHT_AT_INFINITY)
            && self.vertices.iter().all(is_finite)
            && self.weight >= 0.0
            && self.weight.is_finite()
    }
}

/// What all paths of a record have in common.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordHeader {
    /// Number of paths.
    pub count: usize,
    /// Number of paths that added light, among which they were chosen.
    pub found: u64,
    /// Sum of the luminance of all of them.
    pub luminance: f64,
    /// Samples per pixel that were looked at.
    pub samples: u32,
    /// Seed.
    pub seed: u32,
    /// Expression that all paths match, if there is one.
    pub expression: Option<String>,
    /// Names of the kinds of vertices, by number.
    pub kinds: Vec<String>,
    /// Names of the shapes, by number.
    pub shapes: Vec<String>,
    /// Material of each shape, by its name.
    pub materials: Vec<String>,
    /// Names of the emitters, by number.
    pub emitters: Vec<String>,
}

/// A record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathRecord {
    /// What the paths have in common.
    pub header: RecordHeader,
    /// The paths, in the order of the film and of samples.
    pub paths: Vec<RecordedPath>,
}

/// A kind of vertex in the notation of expressions.
pub fn kind_name(kind: u32) -> &'static str {
    match kind {
        scattering::DIFFUSE_REFLECTION => "D^R",
        scattering::DIFFUSE_TRANSMISSION => "D^T",
        scattering::GLOSSY_REFLECTION => "G^R",
        scattering::GLOSSY_TRANSMISSION => "G^T",
        scattering::SPECULAR_REFLECTION => "S^R",
        scattering::SPECULAR_TRANSMISSION => "S^T",
        vertex_kind::LIGHT => "L",
        vertex_kind::LIGHT_AT_INFINITY => "B",
        _ => "E",
    }
}

impl PathRecord {
    /// Writes it to a file, in the format of its name.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), WriteError> {
        let is_lines = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("jsonl"));
        write_atomically(path, |file| {
            if is_lines {
                self.write_lines(file)
            } else {
                self.write_bytes(file)
            }
        })
    }

    /// Writes the bytes.
    ///
    /// # Errors
    /// If the stream does not take them.
    pub fn write_bytes(&self, stream: &mut impl Write) -> io::Result<()> {
        let header = serde_json::to_vec(&self.header)?;
        stream.write_all(&MAGIC)?;
        stream.write_all(&VERSION.to_le_bytes())?;
        stream.write_all(&(header.len() as u32).to_le_bytes())?;
        stream.write_all(&header)?;
        for path in &self.paths {
            for word in path.pixel {
                stream.write_all(&word.to_le_bytes())?;
            }
            for value in path.light {
                stream.write_all(&value.to_le_bytes())?;
            }
            stream.write_all(&path.weight.to_le_bytes())?;
            stream.write_all(&(path.vertices.len() as u32).to_le_bytes())?;
            for vertex in &path.vertices {
                for word in bytemuck::cast::<RecordedVertex, [u32; 8]>(*vertex) {
                    stream.write_all(&word.to_le_bytes())?;
                }
            }
        }
        Ok(())
    }

    /// Reads the bytes.
    ///
    /// # Errors
    /// If they are not what [`PathRecord::write_bytes`] writes.
    pub fn read_bytes(stream: &mut impl Read) -> io::Result<PathRecord> {
        let wrong = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
        let mut magic = Vec::new();
        stream.take(MAGIC.len() as u64).read_to_end(&mut magic)?;
        if magic.starts_with(b"{\"") {
            return Err(wrong(
                "these are lines of JSON, which people and scripts read: a record for this has any other ending than .jsonl",
            ));
        }
        if magic != MAGIC {
            return Err(wrong("this is no record of paths"));
        }
        PathRecord::read_behind_magic(stream).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => wrong("the record ends too early"),
            _ => error,
        })
    }

    fn read_behind_magic(stream: &mut impl Read) -> io::Result<PathRecord> {
        let wrong = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
        let mut word = [0; 4];
        let mut next = |stream: &mut dyn Read| {
            stream.read_exact(&mut word)?;
            Ok::<u32, io::Error>(u32::from_le_bytes(word))
        };
        if next(stream)? != VERSION {
            return Err(wrong("the record has another layout"));
        }
        let length = next(stream)?;
        if length > MAX_HEADER {
            return Err(wrong("the header is too long"));
        }
        let mut bytes = Vec::new();
        stream.take(length.into()).read_to_end(&mut bytes)?;
        if bytes.len() < length as usize {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let header: RecordHeader =
            serde_json::from_slice(&bytes).map_err(|e| wrong(&format!("the header: {e}")))?;
        let mut paths = Vec::new();
        for _ in 0..header.count {
            let mut fixed = [0; PATH_BYTES];
            stream.read_exact(&mut fixed)?;
            let word = |i: usize| u32::from_le_bytes([0, 1, 2, 3].map(|b| fixed[4 * i + b]));
            let count = word(6) as usize;
            if count > MAX_VERTICES {
                return Err(wrong("a path has too many vertices"));
            }
            let mut vertices = Vec::with_capacity(count);
            for _ in 0..count {
                let mut words = [0; 8];
                for value in &mut words {
                    *value = next(stream)?;
                }
                vertices.push(bytemuck::cast::<[u32; 8], RecordedVertex>(words));
            }
            let path = RecordedPath {
                pixel: [word(0), word(1)],
                light: [2, 3, 4].map(|i| f32::from_bits(word(i))),
                weight: f32::from_bits(word(5)),
                vertices,
            };
            if !path.is_sound() {
                return Err(wrong("a path does not lead from a sensor to a light"));
            }
            paths.push(path);
        }
        Ok(PathRecord { header, paths })
    }

    /// Writes lines of JSON.
    ///
    /// # Errors
    /// If the stream does not take them.
    pub fn write_lines(&self, stream: &mut impl Write) -> io::Result<()> {
        writeln!(stream, "{}", serde_json::to_string(&self.header)?)?;
        for path in &self.paths {
            let vertices: Vec<Value> = path.vertices.iter().map(|v| self.vertex_json(v)).collect();
            let line = json!({
                "pixel": path.pixel,
                "light": path.light,
                "weight": path.weight,
                "word": self.word(path),
                "vertices": vertices,
            });
            writeln!(stream, "{line}")?;
        }
        Ok(())
    }

    /// The kinds of a path's vertices from the light to the sensor, as an expression.
    pub fn word(&self, path: &RecordedPath) -> String {
        let kinds = path.vertices.iter().rev().map(|v| match v.kind {
            vertex_kind::LIGHT_AT_INFINITY => "L",
            kind => kind_name(kind),
        });
        kinds.collect::<Vec<_>>().join(" ")
    }

    fn vertex_json(&self, vertex: &RecordedVertex) -> Value {
        let is_light =
            vertex.kind == vertex_kind::LIGHT || vertex.kind == vertex_kind::LIGHT_AT_INFINITY;
        let names = if is_light {
            &self.header.emitters
        } else {
            &self.header.shapes
        };
        let index = vertex.object as usize;
        let name = (vertex.object != NONE).then(|| names.get(index)).flatten();
        let material = (!is_light)
            .then(|| self.header.materials.get(index))
            .flatten();
        json!({
            "kind": kind_name(vertex.kind),
            "position": vertex.position,
            "object": name,
            "material": material,
            "throughput": vertex.throughput,
        })
    }
}
