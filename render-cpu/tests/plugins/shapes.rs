//! Heightfields of 0.6.

use crate::build;

/// A file of heights: 3 x 2, from the top left.
fn heights(folder: &std::path::Path) -> String {
    let mut bytes = b"Pf\n3 2\n-1\n".to_vec();
    for value in [0.25_f32, 0.5, 0.75, 0.0, 1.0, -1.0] {
        // Rows of a float map go from the bottom up.
        bytes.extend(value.to_le_bytes());
    }
    let path = folder.join("heights.pfm");
    std::fs::write(&path, bytes).expect("a file");
    path.display().to_string()
}

#[test]
fn values_are_heights_over_the_square() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = heights(folder.path());
    let direct = format!(
        r#"<shape type="heightfield"><string name="filename" value="{file}"/><float name="scale" value="2"/></shape>"#
    );
    let nested = format!(
        r#"<shape type="heightfield"><float name="scale" value="2"/><texture type="bitmap"><string name="filename" value="{file}"/></texture></shape>"#
    );
    for content in [direct, nested] {
        let tables = build("0.6.0", &content).tables;
        assert_eq!(
            tables.positions,
            [
                [-1.0, -1.0, 0.0],
                [0.0, -1.0, 2.0],
                [1.0, -1.0, -2.0],
                [-1.0, 1.0, 0.5],
                [0.0, 1.0, 1.0],
                [1.0, 1.0, 1.5]
            ]
        );
        assert_eq!(tables.uvs[0], [0.0, 0.0]);
        assert_eq!(tables.triangles.len(), 4);
        // Faces look up.
        for triangle in &tables.triangles {
            let [a, b, c] = triangle
                .vertices
                .map(|i| glam::Vec3::from(tables.positions[i as usize]));
            assert!((b - a).cross(c - a).z > 0.0);
        }
        assert!(tables.normals.iter().all(|n| n[2] > 0.0));
    }
}
