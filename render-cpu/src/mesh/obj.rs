//! Wavefront OBJ meshes.
//!
//! Read are `v` (with colours, if six numbers follow), `vt`, `vn` and `f` with every form of index, negative ones
//! included; polygons are triangulated. Everything else (materials, groups, smoothing, lines, curves) is skipped: the
//! whole file is one mesh. Each distinct triple of position, texture coordinate and normal becomes one vertex, numbered
//! by first use, as in Mitsuba 3. Colours become the attribute `vertex_color`, which Mitsuba does not read.
//!
//! # Why not a library
//! `tobj` reads the format well, but its errors carry no line number, it does not join continued lines, and it
//! triangulates by fans only, which is wrong for concave polygons.
//!
//! # Leniency
//! Lines may end in LF, CR LF or CR; a backslash at the end joins lines; `#` starts a comment anywhere. Bytes need not be
//! UTF-8. An index must refer to an element defined above it.

use super::triangulate::Triangulator;
use super::{Attribute, Mesh, MeshError, Place, is_usable, read_file};
use std::collections::HashMap;
use std::path::Path;

/// What Mitsuba's `obj` plugin assumes for `flip_tex_coords`.
pub const DEFAULT_FLIP_TEX_COORDS: bool = true;

const ABSENT: u32 = u32::MAX;

/// Reads a file; see [`read`].
///
/// # Errors
/// When the file cannot be read, and as [`read`].
pub fn load(path: impl AsRef<Path>, flip_tex_coords: bool) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    read(&read_file(path)?, flip_tex_coords, path)
}

/// Reads an OBJ file from memory. `flip_tex_coords` replaces v by 1 - v, as the format's images start at the bottom;
/// `file` is for messages only.
///
/// # Errors
/// When a line cannot be understood (with its number), and as [`Mesh::validate`].
pub fn read(bytes: &[u8], flip_tex_coords: bool, file: &Path) -> Result<Mesh, MeshError> {
    let mut parser = Parser::default();
    let mut lines = Lines::new(bytes);
    let mut triangulator = Triangulator::new();
    while let Some((number, line)) = lines.next() {
        parser
            .line(line, flip_tex_coords, &mut triangulator)
            .map_err(|what| MeshError::malformed(file, Place::Line(number), what))?;
    }
    let mut mesh = parser.finish();
    mesh.validate(file)?;
    Ok(mesh)
}

/// Logical lines without comments, each with the number of its first physical line.
struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
    joined: Vec<u8>,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Lines<'a> {
        Lines {
            rest: bytes,
            number: 0,
            joined: Vec::new(),
        }
    }

    fn next(&mut self) -> Option<(u64, &[u8])> {
        let (mut line, mut continued) = self.physical()?;
        let first = self.number;
        if continued {
            self.joined.clear();
            while continued {
                self.joined.extend_from_slice(line);
                self.joined.push(b' ');
                (line, continued) = self.physical().unwrap_or((b"", false));
            }
            self.joined.extend_from_slice(line);
            return Some((first, &self.joined));
        }
        Some((first, line))
    }

    /// The next line up to its comment or end, and whether a backslash continues it.
    fn physical(&mut self) -> Option<(&'a [u8], bool)> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let line = &self.rest[..end.unwrap_or(self.rest.len())];
        let next = match end {
            None => self.rest.len(),
            Some(end) if self.rest[end..].starts_with(b"\r\n") => end + 2,
            Some(end) => end + 1,
        };
        self.rest = &self.rest[next..];
        // A comment ends with its line, even if it ends in a backslash, as paths of directories do.
        if let Some(comment) = line.iter().position(|&b| b == b'#') {
            return Some((&line[..comment], false));
        }
        match line.trim_ascii_end() {
            [start @ .., b'\\'] => Some((start, true)),
            _ => Some((line, false)),
        }
    }
}

#[derive(Default)]
struct Parser {
    positions: Vec<[f32; 3]>,
    colors: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Position, texture coordinate and normal of each vertex of the mesh.
    vertices: Vec<[u32; 3]>,
    vertex_of: HashMap<[u32; 3], u32>,
    triangles: Vec<[u32; 3]>,
    corners: Vec<u32>,
    corner_positions: Vec<[f32; 3]>,
}

