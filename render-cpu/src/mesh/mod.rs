//! Triangle meshes and the files that they come from.
//!
//! [`obj`], [`ply`] and [`serialized`] each turn bytes into a [`Mesh`]; `read` takes a slice, `load` a path. What they
//! return has passed [`Mesh::validate`], so that its indices need no further checks.
//!
//! Readers return the vertex normals of the file and compute none. A file without them gets, in Mitsuba, smooth normals
//! from the *placed* mesh (the weights are angles, which an affine map changes), so a scene applies its `to_world` first
//! and calls [`Mesh::compute_vertex_normals`] then, unless the scene or the file sets face normals ([`Mesh::face_normals`]).
//!
//! [`Mesh::warnings`] lists what a reader left out or repaired. A file without a usable triangle is no error: its mesh is
//! empty.
//!
//! # Hostile files
//! No reader reserves memory for a count before comparing it with the number of bytes that follow, and none recurses.

mod colors;
mod creases;
mod error;
mod materials;
pub mod mtl;
mod mtl_map;
pub mod obj;
mod obj_lines;
mod obj_parser;
mod obj_words;
mod part;
pub mod ply;
mod ply_attributes;
mod ply_header;
mod ply_values;
pub mod serialized;
mod text;
mod triangulate;

pub use error::{FileLocation, MeshError};
pub use materials::MaterialNames;

use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};
use std::path::Path;

/// Longest coordinate that is accepted: the square of a difference of two is still finite in `f32`.
pub const MAX_COORDINATE: f32 = 1e18;

/// Most bytes of a mesh file.
const MAX_FILE_BYTES: u64 = 16 << 30;

/// Triangles or vertices that are not worth a second thread.
pub(crate) const MIN_SHARE: usize = 1 << 12;

/// Triangles whose normals are computed before they are added up.
const NORMAL_BLOCK: usize = 1 << 15;

/// Values per vertex or per face under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name as a Mitsuba `mesh_attribute` texture gives it, such as `vertex_color` or `face_color`.
    pub name: String,
    /// Values per vertex or face: 1 or 3.
    pub channels: u32,
    /// `channels` values for each vertex or face.
    pub values: Vec<f32>,
}

/// An indexed triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals of unit length: as many as positions, or none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates: as many as positions, or none.
    pub uvs: Vec<[f32; 2]>,
    /// Indices of the corners of each triangle, anticlockwise seen from the side of the normal.
    pub triangles: Vec<[u32; 3]>,
    /// Attributes per vertex.
    pub vertex_attributes: Vec<Attribute>,
    /// Attributes per triangle.
    pub face_attributes: Vec<Attribute>,
    /// Names of materials in the file.
    pub materials: MaterialNames,
    /// Image files that the file names for its texture coordinates (`.ply` only).
    pub texture_files: Vec<String>,
    /// The file demands face normals (`.serialized` only).
    pub face_normals: bool,
    /// Angle in radians beyond which edges are sharp, if the scene gives one; see [`Mesh::split_at_creases`].
    pub max_smooth_angle: Option<f32>,
    /// What was left out or repaired, a sentence each.
    pub warnings: Vec<String>,
}

