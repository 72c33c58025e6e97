//! A vertex of a chain: position, orthonormal tangents, shading normal with its derivatives, and the kind of constraint.
//!
//! Moves of a vertex are measured in metres along `tangent_u`, `tangent_v`, which are orthonormal and span the geometric
//! tangent plane, so that 2x2 determinants are ratios of areas. The derivatives of the shading normal are taken along the
//! same two tangents: from dp/du, dp/dv by `dn_u /= |p_u|`, `p_v -= (p_u . p_v) p_u`, `dn_v -= (p_u . p_v) dn_u`, and so on.
//!
//! Half vectors are measured in a frame around the shading normal n that is defined by a *reference* vector r fixed in space:
//! `s = (r - (r.n) n) / |.|`, `t = n x s`. The papers take r = dp/du, whose own derivative they leave out; on a sphere, or
//! from triangle to triangle, it turns, and their J is then not the derivative of the half vectors it belongs to (the error
//! is `|h|` times the rate of turning). With a fixed r the derivative is exact and the chart is the same on all triangles of
//! a mesh. A Markov chain keeps r from state to state, so both directions of a mutation use the same chart.
//!
//! Checked: tangents and derivatives against central differences of the surfaces in f64.

use crate::math::Frame;
use crate::math::float::{abs, safe_sqrt, sqrt};
use crate::scene::SurfacePoint;
use glam::{Vec2, Vec3};

/// What is constrained at a vertex.
pub mod vertex_kind {
    /// An endpoint whose position is fixed.
    pub const PINNED_POSITION: u32 = 0;
    /// An endpoint that moves so that the direction of its edge is fixed: directional light, orthographic sensor,
    /// environment.
    pub const PINNED_DIRECTION: u32 = 1;
    /// Reflection.
    pub const REFLECTION: u32 = 2;
    /// Refraction.
    pub const REFRACTION: u32 = 3;
    /// Transmission between equal indices, where no half vector exists; the constraint is `wi + wo = 0`.
    pub const INDEX_MATCHED: u32 = 4;
}

/// Transmission with `|eta - 1|` below this is [`vertex_kind::INDEX_MATCHED`]: the half vector of an unbent ray has length
/// `|eta - 1|`, and `f32` directions leave an error of some 1e-7 in it.
pub const INDEX_MATCHED_TOLERANCE: f32 = 1e-3;

/// A vertex of a chain.
#[derive(Clone, Copy, Debug)]
pub struct ChainVertex {
    /// Position.
    pub position: Vec3,
    /// See [`SurfacePoint::position_error`].
    pub position_error: f32,
    /// Unit geometric normal; zero for a point in space, whose cosine counts as one.
    pub geometric_normal: Vec3,
    /// First unit tangent of the geometric surface.
    pub tangent_u: Vec3,
    /// Second unit tangent, orthogonal to the first.
    pub tangent_v: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
    /// Derivative of the shading normal along `tangent_u`.
    pub dn_u: Vec3,
    /// Derivative of the shading normal along `tangent_v`.
    pub dn_v: Vec3,
    /// Unit vector, fixed in space, that defines the frame of the half vector.
    pub reference: Vec3,
    /// Index of refraction towards the next vertex over that towards the previous one; 1 unless refracting.
    pub eta: f32,
    /// One of [`vertex_kind`].
    pub kind: u32,
    /// Roughness, as a Beckmann alpha, along `alpha_axis` and across it; zero for specular vertices.
    pub alpha: Vec2,
    /// Unit direction, in the frame of the half vector, of the first roughness.
    pub alpha_axis: Vec2,
    /// Material of the surface.
    pub material: u32,
    /// Where the surface was met: see [`SurfacePoint::barycentric`].
    pub barycentric: Vec2,
    /// See [`SurfacePoint::primitive`].
    pub primitive: u32,
    /// See [`SurfacePoint::instance`].
    pub instance: u32,
}

