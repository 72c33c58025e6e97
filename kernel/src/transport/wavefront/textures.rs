//! Texture lookups, in lanes: [`crate::scene::texture`].
//!
//! Nested textures are descended level by level; bitmaps then have a loop, and attributes of meshes are looked up slot by slot.

use super::segment::Segment;
use super::surfaces::PointLanes;
use crate::math::{Rgb, field, vec3};
use crate::scene::bitmap::Bitmap;
use crate::scene::texture::{
    MAX_NESTING, eval_at_point, eval_uv, is_nested, leads_to_second, transform_uv,
};
use crate::scene::{NONE, Tables, texture_kind};
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// A lookup at each of `N` slots.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct TextureLanes<const N: usize> {
    /// The texture, or [`NONE`].
    pub texture: [u32; N],
    /// The value that was found; one without a texture.
    pub value: Vec3Lanes<N>,
}

impl<const N: usize> TextureLanes<N> {
    /// Looks up the textures at `uv`, and overwrites [`TextureLanes::texture`]. Attributes of meshes are those of the `points`,
    /// zero without them.
    pub fn look_up(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        segment: Segment,
        uv: &[[f32; N]; 2],
        points: Option<&PointLanes<N>>,
    ) {
        for k in segment.padded::<N>() {
            self.value.x[k] = 1.0;
            self.value.y[k] = 1.0;
            self.value.z[k] = 1.0;
        }
        let mut is_done = false;
        // As in a single lookup: a texture that is still nested at the last level is black.
        for _ in 1..MAX_NESTING {
            let mut is_nested_further = 0;
            let (texture, value) = (&mut self.texture, &mut self.value);
            descend(
                simd,
                tables,
                segment,
                uv,
                texture,
                value,
                &mut is_nested_further,
            );
            is_done = is_nested_further == 0;
            if is_done {
                break;
            }
        }
        if !is_done {
            self.set_too_deep_to_black(tables, segment);
        }
        let mut others = 0;
        bitmaps(
            simd,
            tables,
            segment,
            uv,
            &self.texture,
            &mut self.value,
            &mut others,
        );
        if others != 0 {
            self.attributes(tables, segment, uv, points);
        }
    }

    /// Black for textures that are nested too deeply.
    #[inline(never)]
    fn set_too_deep_to_black(&mut self, tables: &Tables<'_>, segment: Segment) {
        for k in segment.occupied::<N>() {
            if is_nested(field(tables.textures, self.texture[k], |t| t.kind)) {
                self.value.set(k, Rgb::ZERO);
                self.texture[k] = NONE;
            }
        }
    }

    /// What is neither nested nor a bitmap, slot by slot.
    #[inline(never)]
    fn attributes(
        &mut self,
        tables: &Tables<'_>,
        segment: Segment,
        uv: &[[f32; N]; 2],
        points: Option<&PointLanes<N>>,
    ) {
        for k in segment.occupied::<N>() {
            let texture = self.texture[k];
            let kind = field(tables.textures, texture, |t| t.kind);
            if texture != NONE && kind != texture_kind::BITMAP {
                let attribute = match points {
                    Some(points) => eval_at_point(tables, texture, &points.get(k)),
                    None => eval_uv(tables, texture, Vec2::new(uv[0][k], uv[1][k])),
                };
                self.value.set(k, self.value.get(k) * attribute);
            }
        }
    }
}

/// Coordinates under the transformation of texture `i`.
#[inline(always)]
fn transformed(tables: &Tables<'_>, i: u32, uv: Vec2) -> Vec2 {
    let m = [
        field(tables.textures, i, |t| t.to_uv[0]),
        field(tables.textures, i, |t| t.to_uv[1]),
        field(tables.textures, i, |t| t.to_uv[2]),
        field(tables.textures, i, |t| t.to_uv[3]),
        field(tables.textures, i, |t| t.to_uv[4]),
        field(tables.textures, i, |t| t.to_uv[5]),
    ];
    transform_uv(&m, uv)
}

multiversioned! {
    /// Descends nested textures by one level; reports whether there were any.
    fn descend<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        uv: &[[f32; N]; 2],
        textures: &mut [u32; N],
        values: &mut Vec3Lanes<N>,
        is_nested_further: &mut u32,
    ) {
        let mut found = 0;
        for k in segment.padded::<N>() {
            let i = textures[k];
            let kind = field(tables.textures, i, |t| t.kind);
            let is_nested = is_nested(kind);
            let second = leads_to_second(kind, transformed(tables, i, Vec2::new(uv[0][k], uv[1][k])));
            let (first_value, first) = (
                field(tables.textures, i, |t| t.color0.value),
                field(tables.textures, i, |t| t.color0.texture),
            );
            let (second_value, other) = (
                field(tables.textures, i, |t| t.color1.value),
                field(tables.textures, i, |t| t.color1.texture),
            );
            let value = if second { vec3(second_value) } else { vec3(first_value) };
            let factor = if is_nested { value } else { Vec3::ONE };
            let next = if second { other } else { first };
            textures[k] = if is_nested { next } else { i };
            values.set(k, values.get(k) * factor);
            found |= is_nested as u32;
        }
        *is_nested_further = found;
    }

    /// Looks up the bitmaps among the textures; reports whether there are others.
    fn bitmaps<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        uv: &[[f32; N]; 2],
        textures: &[u32; N],
        values: &mut Vec3Lanes<N>,
        any_others: &mut u32,
    ) {
        let mut others = 0;
        for k in segment.padded::<N>() {
            let i = textures[k];
            let is_some = i < tables.textures.len() as u32;
            let is_bitmap = is_some & (field(tables.textures, i, |t| t.kind) == texture_kind::BITMAP);
            let at = transformed(tables, i, Vec2::new(uv[0][k], uv[1][k]));
            let value = Bitmap::of(tables, i).eval(tables, at);
            let factor = if is_bitmap { value } else { Vec3::ONE };
            values.set(k, values.get(k) * factor);
            others |= (is_some & !is_bitmap) as u32;
        }
        *any_others = others;
    }
}
