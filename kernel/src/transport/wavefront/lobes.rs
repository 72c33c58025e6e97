//! Lobes with their parameters looked up, in lanes.
//!
//! The BSDF variant ([`bsdf_variant`]) is a constant of each function, so that a loop over lanes holds the code of one
//! scattering model.

use super::bsdf_variant;
use super::segment::Segment;
use super::surfaces::PointLanes;
use super::textures::TextureLanes;
use crate::bsdf::Lobe;
use crate::bsdf::lookup::plain_lobe;
use crate::bsdf::microfacet::clamp_alpha;
use crate::bsdf::rough_transmittance::internal_reflectance;
use crate::math::{field as element_field, luminance};
use crate::scene::{LobeRecord, NONE, Tables, lobe_kind};
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;
use glam::Vec2;

/// The lobes of up to `N` points. Of a lobe only the fields that its kind reads are set.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct LobeLanes<const N: usize> {
    flags: [u32; N],
    alpha: [[f32; N]; 2],
    reflectance: Vec3Lanes<N>,
    specular_reflectance: Vec3Lanes<N>,
    specular_transmittance: Vec3Lanes<N>,
    eta: Vec3Lanes<N>,
    k: Vec3Lanes<N>,
    table: [u32; N],
    table_rows: [u32; N],
    internal_reflectance: [f32; N],
}

/// What a kind reads, as bits.
mod field {
    pub const REFLECTANCE: u32 = 1;
    pub const SPECULAR_REFLECTANCE: u32 = 2;
    pub const SPECULAR_TRANSMITTANCE: u32 = 4;
    pub const ETA: u32 = 8;
    pub const K: u32 = 16;
    pub const TABLE: u32 = 64;
    pub const INTERNAL: u32 = 128;
    pub const ALPHA: u32 = 256;
    pub const ALPHA_V: u32 = 512;
}

/// The fields that [`plain_lobe`] sets for a kind.
#[inline(always)]
const fn fields(kind: u32) -> u32 {
    use field::*;
    match kind {
        lobe_kind::DIFFUSE => REFLECTANCE,
        lobe_kind::ROUGH_DIFFUSE => REFLECTANCE | ALPHA,
        lobe_kind::CONDUCTOR => SPECULAR_REFLECTANCE | ETA | K,
        lobe_kind::ROUGH_CONDUCTOR => SPECULAR_REFLECTANCE | ETA | K | ALPHA | ALPHA_V,
        lobe_kind::DIELECTRIC | lobe_kind::THIN_DIELECTRIC => {
            SPECULAR_REFLECTANCE | SPECULAR_TRANSMITTANCE | ETA
        }
        lobe_kind::ROUGH_DIELECTRIC => {
            SPECULAR_REFLECTANCE | SPECULAR_TRANSMITTANCE | ETA | ALPHA | ALPHA_V
        }
        lobe_kind::PLASTIC => REFLECTANCE | SPECULAR_REFLECTANCE | ETA | INTERNAL,
        lobe_kind::ROUGH_PLASTIC => {
            REFLECTANCE | SPECULAR_REFLECTANCE | ETA | INTERNAL | ALPHA | ALPHA_V | TABLE
        }
        _ => u32::MAX,
    }
}

