//! Borrowed scene tables, and the view that transport reads.

use super::records::*;
use super::traverse::Traverse;
#[cfg(not(target_arch = "spirv"))]
use crate::math::table::most_elements;

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
    /// The features that the scene uses ([`super::features`]): a constant of the shader.
    #[cfg(target_arch = "spirv")]
    pub features: u32,
}

#[cfg(not(target_arch = "spirv"))]
impl Tables<'_> {
    /// The name of a table that has more elements than can be indexed ([`most_elements`]), and that limit.
    pub fn oversized(&self) -> Option<(&'static str, usize)> {
        fn check<T>(name: &'static str, table: &[T]) -> Option<(&'static str, usize)> {
            let most = most_elements::<T>();
            (table.len() > most).then_some((name, most))
        }
        check("vertices", self.positions)
            .or_else(|| check("normals", self.normals))
            .or_else(|| check("texture coordinates", self.uvs))
            .or_else(|| check("triangles", self.triangles))
            .or_else(|| check("spheres, disks and cylinders", self.quadrics))
            .or_else(|| check("shapes", self.shapes))
            .or_else(|| check("materials", self.materials))
            .or_else(|| check("scattering models", self.lobes))
            .or_else(|| check("textures", self.textures))
            .or_else(|| check("words of texels", self.texels))
            .or_else(|| check("numbers in tables", self.data))
            .or_else(|| check("emitters", self.emitters))
    }
}

/// Tables and a ray tracer over them.
#[derive(Clone, Copy)]
pub struct SceneView<'a, T: Traverse> {
    /// The tables.
    pub tables: Tables<'a>,
    /// The ray tracer.
    pub traverse: &'a T,
}
