//! Differential geometry of a triangle.
//!
//! p = p0 + b1 e1 + b2 e2. The uv map (b1, b2) -> (u, v) is affine, so with its inverse
//! dp/du = (e1 dv2 - e2 dv1) / det, dp/dv = (e2 du1 - e1 du2) / det, det = du1 dv2 - du2 dv1 (Pharr, Jakob, Humphreys
//! 2023, section 6.5.3), and the same combination of dn/db1, dn/db2 gives dn/du, dn/dv, where n = N / |N| is the
//! *normalised* interpolated normal: dn/db = (dN/db - n (n . dN/db)) / |N|. Without uvs (u, v) = (b1, b2). Where the uv map
//! has no inverse dp/du, dp/dv are any orthonormal tangents and dn/du, dn/dv the derivatives along them. Flat normals have
//! zero derivatives. Checked: every derivative against central differences in f64.

use super::normal::{NormalMap, unit_or};
use super::point::{SurfacePoint, detail};
use crate::math::float::{abs, sqrt};
use crate::math::{Frame, element, field, vec3};
use crate::scene::intersect::ROUNDING;
use crate::scene::records::{NONE, shape_flag};
use crate::scene::view::Tables;
use glam::{Vec2, Vec3};

/// The point with barycentric weights `b1`, `b2` of the second and third vertex, in the space of its group.
#[inline]
pub fn triangle_point(tables: &Tables<'_>, primitive: u32, b1: f32, b2: f32) -> SurfacePoint {
    triangle_point_with::<{ detail::CURVATURE }>(tables, primitive, b1, b2)
}

/// [`triangle_point`] with one of the degrees of [`detail`].
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn triangle_point_with<const DETAIL: u32>(
    tables: &Tables<'_>,
    primitive: u32,
    b1: f32,
    b2: f32,
) -> SurfacePoint {
    let corners = corners(tables, primitive);
    triangle_point_of::<DETAIL>(&corners, primitive, b1, b2)
}

/// What the tables hold about a triangle.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Corners {
    pub shape: u32,
    pub material: u32,
    pub emitter: u32,
    /// Of the shape.
    pub flags: u32,
    pub normal_offset: u32,
    pub uv_offset: u32,
    pub positions: [Vec3; 3],
    /// Zeros without texture coordinates.
    pub uvs: [Vec2; 3],
    /// Zeros without vertex normals.
    pub normals: [Vec3; 3],
}

impl Corners {
    /// Of no triangle.
    pub const ZERO: Corners = Corners {
        shape: 0,
        material: 0,
        emitter: NONE,
        flags: 0,
        normal_offset: NONE,
        uv_offset: NONE,
        positions: [Vec3::ZERO; 3],
        uvs: [Vec2::ZERO; 3],
        normals: [Vec3::ZERO; 3],
    };
}

/// Area of a triangle by its corners' positions.
#[inline]
pub(in crate::scene) fn area([p0, p1, p2]: [Vec3; 3]) -> f32 {
    0.5 * sqrt((p1 - p0).cross(p2 - p0).length_squared())
}

/// Whether the vertex normals of a mesh are to be interpolated.
#[inline]
pub(super) fn is_smooth(normal_offset: u32, flags: u32) -> bool {
    normal_offset != NONE && flags & shape_flag::FACE_NORMALS == 0
}

/// What the tables hold about a triangle.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(in crate::scene) fn corners(tables: &Tables<'_>, primitive: u32) -> Corners {
    let triangle = element(tables.triangles, primitive);
    let shape = triangle.shape;
    let [i0, i1, i2] = triangle.vertices;
    let mut corners = Corners {
        shape,
        material: field(tables.shapes, shape, |s| s.material),
        emitter: field(tables.shapes, shape, |s| s.emitter),
        flags: field(tables.shapes, shape, |s| s.flags),
        normal_offset: field(tables.shapes, shape, |s| s.normal_offset),
        uv_offset: field(tables.shapes, shape, |s| s.uv_offset),
        positions: [
            vec3(element(tables.positions, i0)),
            vec3(element(tables.positions, i1)),
            vec3(element(tables.positions, i2)),
        ],
        ..Corners::ZERO
    };
    // Lanes without normals or uvs are compiled without them.
    #[cfg(not(target_arch = "spirv"))]
    {
        if tables.normals.is_empty() {
            corners.normal_offset = NONE;
        }
        if tables.uvs.is_empty() {
            corners.uv_offset = NONE;
        }
    }
    let (uv_offset, normal_offset) = (corners.uv_offset, corners.normal_offset);
    if uv_offset != NONE {
        corners.uvs = [
            uv_of(tables, i0, uv_offset),
            uv_of(tables, i1, uv_offset),
            uv_of(tables, i2, uv_offset),
        ];
    }
    if is_smooth(normal_offset, corners.flags) {
        corners.normals = [
            normal_of(tables, i0, normal_offset),
            normal_of(tables, i1, normal_offset),
            normal_of(tables, i2, normal_offset),
        ];
    }
    corners
}

