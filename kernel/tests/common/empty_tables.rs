//! Scene tables with nothing in them, to be filled in part: `Tables { quadrics: &q, ..empty_tables() }`.

use halflight_kernel::scene::Tables;

/// Nothing.
pub fn empty_tables() -> Tables<'static> {
    Tables {
        positions: &[],
        normals: &[],
        uvs: &[],
        triangles: &[],
        quadrics: &[],
        shapes: &[],
        instances: &[],
        materials: &[],
        lobes: &[],
        factors: &[],
        frame_maps: &[],
        textures: &[],
        texels: &[],
        data: &[],
        emitters: &[],
        camera: bytemuck::Zeroable::zeroed(),
        info: bytemuck::Zeroable::zeroed(),
    }
}
