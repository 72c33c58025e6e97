//! The parser of the lines of an OBJ file ([`super::obj`]), and the mesh of the faces that it has read.

use super::colors::{self, Bytes};
use super::obj_lines::Lines;
use super::obj_words::{index, numbers, show};
use super::triangulate::Triangulator;
use super::{Attribute, FileLocation, MaterialNames, Mesh, MeshError};
use std::collections::HashMap;
use std::path::Path;

/// The index of an element that a corner does not have.
const ABSENT: u32 = u32::MAX;

/// Which faces of a file are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// All.
    #[default]
    All,
    /// Those of one shape, counted from zero. A new one begins, as in Mitsuba 0.6, with the first face after a line `g` or `usemtl`.
    Numbered(u32),
}

/// The elements of the file so far, and the mesh that its faces make.
#[derive(Default)]
pub(super) struct Parser {
    /// The elements are those of the whole file, from a first pass.
    is_complete: bool,
    /// A first pass, which reads elements only.
    skips_faces: bool,
    /// Faces of other shapes are passed over.
    wanted: Shape,
    /// The number of the shape of the current line.
    shape: u32,
    /// Whether that shape has a face above the current line.
    has_faces: bool,
    /// Some face refers to an element further down.
    refers_ahead: bool,
    /// Numbers of positions, texture coordinates and normals above the current line.
    seen: [usize; 3],
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
    /// Names of materials; the first is that of faces before any.
    materials: Vec<String>,
    /// Lines of `mtllib`.
    libraries: Vec<String>,
    /// The material of the next face.
    material: u32,
    of_triangle: Vec<u32>,
    /// Counts of what was left out, for warnings.
    small_faces: u64,
    broken_faces: u64,
    missing_uvs: u64,
    missing_normals: u64,
    other_geometry: u64,
}

impl Parser {
    /// The faces of a shape, with all elements of the file. Only where a face refers to an element further down does it take two passes.
    pub fn read(
        bytes: &[u8],
        flip_tex_coords: bool,
        shape: Shape,
        file: &Path,
    ) -> Result<Parser, MeshError> {
        let mut parser = Parser {
            wanted: shape,
            ..Parser::default()
        };
        if let Err(error) = parser.lines(bytes, flip_tex_coords, file) {
            if !parser.refers_ahead {
                return Err(error);
            }
            // Once more, with the elements of the whole file.
            let mut tables = Parser {
                skips_faces: true,
                ..Parser::default()
            };
            tables.lines(bytes, flip_tex_coords, file)?;
            parser = Parser {
                positions: tables.positions,
                colors: tables.colors,
                uvs: tables.uvs,
                normals: tables.normals,
                is_complete: true,
                wanted: shape,
                ..Parser::default()
            };
            parser.lines(bytes, flip_tex_coords, file)?;
        }
        Ok(parser)
    }

