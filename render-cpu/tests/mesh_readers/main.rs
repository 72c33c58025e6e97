//! Readers of mesh files: every variant reads back what was written, errors name the line or byte, and no bytes make
//! them panic or reserve memory that the file cannot fill.

mod damaged;
mod obj_files;
mod ply_files;
mod ply_lenient;
mod ply_writer;
mod serialized_files;
mod validation;

use halflight::mesh::{Mesh, MeshError, obj, ply, serialized};
use std::path::Path;

pub(crate) fn read_obj(text: &str) -> Result<Mesh, MeshError> {
    obj::read(text.as_bytes(), false, Path::new("test.obj"))
}

pub(crate) fn read_ply(bytes: &[u8]) -> Result<Mesh, MeshError> {
    ply::read(bytes, false, Path::new("test.ply"))
}

pub(crate) fn read_serialized(bytes: &[u8], index: u32) -> Result<Mesh, MeshError> {
    serialized::read(bytes, index, Path::new("test.serialized"))
}

pub(crate) fn message(result: Result<Mesh, MeshError>) -> String {
    result.expect_err("this file is wrong").to_string()
}

pub(crate) fn area(mesh: &Mesh) -> f64 {
    let corner = |i: u32| mesh.positions[i as usize].map(f64::from);
    let triangle_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        let e = |p: [f64; 3], k: usize| p[k] - a[k];
        let n = [
            e(b, 1) * e(c, 2) - e(b, 2) * e(c, 1),
            e(b, 2) * e(c, 0) - e(b, 0) * e(c, 2),
            e(b, 0) * e(c, 1) - e(b, 1) * e(c, 0),
        ];
        0.5 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
    };
    mesh.triangles.iter().map(triangle_area).sum()
}

pub(crate) const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
