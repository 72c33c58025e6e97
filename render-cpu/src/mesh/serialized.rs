//! Mitsuba's `.serialized` meshes.
//!
//! A file holds any number of meshes one after another, each of them as
//!
//! ```text
//! u16 0x041C, u16 version (3 or 4), then a zlib stream of
//!   u32 flags: 0x0001 normals, 0x0002 texture coordinates, 0x0008 colours,
//!              0x0010 face normals wanted, 0x1000 single, 0x2000 double precision
//!   version 4: name in UTF-8, ended by a zero byte
//!   u64 vertices, u64 triangles
//!   positions, normals, texture coordinates, colours: 3, 3, 2, 3 numbers for each vertex, table after table
//!   indices: 3 u32 for each triangle (u64 from 2^32 vertices on, which is refused here)
//! ```
//!
//! and at the end of the file a table: the offset of each mesh (u64 in version 4, u32 in version 3), and their number as
//! a u32. All is little-endian. Source: documentation of the `serialized` plugin in the manuals of Mitsuba 0.6 and 3.
//!
//! # Bound on memory
//! Deflate expands by at most 1032 : 1, so counts that need more decompressed bytes than that are refused before
//! anything is reserved; tables then grow as their bytes arrive. A mesh ends where the next begins, or where the table
//! begins.

use super::{Attribute, FileLocation, Mesh, MeshError, read_file};
use flate2::read::ZlibDecoder;
use std::io::Read;
use std::path::Path;

const MAGIC: u16 = 0x041C;

/// Largest expansion of deflate: 258 bytes from a little over two bits.
const MAX_EXPANSION: u64 = 1032;

const MAX_NAME_BYTES: usize = 1 << 16;

mod flag {
    pub const NORMALS: u32 = 0x0001;
    pub const TEXTURE_COORDINATES: u32 = 0x0002;
    pub const COLORS: u32 = 0x0008;
    pub const FACE_NORMALS: u32 = 0x0010;
    pub const DOUBLE_PRECISION: u32 = 0x2000;
}

/// Reads one mesh of a file; see [`read`].
///
/// # Errors
/// When the file cannot be read, and as [`read`].
pub fn load(path: impl AsRef<Path>, shape_index: u32) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    read(&read_file(path)?, shape_index, path)
}

/// Reads mesh number `shape_index`, counted from zero, of a file in memory; `file` is for messages only.
///
/// # Errors
/// When the file is not of the format, has no such mesh, is damaged or implausible (with the offset), and as
/// [`Mesh::validate`].
pub fn read(bytes: &[u8], shape_index: u32, file: &Path) -> Result<Mesh, MeshError> {
    let fail =
        |place: FileLocation, what: &str| -> MeshError { MeshError::malformed(file, place, what) };
    let located = match locate(bytes, shape_index) {
        // The first mesh is at the start; programs that write no other leave the table out.
        Err(_) if shape_index == 0 && version_at(bytes, 0).is_some() => Ok((0, bytes.len())),
        located => located,
    };
    let (start, end) =
        located.map_err(|(offset, what)| fail(FileLocation::Offset(offset as u64), &what))?;
    let version = version_at(bytes, start).ok_or_else(|| {
        fail(
            FileLocation::Offset(start as u64),
            "no serialized mesh begins here",
        )
    })?;
    let stream = &bytes[start + 4..end];
    let mut stream = Stream {
        decoder: ZlibDecoder::new(stream),
        position: 0,
        plausible: (stream.len() as u64).saturating_mul(MAX_EXPANSION),
    };
    let mut mesh = read_stream(&mut stream, version)
        .map_err(|what| fail(FileLocation::Decompressed(stream.position), &what))?;
    mesh.validate(file)?;
    Ok(mesh)
}

/// The version of the mesh that begins at `offset`, if one does.
fn version_at(bytes: &[u8], offset: usize) -> Option<u16> {
    let head = bytes.get(offset..)?.get(..4)?;
    let version = u16::from_le_bytes([head[2], head[3]]);
    (u16::from_le_bytes([head[0], head[1]]) == MAGIC && matches!(version, 3 | 4)).then_some(version)
}

