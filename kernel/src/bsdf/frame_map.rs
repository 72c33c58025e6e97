//! Normal and bump maps: perturbed shading frames.
//!
//! A normal map's texel c in [0, 1]^3 is the normal 2 c - 1 in the shading frame (s, t, n) of the surface. A bump map's
//! h(u, v), a displacement along n in scene units, tilts the tangents (Blinn 1978, "Simulation of Wrinkled Surfaces",
//! without the terms in dn/du):
//! dp_du' = dp_du + n (dh/du - n . dp_du), likewise in v, n' = dp_du' x dp_dv', on the side of n.
//! The new tangent is the old one (normal map) or dp_du (bump map) made orthogonal to n'. Maps nest: the parent's frame
//! is the surface frame of its child.
//!
//! A perturbed normal that faces away from wi although the surface faces it would be black: its tangential part is mirrored,
//! n' becomes 2 (n . n') n - n', which faces wi. The terminator of bumps, where n' is lit and the surface faces away, is
//! softened by a microfacet shadowing term (Conty Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to Solve
//! the Bump Terminator Problem", Ray Tracing Gems): G = 2 / (1 + sqrt(1 + a^2 tan^2 theta)), a^2 = min(1, tan^2(n, n') / 8),
//! theta the angle between n and the direction towards the light. Both are what the reference renderer does, to the
//! tolerance in the tests.
//!
//! The result is an orthonormal frame in local coordinates of the surface point; where a map has no direction (a zero
//! normal, degenerate uv) the frame stays as it was.

use crate::math::{Frame, float};
use crate::scene::{FrameMap, NONE, SurfacePoint, Tables, frame_map_kind, texture};
use glam::Vec3;

/// Deepest nesting that is followed.
const MAX_NESTING: usize = 4;

/// The frame perturbed by map `index` and its parents, seen from `wi`, both in local coordinates of `point.frame`.
pub fn perturbed_frame(tables: &Tables<'_>, index: u32, point: &SurfacePoint, wi: Vec3) -> Frame {
    // The chain runs from the innermost map outwards, the frames are built from the outermost inwards.
    let mut chain = [NONE; MAX_NESTING];
    let mut length = 0;
    let mut current = index;
    while current != NONE && length < MAX_NESTING {
        chain[length] = current;
        length += 1;
        current = tables.frame_maps[current as usize].parent;
    }
    let wi = point.frame.to_world(wi);
    let mut frame = point.frame;
    for i in 0..length {
        let map = tables.frame_maps[chain[length - 1 - i] as usize];
        frame = apply(tables, &map, point, &frame, wi);
    }
    Frame {
        s: point.frame.to_local(frame.s),
        t: point.frame.to_local(frame.t),
        n: point.frame.to_local(frame.n),
    }
}

/// One map on top of `frame`, in world space.
fn apply(
    tables: &Tables<'_>,
    map: &FrameMap,
    point: &SurfacePoint,
    frame: &Frame,
    wi: Vec3,
) -> Frame {
    let is_normal_map = map.kind == frame_map_kind::NORMAL;
    let normal = if is_normal_map {
        let color = texture::eval_at_point(tables, map.texture, point);
        frame.to_world(color * 2.0 - Vec3::ONE)
    } else {
        let gradient = texture::eval_gradient(tables, map.texture, point) * map.scale;
        let n = frame.n;
        let dp_du = point.dp_du + n * (gradient.x - n.dot(point.dp_du));
        let dp_dv = point.dp_dv + n * (gradient.y - n.dot(point.dp_dv));
        let normal = dp_du.cross(dp_dv);
        if normal.dot(n) < 0.0 { -normal } else { normal }
    };
    let length2 = normal.length_squared();
    if !(length2 > 1e-30 && length2 < f32::MAX) {
        return *frame;
    }
    let mut normal = normal * (1.0 / float::sqrt(length2));
    if normal.dot(wi) * frame.n.dot(wi) < 0.0 {
        normal = frame.n * (2.0 * frame.n.dot(normal)) - normal;
    }
    let tangent = if is_normal_map { frame.s } else { point.dp_du };
    Frame::from_normal_tangent(normal, tangent)
}

/// Shadowing of the light from direction `w`, given the cosine of the perturbed normal with the surface's and that of `w`
/// with the surface's normal; 1 for an unperturbed normal.
#[inline]
pub fn terminator_shadowing(cos_normals: f32, cos_light: f32) -> f32 {
    let cos2_normals = float::sqr(cos_normals).min(1.0);
    let cos2_light = float::sqr(cos_light).min(1.0);
    if cos2_light <= 0.0 {
        return 0.0;
    }
    // min(1, tan^2 / 8) without a division by a vanishing cosine.
    let sin2_normals = 1.0 - cos2_normals;
    let alpha2 = if sin2_normals >= 8.0 * cos2_normals {
        1.0
    } else {
        0.125 * sin2_normals / cos2_normals
    };
    let tan2_light = (1.0 - cos2_light) / cos2_light;
    2.0 / (1.0 + float::sqrt(1.0 + alpha2 * tan2_light))
}