impl<const N: usize> LobeLanes<N> {
    /// The lobe at slot `k < N`.
    #[inline(always)]
    pub fn get<const VARIANT: u32>(&self, k: usize) -> Lobe {
        let reads = fields(bsdf_variant::kind(VARIANT));
        let mut lobe = Lobe {
            kind: bsdf_variant::kind(VARIANT),
            distribution: bsdf_variant::microfacets(VARIANT),
            flags: self.flags[k],
            weight: 1.0,
            ..Lobe::NONE
        };
        if reads & field::REFLECTANCE != 0 {
            lobe.reflectance = self.reflectance.get(k);
        }
        if reads & field::SPECULAR_REFLECTANCE != 0 {
            lobe.specular_reflectance = self.specular_reflectance.get(k);
        }
        if reads & field::SPECULAR_TRANSMITTANCE != 0 {
            lobe.specular_transmittance = self.specular_transmittance.get(k);
        }
        if reads & field::ETA != 0 {
            lobe.eta = self.eta.get(k);
        }
        if reads & field::K != 0 {
            lobe.k = self.k.get(k);
        }
        if reads & field::ALPHA != 0 {
            lobe.alpha = Vec2::new(self.alpha[0][k], self.alpha[1][k]);
        }
        if reads & field::TABLE != 0 {
            lobe.table = self.table[k];
            lobe.table_rows = self.table_rows[k];
        }
        if reads & field::INTERNAL != 0 {
            lobe.internal_reflectance = self.internal_reflectance[k];
        }
        lobe
    }

    #[inline(always)]
    fn set<const VARIANT: u32>(&mut self, k: usize, lobe: &Lobe) {
        let reads = fields(bsdf_variant::kind(VARIANT));
        self.flags[k] = lobe.flags;
        if reads & field::REFLECTANCE != 0 {
            self.reflectance.set(k, lobe.reflectance);
        }
        if reads & field::SPECULAR_REFLECTANCE != 0 {
            self.specular_reflectance.set(k, lobe.specular_reflectance);
        }
        if reads & field::SPECULAR_TRANSMITTANCE != 0 {
            self.specular_transmittance
                .set(k, lobe.specular_transmittance);
        }
        if reads & field::ETA != 0 {
            self.eta.set(k, lobe.eta);
        }
        if reads & field::K != 0 {
            self.k.set(k, lobe.k);
        }
        if reads & field::ALPHA != 0 {
            self.alpha[0][k] = lobe.alpha.x;
            self.alpha[1][k] = lobe.alpha.y;
        }
        if reads & field::TABLE != 0 {
            self.table[k] = lobe.table;
            self.table_rows[k] = lobe.table_rows;
        }
        if reads & field::INTERNAL != 0 {
            self.internal_reflectance[k] = lobe.internal_reflectance;
        }
    }

    /// Multiplies the fields that have a texture by it.
    pub fn look_up_textures<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        segment: Segment,
        textures: &mut TextureLanes<N>,
    ) {
        let reads = fields(bsdf_variant::kind(VARIANT));
        macro_rules! multiply {
            ($($field:ident)*) => {$(
                if reads & field::$field != 0 {
                    self.multiply::<VARIANT, { field::$field }>(simd, tables, points, segment, textures);
                }
            )*};
        }
        multiply!(REFLECTANCE SPECULAR_REFLECTANCE SPECULAR_TRANSMITTANCE ETA K ALPHA ALPHA_V);
    }

    /// Multiplies a field by its texture.
    #[inline(always)]
    fn multiply<const VARIANT: u32, const FIELD: u32>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        segment: Segment,
        textures: &mut TextureLanes<N>,
    ) {
        let mut any = 0;
        find_textures::<FIELD, N>(
            simd,
            tables,
            points,
            segment,
            &mut textures.texture,
            &mut any,
        );
        if any != 0 {
            textures.look_up(simd, tables, segment, &points.uv, Some(points));
            let values = &textures.value;
            if FIELD == field::ALPHA || FIELD == field::ALPHA_V {
                multiply_roughness::<VARIANT, FIELD, N>(
                    simd, tables, points, segment, values, self,
                );
            } else {
                multiply::<FIELD, N>(simd, segment, values, self);
            }
        }
    }
}

/// The only lobe of a plain material.
#[inline(always)]
fn lobe_of(tables: &Tables<'_>, material: u32) -> u32 {
    element_field(tables.materials, material, |m| m.first_lobe)
}