/// First byte of a mesh, and the byte after its last.
fn locate(bytes: &[u8], shape_index: u32) -> Result<(usize, usize), (usize, String)> {
    let version = version_at(bytes, 0)
        .ok_or_else(|| (0, "not a serialized mesh of version 3 or 4".to_owned()))?;
    let offset_size = if version == 4 { 8 } else { 4 };
    let truncated = || (bytes.len(), "the table of meshes is missing".to_owned());
    let (rest, count) = bytes.split_last_chunk::<4>().ok_or_else(truncated)?;
    let count = u32::from_le_bytes(*count);
    if shape_index >= count {
        let what = format!("mesh {shape_index} is asked for, but the file holds {count}");
        return Err((rest.len(), what));
    }
    let table = (count as usize)
        .checked_mul(offset_size)
        .and_then(|size| rest.len().checked_sub(size))
        .ok_or_else(truncated)?;
    let entry = |i: usize| {
        let mut word = [0; 8];
        word[..offset_size].copy_from_slice(&rest[table + i * offset_size..][..offset_size]);
        u64::from_le_bytes(word)
    };
    let index = shape_index as usize;
    let start = entry(index);
    let end = match index + 1 {
        next if next < count as usize => entry(next),
        _ => table as u64,
    };
    if start.saturating_add(4) > end || end > table as u64 {
        let what = format!("the table puts mesh {shape_index} at bytes {start} to {end}");
        return Err((table + index * offset_size, what));
    }
    Ok((start as usize, end as usize))
}

/// A zlib stream with a count of what came out of it.
struct Stream<'a> {
    decoder: ZlibDecoder<&'a [u8]>,
    position: u64,
    /// Most bytes that can come out.
    plausible: u64,
}

impl Stream<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), String> {
        self.decoder
            .read_exact(buffer)
            .map_err(|error| format!("the compressed data is damaged or ends early ({error})"))?;
        self.position += buffer.len() as u64;
        Ok(())
    }

    fn u32(&mut self) -> Result<u32, String> {
        let mut word = [0; 4];
        self.fill(&mut word)?;
        Ok(u32::from_le_bytes(word))
    }

    fn u64(&mut self) -> Result<u64, String> {
        let mut word = [0; 8];
        self.fill(&mut word)?;
        Ok(u64::from_le_bytes(word))
    }

    /// `count` rows of `N` numbers.
    fn rows<const N: usize>(
        &mut self,
        count: usize,
        double: bool,
    ) -> Result<Vec<[f32; N]>, String> {
        if double {
            self.table::<8, f32, N>(count, |word| f64::from_le_bytes(word) as f32)
        } else {
            self.table::<4, f32, N>(count, f32::from_le_bytes)
        }
    }

    fn table<const BYTES: usize, T: Copy + Default, const N: usize>(
        &mut self,
        count: usize,
        decode: impl Fn([u8; BYTES]) -> T,
    ) -> Result<Vec<[T; N]>, String> {
        const ROWS_AT_ONCE: usize = 4096;
        let mut rows = Vec::new();
        let mut buffer = vec![0; ROWS_AT_ONCE.min(count) * N * BYTES];
        while rows.len() < count {
            let now = ROWS_AT_ONCE.min(count - rows.len());
            let bytes = &mut buffer[..now * N * BYTES];
            self.fill(bytes)?;
            rows.extend(bytes.chunks_exact(N * BYTES).map(|row| {
                let mut values = [T::default(); N];
                for (value, word) in values.iter_mut().zip(row.as_chunks::<BYTES>().0) {
                    *value = decode(*word);
                }
                values
            }));
        }
        Ok(rows)
    }
}

fn read_stream(stream: &mut Stream<'_>, version: u16) -> Result<Mesh, String> {
    let flags = stream.u32()?;
    let has = |bit: u32| flags & bit != 0;
    if version == 4 {
        let mut byte = [1];
        let mut length = 0;
        while byte[0] != 0 {
            stream.fill(&mut byte)?;
            length += 1;
            if length > MAX_NAME_BYTES {
                return Err("the mesh's name does not end".into());
            }
        }
    }
    let (vertices, triangles) = (stream.u64()?, stream.u64()?);
    let double = has(flag::DOUBLE_PRECISION);
    let per_vertex = 3
        + 3 * u64::from(has(flag::NORMALS))
        + 2 * u64::from(has(flag::TEXTURE_COORDINATES))
        + 3 * u64::from(has(flag::COLORS));
    let needed = vertices
        .saturating_mul(per_vertex * if double { 8 } else { 4 })
        .saturating_add(triangles.saturating_mul(12));
    if needed > stream.plausible || vertices > u64::from(u32::MAX) {
        return Err(format!(
            "{vertices} vertices and {triangles} triangles are announced, which is more than the file can hold"
        ));
    }
    let count = vertices as usize;
    let mut mesh = Mesh {
        positions: stream.rows(count, double)?,
        face_normals: has(flag::FACE_NORMALS),
        ..Mesh::default()
    };
    if has(flag::NORMALS) {
        mesh.normals = stream.rows(count, double)?;
    }
    if has(flag::TEXTURE_COORDINATES) {
        mesh.uvs = stream.rows(count, double)?;
    }
    if has(flag::COLORS) {
        mesh.vertex_attributes.push(Attribute {
            name: "vertex_color".into(),
            channels: 3,
            values: stream.rows::<3>(count, double)?.into_flattened(),
        });
    }
    mesh.triangles = stream.table::<4, u32, 3>(triangles as usize, u32::from_le_bytes)?;
    Ok(mesh)
}
