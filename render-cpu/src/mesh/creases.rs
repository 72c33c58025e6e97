//! Vertices are split where faces meet at a large angle: `maxSmoothAngle` of Mitsuba 0.6.
//!
//! Faces around a vertex are grouped greedily: the first ungrouped face collects all others whose normal is within the angle of
//! its own, and the group gets a vertex of its own, whose normal is computed from these faces only. Vertices are identified by
//! position, texture coordinates and attributes; given normals are ignored. This is `TriMesh::rebuildTopology` of Mitsuba 0.6,
//! with the faces in the order of the file.
//!
//! Invariant (tests): at an angle of 0 every face is flat, at 180 degrees no edge is sharp.

use super::part::{gather, gather_attributes};
use super::{Mesh, face_normal, to_f64};
use std::collections::HashMap;

impl Mesh {
    /// Splits vertices at edges sharper than `angle` in radians, and drops the normals.
    ///
    /// # Panics
    /// When a triangle's index is out of range, which [`Mesh::validate`] rules out.
    pub fn split_at_creases(&mut self, angle: f32) {
        let least_cos = f64::from(angle).cos();
        let normals: Vec<[f64; 3]> = self
            .triangles
            .iter()
            .map(|t| face_normal(&t.map(|i| to_f64(self.positions[i as usize]))))
            .collect();
        let same = self.equal_vertices();
        // Corners around each vertex, in the order of the triangles.
        let mut around: Vec<Vec<(u32, u8)>> = vec![Vec::new(); self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            for (k, &i) in triangle.iter().enumerate() {
                around[same[i as usize] as usize].push((t as u32, k as u8));
            }
        }
        let mut vertices: Vec<usize> = Vec::new();
        let mut triangles = vec![[0_u32; 3]; self.triangles.len()];
        for (vertex, corners) in around.iter().enumerate() {
            let mut left: Vec<(u32, u8)> = corners.clone();
            while let Some(&(first, _)) = left.first() {
                let n = normals[first as usize];
                let new = vertices.len() as u32;
                vertices.push(vertex);
                left.retain(|&(t, k)| {
                    let m = normals[t as usize];
                    let joins = m == n || super::dot(m, n) > least_cos;
                    if joins {
                        triangles[t as usize][usize::from(k)] = new;
                    }
                    !joins
                });
            }
        }
        self.positions = gather(&self.positions, &vertices);
        self.uvs = gather(&self.uvs, &vertices);
        self.vertex_attributes = gather_attributes(&self.vertex_attributes, &vertices);
        self.normals.clear();
        self.triangles = triangles;
    }

    /// For each vertex, the first that is equal to it in all but its normal.
    fn equal_vertices(&self) -> Vec<u32> {
        let mut first: HashMap<Vec<u32>, u32> = HashMap::with_capacity(self.positions.len());
        (0..self.positions.len())
            .map(|i| {
                let mut key: Vec<u32> = self.positions[i].map(key_bits).to_vec();
                if let Some(uv) = self.uvs.get(i) {
                    key.extend(uv.map(key_bits));
                }
                for attribute in &self.vertex_attributes {
                    let channels = attribute.channels as usize;
                    let values = &attribute.values[i * channels..(i + 1) * channels];
                    key.extend(values.iter().map(|&v| key_bits(v)));
                }
                *first.entry(key).or_insert(i as u32)
            })
            .collect()
    }
}

/// Bits that are equal where numbers are.
fn key_bits(x: f32) -> u32 {
    // Adding zero makes negative zeros positive.
    (x + 0.0).to_bits()
}

#[cfg(test)]
mod tests {
    use crate::mesh::obj;
    use std::path::Path;

    /// Two triangles that meet at 60 degrees along the x axis, and a third in the plane of the first.
    const ROOF: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -0.5 -0.8660254\nv 1 1 0\nvn 0 0 1\n\
        f 1//1 2//1 3//1\nf 2//1 1//1 4//1\nf 2//1 5//1 3//1\n";

    fn split(angle_in_degrees: f32) -> crate::mesh::Mesh {
        let mut mesh = obj::read(ROOF.as_bytes(), false, Path::new("roof.obj")).unwrap();
        mesh.split_at_creases(angle_in_degrees.to_radians());
        mesh.compute_vertex_normals();
        mesh
    }

    #[test]
    fn sharp_edges_are_split_and_blunt_ones_are_not() {
        // Five vertices, and the two of the sharp edge once more.
        let sharp = split(59.0);
        assert_eq!(sharp.positions.len(), 7);
        for (t, triangle) in sharp.triangles.iter().enumerate() {
            for &i in triangle {
                let n = sharp.normals[i as usize];
                assert_eq!(n[2] == 1.0, t != 1, "triangle {t}: {n:?}");
            }
        }
        let blunt = split(61.0);
        assert_eq!(blunt.positions.len(), 5);
        assert!(blunt.normals[0][2] < 1.0);
        assert_eq!(split(180.0).positions.len(), 5);
        assert_eq!(split(0.0).positions.len(), 7);
    }
}
