//! Normal and bump maps: perturbed shading frames.
//!
//! A normal map's texel c in [0, 1]^3 is the normal 2 c - 1 in the shading frame (s, t, n) of the surface. A bump map's
//! h(u, v), a displacement along n in scene units, tilts the tangents (Blinn 1978, "Simulation of Wrinkled Surfaces",
//! without the terms in dn/du):
//! dp_du' = dp_du + n (dh/du - n . dp_du), likewise in v, n' = dp_du' x dp_dv', on the side of n.
//! In both cases s' is dp_du made orthogonal to n'. Maps nest: the parent's frame is the surface frame of its child.
//!
//! The result is an orthonormal frame in local coordinates of the surface point; where a map has no direction (a zero
//! normal, degenerate uv) the frame stays as it was.

use crate::math::{Frame, float};
use crate::scene::{FrameMap, NONE, SurfacePoint, Tables, frame_map_kind, texture};
use glam::Vec3;

/// Deepest nesting that is followed.
const MAX_NESTING: usize = 4;

/// The frame perturbed by map `index` and its parents, in local coordinates of `point.frame`.
pub fn perturbed_frame(tables: &Tables<'_>, index: u32, point: &SurfacePoint) -> Frame {
    // The chain runs from the innermost map outwards, the frames are built from the outermost inwards.
    let mut chain = [NONE; MAX_NESTING];
    let mut length = 0;
    let mut current = index;
    while current != NONE && length < MAX_NESTING {
        chain[length] = current;
        length += 1;
        current = tables.frame_maps[current as usize].parent;
    }
    let mut frame = point.frame;
    for i in 0..length {
        let map = tables.frame_maps[chain[length - 1 - i] as usize];
        frame = apply(tables, &map, point, &frame);
    }
    Frame {
        s: point.frame.to_local(frame.s),
        t: point.frame.to_local(frame.t),
        n: point.frame.to_local(frame.n),
    }
}

/// One map on top of `frame`, in world space.
fn apply(tables: &Tables<'_>, map: &FrameMap, point: &SurfacePoint, frame: &Frame) -> Frame {
    let normal = if map.kind == frame_map_kind::NORMAL {
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
    Frame::from_normal_tangent(normal * (1.0 / float::sqrt(length2)), point.dp_du)
}
