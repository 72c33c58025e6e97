//! Borrowed scene tables, and the view that transport reads.

use super::records::*;
use super::traverse::Traverse;

/// The tables of a scene, borrowed.
#[derive(Clone, Copy)]
pub struct Tables<'a> {
    /// Vertex positions of all meshes, in world space (instance 0) or group space.
    pub positions: &'a [[f32; 3]],
    /// Vertex normals of the meshes that have them.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates of the meshes that have them.
    pub uvs: &'a [[f32; 2]],
    /// Triangles of all meshes.
    pub triangles: &'a [Triangle],
    /// Analytic shapes.
    pub quadrics: &'a [Quadric],
    /// Shapes.
    pub shapes: &'a [Shape],
    /// Instances; the first is the world.
    pub instances: &'a [Instance],
    /// Materials.
    pub materials: &'a [Material],
    /// Lobes of the materials.
    pub lobes: &'a [LobeRecord],
    /// Factors of the lobes' weights.
    pub factors: &'a [WeightFactor],
    /// Normal and bump maps.
    pub frame_maps: &'a [FrameMap],
    /// Textures.
    pub textures: &'a [Texture],
    /// Texels of the bitmaps.
    pub texels: &'a [u32],
    /// Sampling tables, attributes and other floats.
    pub data: &'a [f32],
    /// Emitters.
    pub emitters: &'a [Emitter],
    /// The sensor.
    pub camera: Camera,
    /// Facts about the whole.
    pub info: SceneInfo,
    /// What there is, see [`super::features`]: a constant of the shader.
    #[cfg(target_arch = "spirv")]
    pub features: u32,
}

/// Tables and a ray tracer over them.
#[derive(Clone, Copy)]
pub struct SceneView<'a, T: Traverse> {
    /// The tables.
    pub tables: Tables<'a>,
    /// The ray tracer.
    pub traverse: &'a T,
}
