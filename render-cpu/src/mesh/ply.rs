//! PLY meshes: ascii and binary of both byte orders.
//!
//! Elements may stand in any order. Of the element `vertex` are read: positions `x y z`; normals `nx ny nz`; texture coordinates `u v`, `s t` or
//! `texture_u texture_v`; and attributes. Of the element `face`: the list `vertex_indices`, `vertex_index` or
//! `vertex_indexes`, with polygons triangulated and those left out that name vertices which do not exist; the list `texcoord` of MeshLab, which gives each corner coordinates of its own; and attributes,
//! repeated for each triangle of a polygon. Of `tristrips`: the list of indices, where -1 ends a strip. Other elements
//! are skipped. Which properties are attributes: see `ply_attributes`.
//!
//! # Why not a library
//! `ply-rs-bw` reads the format with bounded reservations, but it represents each vertex as a map from names to values; its
//! typed elements leave the grouping of columns by their names at run time to the caller, which is most of the work here. The
//! rest, the header, is the smaller part.

use super::part::{gather, gather_attributes};
use super::ply_attributes::{Target, attribute_targets, decode_colors, unused};
use super::ply_header::{Element, Header, Property, Scalar};
use super::ply_values::Values;
use super::text::plain;
use super::triangulate::Triangulator;
use super::{Mesh, MeshError, read_file};
use std::collections::HashMap;
use std::path::Path;

/// What Mitsuba's `ply` plugin assumes for `flip_tex_coords`.
pub const DEFAULT_FLIP_TEX_COORDS: bool = false;

/// Reads a file; see [`read`].
///
/// # Errors
/// When the file cannot be read, and as [`read`].
pub fn load(path: impl AsRef<Path>, flip_tex_coords: bool) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    read(&read_file(path)?, flip_tex_coords, path)
}

/// Reads a PLY file from memory. `flip_tex_coords` replaces v by 1 - v; `file` is for messages only.
///
/// # Errors
/// When the header or the values cannot be understood (with the line, or the offset in a binary file), and as
/// [`Mesh::validate`].
pub fn read(bytes: &[u8], flip_tex_coords: bool, file: &Path) -> Result<Mesh, MeshError> {
    // A mark can only stand before the text of the header; behind it may be bytes of any kind.
    let text = match bytes {
        [0xfe, 0xff, ..] | [0xff, 0xfe, ..] => plain(bytes),
        _ => bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).into(),
    };
    let bytes = &text[..];
    let header = Header::read(bytes, file)?;
    let mut values = Values::after(&header, bytes);
    let mut mesh = Mesh {
        texture_files: header.texture_files.clone(),
        ..Mesh::default()
    };
    let index_of = |name: &str| header.elements.iter().position(|e| e.name == name);
    // Faces before their vertices wait for a second pass.
    let is_backwards =
        index_of("face").is_some_and(|face| index_of("vertex").is_some_and(|v| face < v));
    for element in &header.elements {
        let result = match element.name.as_str() {
            "face" if is_backwards => skip(element, &mut values),
            "vertex" if mesh.positions.is_empty() => read_vertices(element, &mut values, &mut mesh),
            "face" if mesh.triangles.is_empty() => read_faces(element, &mut values, &mut mesh),
            "tristrips" => read_strips(element, &mut values, &mut mesh),
            "polyline" | "edge" if element.count > 0 => {
                mesh.warnings
                    .push(format!("{} lines are left out", element.count));
                skip(element, &mut values)
            }
            name => {
                // A view of MeshLab, which no renderer wants.
                if element.count > 0 && !matches!(name, "camera" | "vertex" | "face") {
                    mesh.warnings
                        .push(format!("the element \"{name}\" is not read"));
                }
                skip(element, &mut values)
            }
        };
        result.map_err(|what| MeshError::malformed(file, values.location(), what))?;
    }
    if values.rest() > 0 {
        mesh.warnings.push(format!(
            "{} bytes are left after all that the header announces, and are not read",
            values.rest()
        ));
    }
    if is_backwards {
        values = Values::after(&header, bytes);
        for element in &header.elements {
            let result = match element.name.as_str() {
                "face" if mesh.triangles.is_empty() => read_faces(element, &mut values, &mut mesh),
                _ => skip(element, &mut values),
            };
            result.map_err(|what| MeshError::malformed(file, values.location(), what))?;
        }
    }
    if flip_tex_coords {
        for uv in &mut mesh.uvs {
            uv[1] = 1.0 - uv[1];
        }
    }
    mesh.validate(file)?;
    Ok(mesh)
}

fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), String> {
    for _ in 0..values.check_room(element)? {
        for property in &element.properties {
            values.skip_property(property)?;
        }
    }
    Ok(())
}

