//! Meshes with fewer triangles, for pages that would be too large otherwise.
//!
//! Vertices of a shape in the same cell of a grid become one, the first of them, and triangles that lose a corner vanish (Rossignac and
//! Borrel 1993). The grid is as fine as the wanted number of triangles allows, to a factor of 1.4.

use super::mesh::FlatMesh;
use std::collections::{HashMap, HashSet};

/// Most cells along the longest axis.
const FINEST: f32 = 8192.0;

/// The mesh, or one of at most `most` triangles instead.
pub(super) fn thinned(mesh: FlatMesh, most: usize) -> FlatMesh {
    if mesh.indices.len() <= most {
        return mesh;
    }
    let mut cells = FINEST;
    loop {
        let found = with_cells(&mesh, cells);
        if found.indices.len() <= most || cells < 2.0 {
            return found;
        }
        cells /= 1.4;
    }
}

/// The mesh on a grid of so many cells along the longest axis.
fn with_cells(mesh: &FlatMesh, cells: f32) -> FlatMesh {
    let axis = |pick: fn(f32, f32) -> f32, start: f32| {
        let fold = |a: [f32; 3], p: &[f32; 3]| [0, 1, 2].map(|i| pick(a[i], p[i]));
        mesh.positions.iter().fold([start; 3], fold)
    };
    let (low, high) = (axis(f32::min, f32::MAX), axis(f32::max, f32::MIN));
    let longest = [0, 1, 2]
        .map(|i| high[i] - low[i])
        .into_iter()
        .fold(1e-20, f32::max);
    let scale = cells / longest;
    let mut thin = FlatMesh::default();
    for [shape, first, count] in &mesh.ranges {
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        let mut seen: HashSet<[u32; 3]> = HashSet::new();
        for triangle in &mesh.indices[*first as usize..(first + count) as usize] {
            let corners = triangle.map(|vertex| {
                let p = mesh.positions[vertex as usize];
                let cell = [0, 1, 2].map(|i| ((p[i] - low[i]) * scale) as u32);
                *places.entry(cell).or_insert_with(|| {
                    thin.positions.push(p);
                    thin.positions.len() as u32 - 1
                })
            });
            let [a, b, c] = corners;
            let mut sorted = corners;
            sorted.sort_unstable();
            if a != b && b != c && c != a && seen.insert(sorted) {
                thin.add(*shape, corners);
            }
        }
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 n^2 triangles in the plane z = 0, of one shape, and a single triangle of another.
    fn grid(n: u32) -> FlatMesh {
        let mut mesh = FlatMesh::default();
        for y in 0..=n {
            for x in 0..=n {
                mesh.positions
                    .push([x as f32 / n as f32, y as f32 / n as f32, 0.0]);
            }
        }
        let at = |x: u32, y: u32| y * (n + 1) + x;
        for y in 0..n {
            for x in 0..n {
                mesh.add(0, [at(x, y), at(x + 1, y), at(x, y + 1)]);
                mesh.add(0, [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]);
            }
        }
        mesh.add(7, [0, at(n, 0), at(n, n)]);
        mesh
    }

    fn area(mesh: &FlatMesh) -> f32 {
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| glam::Vec3::from_array(mesh.positions[i as usize]));
            0.5 * (b - a).cross(c - a).length()
        };
        mesh.indices.iter().map(of).sum()
    }

    #[test]
    fn thin_meshes_cover_what_the_whole_one_covers() {
        let whole = grid(64);
        assert_eq!(thinned(whole.clone(), 10_000), whole);
        let thin = thinned(whole.clone(), 2000);
        assert!(
            thin.indices.len() <= 2000 && thin.indices.len() > 500,
            "{}",
            thin.indices.len()
        );
        assert!(
            (area(&thin) / area(&whole) - 1.0).abs() < 0.08,
            "{}",
            area(&thin)
        );
        let [first, second] = thin.ranges[..] else {
            panic!("{:?}", thin.ranges)
        };
        assert_eq!((first[0], first[1], second), (0, 0, [7, first[2], 1]));
        assert_eq!(first[2] as usize + 1, thin.indices.len());
    }
}