    /// Whether there is no vertex and no face.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty() && self.triangles.is_empty()
    }

    /// Number of shapes in the file.
    pub fn shape_count(&self) -> u32 {
        self.shape + u32::from(self.has_faces)
    }

    fn lines(&mut self, bytes: &[u8], flip_tex_coords: bool, file: &Path) -> Result<(), MeshError> {
        let mut lines = Lines::new(bytes);
        let mut triangulator = Triangulator::new();
        while let Some((number, line)) = lines.next() {
            self.line(line, flip_tex_coords, &mut triangulator)
                .map_err(|what| MeshError::malformed(file, FileLocation::Line(number), what))?;
        }
        Ok(())
    }

    /// Whether an element of the kind that [`Self::seen`] counts is to be kept; counts it.
    fn is_new(&mut self, kind: usize) -> bool {
        self.seen[kind] += 1;
        !self.is_complete
    }

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
                let (numbers, count) = numbers::<7>(words)?;
                if count < 3 {
                    return Err("a vertex needs three coordinates".into());
                }
                if !self.is_new(0) {
                    return Ok(());
                }
                if let 6 | 7 = count {
                    // Vertices before the first colour are white.
                    self.colors.resize(self.positions.len(), [1.0; 3]);
                    self.colors.push([1, 2, 3].map(|k| numbers[count - 4 + k]));
                }
                self.positions.push([numbers[0], numbers[1], numbers[2]]);
            }
            Some(b"vt") => {
                let ([u, v], count) = numbers::<2>(words)?;
                if count < 1 {
                    return Err("a texture coordinate needs a number".into());
                }
                if self.is_new(1) {
                    self.uvs
                        .push([u, if flip_tex_coords { 1.0 - v } else { v }]);
                }
            }
            Some(b"vn") => {
                let (normal, count) = numbers::<3>(words)?;
                if count < 3 {
                    return Err("a normal needs three numbers".into());
                }
                if self.is_new(2) {
                    self.normals.push(normal);
                }
            }
            Some(b"f" | b"fo") if !self.skips_faces => {
                self.has_faces = true;
                if self.wanted != Shape::All && self.wanted != Shape::Numbered(self.shape) {
                    return Ok(());
                }
                self.corners.clear();
                let mut is_whole = true;
                for word in words {
                    match self.corner(word)? {
                        Some(corner) => self.corners.push(corner),
                        None => is_whole = false,
                    }
                }
                if is_whole {
                    self.face(triangulator);
                } else {
                    self.broken_faces += 1;
                }
            }
            Some(b"g") => self.end_shape(),
            Some(b"usemtl") => {
                self.end_shape();
                let name = line.trim_ascii_start()[b"usemtl".len()..].trim_ascii();
                self.use_material(&String::from_utf8_lossy(name));
            }
            Some(b"mtllib") => {
                let name = line.trim_ascii_start()[b"mtllib".len()..].trim_ascii();
                self.libraries
                    .push(String::from_utf8_lossy(name).into_owned());
            }
            Some(b"l" | b"p" | b"curv" | b"curv2" | b"surf") => self.other_geometry += 1,
            _ => {}
        }
        Ok(())
    }

    /// The next face is one of another shape.
    fn end_shape(&mut self) {
        self.shape += u32::from(self.has_faces);
        self.has_faces = false;
    }

    /// Sets the material of the faces that follow.
    fn use_material(&mut self, name: &str) {
        if self.materials.is_empty() {
            self.materials.push(String::new());
        }
        self.of_triangle.resize(self.triangles.len(), self.material);
        let known = self.materials.iter().position(|known| known == name);
        let index = known.unwrap_or(self.materials.len());
        if index == self.materials.len() {
            self.materials.push(name.to_owned());
        }
        self.material = index as u32;
    }

    /// The mesh's vertex for `position`, `position/uv`, `position//normal` or `position/uv/normal`; none if there is no such position.
    fn corner(&mut self, word: &[u8]) -> Result<Option<u32>, String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let seen = self.seen;
        let names = ["vertex", "texture coordinate", "normal"];
        let mut triple = [ABSENT; 3];
        for (k, part) in word.split(|&b| b == b'/').enumerate() {
            if k == 3 && part.is_empty() {
                break;
            }
            if k == 3 {
                return Err(format!("\"{}\" has too many indices", show(word)));
            }
            if part.is_empty() && k > 0 {
                continue;
            }
            let index = index(part)
                .ok_or_else(|| format!("\"{}\" is not an index of a corner", show(word)))?;
            let count = counts[k];
            // Positive indices count from the first element, negative ones back from the latest.
            let resolved = if index < 0 {
                index.saturating_add(seen[k] as i64)
            } else {
                index - 1
            };
            if resolved < 0 || resolved >= count as i64 {
                if index > 0 && !self.is_complete {
                    self.refers_ahead = true;
                    return Err(format!("{} {index} does not exist yet", names[k]));
                }
                match k {
                    0 => return Ok(None),
                    1 => self.missing_uvs += 1,
                    _ => self.missing_normals += 1,
                }
                continue;
            }
            triple[k] = u32::try_from(resolved)
                .ok()
                .filter(|&index| index != ABSENT)
                .ok_or("more elements than 32 bits can count")?;
        }
        let next = u32::try_from(self.vertices.len())
            .map_err(|_| "more vertices than 32 bits can count")?;
        let vertices = &mut self.vertices;
        Ok(Some(*self.vertex_of.entry(triple).or_insert_with(|| {
            vertices.push(triple);
            next
        })))
    }

    fn face(&mut self, triangulator: &mut Triangulator) {
        let corners = &self.corners;
        if let [a, b, c] = corners[..] {
            self.triangles.push([a, b, c]);
            return;
        }
        if corners.len() < 3 {
            self.small_faces += 1;
            return;
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
    }

    /// The mesh of the faces.
    pub fn finish(mut self) -> Mesh {
        // Where only some corners have a normal, the others get NaN, which validation replaces by a computed one.
        let normals = self.attribute(2, &self.normals, [f32::NAN; 3]);
        let uvs = self.attribute(1, &self.uvs, [0.0; 2]);
        let mut vertex_attributes = Vec::new();
        let mut said_of_colors = None;
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            vertex_attributes.push(Attribute {
                name: "vertex_color".into(),
                channels: 3,
                values: self.attribute(0, &self.colors, [1.0; 3]).into_flattened(),
            });
            said_of_colors = colors::decode(&mut vertex_attributes[0], Bytes::AreScaled);
        }
        if !self.materials.is_empty() {
            self.of_triangle.resize(self.triangles.len(), self.material);
        }
        let warnings = [
            (
                self.small_faces,
                "faces with fewer than three corners are left out",
            ),
            (
                self.broken_faces,
                "faces name vertices that do not exist, and are left out",
            ),
            (
                self.missing_uvs,
                "corners name texture coordinates that do not exist, and get none",
            ),
            (
                self.missing_normals,
                "corners name normals that do not exist, and get those of the faces",
            ),
            (
                self.other_geometry,
                "points, lines, curves or curved surfaces are left out",
            ),
        ];
        Mesh {
            warnings: warnings
                .iter()
                .filter(|(count, _)| *count > 0)
                .map(|(count, what)| format!("{count} {what}"))
                .chain(said_of_colors)
                .collect(),
            materials: MaterialNames {
                names: std::mem::take(&mut self.materials),
                of_triangle: std::mem::take(&mut self.of_triangle),
                libraries: std::mem::take(&mut self.libraries),
            },
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