fn read_vertices(
    element: &Element,
    values: &mut Values<'_>,
    mesh: &mut Mesh,
) -> Result<(), String> {
    let count = values.check_room(element)?;
    let names: Vec<&str> = element
        .properties
        .iter()
        .map(|p| {
            if p.list.is_none() {
                p.name.as_str()
            } else {
                ""
            }
        })
        .collect();
    let has = |wanted: &[&str]| wanted.iter().all(|name| names.contains(name));
    let places = ["x", "y", "z"];
    let normals = ["nx", "ny", "nz"];
    if !has(&places) {
        return Err("the vertices have no x, y and z".into());
    }
    let has_normals = has(&normals);
    let uvs = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]]
        .into_iter()
        .find(|pair| has(pair));

    let (mut targets, attributes) = attribute_targets(element, "vertex_", &mut mesh.warnings);
    for (target, name) in targets.iter_mut().zip(&names) {
        let index = |list: &[&str]| list.iter().position(|n| n == name);
        if let Some(k) = index(&places) {
            *target = Target::Position(k);
        } else if let Some(k) = index(&normals).filter(|_| has_normals) {
            *target = Target::Normal(k);
        } else if let Some(k) = uvs.and_then(|pair| index(&pair)) {
            *target = Target::Uv(k);
        }
    }
    mesh.warnings.extend(unused(element, &targets));
    mesh.vertex_attributes = attributes;
    mesh.positions.reserve(count);
    for _ in 0..count {
        let (mut position, mut normal, mut uv) = ([0.0; 3], [0.0; 3], [0.0; 2]);
        for (property, target) in element.properties.iter().zip(&targets) {
            if property.list.is_some() {
                values.skip_property(property)?;
                continue;
            }
            let number = values.next(property.scalar)?;
            match *target {
                Target::Skip => {}
                Target::Position(k) => position[k] = number as f32,
                Target::Normal(k) => normal[k] = number as f32,
                Target::Uv(k) => uv[k] = number as f32,
                Target::Attribute(a, factor) => mesh.vertex_attributes[a]
                    .values
                    .push((number * factor) as f32),
            }
        }
        mesh.positions.push(position);
        if has_normals {
            mesh.normals.push(normal);
        }
        if uvs.is_some() {
            mesh.uvs.push(uv);
        }
    }
    let said = decode_colors(element, &targets, &mut mesh.vertex_attributes);
    mesh.warnings.extend(said);
    Ok(())
}

fn read_faces(element: &Element, values: &mut Values<'_>, mesh: &mut Mesh) -> Result<(), String> {
    let count = values.check_room(element)?;
    if count == 0 {
        return Ok(());
    }
    let is_indices = |p: &Property| {
        let names = ["vertex_indices", "vertex_index", "vertex_indexes"];
        p.list.is_some() && names.contains(&p.name.as_str())
    };
    let indices_at = element
        .properties
        .iter()
        .position(is_indices)
        .ok_or("the faces have no list \"vertex_indices\"")?;
    let corner_uvs_at = element
        .properties
        .iter()
        .position(|p| p.list.is_some() && p.name == "texcoord");
    let (targets, mut attributes) = attribute_targets(element, "face_", &mut mesh.warnings);
    let mut corner_uvs = CornerUvs::default();
    let mut uvs: Vec<f32> = Vec::new();
    let mut triangulator = Triangulator::new();
    let mut corners: Vec<u32> = Vec::new();
    let mut corner_positions = Vec::new();
    let mut row = vec![Vec::new(); attributes.len()];
    let (mut ignored, mut broken, mut odd_uvs) = (0_u64, 0_u64, 0_u64);
    let mut is_whole = true;
    mesh.triangles.reserve(count);
    let only_indices = match &element.properties[..] {
        [indices] => indices.list.map(|length| (length, indices.scalar)),
        _ => None,
    };
    for _ in 0..count {
        // What most files hold, read without a detour through lists of numbers.
        if only_indices == Some((Scalar::U8, Scalar::I32))
            && let Some(triangle) = values.next_triangle(mesh.positions.len())
        {
            mesh.triangles.push(triangle);
            continue;
        }
        row.iter_mut().for_each(Vec::clear);
        for (k, (property, target)) in element.properties.iter().zip(&targets).enumerate() {
            if k == indices_at {
                corners.clear();
                let length = values.next_length(property.list.unwrap_or(property.scalar))?;
                is_whole = true;
                for _ in 0..length {
                    let index = values.next(property.scalar)?;
                    // Written so that what is no number fails.
                    is_whole &=
                        index >= 0.0 && index.fract() == 0.0 && index < mesh.positions.len() as f64;
                    corners.push(index as u32);
                }
            } else if Some(k) == corner_uvs_at {
                uvs.clear();
                let length = values.next_length(property.list.unwrap_or(property.scalar))?;
                for _ in 0..length {
                    uvs.push(values.next(property.scalar)? as f32);
                }
            } else if let Target::Attribute(a, factor) = *target {
                row[a].push((values.next(property.scalar)? * factor) as f32);
            } else {
                values.skip_property(property)?;
            }
        }
        if corners.len() < 3 {
            ignored += 1;
            continue;
        }
        if !is_whole {
            broken += 1;
            continue;
        }
        corner_positions.clear();
        corner_positions.extend(corners.iter().map(|&i| mesh.positions[i as usize]));
        if corner_uvs_at.is_some() {
            odd_uvs += u64::from(!uvs.is_empty() && uvs.len() != 2 * corners.len());
            corner_uvs.assign(&mut corners, &uvs)?;
        }
        triangulator.polygon(&corner_positions, |triangle| {
            mesh.triangles.push(triangle.map(|k| corners[k]));
            for (attribute, row) in attributes.iter_mut().zip(&row) {
                attribute.values.extend_from_slice(row);
            }
        });
    }
    for (count, what) in [
        (ignored, "faces with fewer than three corners are left out"),
        (
            broken,
            "faces name vertices that do not exist, and are left out",
        ),
        (
            odd_uvs,
            "faces have not two numbers in the list \"texcoord\" for each corner",
        ),
    ] {
        if count > 0 {
            mesh.warnings.push(format!("{count} {what}"));
        }
    }
    mesh.warnings
        .extend(decode_colors(element, &targets, &mut attributes));
    mesh.face_attributes = attributes;
    corner_uvs.apply(mesh);
    Ok(())
}

