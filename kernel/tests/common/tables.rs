//! Small scene tables owned by a test.

use super::empty_tables::empty_tables;
use glam::{Vec2, Vec3};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::*;

/// Owned tables; what a test does not fill stays empty.
#[derive(Default)]
pub struct Owned {
    /// Triangles.
    pub triangles: Vec<Triangle>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Lobes.
    pub lobes: Vec<LobeRecord>,
    /// Factors.
    pub factors: Vec<WeightFactor>,
    /// Frame maps.
    pub frame_maps: Vec<FrameMap>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Texels.
    pub texels: Vec<u32>,
    /// Floats.
    pub data: Vec<f32>,
}

impl Owned {
    /// The borrowed form.
    pub fn tables(&self) -> Tables<'_> {
        Tables {
            triangles: &self.triangles,
            materials: &self.materials,
            lobes: &self.lobes,
            factors: &self.factors,
            frame_maps: &self.frame_maps,
            textures: &self.textures,
            texels: &self.texels,
            data: &self.data,
            ..empty_tables()
        }
    }

    /// Appends a bitmap of floats, row by row, and returns its index.
    pub fn bitmap(&mut self, width: u32, texels: &[[f32; 3]], filter: u32, wrap: u32) -> u32 {
        let first = self.texels.len() as u32;
        self.texels
            .extend(texels.iter().flatten().map(|x| x.to_bits()));
        let mut texture = texture(texture_kind::BITMAP);
        let height = texels.len() as u32 / width;
        texture.data = [first, width, height, texel_format::RGB32F, filter, wrap];
        self.textures.push(texture);
        self.textures.len() as u32 - 1
    }
}

/// A texture of a kind with the identity map and white colours.
pub fn texture(kind: u32) -> Texture {
    Texture {
        kind,
        data: [0; 6],
        to_uv: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        color0: RgbParameter::constant([1.0; 3]),
        color1: RgbParameter::constant([1.0; 3]),
    }
}

/// A front-side white lobe record of a kind.
pub fn lobe_record(kind: u32) -> LobeRecord {
    LobeRecord {
        kind,
        distribution: distribution::GGX,
        flags: lobe_flag::FRONT,
        first_factor: 0,
        factor_count: 0,
        frame: NONE,
        reflectance: RgbParameter::constant([1.0; 3]),
        specular_reflectance: RgbParameter::constant([1.0; 3]),
        specular_transmittance: RgbParameter::constant([1.0; 3]),
        eta: RgbParameter::constant([1.5; 3]),
        k: RgbParameter::constant([0.0; 3]),
        alpha_u: ScalarParameter::constant(0.2),
        alpha_v: ScalarParameter::constant(0.2),
        table: NONE,
        table_rows: 1,
        internal_reflectance: 0.0,
        optical_depth: RgbParameter::constant([0.0; 3]),
        coat_count: 0,
        coats: [CoatRecord::NONE; MAX_COATS],
        exponent: ScalarParameter::constant(1.0),
    }
}

/// A point on the plane z = 0 with the given coordinates and material 0.
pub fn point(uv: Vec2) -> SurfacePoint {
    SurfacePoint {
        geometric_normal: Vec3::Z,
        frame: Frame::LOCAL,
        uv,
        dp_du: Vec3::X,
        dp_dv: Vec3::Y,
        primitive: NONE,
        ..SurfacePoint::ZERO
    }
}