/// [`triangle_point_with`] of a triangle that has been looked up.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(in crate::scene) fn triangle_point_of<const DETAIL: u32>(
    corners: &Corners,
    primitive: u32,
    b1: f32,
    b2: f32,
) -> SurfacePoint {
    let [p0, p1, p2] = corners.positions;
    let (e1, e2) = (p1 - p0, p2 - p0);
    let position = p0 + e1 * b1 + e2 * b2;

    let cross = e1.cross(e2);
    let squared = cross.length_squared();
    let area2 = sqrt(squared);
    let inverse_area2 = if area2 > 1e-30 { 1.0 / area2 } else { 0.0 };
    let mut geometric_normal = if squared > 1e-30 && squared < f32::MAX {
        cross * inverse_area2
    } else {
        unit_or(scaled_cross(e1, e2), Vec3::Z)
    };

    // The map from (b1, b2) to (u, v), by its columns.
    let (mut uv, mut duv1, mut duv2) = (Vec2::new(b1, b2), Vec2::X, Vec2::Y);
    if corners.uv_offset != NONE {
        let [uv0, uv1, uv2] = corners.uvs;
        (duv1, duv2) = (uv1 - uv0, uv2 - uv0);
        uv = uv0 + duv1 * b1 + duv2 * b2;
    }
    let is_smooth = is_smooth(corners.normal_offset, corners.flags);
    let (mut dn1, mut dn2) = (Vec3::ZERO, Vec3::ZERO);
    let mut n = geometric_normal;
    if is_smooth {
        let n0 = corners.normals[0];
        let (n1, n2) = (corners.normals[1] - n0, corners.normals[2] - n0);
        let normal = NormalMap::new(n0 + n1 * b1 + n2 * b2, geometric_normal);
        n = normal.n;
        if DETAIL >= detail::CURVATURE {
            dn1 = normal.derivative(n1);
            dn2 = normal.derivative(n2);
        }
    }
    let position_error = position_error(position, e1, e2, geometric_normal, inverse_area2);
    let map_normal = geometric_normal;
    if corners.flags & shape_flag::FLIP_NORMALS != 0 {
        geometric_normal = -geometric_normal;
        n = -n;
        dn1 = -dn1;
        dn2 = -dn2;
    }
    let (mut dp_du, mut dp_dv) = (Vec3::ZERO, Vec3::ZERO);
    let (mut dn_du, mut dn_dv) = (Vec3::ZERO, Vec3::ZERO);
    let mut frame = Frame {
        s: Vec3::ZERO,
        t: Vec3::ZERO,
        n,
    };
    if DETAIL >= detail::TANGENTS {
        let map = UvMap::new(duv1, duv2, e1, e2, map_normal, inverse_area2);
        (dp_du, dp_dv) = (map.dp_du, map.dp_dv);
        if !map.is_moderate {
            let frame = Frame::from_normal(geometric_normal);
            (dp_du, dp_dv) = (frame.s, frame.t);
        }
        frame = Frame::from_normal_tangent(n, dp_du);
        if DETAIL >= detail::CURVATURE && is_smooth {
            (dn_du, dn_dv) = (map.u(dn1, dn2), map.v(dn1, dn2));
            if !(is_moderate(dn_du) && is_moderate(dn_dv)) {
                (dn_du, dn_dv) = (Vec3::ZERO, Vec3::ZERO);
            }
        }
    }
    SurfacePoint {
        position,
        position_error,
        geometric_normal,
        frame,
        uv,
        barycentric: Vec2::new(b1, b2),
        dp_du,
        dp_dv,
        dn_du,
        dn_dv,
        shape: corners.shape,
        primitive,
        instance: 0,
        material: corners.material,
        emitter: corners.emitter,
    }
}

/// A vector along e1 x e2 whose length neither overflows nor vanishes before the triangle does.
#[inline]
fn scaled_cross(e1: Vec3, e2: Vec3) -> Vec3 {
    let l1 = e1.abs().max_element();
    let l2 = e2.abs().max_element();
    if l1 > 0.0 && l2 > 0.0 {
        (e1 * (1.0 / l1)).cross(e2 * (1.0 / l2))
    } else {
        Vec3::ZERO
    }
}

