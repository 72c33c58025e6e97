//! Forms of lobes that loops over lanes ([`crate::transport::wave`]) are compiled for: a kind, and the distribution of its
//! microfacets.
//!
//! Hosts only.

use super::material::{distribution, lobe_kind};

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
/// Number of forms.
pub const COUNT: u32 = 12;

/// The kind of a form's lobes.
pub const fn kind(form: u32) -> u32 {
    match form {
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

/// Whether the form's lobes have microfacets.
pub const fn is_rough(form: u32) -> bool {
    form >= ROUGH_CONDUCTOR_BECKMANN
}

/// The distribution of the microfacets of a rough form.
pub const fn facets(form: u32) -> u32 {
    match form {
        ROUGH_CONDUCTOR_GGX | ROUGH_DIELECTRIC_GGX | ROUGH_PLASTIC_GGX => distribution::GGX,
        _ => distribution::BECKMANN,
    }
}

/// The form of a kind with a distribution; [`COUNT`] where there is none.
#[inline(always)]
pub fn of(kind: u32, facets: u32) -> u32 {
    let rough = if facets > distribution::GGX {
        COUNT
    } else if kind == lobe_kind::ROUGH_CONDUCTOR {
        ROUGH_CONDUCTOR_BECKMANN + facets
    } else if kind == lobe_kind::ROUGH_DIELECTRIC {
        ROUGH_DIELECTRIC_BECKMANN + facets
    } else if kind == lobe_kind::ROUGH_PLASTIC {
        ROUGH_PLASTIC_BECKMANN + facets
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
