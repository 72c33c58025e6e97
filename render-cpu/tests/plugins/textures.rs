//! Textures of 0.6: grids, wireframes, colours of vertices, scales.

use crate::{build, pixels};

/// The image of a rectangle of reflectance `texture` under a white sky, which is the reflectance.
fn image(shape: &str, texture: &str) -> Vec<[f64; 3]> {
    let content = format!(r#"<shape type="{shape}"><bsdf type="diffuse">{texture}</bsdf></shape>"#);
    pixels(&build("0.6.0", &content), 64)
}

fn share_of(pixels: &[[f64; 3]], low: f64, high: f64) -> f64 {
    let mean = pixels.iter().map(|p| p[0]).sum::<f64>() / pixels.len() as f64;
    (mean - low) / (high - low)
}

#[test]
fn grid_lines_have_their_width() {
    let grid = |properties: &str| {
        image(
            "rectangle",
            &format!(
                r#"<texture name="reflectance" type="gridtexture"><rgb name="color0" value="0"/><rgb name="color1" value="1"/>{properties}</texture>"#
            ),
        )
    };
    // Lines of twice the width around whole coordinates: 1 - (1 - 2 w)^2 of the square, whatever the number of squares.
    for (width, scale) in [(0.1, 1.0), (0.1, 4.0), (0.25, 2.0)] {
        let pixels = grid(&format!(
            r#"<float name="lineWidth" value="{width}"/><float name="uvscale" value="{scale}"/>"#
        ));
        let expected = 1.0 - (1.0_f64 - 2.0 * width).powi(2);
        let share = share_of(&pixels, 0.0, 1.0);
        assert!(
            (share - expected).abs() < 0.01,
            "{width} {scale}: {share}, not {expected}"
        );
    }
    // Defaults: lines of 0.4 on 0.2.
    let defaults = image(
        "rectangle",
        r#"<texture name="reflectance" type="gridtexture"/>"#,
    );
    let share = share_of(&defaults, 0.2, 0.4);
    assert!((share - (1.0 - 0.98_f64.powi(2))).abs() < 0.01, "{share}");
}

#[test]
fn wireframes_follow_the_edges_of_triangles() {
    let frame = |properties: &str| {
        image(
            "rectangle",
            &format!(
                r#"<texture name="reflectance" type="wireframe"><rgb name="edgeColor" value="1"/><rgb name="interiorColor" value="0"/>{properties}</texture>"#
            ),
        )
    };
    // Two right triangles with legs of 2. Without a blend an edge is a band of the width w within each: the triangle less the similar
    // one around the same centre of the inscribed circle, 1 - (1 - w / r)^2.
    let radius = 2.0 - 2.0_f64.sqrt();
    for width in [0.05, 0.2] {
        let pixels = frame(&format!(
            r#"<float name="lineWidth" value="{width}"/><float name="stepWidth" value="0"/>"#
        ));
        let expected = 1.0 - (1.0 - width / radius).powi(2);
        let share = share_of(&pixels, 0.0, 1.0);
        assert!(
            (share - expected).abs() < 0.01,
            "{width}: {share}, not {expected}"
        );
    }
    // A tenth of the mean edge by default, blended over its outer half: less than the whole band.
    let mean_edge = (2.0 + 2.0 + 8.0_f64.sqrt()) / 3.0;
    let share = share_of(&frame(""), 0.0, 1.0);
    let band = |w: f64| 1.0 - (1.0 - w / radius).powi(2);
    assert!(
        share < band(0.1 * mean_edge) && share > band(0.05 * mean_edge),
        "{share}"
    );
    // Surfaces without triangles have no edges.
    let sphere = r#"<texture name="reflectance" type="wireframe"><rgb name="interiorColor" value="0.25"/></texture>"#;
    let scene = build(
        "0.6.0",
        &format!(
            r#"<shape type="sphere"><float name="radius" value="3"/><bsdf type="diffuse">{sphere}</bsdf></shape>"#
        ),
    );
    assert!(scene.tables.lobes.len() == 1);
}

#[test]
fn colours_of_vertices_are_decoded_before_version_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n-9 -9 0 128 128 128\n9 -9 0 128 128 128\n0 9 0 128 128 128\n3 0 1 2\n";
    let path = folder.path().join("c.ply");
    std::fs::write(&path, ply).expect("a file");
    let shown = |version: &str, texture: &str, properties: &str| {
        let content = format!(
            r#"<shape type="ply"><string name="filename" value="{}"/>{properties}<bsdf type="diffuse">{texture}</bsdf></shape>"#,
            path.display()
        );
        pixels(&build(version, &content), 1)[100][0]
    };
    let old = r#"<texture type="vertexcolors" name="reflectance"/>"#;
    let new = r#"<texture type="mesh_attribute" name="reflectance"><string name="name" value="vertex_color"/></texture>"#;
    let byte = 128.0_f64 / 255.0;
    let linear = ((byte + 0.055) / 1.055).powf(2.4);
    let encoded = r#"<boolean name="srgb" value="false"/>"#;
    for (value, expected) in [
        (shown("0.6.0", old, ""), linear),
        (shown("0.6.0", old, encoded), byte),
        (shown("3.0.0", new, ""), byte),
    ] {
        assert!((value - expected).abs() < 1e-4, "{value}, not {expected}");
    }
}

#[test]
fn scales_multiply_what_they_hold() {
    let half = r#"<texture type="scale" name="reflectance"><float name="scale" value="0.5"/><texture type="checkerboard"><rgb name="color0" value="0.8"/><rgb name="color1" value="0.8"/></texture></texture>"#;
    for pixel in image("rectangle", half) {
        assert!((pixel[0] - 0.4).abs() < 1e-5, "{pixel:?}");
    }
}

#[test]
fn attributes_of_meshes_have_a_scale() {
    let folder = tempfile::tempdir().expect("a folder");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float r\nproperty float g\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\nproperty float r\nproperty float g\nproperty float b\nend_header\n-9 -9 0 0.2 0.2 0.2\n9 -9 0 0.2 0.2 0.2\n0 9 0 0.2 0.2 0.2\n3 0 1 2 0.3 0.3 0.3\n";
    let path = folder.path().join("c.ply");
    std::fs::write(&path, ply).expect("a file");
    for (name, scale, expected) in [
        ("vertex_color", "", 0.2),
        ("vertex_color", r#"<float name="scale" value="3"/>"#, 0.6),
        ("face_color", "", 0.3),
        ("face_color", r#"<float name="scale" value="0.5"/>"#, 0.15),
    ] {
        let content = format!(
            r#"<shape type="ply"><string name="filename" value="{}"/><bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"><string name="name" value="{name}"/>{scale}</texture></bsdf></shape>"#,
            path.display()
        );
        let value = pixels(&build("3.0.0", &content), 1)[100][0];
        assert!(
            (value - expected).abs() < 1e-5,
            "{name}: {value}, not {expected}"
        );
    }
}