/// Interpolation rounds each component of p0, b1 e1 and b2 e2; the plane distance of an intersection rounds p0 - o and the
/// products of the normal's components (each relative to the sum of the two products, not to their difference). Along the
/// normal that is at most `roundings` times the sum below; axis-parallel triangles lose all terms but their own offset.
#[inline]
fn position_error(position: Vec3, e1: Vec3, e2: Vec3, normal: Vec3, inverse_area2: f32) -> f32 {
    let (a1, a2) = (e1.abs(), e2.abs());
    let reach = a1 + a2;
    let products = Vec3::new(
        a1.y * a2.z + a1.z * a2.y,
        a1.z * a2.x + a1.x * a2.z,
        a1.x * a2.y + a1.y * a2.x,
    );
    // Slivers have a poor normal, but points found on them lie between their vertices: at most their reach away.
    let tilt = if inverse_area2 > 0.0 {
        (products.dot(reach) * inverse_area2).min(64.0 * reach.max_element())
    } else {
        64.0 * reach.max_element()
    };
    // The ray's origin after the offset is rounded in all components, and the floor leaves the triangle's vicinity
    // also where everything else is exact.
    let floor = position.abs().max_element() * 0.25;
    8.0 * ROUNDING * ((position.abs() + reach).dot(normal.abs()) + tilt + floor)
}

/// Whether a derivative is finite, and stays so under an instance's map.
#[inline]
fn is_moderate(v: Vec3) -> bool {
    abs(v.x) + abs(v.y) + abs(v.z) < 1e25
}

/// The inverse of the map from barycentric weights to uv, and the tangents that it makes of the edges.
#[derive(Clone, Copy)]
struct UvMap {
    /// (db1/du, db2/du).
    du: Vec2,
    /// (db1/dv, db2/dv).
    dv: Vec2,
    dp_du: Vec3,
    dp_dv: Vec3,
    /// [`is_moderate`] of both tangents.
    is_moderate: bool,
}

impl UvMap {
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    fn new(duv1: Vec2, duv2: Vec2, e1: Vec3, e2: Vec3, normal: Vec3, inverse_area2: f32) -> UvMap {
        let determinant = duv1.x * duv2.y - duv1.y * duv2.x;
        let inverse = 1.0 / determinant;
        let map = UvMap::from_columns(
            Vec2::new(duv2.y, -duv1.y) * inverse,
            Vec2::new(-duv2.x, duv1.x) * inverse,
            e1,
            e2,
        );
        if abs(determinant) > 0.0 && map.is_moderate {
            return map;
        }
        // Orthonormal tangents s, t written in the basis e1, e2: b1 = n . (s x e2) / |e1 x e2|, b2 = n . (e1 x s) / ...
        let inverse = inverse_area2;
        let frame = Frame::from_normal(normal);
        UvMap::from_columns(
            Vec2::new(normal.dot(frame.s.cross(e2)), normal.dot(e1.cross(frame.s))) * inverse,
            Vec2::new(normal.dot(frame.t.cross(e2)), normal.dot(e1.cross(frame.t))) * inverse,
            e1,
            e2,
        )
    }

    #[inline]
    fn from_columns(du: Vec2, dv: Vec2, e1: Vec3, e2: Vec3) -> UvMap {
        let dp_du = e1 * du.x + e2 * du.y;
        let dp_dv = e1 * dv.x + e2 * dv.y;
        UvMap {
            du,
            dv,
            dp_du,
            dp_dv,
            is_moderate: is_moderate(dp_du) && is_moderate(dp_dv),
        }
    }

    /// The u derivative of something with the given derivatives in b1 and b2.
    #[inline]
    fn u(&self, d1: Vec3, d2: Vec3) -> Vec3 {
        d1 * self.du.x + d2 * self.du.y
    }

    /// The v derivative.
    #[inline]
    fn v(&self, d1: Vec3, d2: Vec3) -> Vec3 {
        d1 * self.dv.x + d2 * self.dv.y
    }
}

#[inline]
fn normal_of(tables: &Tables<'_>, vertex: u32, offset: u32) -> Vec3 {
    vec3(element(tables.normals, vertex.wrapping_add(offset)))
}

#[inline]
fn uv_of(tables: &Tables<'_>, vertex: u32, offset: u32) -> Vec2 {
    let uv = element(tables.uvs, vertex.wrapping_add(offset));
    Vec2::new(uv[0], uv[1])
}
