//! BSDF variants: the materials whose shading is compiled to loops over lanes of their own.
//!
//! A variant is one scattering model without coats, mixing factors, absorption or a perturbed frame, together with the
//! distribution of its microfacets. Materials of no variant are shaded path by path. The front end records the variant of a
//! material in its flags ([`material_flags`]), so that sorting paths reads a single word.

use crate::scene::{LobeRecord, distribution, lobe_kind, material_flag};

/// Lambertian reflection.
pub const DIFFUSE: u32 = 0;
/// Rough diffuse reflection.
pub const ROUGH_DIFFUSE: u32 = 1;
/// Smooth conductor.
pub const CONDUCTOR: u32 = 2;
/// Smooth dielectric boundary.
pub const DIELECTRIC: u32 = 3;
/// Thin dielectric slab.
pub const THIN_DIELECTRIC: u32 = 4;
/// Diffuse base under a smooth dielectric.
pub const PLASTIC: u32 = 5;
/// Conductor with Beckmann facets.
pub const ROUGH_CONDUCTOR_BECKMANN: u32 = 6;
/// Conductor with GGX facets.
pub const ROUGH_CONDUCTOR_GGX: u32 = 7;
/// Dielectric boundary with Beckmann facets.
pub const ROUGH_DIELECTRIC_BECKMANN: u32 = 8;
/// Dielectric boundary with GGX facets.
pub const ROUGH_DIELECTRIC_GGX: u32 = 9;
/// Diffuse base under a dielectric with Beckmann facets.
pub const ROUGH_PLASTIC_BECKMANN: u32 = 10;
/// Diffuse base under a dielectric with GGX facets.
pub const ROUGH_PLASTIC_GGX: u32 = 11;
/// Number of variants; as a variant, none.
pub const COUNT: u32 = 12;

/// The scattering model of a variant. Inlined in every build, as the others are: loops over lanes then hold one model.
#[inline(always)]
pub const fn kind(variant: u32) -> u32 {
    match variant {
        DIFFUSE => lobe_kind::DIFFUSE,
        ROUGH_DIFFUSE => lobe_kind::ROUGH_DIFFUSE,
        CONDUCTOR => lobe_kind::CONDUCTOR,
        DIELECTRIC => lobe_kind::DIELECTRIC,
        THIN_DIELECTRIC => lobe_kind::THIN_DIELECTRIC,
        PLASTIC => lobe_kind::PLASTIC,
        ROUGH_CONDUCTOR_BECKMANN | ROUGH_CONDUCTOR_GGX => lobe_kind::ROUGH_CONDUCTOR,
        ROUGH_DIELECTRIC_BECKMANN | ROUGH_DIELECTRIC_GGX => lobe_kind::ROUGH_DIELECTRIC,
        _ => lobe_kind::ROUGH_PLASTIC,
    }
}

/// Whether the variant has microfacets.
#[inline(always)]
pub const fn is_rough(variant: u32) -> bool {
    variant >= ROUGH_CONDUCTOR_BECKMANN
}

/// The microfacet distribution of a rough variant.
#[inline(always)]
pub const fn microfacets(variant: u32) -> u32 {
    match variant {
        ROUGH_CONDUCTOR_GGX | ROUGH_DIELECTRIC_GGX | ROUGH_PLASTIC_GGX => distribution::GGX,
        _ => distribution::BECKMANN,
    }
}

/// The variant of a scattering model with a microfacet distribution; [`COUNT`] if there is none.
#[inline(always)]
pub fn of(kind: u32, microfacets: u32) -> u32 {
    let rough = if microfacets > distribution::GGX {
        COUNT
    } else if kind == lobe_kind::ROUGH_CONDUCTOR {
        ROUGH_CONDUCTOR_BECKMANN + microfacets
    } else if kind == lobe_kind::ROUGH_DIELECTRIC {
        ROUGH_DIELECTRIC_BECKMANN + microfacets
    } else if kind == lobe_kind::ROUGH_PLASTIC {
        ROUGH_PLASTIC_BECKMANN + microfacets
    } else {
        COUNT
    };
    if kind == lobe_kind::DIFFUSE {
        DIFFUSE
    } else if kind == lobe_kind::ROUGH_DIFFUSE {
        ROUGH_DIFFUSE
    } else if kind == lobe_kind::CONDUCTOR {
        CONDUCTOR
    } else if kind == lobe_kind::DIELECTRIC {
        DIELECTRIC
    } else if kind == lobe_kind::THIN_DIELECTRIC {
        THIN_DIELECTRIC
    } else if kind == lobe_kind::PLASTIC {
        PLASTIC
    } else {
        rough
    }
}

/// The flags that tell the wavefront the variant of a material of the given lobes, to be added to
/// [`Material::flags_of`](crate::scene::Material::flags_of).
pub fn material_flags(lobes: &[LobeRecord]) -> u32 {
    if lobes.len() != 1 || !lobes[0].is_plain() {
        return 0;
    }
    let variant = of(lobes[0].kind, lobes[0].distribution);
    if variant < COUNT {
        (variant + 1) << material_flag::ACCELERATOR_SHIFT
    } else {
        0
    }
}

/// The variant in a material's flags; not below [`COUNT`] if there is none.
#[inline(always)]
pub fn of_material(flags: u32) -> u32 {
    ((flags >> material_flag::ACCELERATOR_SHIFT) & 0xff).wrapping_sub(1)
}
