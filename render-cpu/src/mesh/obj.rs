//! Wavefront OBJ meshes.
//!
//! Read are `v` (with colours, if six numbers follow), `vt`, `vn`, `f` with every form of index, negative ones
//! included, and the names of `usemtl` and `mtllib`; polygons are triangulated. Groups and smoothing groups are ignored, but where one shape of a file is wanted;
//! lines, points and curved surfaces are left out with a warning. The whole file is one mesh ([`Mesh::part`] splits it by
//! material). Each distinct triple of position, texture coordinate and normal becomes one vertex, numbered
//! by first use, as in Mitsuba 3. Colours become the attribute `vertex_color`, which Mitsuba does not read.
//!
//! # Why not a library
//! `tobj` reads the format well, but its errors carry no line number, it does not join continued lines, and it
//! triangulates by fans only, which is wrong for concave polygons.
//!
//! # Leniency
//! Lines may end in LF, CR LF or CR; a backslash at the end joins lines; `#` starts a comment wherever a word may begin. Bytes need
//! not be UTF-8; a byte order mark is skipped. Positive indices may refer to elements that are defined further down. A corner
//! without the texture coordinate or normal that it names has none, and a face of fewer than three corners or with one
//! that does not exist is left out; both with a warning. Between position and colour may be a weight, which means nothing here;
//! colours from 0 to 255 are taken for bytes.

use super::obj_parser::Parser;
use super::text::plain;
use super::{FileLocation, Mesh, MeshError, read_file};
use std::path::Path;

pub use super::obj_parser::Shape;

/// What Mitsuba's `obj` plugin assumes for `flip_tex_coords`.
pub const DEFAULT_FLIP_TEX_COORDS: bool = true;

/// Reads a file; see [`read`].
///
/// # Errors
/// When the file cannot be read, and as [`read`].
pub fn load(path: impl AsRef<Path>, flip_tex_coords: bool) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    read(&read_file(path)?, flip_tex_coords, path)
}

/// Reads one of the shapes of a file; see [`read_shape`].
///
/// # Errors
/// When the file cannot be read, and as [`read`].
pub fn load_shape(
    path: impl AsRef<Path>,
    flip_tex_coords: bool,
    shape: Shape,
) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    read_shape(&read_file(path)?, flip_tex_coords, shape, path)
}

/// Reads an OBJ file from memory. `flip_tex_coords` replaces v by 1 - v, as the format's images start at the bottom;
/// `file` is for messages only.
///
/// # Errors
/// When a line cannot be understood (with its number), and as [`Mesh::validate`].
pub fn read(bytes: &[u8], flip_tex_coords: bool, file: &Path) -> Result<Mesh, MeshError> {
    read_shape(bytes, flip_tex_coords, Shape::All, file)
}

/// Reads one of the shapes of an OBJ file in memory, as [`read`] does all. There is a warning if there are not that many.
///
/// # Errors
/// As [`read`].
pub fn read_shape(
    bytes: &[u8],
    flip_tex_coords: bool,
    shape: Shape,
    file: &Path,
) -> Result<Mesh, MeshError> {
    let bytes = plain(bytes);
    let parser = Parser::read(&bytes, flip_tex_coords, shape, file)?;
    if parser.is_empty() {
        return Err(MeshError::malformed(
            file,
            FileLocation::Whole,
            "there is no vertex and no face in it; is it an OBJ file?",
        ));
    }
    let count = parser.shape_count();
    let mut mesh = parser.finish();
    if let Shape::Numbered(index) = shape
        && index >= count
    {
        mesh.warnings.push(format!(
            "there is no shape number {index} in it; there are {count}, from 0 on"
        ));
    }
    mesh.validate(file)?;
    Ok(mesh)
}