/// The texture of a record's field.
#[inline(always)]
fn texture_of<const FIELD: u32>(record: &LobeRecord) -> u32 {
    match FIELD {
        field::REFLECTANCE => record.reflectance.texture,
        field::SPECULAR_REFLECTANCE => record.specular_reflectance.texture,
        field::SPECULAR_TRANSMITTANCE => record.specular_transmittance.texture,
        field::ETA => record.eta.texture,
        field::K => record.k.texture,
        field::ALPHA => record.alpha_u.texture,
        _ => record.alpha_v.texture,
    }
}

multiversioned! {
    /// Looks up the lobes of plain materials without textures.
    pub(super) fn look_up<; const VARIANT: u32, const N: usize>(
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        segment: Segment,
        lobes: &mut LobeLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let lobe = match crate::math::within(tables.materials, points.material[k]) {
                Some(material) => match crate::math::within(tables.lobes, material.first_lobe) {
                    Some(record) => plain_lobe(record, bsdf_variant::kind(VARIANT)),
                    None => Lobe::NONE,
                },
                None => Lobe::NONE,
            };
            lobes.set::<VARIANT>(k, &lobe);
        }
    }

    /// The textures of a field, and whether there are any.
    fn find_textures<; const FIELD: u32, const N: usize>(
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        segment: Segment,
        textures: &mut [u32; N],
        any: &mut u32,
    ) {
        let mut found = 0;
        for k in segment.padded::<N>() {
            let lobe = lobe_of(tables, points.material[k]);
            let is_some = lobe < tables.lobes.len() as u32;
            let texture = element_field(tables.lobes, lobe, texture_of::<FIELD>);
            textures[k] = if is_some { texture } else { NONE };
            found |= (is_some & (texture != NONE)) as u32;
        }
        *any = found;
    }

    /// Multiplies a field of colours by its texture's values.
    fn multiply<; const FIELD: u32, const N: usize>(
        segment: Segment,
        values: &Vec3Lanes<N>,
        lobes: &mut LobeLanes<N>,
    ) {
        let row = match FIELD {
            field::REFLECTANCE => &mut lobes.reflectance,
            field::SPECULAR_REFLECTANCE => &mut lobes.specular_reflectance,
            field::SPECULAR_TRANSMITTANCE => &mut lobes.specular_transmittance,
            field::ETA => &mut lobes.eta,
            _ => &mut lobes.k,
        };
        for k in segment.padded::<N>() {
            row.set(k, row.get(k) * values.get(k));
        }
    }

    /// Multiplies a roughness by the values of its texture, clamps it, and looks up again what depends on it.
    fn multiply_roughness<; const VARIANT: u32, const FIELD: u32, const N: usize>(
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        segment: Segment,
        values: &Vec3Lanes<N>,
        lobes: &mut LobeLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let i = lobe_of(tables, points.material[k]);
            let is_v = FIELD == field::ALPHA_V;
            let parameter = if is_v {
                element_field(tables.lobes, i, |l| l.alpha_v.value)
            } else {
                element_field(tables.lobes, i, |l| l.alpha_u.value)
            };
            let has_texture = element_field(tables.lobes, i, texture_of::<FIELD>) != NONE;
            let alpha = if has_texture {
                parameter * luminance(values.get(k))
            } else {
                parameter
            };
            if bsdf_variant::kind(VARIANT) == lobe_kind::ROUGH_DIFFUSE {
                lobes.alpha[0][k] = alpha;
                lobes.alpha[1][k] = alpha;
            } else if is_v {
                lobes.alpha[1][k] = clamp_alpha(Vec2::splat(alpha)).x;
            } else {
                lobes.alpha[0][k] = clamp_alpha(Vec2::splat(alpha)).x;
            }
            if bsdf_variant::kind(VARIANT) == lobe_kind::ROUGH_PLASTIC && !is_v {
                let (table, rows) = (lobes.table[k], lobes.table_rows[k]);
                let internal = internal_reflectance(tables.data, table, rows, lobes.alpha[0][k]);
                let has_table = (table != NONE) & (rows > 1);
                lobes.internal_reflectance[k] = if has_table {
                    internal
                } else {
                    lobes.internal_reflectance[k]
                };
            }
        }
    }
}
