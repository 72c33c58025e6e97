//! The state of building a scene: the tables so far, and which objects they already hold.

use super::reading::Reading;
use super::value_range::ValueRange;
use crate::accel::GroupRange;
use crate::expression::SceneNames;
use crate::scene::tables::SceneTables;
use crate::scene::xml::{Object, Value};
use halflight_kernel::scene::{Camera, NONE, SceneInfo};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Where a table of rough transmittance lies in the data.
#[derive(Clone, Copy)]
pub(super) struct TransmittanceTable {
    /// First word.
    pub first: u32,
    /// Number of rows: one for each roughness.
    pub rows: u32,
    /// At the roughness of a table of one row.
    pub internal_reflectance: f32,
}

/// The growing tables, and what has been built already.
pub(super) struct Builder {
    /// The records so far.
    pub tables: SceneTables,
    /// What records are called.
    pub names: SceneNames,
    /// Materials by object index.
    pub materials: HashMap<usize, u32>,
    /// The material of shapes that name none: plain, of emitters, and of boundaries of media.
    pub default_materials: [Option<u32>; 3],
    /// Textures by object index.
    pub textures: HashMap<(usize, ValueRange), u32>,
    /// Textures whose range has been looked at.
    pub checked_textures: HashSet<u32>,
    /// Bitmaps by file and how it is read: first word, width, height, format.
    pub bitmaps: HashMap<(PathBuf, Reading), [u32; 4]>,
    /// Shape groups by object index.
    pub groups: HashMap<usize, u32>,
    /// Tables of rough transmittance by distribution, whether a texture gives the roughness, its bits, and the index's.
    pub transmittance_tables: HashMap<(u32, bool, u32, u32), TransmittanceTable>,
    /// The object of the irradiance meter that is the sensor, by its index.
    pub meter: Option<usize>,
    /// Material libraries of meshes that were read.
    pub libraries_read: usize,
}

impl Builder {
    /// Empty tables of a scene seen by a camera.
    pub fn new(camera: Camera) -> Builder {
        let data = (0..256)
            .map(|i| crate::scene::color::srgb_to_linear(f64::from(i) / 255.0) as f32)
            .collect();
        Builder {
            tables: SceneTables {
                positions: Vec::new(),
                normals: Vec::new(),
                uvs: Vec::new(),
                triangles: Vec::new(),
                quadrics: Vec::new(),
                shapes: Vec::new(),
                instances: Vec::new(),
                materials: Vec::new(),
                lobes: Vec::new(),
                factors: Vec::new(),
                frame_maps: Vec::new(),
                textures: Vec::new(),
                texels: Vec::new(),
                data,
                emitters: Vec::new(),
                camera,
                info: SceneInfo {
                    center: [0.0; 3],
                    radius: 1.0,
                    environment: NONE,
                    srgb_table: 0,
                    flags: 0,
                },
                groups: vec![GroupRange::default()],
            },
            names: SceneNames::default(),
            materials: HashMap::new(),
            default_materials: [None; 3],
            textures: HashMap::new(),
            checked_textures: HashSet::new(),
            bitmaps: HashMap::new(),
            groups: HashMap::new(),
            transmittance_tables: HashMap::new(),
            meter: None,
            libraries_read: 0,
        }
    }
}

/// Names the last of `count` records; those before it that have no name get none.
pub(super) fn name_last(names: &mut Vec<String>, count: usize, name: &str) {
    names.resize(count.max(1) - 1, String::new());
    names.push(name.to_owned());
}

/// What a record of an object is called: its id, or the stem of the name of its file.
pub(super) fn name_of(object: &Object) -> String {
    if let Some(id) = &object.id {
        return id.clone();
    }
    let file = object.properties.iter().find(|p| p.name == "filename");
    let stem = file.and_then(|p| match &p.value {
        Value::String(name) => Path::new(name).file_stem(),
        _ => None,
    });
    stem.map(|s| s.to_string_lossy().into_owned())
        .unwrap_or_default()
}