impl ChainVertex {
    /// Nothing; fills arrays.
    pub const NONE: ChainVertex = ChainVertex {
        position: Vec3::ZERO,
        position_error: 0.0,
        geometric_normal: Vec3::ZERO,
        tangent_u: Vec3::X,
        tangent_v: Vec3::Y,
        normal: Vec3::Z,
        dn_u: Vec3::ZERO,
        dn_v: Vec3::ZERO,
        reference: Vec3::X,
        eta: 1.0,
        kind: vertex_kind::PINNED_POSITION,
        alpha: Vec2::ZERO,
        alpha_axis: Vec2::X,
        material: u32::MAX,
        barycentric: Vec2::ZERO,
        primitive: u32::MAX,
        instance: 0,
    };

    /// A point on a surface with a pinned position; [`ChainVertex::scattering`] makes an inner vertex of it.
    #[inline]
    pub fn from_surface(point: &SurfacePoint) -> ChainVertex {
        ChainVertex::from_surface_with(point, reference_for(point.frame.n))
    }

    /// The same, with the frame of the half vector built around a given vector.
    #[inline]
    pub fn from_surface_with(point: &SurfacePoint, reference: Vec3) -> ChainVertex {
        let mut vertex = ChainVertex::without_axis(point, reference);
        vertex.set_axis(point);
        vertex
    }

    /// The axis of roughness: the first tangent of the shading frame.
    #[inline]
    pub fn set_axis(&mut self, point: &SurfacePoint) {
        self.alpha_axis = self.direction_in_frame(point.frame.s);
    }

    /// The same for a vertex whose roughness is the same along all axes.
    #[inline]
    pub fn without_axis(point: &SurfacePoint, reference: Vec3) -> ChainVertex {
        let mut vertex = ChainVertex {
            position: point.position,
            position_error: point.position_error,
            geometric_normal: point.geometric_normal,
            normal: point.frame.n,
            reference,
            material: point.material,
            barycentric: point.barycentric,
            primitive: point.primitive,
            instance: point.instance,
            ..ChainVertex::NONE
        };
        vertex.set_tangents(point.dp_du, point.dp_dv, point.dn_du, point.dn_dv);
        vertex
    }

    /// An inner vertex: `transmits`, and the index of refraction towards the next vertex over that towards the previous.
    #[inline]
    pub fn scattering(mut self, transmits: bool, eta: f32, alpha: Vec2) -> ChainVertex {
        self.alpha = alpha;
        self.kind = if !transmits {
            vertex_kind::REFLECTION
        } else if abs(eta - 1.0) < INDEX_MATCHED_TOLERANCE {
            vertex_kind::INDEX_MATCHED
        } else {
            vertex_kind::REFRACTION
        };
        self.eta = if self.kind == vertex_kind::REFRACTION {
            eta
        } else {
            1.0
        };
        self
    }

    /// A point in space with a pinned position: a point light, a pinhole, a point of a lens.
    #[inline]
    pub fn point(position: Vec3) -> ChainVertex {
        ChainVertex {
            position,
            ..ChainVertex::NONE
        }
    }

    /// An endpoint on a virtual plane across `direction`, which its edge keeps; `direction` leads away from the vertex.
    #[inline]
    pub fn pinned_direction(position: Vec3, direction: Vec3) -> ChainVertex {
        let frame = Frame::from_normal(direction);
        ChainVertex {
            position,
            geometric_normal: direction,
            tangent_u: frame.s,
            tangent_v: frame.t,
            normal: direction,
            reference: frame.s,
            kind: vertex_kind::PINNED_DIRECTION,
            ..ChainVertex::NONE
        }
    }

    /// Orthonormal tangents and the derivatives along them. A degenerate parametrisation, or one whose plane is not that of
    /// the geometric normal, gives some tangents and no curvature.
    #[inline]
    fn set_tangents(&mut self, dp_du: Vec3, dp_dv: Vec3, dn_du: Vec3, dn_dv: Vec3) {
        let lu = safe_sqrt(dp_du.length_squared());
        let lv = safe_sqrt(dp_dv.length_squared());
        if lu > 1e-20 && lu < 1e18 && lv > 1e-20 && lv < 1e18 {
            let (u, n_u) = (dp_du * (1.0 / lu), dn_du * (1.0 / lu));
            let (v, n_v) = (dp_dv * (1.0 / lv), dn_dv * (1.0 / lv));
            let d = u.dot(v);
            let rest = v - u * d;
            let length = safe_sqrt(rest.length_squared());
            if length > 1e-4 {
                self.tangent_u = u;
                self.dn_u = n_u;
                self.tangent_v = rest * (1.0 / length);
                self.dn_v = (n_v - n_u * d) * (1.0 / length);
                return;
            }
        }
        let frame = Frame::from_normal(self.geometric_normal);
        self.tangent_u = frame.s;
        self.tangent_v = frame.t;
        self.dn_u = Vec3::ZERO;
        self.dn_v = Vec3::ZERO;
    }

