//! Parts of a mesh: the triangles of one material, and the tables of chosen vertices or faces.

use super::{Attribute, MaterialNames, Mesh};

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
        let mut new_index = vec![UNUSED; self.positions.len()];
        let mut kept = Vec::new();
        for &t in &chosen {
            for i in self.triangles[t] {
                if new_index[i as usize] == UNUSED {
                    new_index[i as usize] = kept.len() as u32;
                    kept.push(i as usize);
                }
            }
        }
        Mesh {
            positions: gather(&self.positions, &kept),
            normals: gather(&self.normals, &kept),
            uvs: gather(&self.uvs, &kept),
            triangles: chosen
                .iter()
                .map(|&t| self.triangles[t].map(|i| new_index[i as usize]))
                .collect(),
            vertex_attributes: gather_attributes(&self.vertex_attributes, &kept),
            face_attributes: gather_attributes(&self.face_attributes, &chosen),
            materials: MaterialNames {
                names: self
                    .materials
                    .names
                    .get(name as usize)
                    .cloned()
                    .into_iter()
                    .collect(),
                ..MaterialNames::default()
            },
            texture_files: self.texture_files.clone(),
            face_normals: self.face_normals,
            max_smooth_angle: self.max_smooth_angle,
            warnings: Vec::new(),
        }
    }
}

/// The items of a table at the given indices; none of an empty table, which a mesh has for what it lacks.
pub(super) fn gather<T: Copy>(table: &[T], indices: &[usize]) -> Vec<T> {
    if table.is_empty() {
        return Vec::new();
    }
    indices.iter().map(|&i| table[i]).collect()
}

/// Attributes at the given vertices or faces.
pub(super) fn gather_attributes(attributes: &[Attribute], indices: &[usize]) -> Vec<Attribute> {
    attributes
        .iter()
        .map(|attribute| {
            let channels = attribute.channels as usize;
            Attribute {
                name: attribute.name.clone(),
                channels: attribute.channels,
                values: indices
                    .iter()
                    .flat_map(|&i| &attribute.values[i * channels..(i + 1) * channels])
                    .copied()
                    .collect(),
            }
        })
        .collect()
}
