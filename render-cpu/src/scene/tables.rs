//! The owned tables of a scene, and their view and size.

use crate::accel::GroupRange;
use halflight_kernel::scene::{
    Camera, Emitter, FrameMap, Instance, LobeRecord, Material, Quadric, SceneInfo, Shape, Tables,
    Texture, Triangle, WeightFactor,
};

/// Everything that a rendering reads, as flat vectors of the kernel's records.
#[derive(Clone, Debug)]
pub struct SceneTables {
    /// See [`Tables::positions`].
    pub positions: Vec<[f32; 3]>,
    /// See [`Tables::normals`].
    pub normals: Vec<[f32; 3]>,
    /// See [`Tables::uvs`].
    pub uvs: Vec<[f32; 2]>,
    /// See [`Tables::triangles`].
    pub triangles: Vec<Triangle>,
    /// See [`Tables::quadrics`].
    pub quadrics: Vec<Quadric>,
    /// See [`Tables::shapes`].
    pub shapes: Vec<Shape>,
    /// See [`Tables::instances`].
    pub instances: Vec<Instance>,
    /// See [`Tables::materials`].
    pub materials: Vec<Material>,
    /// See [`Tables::lobes`].
    pub lobes: Vec<LobeRecord>,
    /// See [`Tables::factors`].
    pub factors: Vec<WeightFactor>,
    /// See [`Tables::frame_maps`].
    pub frame_maps: Vec<FrameMap>,
    /// See [`Tables::textures`].
    pub textures: Vec<Texture>,
    /// See [`Tables::texels`].
    pub texels: Vec<u32>,
    /// See [`Tables::data`].
    pub data: Vec<f32>,
    /// See [`Tables::emitters`].
    pub emitters: Vec<Emitter>,
    /// See [`Tables::camera`].
    pub camera: Camera,
    /// See [`Tables::info`].
    pub info: SceneInfo,
    /// Ranges of the groups that instances place.
    pub groups: Vec<GroupRange>,
}

impl SceneTables {
    /// The tables, borrowed for the kernel.
    pub fn view(&self) -> Tables<'_> {
        Tables {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            triangles: &self.triangles,
            quadrics: &self.quadrics,
            shapes: &self.shapes,
            instances: &self.instances,
            materials: &self.materials,
            lobes: &self.lobes,
            factors: &self.factors,
            frame_maps: &self.frame_maps,
            textures: &self.textures,
            texels: &self.texels,
            data: &self.data,
            emitters: &self.emitters,
            camera: self.camera,
            info: self.info,
        }
    }

    /// Whether rays meet the same triangles, quadrics and instances as in `other`, so that its trees serve both.
    pub fn has_geometry_of(&self, other: &SceneTables) -> bool {
        fn same<T: bytemuck::NoUninit>(a: &[T], b: &[T]) -> bool {
            bytemuck::cast_slice::<T, u8>(a) == bytemuck::cast_slice::<T, u8>(b)
        }
        same(&self.positions, &other.positions)
            && same(&self.triangles, &other.triangles)
            && same(&self.quadrics, &other.quadrics)
            && same(&self.instances, &other.instances)
            && self.groups == other.groups
    }

    /// Bytes held by the tables.
    pub fn memory_bytes(&self) -> usize {
        fn bytes<T>(v: &[T]) -> usize {
            size_of_val(v)
        }
        bytes(&self.positions)
            + bytes(&self.normals)
            + bytes(&self.uvs)
            + bytes(&self.triangles)
            + bytes(&self.quadrics)
            + bytes(&self.shapes)
            + bytes(&self.instances)
            + bytes(&self.materials)
            + bytes(&self.lobes)
            + bytes(&self.factors)
            + bytes(&self.frame_maps)
            + bytes(&self.textures)
            + bytes(&self.texels)
            + bytes(&self.data)
            + bytes(&self.emitters)
    }

    /// A number that differs for different scenes: FNV-1a over the words of all tables. Which part of the film is rendered
    /// makes no difference. Checkpoints and images keep it.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = Fingerprint(0xcbf2_9ce4_8422_2325);
        hash.add(&self.positions);
        hash.add(&self.normals);
        hash.add(&self.uvs);
        hash.add(&self.triangles);
        hash.add(&self.quadrics);
        hash.add(&self.shapes);
        hash.add(&self.instances);
        hash.add(&self.materials);
        hash.add(&self.lobes);
        hash.add(&self.factors);
        hash.add(&self.frame_maps);
        hash.add(&self.textures);
        hash.add(&self.texels);
        hash.add(&self.data);
        hash.add(&self.emitters);
        hash.add(&[Camera {
            crop_offset: [0, 0],
            crop_size: self.camera.film_size,
            ..self.camera
        }]);
        hash.add(&[self.info]);
        hash.0
    }
}

struct Fingerprint(u64);

impl Fingerprint {
    fn add<T: bytemuck::NoUninit>(&mut self, table: &[T]) {
        self.word(table.len() as u32);
        // Every record is made of 32-bit words.
        for word in bytemuck::cast_slice::<u8, [u8; 4]>(bytemuck::cast_slice(table)) {
            self.word(u32::from_le_bytes(*word));
        }
    }

    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3);
    }
}
