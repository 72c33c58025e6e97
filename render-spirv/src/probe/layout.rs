//! Layouts of the records that host and shaders exchange, as the device sees them.
//!
//! A table of two records is filled with words that hold their own offsets. A probe reads the first word of every field of the
//! second record by its name, which gives the offsets of the fields and the stride of the records on the device. The lists of
//! fields are exhaustive: a new field that is missing here does not compile.

use crate::interface::{Dispatch, SceneConstants, WorkItem};
use halflight_kernel::path::PathRules;
use halflight_kernel::scene::{
    BvhNode, Camera, CoatRecord, Emitter, FrameMap, Instance, LobeRecord, Material, Quadric,
    RgbParameter, ScalarParameter, SceneInfo, Shape, Texture, Triangle, WeightFactor,
};
use halflight_kernel::transport::settings::{
    BidirectionalSettings, ChainSettings, DirectSettings, IntegratorSettings, OcclusionSettings,
    PhotonSettings, RegularizationSettings,
};

/// Word `i` of a table. As a float it is a normal number, which no device rounds.
pub const PATTERN: u32 = 0x4000_0000;

/// The first word of a value.
pub trait FirstWord: Copy {
    /// Its bits.
    fn first_word(self) -> u32;
}

impl FirstWord for u32 {
    fn first_word(self) -> u32 {
        self
    }
}

impl FirstWord for f32 {
    fn first_word(self) -> u32 {
        self.to_bits()
    }
}

impl<T: FirstWord, const N: usize> FirstWord for [T; N] {
    fn first_word(self) -> u32 {
        self[0].first_word()
    }
}

macro_rules! layouts {
    ($($function:ident, $record:ident { $first:ident $(, $field:ident)* })*) => {
        $(
            impl FirstWord for $record {
                fn first_word(self) -> u32 {
                    self.$first.first_word()
                }
            }

            /// Writes the offsets of the record's fields from `at` on and returns the end.
            pub fn $function(records: &[$record], out: &mut [u32], at: usize) -> usize {
                let $record { $first $(, $field)* } = records[1];
                let mut at = at;
                out[at] = $first.first_word();
                $(
                    at += 1;
                    out[at] = $field.first_word();
                )*
                at + 1
            }
        )*

        /// Record, field, and the word at which the field of the second record begins, in the order of the functions.
        #[cfg(not(target_arch = "spirv"))]
        pub mod host {
            use super::*;

            $(
                /// The fields of one record.
                pub fn $function() -> Vec<(&'static str, &'static str, u32)> {
                    let start = size_of::<$record>();
                    let word = |offset: usize| ((start + offset) / 4) as u32;
                    vec![
                        (stringify!($record), stringify!($first), word(core::mem::offset_of!($record, $first))),
                        $((stringify!($record), stringify!($field), word(core::mem::offset_of!($record, $field))),)*
                    ]
                }
            )*
        }
    };
}

layouts! {
    triangle, Triangle { vertices, shape }
    quadric, Quadric { to_world, to_object, kind, shape }
    shape, Shape { material, emitter, flags, normal_offset, uv_offset, first_vertex, first_primitive, primitive_count }
    instance, Instance { to_world, to_object, root, group }
    material, Material { first_lobe, lobe_count, flags }
    lobe, LobeRecord {
        kind, distribution, flags, first_factor, factor_count, frame, reflectance, specular_reflectance,
        specular_transmittance, eta, k, alpha_u, alpha_v, table, table_rows, internal_reflectance, optical_depth,
        coat_count, coats, exponent
    }
    factor, WeightFactor { parameter, complement }
    frame_map, FrameMap { kind, texture, scale, parent }
    texture, Texture { kind, data, to_uv, color0, color1 }
    emitter, Emitter {
        kind, radiance, to_world, to_local, parameters, shape, area, distribution, width, height, selection_pdf,
        selection_cdf
    }
    node, BvhNode { min, first, max, count }
    camera, Camera {
        kind, to_world, to_camera, film_size, crop_offset, crop_size, tan_half_width, tan_half_height,
        principal_point_offset, aperture_radius, focus_distance, clip, filter, filter_parameters, filter_table,
        filter_table_size, shape, shape_areas
    }
    info, SceneInfo { center, radius, environment, srgb_table, flags }
    settings, IntegratorSettings {
        kind, rules, direct, occlusion, bidirectional, photon, chains, regularization
    }
    rules, PathRules { max_depth, rr_depth, hide_emitters, strict_normals }
    direct, DirectSettings { emitter_samples, bsdf_samples }
    occlusion, OcclusionSettings { samples, distance }
    bidirectional, BidirectionalSettings { light_image, sample_direct, power_heuristic, only_s, only_t, unweighted, connections }
    photon, PhotonSettings { photon_count, alpha, initial_radius, gather_roughness, connections, least_radius, largest_radius, nearest }
    chains, ChainSettings {
        technique, p_large, candidates, chains, mutations, direct_samples, chain_length, bidirectional_weight,
        lens_weight, caustic_weight, multi_chain_weight, manifold_weight, half_vector_weight, lambda, half_vector_flags,
        half_vector_step, two_stage
    }
    regularization, RegularizationSettings { tau, radius, exponent, kernel, flags, fade, one_minus_gamma, quantile }
    constants, SceneConstants { camera, info, settings }
    item, WorkItem { pixel, sample, slot }
    dispatch, Dispatch { count, seed, sampler, first }
    rgb, RgbParameter { value, texture }
    scalar, ScalarParameter { value, texture }
    coat, CoatRecord { eta, optical_depth, alpha, table, table_rows }
}
