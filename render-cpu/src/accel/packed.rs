//! Triangles as the traversal reads them.

use glam::Vec4;
use halflight_kernel::math::vec3;
use halflight_kernel::scene::Tables;

/// The three vertices component by component: `axes[k]` holds component k of each, and the first vertex again. The
/// watertight test chooses its axes per ray, which here is a choice of rows, and does its three vertices at once.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct PackedTriangle {
    /// x, y and z of the vertices.
    pub axes: [Vec4; 3],
}

impl PackedTriangle {
    /// A triangle that nothing hits.
    pub const NOTHING: PackedTriangle = PackedTriangle {
        axes: [Vec4::NAN; 3],
    };

    /// The triangle with this index; [`PackedTriangle::NOTHING`] for other primitives.
    pub fn new(tables: &Tables<'_>, primitive: u32) -> PackedTriangle {
        let Some(triangle) = tables.triangles.get(primitive as usize) else {
            return PackedTriangle::NOTHING;
        };
        let [p0, p1, p2] = triangle
            .vertices
            .map(|v| vec3(tables.positions[v as usize]));
        PackedTriangle {
            axes: [
                Vec4::new(p0.x, p1.x, p2.x, p0.x),
                Vec4::new(p0.y, p1.y, p2.y, p0.y),
                Vec4::new(p0.z, p1.z, p2.z, p0.z),
            ],
        }
    }
}
