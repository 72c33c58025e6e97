//! What expressions can name in a scene.

use super::syntax::{NameKind, NamePattern, light};
use halflight_kernel::path::expression::{Region, region_kind};
use halflight_kernel::scene::{NONE, Tables, emitter_kind, quadric_kind};

/// Names of a scene's records, by their indices; empty for what has none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneNames {
    /// Of shapes: the id, or the stem of the file's name.
    pub shapes: Vec<String>,
    /// Of instances.
    pub instances: Vec<String>,
    /// Of materials: the id of the BSDF.
    pub materials: Vec<String>,
    /// Of emitters: the id, or the shape's, or the kind of plugin.
    pub emitters: Vec<String>,
}

/// The name at an index.
pub(crate) fn name(names: &[String], index: usize) -> &str {
    names.get(index).map_or("", String::as_str)
}

/// Which of [`light`] an emitter is.
pub(super) fn light_kind(kind: u32) -> u8 {
    match kind {
        emitter_kind::AREA => light::OBJECT,
        emitter_kind::CONSTANT | emitter_kind::ENVIRONMENT => light::BACKGROUND,
        _ => light::OTHER,
    }
}

/// The letter of an emitter in expressions that fits no other kind of emitters, or L.
pub(crate) fn light_letter(kind: u32) -> &'static str {
    match light_kind(kind) {
        light::OBJECT => "O",
        light::BACKGROUND => "B",
        _ => "L",
    }
}

/// The region of the shapes of a name: the ball of a sphere, else the box around all of them, along the axes of the world.
pub fn region(tables: &Tables<'_>, names: &SceneNames, wanted: &str) -> Option<Region> {
    let shapes = || {
        let all = tables.shapes.iter().enumerate();
        all.filter(|(i, _)| name(&names.shapes, *i) == wanted)
    };
    let quadric_of = |shape: usize| {
        let is_own = |q: &&halflight_kernel::scene::Quadric| q.shape as usize == shape;
        tables.quadrics.iter().find(is_own)
    };
    if let Some((index, _)) = shapes().next()
        && shapes().count() == 1
        && let Some(quadric) = quadric_of(index)
        && quadric.kind == quadric_kind::SPHERE
    {
        return Some(Region {
            to_unit: quadric.to_object,
            kind: region_kind::SPHERE,
        });
    }
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    let mut include = |p: [f32; 3]| {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    };
    for (index, shape) in shapes() {
        if let Some(quadric) = quadric_of(index) {
            // Around the corners of the box that holds the canonical surface.
            for corner in 0..8 {
                let side = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let m = &quadric.to_world;
                let corner = glam::Vec3::new(side(0), side(1), side(2));
                include(halflight_kernel::math::affine::transform_point(m, corner).to_array());
            }
            continue;
        }
        let first = shape.first_primitive as usize;
        for triangle in &tables.triangles[first..first + shape.primitive_count as usize] {
            for vertex in triangle.vertices {
                include(tables.positions[vertex as usize]);
            }
        }
    }
    if low[0] > high[0] {
        return None;
    }
    // A flat shape is a slab as thick as rounding needs.
    let margin = 1e-4 * (0..3).map(|i| high[i] - low[i]).fold(1e-6, f32::max);
    let mut to_unit = [0.0; 12];
    for axis in 0..3 {
        let half = 0.5 * (high[axis] - low[axis]) + margin;
        to_unit[4 * axis + axis] = 1.0 / half;
        to_unit[4 * axis + 3] = -0.5 * (high[axis] + low[axis]) / half;
    }
    Some(Region {
        to_unit,
        kind: region_kind::BOX,
    })
}

/// Name of the shape of an area light.
pub(crate) fn object_of_emitter(names: &SceneNames, shape: u32) -> &str {
    if shape == NONE {
        ""
    } else {
        name(&names.shapes, shape as usize)
    }
}

/// Whether anything in the scene fits a pattern.
pub(super) fn is_named(pattern: &NamePattern, tables: &Tables<'_>, names: &SceneNames) -> bool {
    let is_kind = |kind| pattern.kind == NameKind::Any || pattern.kind == kind;
    let any = |list: &[String]| {
        list.iter()
            .any(|n| !n.is_empty() && pattern.glob.matches(n))
    };
    let lamps = tables.emitters.iter();
    is_kind(NameKind::Object) && (any(&names.shapes) || any(&names.instances))
        || is_kind(NameKind::Material) && any(&names.materials)
        || is_kind(NameKind::Emitter) && any(&names.emitters)
        || is_kind(NameKind::Object)
            && lamps
                .map(|e| object_of_emitter(names, e.shape))
                .any(|n| !n.is_empty() && pattern.glob.matches(n))
}
