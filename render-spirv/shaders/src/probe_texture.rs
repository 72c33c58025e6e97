//! The probe of textures: it needs the tables of a scene, whose coordinates are the inputs.

use crate::scene_entry::{scene_entry, vector};
use halflight_kernel::scene::texture;
use spirv_std::glam::Vec2;

// Input i goes to texture i modulo their number.
scene_entry!(textures, |view, settings, work, out[slot], paths[path]| {
    let uv = view.tables.uvs[slot];
    let index = slot % view.tables.textures.len();
    let colour = texture::eval_uv(&view.tables, index as u32, Vec2::new(uv[0], uv[1]));
    out[slot] = vector(colour, 0.0);
});
