//! Lights of a single position or a single direction.
//!
//! - Point: intensity I in all directions, `E = I / d^2`.
//! - Spot: `E = I f(theta) T / d^2` along +z of its frame. The falloff f is one inside the beam's angle and falls
//!   linearly *in the angle* to zero at the cutoff; T is an optional texture at
//!   `uv = 1/2 + (x, y) / (2 z tan(cutoff))`.
//! - Projector: a texture seen from a pinhole along +z, `E = pi T(uv) / (z^2 cos theta)` on a facing surface, with
//!   `uv = 1/2 - (x, y) / (2 z tan)`: a plane at z = 1 across the axis is lit with an irradiance of pi T, evenly.
//! - Directional: irradiance E on a facing surface, from infinity, travelling along +z.
//! - Collimated: a power along +z from a point, without width. No point is lit by it but where the beam ends, so that only walks
//!   from the light find it.
//!
//! Here E is in W/m^2 on a surface that faces the light, x, y, z the reference point in the light's frame. Definitions
//! and the factor pi are those of Mitsuba 3 (numbers in the tests).

use super::direct_sample::DirectSample;
use crate::math::affine::{transform_point, transform_vector, translation};
use crate::math::{Rgb, float, vec3};
use crate::scene::texture::eval_uv;
use crate::scene::{Emitter, NONE, Tables, emitter_kind, features};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// The emitter's colour times its texture at `uv`.
#[inline]
fn color(tables: &Tables<'_>, emitter: &Emitter, uv: Vec2) -> Rgb {
    let value = vec3(emitter.radiance.value);
    if !tables.has(features::TEXTURES) || emitter.radiance.texture == NONE {
        value
    } else {
        value * eval_uv(tables, emitter.radiance.texture, uv)
    }
}

/// The factor of a spot light at an angle from its axis, from that of the beam to that of the cutoff.
#[inline]
fn spot_falloff(angle: f32, beam: f32, cutoff: f32) -> f32 {
    if angle >= cutoff {
        0.0
    } else if angle <= beam {
        1.0
    } else {
        (cutoff - angle) / (cutoff - beam)
    }
}

/// The light that arrives at `reference`.
pub fn sample(tables: &Tables<'_>, emitter: u32, reference: Vec3) -> DirectSample {
    let record = &tables.emitters[emitter as usize];
    let mut result = DirectSample {
        pdf: 1.0,
        is_delta: 1,
        emitter,
        ..DirectSample::NONE
    };
    if record.kind == emitter_kind::DIRECTIONAL {
        let axis = transform_vector(&record.to_world, Vec3::Z);
        let length = axis.length();
        if !(length > 0.0) {
            return DirectSample::NONE;
        }
        result.direction = axis * (-1.0 / length);
        result.distance = f32::MAX;
        result.radiance = vec3(record.radiance.value);
        return result;
    }
    let position = translation(&record.to_world);
    let to_light = position - reference;
    let distance2 = to_light.length_squared();
    if !(distance2 > 1e-30) || !float::is_finite(distance2) {
        return DirectSample::NONE;
    }
    result.distance = float::sqrt(distance2);
    result.direction = to_light / result.distance;
    result.target = position;
    if record.kind == emitter_kind::POINT {
        result.radiance = vec3(record.radiance.value) / distance2;
        return result;
    }
    let local = transform_point(&record.to_local, reference);
    let radiance = if record.kind == emitter_kind::SPOT {
        spot(tables, record, local) / distance2
    } else if record.kind == emitter_kind::PROJECTOR {
        projector(tables, record, local)
    } else {
        Vec3::ZERO
    };
    if !(radiance.max_element() > 0.0) || !radiance.is_finite() {
        return DirectSample::NONE;
    }
    result.radiance = radiance;
    result
}

/// Intensity of a point light, spot light or projector in a unit world direction: its irradiance on a facing surface times
/// the squared distance.
pub fn intensity(tables: &Tables<'_>, emitter: u32, direction: Vec3) -> Rgb {
    let record = &tables.emitters[emitter as usize];
    if record.kind == emitter_kind::POINT {
        return vec3(record.radiance.value);
    }
    // A beam has no intensity: all of its power goes one way.
    if record.kind == emitter_kind::COLLIMATED {
        return Vec3::ZERO;
    }
    let local = transform_vector(&record.to_local, direction);
    if record.kind == emitter_kind::SPOT {
        spot(tables, record, local)
    } else {
        projector(tables, record, local)
    }
}

/// Intensity of a spot light towards a point in its frame.
#[inline]
fn spot(tables: &Tables<'_>, record: &Emitter, local: Vec3) -> Rgb {
    let (beam, cutoff) = (record.parameters[0], record.parameters[1]);
    // The arc tangent of the two components keeps its precision near the axis, where the cosine's does not.
    let across = local.truncate();
    let angle = float::atan2(float::sqrt(across.length_squared()), local.z);
    let falloff = spot_falloff(angle, beam, cutoff);
    if falloff <= 0.0 {
        return Vec3::ZERO;
    }
    let scale = 0.5 / (local.z * float::tan(cutoff));
    color(tables, record, across * scale + 0.5) * falloff
}

/// Irradiance of a projector on a surface that faces it at a point in its frame.
#[inline]
fn projector(tables: &Tables<'_>, record: &Emitter, local: Vec3) -> Rgb {
    let (tan_x, tan_y) = (record.parameters[0], record.parameters[1]);
    if !(local.z > 0.0) || !(tan_x > 0.0) || !(tan_y > 0.0) {
        return Vec3::ZERO;
    }
    let uv = Vec2::new(
        0.5 - 0.5 * local.x / (local.z * tan_x),
        0.5 - 0.5 * local.y / (local.z * tan_y),
    );
    // Unequal also where it is not a number.
    if uv != uv.max(Vec2::ZERO).min(Vec2::ONE) {
        return Vec3::ZERO;
    }
    let cos_theta = local.z / local.length();
    color(tables, record, uv) * (PI / (local.z * local.z * cos_theta))
}

/// See [`super::power`].
#[cfg(not(target_arch = "spirv"))]
pub(super) fn power(tables: &Tables<'_>, emitter: &Emitter) -> f64 {
    use crate::math::luminance;
    let pi = core::f64::consts::PI;
    // A texture counts by the mean over a grid.
    const N: u32 = 16;
    let mut mean = 0.0;
    for i in 0..N * N {
        let uv = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
        mean += f64::from(luminance(color(tables, emitter, uv))) / f64::from(N * N);
    }
    match emitter.kind {
        emitter_kind::POINT => 4.0 * pi * mean,
        emitter_kind::COLLIMATED => mean,
        emitter_kind::SPOT => {
            // The solid angle of the cone half way down the falloff.
            let half = 0.5 * (emitter.parameters[0] + emitter.parameters[1]);
            2.0 * pi * (1.0 - f64::from(float::cos(half))) * mean
        }
        emitter_kind::PROJECTOR => {
            4.0 * pi * f64::from(emitter.parameters[0] * emitter.parameters[1]) * mean
        }
        _ => pi * f64::from(tables.info.radius) * f64::from(tables.info.radius) * mean,
    }
}
