//! The features that a scene uses, as bits: shaders are specialised for them, without the code of all others.
//!
//! Compilers of graphics drivers inline all functions and take more than linear time for the result, so that some cannot
//! compile a shader over every scattering model, texture and light. The set is a specialisation constant of the entry points;
//! code of a single feature is guarded by a test of its bit, and the driver removes it where the bit is not set. On hosts
//! every test is true.
//!
//! Invariant (tests): a scene renders to the same image with its own set as with all features.

#[cfg(not(target_arch = "spirv"))]
use super::records::*;
use super::view::Tables;

/// The scattering model of a [`super::lobe_kind`]. Those from 15 on share the bit that no other kind has, since the set is
/// one word: a scene with one of them compiles all.
#[inline]
pub const fn lobe(kind: u32) -> u32 {
    if kind < 15 { 1 << kind } else { LATER_LOBES }
}

/// The scattering models whose kinds begin at 15.
const LATER_LOBES: u32 = 1 << 11;

/// Materials of more than one lobe.
pub const MIXTURES: u32 = 1 << 15;

/// The microfacets of a [`super::distribution`].
#[inline]
pub const fn microfacets(distribution: u32) -> u32 {
    1 << (16 + distribution)
}

/// Meshes.
pub const TRIANGLES: u32 = 1 << 20;
/// Analytic shapes.
pub const QUADRICS: u32 = 1 << 21;
/// Instances other than the world.
pub const INSTANCES: u32 = 1 << 22;
/// Textures of any kind.
pub const TEXTURES: u32 = 1 << 23;
/// Bitmaps among them.
pub const BITMAPS: u32 = 1 << 24;
/// Attributes of meshes, grids and wireframes among them.
pub const ATTRIBUTES: u32 = 1 << 25;
/// Normal and bump maps.
pub const FRAME_MAPS: u32 = 1 << 26;
/// Coats above lobes.
pub const COATS: u32 = 1 << 27;
/// Emission of shapes.
pub const AREA_LIGHTS: u32 = 1 << 28;
/// Light from infinity in all directions.
pub const ENVIRONMENT: u32 = 1 << 29;
/// Lights of one point or one direction.
pub const DELTA_LIGHTS: u32 = 1 << 30;
/// Mixing factors of lobes.
pub const FACTORS: u32 = 1 << 31;

/// Everything.
pub const ALL: u32 = u32::MAX;

impl Tables<'_> {
    /// Whether the scene may have one of the features.
    #[inline]
    pub fn has(&self, features: u32) -> bool {
        #[cfg(target_arch = "spirv")]
        {
            self.features & features != 0
        }
        #[cfg(not(target_arch = "spirv"))]
        {
            let _ = features;
            true
        }
    }
}

/// The features of a scene. Runs on the host only: it visits the tables.
#[cfg(not(target_arch = "spirv"))]
pub fn of(tables: &Tables<'_>) -> u32 {
    let mut set = 0;
    let mut add = |feature: u32, present: bool| {
        if present {
            set |= feature;
        }
    };
    add(TRIANGLES, !tables.triangles.is_empty());
    add(QUADRICS, !tables.quadrics.is_empty());
    add(INSTANCES, tables.instances.len() > 1);
    add(TEXTURES, !tables.textures.is_empty());
    for texture in tables.textures {
        add(BITMAPS, texture.kind == texture_kind::BITMAP);
        let attribute = texture.kind == texture_kind::VERTEX_ATTRIBUTE
            || texture.kind == texture_kind::FACE_ATTRIBUTE
            || texture.kind == texture_kind::GRID
            || texture.kind == texture_kind::WIREFRAME;
        add(ATTRIBUTES, attribute);
    }
    add(FRAME_MAPS, !tables.frame_maps.is_empty());
    add(FACTORS, !tables.factors.is_empty());
    for material in tables.materials {
        add(MIXTURES, material.lobe_count > 1);
    }
    for record in tables.lobes {
        add(lobe(record.kind), true);
        let is_rough = matches!(
            record.kind,
            lobe_kind::ROUGH_CONDUCTOR
                | lobe_kind::ROUGH_DIELECTRIC
                | lobe_kind::ROUGH_PLASTIC
                | lobe_kind::ROUGH_COAT
                | lobe_kind::DIFFRACTING_CONDUCTOR
                | lobe_kind::SCHLICK_REFLECTION
                | lobe_kind::THIN_TRANSMISSION
        );
        add(microfacets(record.distribution), is_rough);
        // Whatever its variant.
        add(
            microfacets(distribution::BECKMANN),
            record.kind == lobe_kind::WARD,
        );
        add(COATS, record.coat_count > 0);
    }
    for emitter in tables.emitters {
        match emitter.kind {
            emitter_kind::AREA => add(AREA_LIGHTS, true),
            emitter_kind::CONSTANT | emitter_kind::ENVIRONMENT => add(ENVIRONMENT, true),
            _ => add(DELTA_LIGHTS, true),
        }
    }
    set
}
