//! The nearest intersection along a ray, as plain data.

use bytemuck::{Pod, Zeroable};

/// The nearest intersection along a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// Ray parameter; [`f32::MAX`] when nothing was hit.
    pub t: f32,
    /// Barycentric weight of a triangle's second vertex; unused for quadrics.
    pub b1: f32,
    /// Barycentric weight of a triangle's third vertex; unused for quadrics.
    pub b2: f32,
    /// Index of a triangle, or the number of triangles plus the index of a quadric.
    pub primitive: u32,
    /// Index of the instance, 0 for the world.
    pub instance: u32,
}

impl Hit {
    /// No intersection.
    pub const MISS: Hit = Hit {
        t: f32::MAX,
        b1: 0.0,
        b2: 0.0,
        primitive: u32::MAX,
        instance: 0,
    };

    /// Whether something was hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.t < f32::MAX
    }

    /// Whether an intersection comes before this one in the order of [`crate::scene::Traverse::closest_hit`]; one at [`f32::MAX`], which
    /// is a miss, comes before none.
    #[inline]
    pub fn is_behind(&self, t: f32, primitive: u32, instance: u32) -> bool {
        let is_lower =
            primitive < self.primitive || (primitive == self.primitive && instance < self.instance);
        t < self.t || (t == self.t && self.is_hit() && is_lower)
    }
}
