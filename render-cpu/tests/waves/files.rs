//! Meshes and images that the scenes refer to.

use image::{
    DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, Rgb32FImage, RgbImage, Rgba, RgbaImage,
};
use std::f32::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;
use tempfile::TempDir;

/// A folder that is removed in the end.
pub struct Files(TempDir);

impl Files {
    /// Writes them all.
    pub fn new() -> Files {
        let files = Files(tempfile::tempdir().expect("a folder"));
        files.write("ball.obj", &ball());
        files.write("tinted.ply", &tinted());
        files.images();
        files
    }

    pub fn folder(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder().join(name), text).expect("a file");
    }

    /// One image for each form that texels have in memory, of sides that are no powers of two.
    fn images(&self) {
        let wave = |i: u32| ((i * 97 + 13) % 256) as u8;
        let color = RgbImage::from_fn(5, 7, |x, y| {
            Rgb([wave(x + 11 * y), wave(3 * x + y), wave(7 * x + 5 * y)])
        });
        self.save("color.png", color.clone().into());
        self.save("color.bmp", color.into());
        let grey = GrayImage::from_fn(6, 3, |x, y| Luma([wave(x + 6 * y)]));
        self.save("grey.png", grey.into());
        let alpha = RgbaImage::from_fn(4, 4, |x, y| {
            Rgba([wave(x), wave(y), wave(x + y), wave(x * y)])
        });
        self.save("alpha.png", alpha.into());
        let deep: ImageBuffer<Rgb<u16>, Vec<u16>> = ImageBuffer::from_fn(3, 5, |x, y| {
            Rgb([x, y, x + y].map(|i| ((i * 7919 + 4000) % 65536) as u16))
        });
        self.save("deep.png", DynamicImage::ImageRgb16(deep));
        let normals = RgbImage::from_fn(9, 9, |x, y| {
            Rgb([128 + (x * 12 % 60) as u8, 110 + (y * 17 % 50) as u8, 230])
        });
        self.save("normals.png", normals.into());
        // A sun on a gradient.
        let sky = Rgb32FImage::from_fn(32, 16, |x, y| {
            let sun = if (x, y) == (9, 4) { 60.0 } else { 0.0 };
            Rgb([
                0.1 + 0.02 * x as f32 + sun,
                0.3 + sun,
                0.9 - 0.05 * y as f32,
            ])
        });
        self.save("sky.hdr", sky.into());
        self.save(
            "dot.hdr",
            Rgb32FImage::from_pixel(1, 1, Rgb([0.5, 0.25, 1.5])).into(),
        );
    }

    fn save(&self, name: &str, image: DynamicImage) {
        image.save(self.folder().join(name)).expect("an image");
    }
}

/// A unit sphere of triangles with normals and texture coordinates.
fn ball() -> String {
    const ROWS: usize = 8;
    const COLUMNS: usize = 12;
    let mut text = String::new();
    for row in 0..=ROWS {
        for column in 0..=COLUMNS {
            let (v, u) = (row as f32 / ROWS as f32, column as f32 / COLUMNS as f32);
            let ((st, ct), (sp, cp)) = ((PI * v).sin_cos(), (TAU * u).sin_cos());
            let (x, y, z) = (st * cp, ct, -st * sp);
            writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}\nvt {u} {v}").expect("text");
        }
    }
    let mut face = |corners: [usize; 3]| {
        let [a, b, c] = corners.map(|i| i + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").expect("text");
    };
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let first = row * (COLUMNS + 1) + column;
            let below = first + COLUMNS + 1;
            if row > 0 {
                face([first, below, first + 1]);
            }
            if row + 1 < ROWS {
                face([first + 1, below, below + 1]);
            }
        }
    }
    text
}

/// A wavy sheet over [-1, 1]^2 with a colour at each vertex, a number at each vertex and a colour for each face.
fn tinted() -> String {
    const SIDE: usize = 4;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\n",
        (SIDE + 1) * (SIDE + 1)
    );
    for name in ["x", "y", "z", "u", "v", "r", "g", "b", "rough_0"] {
        writeln!(text, "property float {name}").expect("text");
    }
    writeln!(text, "element face {}", 2 * SIDE * SIDE).expect("text");
    text += "property list uchar int vertex_indices\n";
    for name in ["r", "g", "b"] {
        writeln!(text, "property float {name}").expect("text");
    }
    text += "end_header\n";
    for i in 0..=SIDE {
        for j in 0..=SIDE {
            let (u, v) = (j as f32 / SIDE as f32, i as f32 / SIDE as f32);
            let (x, y, z) = (2.0 * u - 1.0, 2.0 * v - 1.0, 0.2 * (5.0 * u).sin() * v);
            let rough = 0.05 + 0.3 * u;
            writeln!(text, "{x} {y} {z} {u} {v} {u} {v} 0.7 {rough}").expect("text");
        }
    }
    for i in 0..SIDE {
        for j in 0..SIDE {
            let a = i * (SIDE + 1) + j;
            let d = a + SIDE + 1;
            let tint = 0.2 + 0.05 * (i * SIDE + j) as f32;
            writeln!(text, "3 {a} {} {d} {tint} 0.4 0.8", a + 1).expect("text");
            writeln!(text, "3 {} {} {d} 0.9 {tint} 0.1", a + 1, d + 1).expect("text");
        }
    }
    text
}
