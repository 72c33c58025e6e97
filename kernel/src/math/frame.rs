//! Orthonormal frames with z along the normal.
//!
//! `to_local` and `to_world` are inverse to each other up to rounding (a property test: 16 ulp of the
//! vector's length). Local cosines: `cos_theta(w) = w.z`.

use glam::Vec3;

/// A right-handed orthonormal frame: columns `s`, `t`, `n` in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent (local x).
    pub s: Vec3,
    /// Second tangent (local y), `n x s`.
    pub t: Vec3,
    /// Normal (local z).
    pub n: Vec3,
}

impl Frame {
    /// The identity.
    pub const LOCAL: Frame = Frame {
        s: Vec3::X,
        t: Vec3::Y,
        n: Vec3::Z,
    };

    /// Any frame around the unit vector `n`, without a branch on its direction but the sign of z
    /// (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    #[inline]
    pub fn from_normal(n: Vec3) -> Frame {
        let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// The frame around unit `n` whose s is the part of `tangent` orthogonal to `n`; any frame when that vanishes.
    ///
    /// Orthonormal to a few roundings whatever the angle of the two: the part along `n` that rounding leaves in a small
    /// difference is taken off once more.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn from_normal_tangent(n: Vec3, tangent: Vec3) -> Frame {
        let mut s = tangent - n * n.dot(tangent);
        let mut length2 = s.length_squared();
        let tangent2 = tangent.length_squared();
        if length2 > 1e-12 * tangent2 && length2 > 1e-36 {
            if length2 < 0.25 * tangent2 {
                s -= n * n.dot(s);
                length2 = s.length_squared();
            }
            let s = s * (1.0 / super::float::sqrt(length2));
            Frame {
                s,
                t: n.cross(s),
                n,
            }
        } else {
            Frame::from_normal(n)
        }
    }

    /// World vector to local coordinates.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.s.dot(v), self.t.dot(v), self.n.dot(v))
    }

    /// Local vector to world coordinates.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

/// The unit vector along `(x, y, z)` with `z` clamped to zero from below; `Z` if all vanish.
#[inline]
pub fn upper_unit_vector(x: f32, y: f32, z: f32) -> Vec3 {
    let m = Vec3::new(x, y, z.max(0.0));
    let length = super::float::safe_sqrt(m.length_squared());
    if length < 1e-18 {
        return Vec3::Z;
    }
    m * (1.0 / length)
}
