//! `heightfield` of Mitsuba 0.6: an image of heights as a mesh.
//!
//! The image covers [-1, 1]^2: its first row is at y = -1, where v is 0. The luminance of its linear values times `scale` is z. It
//! comes from `filename`, or from a nested `bitmap`. Between four values 0.6 has a bilinear patch; here there are two triangles, which
//! agree with it at the values and along the sides of the patch. 0.6 also resamples images whose sides are not a power of two and
//! one more, which is not done here. With `shading_normals` (the default) normals are smooth.

use crate::image::{Bitmap, Texels};
use crate::mesh::Mesh;
use crate::scene::build::reading::Reading;
use crate::scene::color::srgb_to_linear;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::math::luminance;

/// The mesh of a heightfield, in its own space.
pub(super) fn mesh(object: &Object) -> Result<Mesh, SceneError> {
    let scale = object.get_float("scale", 1.0)? as f32;
    let is_smooth = object.get_bool("shading_normals", true)?;
    // The resolution of textures that have none of their own.
    object.get("width");
    object.get("height");
    let bitmap = match object.single_child_of(ObjectKind::Texture)? {
        Some(texture) if texture.plugin == "bitmap" => load(texture)?,
        Some(texture) => return Err(texture.error("only a bitmap can give the heights")),
        None => load(object)?,
    };
    let (width, height) = (bitmap.width, bitmap.height);
    if width < 2 || height < 2 {
        return Err(object.error("needs an image of at least 2 x 2 heights"));
    }
    let heights = values(&bitmap);
    let mut mesh = Mesh {
        face_normals: !is_smooth,
        ..Mesh::default()
    };
    let at = |i: u32, n: u32| i as f32 / (n - 1) as f32;
    for row in 0..height {
        for column in 0..width {
            let (u, v) = (at(column, width), at(row, height));
            let z = heights[row as usize * width as usize + column as usize] * scale;
            mesh.positions.push([2.0 * u - 1.0, 2.0 * v - 1.0, z]);
            mesh.uvs.push([u, v]);
        }
    }
    for row in 0..height - 1 {
        for column in 0..width - 1 {
            let a = row * width + column;
            let (b, c, d) = (a + 1, a + width, a + width + 1);
            mesh.triangles.push([a, b, d]);
            mesh.triangles.push([a, d, c]);
        }
    }
    Ok(mesh)
}

/// The image that an object names.
fn load(object: &Object) -> Result<Bitmap, SceneError> {
    let path = object.require_file("filename")?;
    let mut bitmap = Reading::of(object)?
        .load(&path)
        .map_err(|e| object.property_error("filename", e.to_string()))?;
    for warning in bitmap.warnings.drain(..) {
        object.property_warn("filename", format!("{}: {warning}", path.display()))?;
    }
    Ok(bitmap)
}

/// The heights, row by row from the top of the image.
fn values(bitmap: &Bitmap) -> Vec<f32> {
    match &bitmap.texels {
        Texels::Rgba8 { data, srgb } => {
            let linear = |byte: u8| {
                let encoded = f64::from(byte) / 255.0;
                (if *srgb {
                    srgb_to_linear(encoded)
                } else {
                    encoded
                }) as f32
            };
            let texels = data.as_chunks::<4>().0;
            let value = |t: &[u8; 4]| luminance([t[0], t[1], t[2]].map(linear).into());
            texels.iter().map(value).collect()
        }
        Texels::Rgb32F(data) => {
            let texels = data.as_chunks::<3>().0;
            texels.iter().map(|t| luminance((*t).into())).collect()
        }
    }
}