/// Vertices with coordinates of their own where the corners of faces have some.
#[derive(Default)]
struct CornerUvs {
    /// Vertex of the file and coordinates of each vertex of the mesh.
    vertices: Vec<(u32, [f32; 2])>,
    vertex_of: HashMap<(u32, [u32; 2]), u32>,
}

impl CornerUvs {
    /// Replaces the corners of a face by vertices that have its coordinates.
    fn assign(&mut self, corners: &mut [u32], uvs: &[f32]) -> Result<(), String> {
        for (k, corner) in corners.iter_mut().enumerate() {
            // A face without coordinates has an empty list.
            let uv = [2 * k, 2 * k + 1].map(|i| uvs.get(i).copied().unwrap_or(0.0));
            let next = u32::try_from(self.vertices.len())
                .map_err(|_| "more vertices than 32 bits can count")?;
            let vertices = &mut self.vertices;
            let key = (*corner, uv.map(f32::to_bits));
            *corner = *self.vertex_of.entry(key).or_insert_with(|| {
                vertices.push((key.0, uv));
                next
            });
        }
        Ok(())
    }

    /// Makes the mesh one of these vertices, if there are any.
    fn apply(self, mesh: &mut Mesh) {
        if self.vertices.is_empty() {
            return;
        }
        let places: Vec<usize> = self.vertices.iter().map(|(i, _)| *i as usize).collect();
        mesh.positions = gather(&mesh.positions, &places);
        mesh.normals = gather(&mesh.normals, &places);
        mesh.vertex_attributes = gather_attributes(&mesh.vertex_attributes, &places);
        mesh.uvs = self.vertices.iter().map(|(_, uv)| *uv).collect();
    }
}

/// Strips of triangles: each index makes a triangle with the two before it, of which every other one is turned round.
fn read_strips(element: &Element, values: &mut Values<'_>, mesh: &mut Mesh) -> Result<(), String> {
    let rows = values.check_room(element)?;
    let mut broken = 0_u64;
    for _ in 0..rows {
        for property in &element.properties {
            let Some(length) = property.list else {
                values.skip_property(property)?;
                continue;
            };
            let mut strip: Vec<u32> = Vec::new();
            for _ in 0..values.next_length(length)? {
                let index = values.next(property.scalar)?;
                if index < 0.0 {
                    strip.clear();
                    continue;
                }
                if index.fract() != 0.0 || index >= mesh.positions.len() as f64 {
                    broken += 1;
                    strip.clear();
                    continue;
                }
                strip.push(index as u32);
                if let [.., a, b, c] = strip[..] {
                    let is_odd = strip.len().is_multiple_of(2);
                    // Two equal indices turn to another part of the surface; they are no face.
                    if a != b && b != c && c != a {
                        mesh.triangles
                            .push(if is_odd { [b, a, c] } else { [a, b, c] });
                    }
                }
            }
        }
    }
    if broken > 0 {
        mesh.warnings.push(format!(
            "{broken} indices of strips name vertices that do not exist; the strips are cut there"
        ));
    }
    Ok(())
}