impl Mesh {
    /// Checks everything that the rest of the program relies on, and repairs what has an obvious repair.
    ///
    /// Repairs, each with one of [`Mesh::warnings`]: triangles are dropped that have a corner which does not exist, is not finite or
    /// is beyond [`MAX_COORDINATE`]; degenerate triangles (no area in `f32`) are dropped together with their face
    /// attributes; a vertex normal that is zero or not finite is replaced by the angle-weighted mean of the normals of
    /// the adjacent faces; texture coordinates and attribute values that are not finite become zero. Normals are
    /// normalised. `file` is for messages only.
    ///
    /// # Errors
    /// When a table has the wrong length.
    pub fn validate(&mut self, file: &Path) -> Result<(), MeshError> {
        let fail = |what: String| Err(MeshError::malformed(file, FileLocation::Whole, what));
        let count = self.positions.len();
        if count > u32::MAX as usize || self.triangles.len() > u32::MAX as usize {
            return fail("the mesh has more vertices or triangles than 32 bits can count".into());
        }
        if !(self.normals.is_empty() || self.normals.len() == count)
            || !(self.uvs.is_empty() || self.uvs.len() == count)
        {
            return fail("normals or texture coordinates do not match the vertices".into());
        }
        let tables = [
            (&self.vertex_attributes, count),
            (&self.face_attributes, self.triangles.len()),
        ];
        for (attributes, count) in tables {
            for attribute in attributes {
                if !matches!(attribute.channels, 1 | 3)
                    || attribute.values.len() != count * attribute.channels as usize
                {
                    return fail(format!(
                        "attribute \"{}\" does not match the mesh",
                        attribute.name
                    ));
                }
            }
        }
        if !(self.materials.of_triangle.is_empty()
            || self.materials.of_triangle.len() == self.triangles.len())
        {
            return fail("materials do not match the triangles".into());
        }
        self.drop_unusable_points();
        self.drop_degenerate_triangles();
        self.repair_normals();
        self.repair_values();
        Ok(())
    }

    /// Sets smooth vertex normals: the mean of the normals of the adjacent triangles, weighted by the triangle's angle
    /// at the vertex (Thürmer and Wüthrich, "Computing vertex normals from polygonal facets", 1998), as Mitsuba 3 does.
    /// A vertex without adjacent triangles gets (1, 0, 0).
    ///
    /// # Panics
    /// When a triangle's index is out of range, which [`Mesh::validate`] rules out.
    pub fn compute_vertex_normals(&mut self) {
        let mut sums = vec![[0.0_f32; 3]; self.positions.len()];
        let mut parts = Vec::new();
        for block in self.triangles.chunks(NORMAL_BLOCK) {
            block
                .par_iter()
                .with_min_len(MIN_SHARE)
                .map(|triangle| weighted_normals(&triangle.map(|i| self.positions[i as usize])))
                .collect_into_vec(&mut parts);
            // In the order of the triangles, so that the sums do not depend on the threads.
            for (triangle, normals) in block.iter().zip(&parts) {
                for (&vertex, normal) in triangle.iter().zip(normals) {
                    let sum = &mut sums[vertex as usize];
                    for axis in 0..3 {
                        sum[axis] += normal[axis];
                    }
                }
            }
        }
        sums.par_iter_mut()
            .with_min_len(MIN_SHARE)
            .for_each(|sum| *sum = normalized(*sum).unwrap_or([1.0, 0.0, 0.0]));
        self.normals = sums;
    }

    /// Drops triangles whose corners do not exist or are no usable points. Those points, which nothing has then, become the origin.
    fn drop_unusable_points(&mut self) {
        let positions = &self.positions;
        let is_sound = |triangle: &[u32; 3]| {
            let corner = |i: u32| positions.get(i as usize);
            triangle.iter().all(|&i| corner(i).is_some_and(is_usable))
        };
        let points = positions.par_iter().with_min_len(MIN_SHARE);
        let points = points.filter(|p| !is_usable(p)).count();
        let triangles = self.triangles.par_iter().with_min_len(MIN_SHARE);
        if points == 0 && triangles.all(is_sound) {
            return;
        }
        let keep: Vec<bool> = self.triangles.iter().map(is_sound).collect();
        let dropped = keep.iter().filter(|k| !**k).count();
        if points > 0 {
            self.warnings
                .push(format!("{points} vertices are no usable points"));
        }
        if dropped > 0 {
            self.warnings.push(format!(
                "{dropped} of {} triangles have corners that do not exist or are no usable points, and are left out",
                keep.len()
            ));
        }
        for position in &mut self.positions {
            if !is_usable(position) {
                *position = [0.0; 3];
            }
        }
        self.keep_triangles(&keep);
    }

    /// Drops triangles without an area, with a warning.
    pub(crate) fn drop_degenerate_triangles(&mut self) {
        let positions = &self.positions;
        let is_kept = |t: &[u32; 3]| has_area(&t.map(|i| positions[i as usize]));
        let triangles = self.triangles.par_iter().with_min_len(MIN_SHARE);
        if triangles.all(is_kept) {
            return;
        }
        let keep: Vec<bool> = self.triangles.iter().map(is_kept).collect();
        let dropped = keep.iter().filter(|k| !**k).count();
        self.warnings.push(format!(
            "{dropped} of {} triangles have no area and are left out",
            keep.len()
        ));
        self.keep_triangles(&keep);
    }