impl Parser {
    fn line(
        &mut self,
        line: &[u8],
        flip_tex_coords: bool,
        triangulator: &mut Triangulator,
    ) -> Result<(), String> {
        let mut words = line
            .split(|b| b.is_ascii_whitespace())
            .filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                let (numbers, count) = numbers::<6>(words)?;
                if count < 3 {
                    return Err("a vertex needs three coordinates".into());
                }
                let position = [numbers[0], numbers[1], numbers[2]];
                if !is_usable(&position) {
                    return Err(format!("not a usable point: {position:?}"));
                }
                if count == 6 {
                    // Vertices before the first colour are white.
                    self.colors.resize(self.positions.len(), [1.0; 3]);
                    self.colors.push([numbers[3], numbers[4], numbers[5]]);
                }
                self.positions.push(position);
            }
            Some(b"vt") => {
                let ([u, v], count) = numbers::<2>(words)?;
                if count < 1 {
                    return Err("a texture coordinate needs a number".into());
                }
                self.uvs
                    .push([u, if flip_tex_coords { 1.0 - v } else { v }]);
            }
            Some(b"vn") => {
                let (normal, count) = numbers::<3>(words)?;
                if count < 3 {
                    return Err("a normal needs three numbers".into());
                }
                self.normals.push(normal);
            }
            Some(b"f") => {
                self.corners.clear();
                for word in words {
                    let corner = self.corner(word)?;
                    self.corners.push(corner);
                }
                self.face(triangulator)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// The mesh's vertex for `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&mut self, word: &[u8]) -> Result<u32, String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let names = ["vertex", "texture coordinate", "normal"];
        let mut triple = [ABSENT; 3];
        for (k, part) in word.split(|&b| b == b'/').enumerate() {
            if k == 3 {
                return Err(format!("\"{}\" has too many indices", show(word)));
            }
            if part.is_empty() && k > 0 {
                continue;
            }
            let index: i64 = parse(part)
                .ok_or_else(|| format!("\"{}\" is not an index of a corner", show(word)))?;
            let count = counts[k];
            // Positive indices count from the first element, negative ones back from the latest.
            let resolved = if index < 0 {
                index.saturating_add(count as i64)
            } else {
                index - 1
            };
            if resolved < 0 || resolved >= count as i64 {
                return Err(format!(
                    "{} {index} does not exist; {count} are defined up to here",
                    names[k]
                ));
            }
            triple[k] = u32::try_from(resolved)
                .ok()
                .filter(|&index| index != ABSENT)
                .ok_or("more elements than 32 bits can count")?;
        }
        let next = u32::try_from(self.vertices.len())
            .map_err(|_| "more vertices than 32 bits can count")?;
        let vertices = &mut self.vertices;
        Ok(*self.vertex_of.entry(triple).or_insert_with(|| {
            vertices.push(triple);
            next
        }))
    }

    fn face(&mut self, triangulator: &mut Triangulator) -> Result<(), String> {
        let corners = &self.corners;
        if let [a, b, c] = corners[..] {
            self.triangles.push([a, b, c]);
            return Ok(());
        }
        if corners.len() < 3 {
            return Err("a face needs three corners".into());
        }
        let (positions, vertices) = (&self.positions, &self.vertices);
        self.corner_positions.clear();
        self.corner_positions.extend(
            corners
                .iter()
                .map(|&i| positions[vertices[i as usize][0] as usize]),
        );
        triangulator.polygon(&self.corner_positions, |triangle| {
            self.triangles.push(triangle.map(|k| corners[k]));
        });
        Ok(())
    }

    fn finish(mut self) -> Mesh {
        // Where only some corners have a normal, the others get NaN, which validation replaces by a computed one.
        let normals = self.attribute(2, &self.normals, [f32::NAN; 3]);
        let uvs = self.attribute(1, &self.uvs, [0.0; 2]);
        let mut vertex_attributes = Vec::new();
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            vertex_attributes.push(Attribute {
                name: "vertex_color".into(),
                channels: 3,
                values: self.attribute(0, &self.colors, [1.0; 3]).into_flattened(),
            });
        }
        Mesh {
            positions: self.attribute(0, &self.positions, [0.0; 3]),
            normals,
            uvs,
            triangles: self.triangles,
            vertex_attributes,
            ..Mesh::default()
        }
    }

    /// Component `k` of the vertices' triples, looked up; empty when no vertex has it.
    fn attribute<T: Copy>(&self, k: usize, table: &[T], absent: T) -> Vec<T> {
        if self.vertices.iter().all(|triple| triple[k] == ABSENT) {
            return Vec::new();
        }
        let look_up = |triple: &[u32; 3]| table.get(triple[k] as usize).copied().unwrap_or(absent);
        self.vertices.iter().map(look_up).collect()
    }
}

/// The first `N` numbers of a line, and how many there are.
fn numbers<'a, const N: usize>(
    words: impl Iterator<Item = &'a [u8]>,
) -> Result<([f32; N], usize), String> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for (slot, word) in numbers.iter_mut().zip(words) {
        *slot = parse(word).ok_or_else(|| format!("\"{}\" is not a number", show(word)))?;
        count += 1;
    }
    Ok((numbers, count))
}

fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word for a message: printable and not too long.
fn show(word: &[u8]) -> String {
    word[..word.len().min(40)].escape_ascii().to_string()
}
