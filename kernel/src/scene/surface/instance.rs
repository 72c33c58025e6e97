//! Surface points under an instance's map.
//!
//! Positions and tangents are transformed by the map, normals by its inverse transpose, so that the outside of a mirrored
//! instance remains the outside.

use super::normal::NormalMap;
use super::point::SurfacePoint;
use crate::math::Frame;
use crate::math::affine::{
    transform_magnitude, transform_normal, transform_point, transform_vector, translation,
};
use crate::scene::intersect::ROUNDING;
use crate::scene::records::Instance;

/// Transforms a point from the space of its group to the world.
pub(super) fn transform_to_world(record: &Instance, p: &mut SurfacePoint, instance: u32) {
    let (to_world, to_object) = (&record.to_world, &record.to_object);
    let (in_group, normal_in_group) = (p.position, p.geometric_normal);
    p.instance = instance;
    p.position = transform_point(to_world, in_group);
    let geometric = NormalMap::new(
        transform_normal(to_object, normal_in_group),
        normal_in_group,
    );
    p.geometric_normal = geometric.n;
    p.dp_du = transform_vector(to_world, p.dp_du);
    p.dp_dv = transform_vector(to_world, p.dp_dv);
    let n = transform_normal(to_object, p.frame.n);
    let normal = NormalMap::new(n, p.geometric_normal);
    p.dn_du = normal.derivative(transform_normal(to_object, p.dn_du));
    p.dn_dv = normal.derivative(transform_normal(to_object, p.dn_dv));
    let tangent = if p.dp_du.length_squared() > 0.0 {
        p.dp_du
    } else {
        transform_vector(to_world, p.frame.s)
    };
    p.frame = Frame::from_normal_tangent(normal.n, tangent);
    // The error in the group and that of mapping a ray's origin into it, as long as the map makes them along the normal,
    // and the rounding of the position here.
    let outside = transform_magnitude(to_world, in_group) + translation(to_world).abs();
    let inside = transform_magnitude(to_object, p.position) + translation(to_object).abs();
    let mapped = 8.0 * ROUNDING * inside.dot(normal_in_group.abs());
    p.position_error = (p.position_error + mapped) * geometric.inverse_length
        + 8.0 * ROUNDING * outside.dot(p.geometric_normal.abs());
}