    /// Keeps some triangles, with what belongs to them.
    fn keep_triangles(&mut self, keep: &[bool]) {
        let mut kept = keep.iter();
        self.triangles.retain(|_| kept.next() == Some(&true));
        let mut kept = keep.iter();
        self.materials
            .of_triangle
            .retain(|_| kept.next() == Some(&true));
        for attribute in &mut self.face_attributes {
            let channels = attribute.channels as usize;
            let mut i = 0;
            attribute.values.retain(|_| {
                i += 1;
                keep[(i - 1) / channels]
            });
        }
    }

    fn repair_normals(&mut self) {
        let mut bad = Vec::new();
        for (i, normal) in self.normals.iter_mut().enumerate() {
            match normalized(*normal) {
                Some(unit) => *normal = unit,
                None => bad.push(i),
            }
        }
        if bad.is_empty() {
            return;
        }
        self.warnings.push(format!(
            "{} vertex normals are zero or not finite and are replaced by those of the faces",
            bad.len()
        ));
        let given = std::mem::take(&mut self.normals);
        self.compute_vertex_normals();
        let computed = std::mem::replace(&mut self.normals, given);
        for i in bad {
            self.normals[i] = computed[i];
        }
    }

    fn repair_values(&mut self) {
        let mut repaired = 0_usize;
        let attributes = self
            .vertex_attributes
            .iter_mut()
            .chain(&mut self.face_attributes)
            .flat_map(|attribute| &mut attribute.values);
        for value in self.uvs.as_flattened_mut().iter_mut().chain(attributes) {
            if !value.is_finite() {
                *value = 0.0;
                repaired += 1;
            }
        }
        if repaired > 0 {
            self.warnings.push(format!(
                "{repaired} texture coordinates or attribute values are not finite and become zero"
            ));
        }
    }
}

fn read_file(path: &Path) -> Result<Vec<u8>, MeshError> {
    crate::bytes::read_file(path, MAX_FILE_BYTES).map_err(|source| MeshError::Io {
        file: path.to_owned(),
        source,
    })
}

/// Whether a position is finite and not absurdly far.
fn is_usable(position: &[f32; 3]) -> bool {
    // Written so that NaN fails.
    position.iter().all(|x| x.abs() <= MAX_COORDINATE)
}

/// Whether the squared length of the edges' cross product is positive in `f32`.
fn has_area(corners: &[[f32; 3]; 3]) -> bool {
    let corners = corners.map(to_f64);
    let c = cross(
        subtract(corners[1], corners[0]),
        subtract(corners[2], corners[0]),
    );
    dot(c, c) as f32 > 0.0
}

/// The triangle's normal at each corner, times its angle there.
fn weighted_normals(corners: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let corners = corners.map(to_f64);
    let normal = face_normal(&corners);
    [0, 1, 2].map(|k| {
        let a = subtract(corners[(k + 1) % 3], corners[k]);
        let b = subtract(corners[(k + 2) % 3], corners[k]);
        // atan2 of |sin| and cos is accurate for all angles, acos is not near 0 and pi.
        let angle = length(cross(a, b)).atan2(dot(a, b));
        normal.map(|x| (angle * x) as f32)
    })
}

fn face_normal(corners: &[[f64; 3]; 3]) -> [f64; 3] {
    let n = cross(
        subtract(corners[1], corners[0]),
        subtract(corners[2], corners[0]),
    );
    let length = length(n);
    if length > 0.0 {
        n.map(|x| x / length)
    } else {
        [0.0; 3]
    }
}

/// The unit vector along `v`, or `None` for zero and for vectors that are not finite.
fn normalized(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = length(to_f64(v));
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| (f64::from(x) / length) as f32))
}

fn to_f64(v: [f32; 3]) -> [f64; 3] {
    v.map(f64::from)
}

fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}
