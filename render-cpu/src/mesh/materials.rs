//! The materials that a mesh file names, and the parts of a mesh that have one.
//!
//! OBJ files say `usemtl` before the faces of a material. A scene may give a scattering model to each name; a mesh is then
//! taken apart, as Mitsuba 0.6 does while it reads, so that normals are not smoothed across.

use super::{Attribute, Mesh};

/// Which triangles have which material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialNames {
    /// Names in the order of their first use; the empty one is that of faces before the first `usemtl`.
    pub names: Vec<String>,
    /// Index of each triangle's name; empty when there is but one name or none.
    pub of_triangle: Vec<u32>,
}

impl Mesh {
    /// The part of the mesh whose material has the index `name` in [`MaterialNames::names`], with the vertices that it
    /// uses, numbered by first use.
    ///
    /// # Panics
    /// When a triangle's index is out of range, which [`Mesh::validate`] rules out.
    pub fn part(&self, name: u32) -> Mesh {
        const UNUSED: u32 = u32::MAX;
        let is_in = |t: usize| match self.materials.of_triangle.get(t) {
            Some(&of) => of == name,
            None => name == 0,
        };
        let chosen: Vec<usize> = (0..self.triangles.len()).filter(|&t| is_in(t)).collect();
        let mut place = vec![UNUSED; self.positions.len()];
        let mut kept = Vec::new();
        for &t in &chosen {
            for i in self.triangles[t] {
                if place[i as usize] == UNUSED {
                    place[i as usize] = kept.len() as u32;
                    kept.push(i as usize);
                }
            }
        }
        Mesh {
            positions: pick(&self.positions, &kept),
            normals: pick(&self.normals, &kept),
            uvs: pick(&self.uvs, &kept),
            triangles: chosen
                .iter()
                .map(|&t| self.triangles[t].map(|i| place[i as usize]))
                .collect(),
            vertex_attributes: pick_attributes(&self.vertex_attributes, &kept),
            face_attributes: pick_attributes(&self.face_attributes, &chosen),
            materials: MaterialNames {
                names: self
                    .materials
                    .names
                    .get(name as usize)
                    .cloned()
                    .into_iter()
                    .collect(),
                of_triangle: Vec::new(),
            },
            face_normals: self.face_normals,
            max_smooth_angle: self.max_smooth_angle,
            warnings: Vec::new(),
        }
    }
}

/// The items at the given places; none of an empty table.
pub(super) fn pick<T: Copy>(table: &[T], places: &[usize]) -> Vec<T> {
    if table.is_empty() {
        return Vec::new();
    }
    places.iter().map(|&i| table[i]).collect()
}

/// Attributes at the given vertices or faces.
pub(super) fn pick_attributes(attributes: &[Attribute], places: &[usize]) -> Vec<Attribute> {
    attributes
        .iter()
        .map(|attribute| {
            let channels = attribute.channels as usize;
            Attribute {
                name: attribute.name.clone(),
                channels: attribute.channels,
                values: places
                    .iter()
                    .flat_map(|&i| &attribute.values[i * channels..(i + 1) * channels])
                    .copied()
                    .collect(),
            }
        })
        .collect()
}