    /// The frame in which the half vector is measured.
    #[inline]
    pub fn frame(&self) -> Frame {
        Frame::from_normal_tangent(self.normal, self.reference)
    }

    /// Unit components in the frame of the half vector of a direction's part in the plane of the frame.
    #[inline]
    fn direction_in_frame(&self, direction: Vec3) -> Vec2 {
        let frame = self.frame();
        let d = Vec2::new(frame.s.dot(direction), frame.t.dot(direction));
        let l2 = d.length_squared();
        if l2 > 1e-12 && l2 < f32::MAX {
            d * (1.0 / sqrt(l2))
        } else {
            Vec2::X
        }
    }

    /// The frame's derivatives along both tangents: those of s and t.
    #[inline]
    pub fn frame_derivatives(&self, frame: &Frame) -> FrameDerivatives {
        let (s_u, t_u) = self.frame_derivative(frame, self.dn_u);
        let (s_v, t_v) = self.frame_derivative(frame, self.dn_v);
        FrameDerivatives { s_u, t_u, s_v, t_v }
    }

    /// ds and dt when n changes by `dn`.
    #[inline]
    fn frame_derivative(&self, frame: &Frame, dn: Vec3) -> (Vec3, Vec3) {
        let r = self.reference;
        let along = self.normal.dot(r);
        let across = r - self.normal * along;
        let l2 = across.length_squared();
        let mut ds = -frame.n * frame.s.dot(dn);
        if l2 > 1e-10 {
            // d(r - (r.n) n), its part across s over the length.
            let d = -(dn * along + frame.n * r.dot(dn));
            ds = (d - frame.s * frame.s.dot(d)) * (1.0 / sqrt(l2));
        }
        (ds, dn.cross(frame.s) + frame.n.cross(ds))
    }

    /// |n . w| of the geometric normal; one for a point in space.
    #[inline]
    pub fn cosine(&self, w: Vec3) -> f32 {
        if self.geometric_normal.length_squared() > 0.0 {
            abs(self.geometric_normal.dot(w))
        } else {
            1.0
        }
    }

    /// The vertex with tangents across `towards`, when it is a point in space, which has none of its own.
    #[inline]
    pub fn facing(mut self, towards: Vec3) -> ChainVertex {
        if self.geometric_normal.length_squared() > 0.0 {
            return self;
        }
        let d = towards - self.position;
        let l2 = d.length_squared();
        if l2 > 1e-30 && l2 < f32::MAX {
            let frame = Frame::from_normal(d * (1.0 / sqrt(l2)));
            self.tangent_u = frame.s;
            self.tangent_v = frame.t;
        }
        self
    }

    /// The point of the tangent plane at an offset.
    #[inline]
    pub fn moved(&self, offset: Vec2) -> Vec3 {
        self.position + self.tangent_u * offset.x + self.tangent_v * offset.y
    }

    /// Whether light is scattered here.
    #[inline]
    pub fn is_inner(&self) -> bool {
        self.kind >= vertex_kind::REFLECTION
    }
}

/// Derivatives of a frame's s and t along both tangents.
#[derive(Clone, Copy, Debug)]
pub struct FrameDerivatives {
    /// ds along `tangent_u`.
    pub s_u: Vec3,
    /// dt along `tangent_u`.
    pub t_u: Vec3,
    /// ds along `tangent_v`.
    pub s_v: Vec3,
    /// dt along `tangent_v`.
    pub t_v: Vec3,
}

/// The axis of space that lies most across `n`.
#[inline]
pub fn reference_for(n: Vec3) -> Vec3 {
    let a = n.abs();
    if a.x <= a.y && a.x <= a.z {
        Vec3::X
    } else if a.y <= a.z {
        Vec3::Y
    } else {
        Vec3::Z
    }
}
