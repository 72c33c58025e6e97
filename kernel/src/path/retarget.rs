//! Edits of light transport by path retargeting (Schmidt et al. 2013, "Path-Space Manipulation of Physically-Based Light
//! Transport"; Kaplanyan 2017, section 9.2.1): which directions at a surface point an edit turns, whereto, and what that does to
//! densities.
//!
//! An edit selects parts of paths ([`super::retarget_states`]) and carries an affine map T, which places a source region in its
//! target. What a selected path sends from x into the source region, along a direction w, goes along o towards the target
//! instead; R is the inverse map, w = R o. The BSDF becomes (thesis 9.2.1, i the direction at the other side)
//!
//! ```text
//! f'(i -> o)  = f(i -> R o)                                        light is turned on its way from the emitter,
//! f'*(i -> o) = f(R o -> i) |R o.n| / |o.n|  |dR o / do|           importance on its way from the sensor.
//! ```
//!
//! Both leave radiance as it is: a surface sends along o what it sent along R o, and a mirror shows along w what lies along o.
//! The thesis has rotations of the tangent frame in mind, for which R^T is the inverse and |dR o / do| is one; R of an affine map
//! and a region is not even linear, so the inverse and its Jacobian stand in their places. Neither f' nor f'* is a density in o:
//! a direction is sampled as before and then turned, o = R^-1 w, with the density p(o) = p(R o) |dR o / do|.
//!
//! **R as a map of directions alone.** A direction must name a point for T to move. That is where its line meets the region's
//! plane: of a box the plane through its middle, z = 0 in its own coordinates, of a ball the polar plane of x, which holds
//! all points where lines from x touch it. Points y of that plane within the region go to T y, on a plane again, so
//!
//! ```text
//! o = (T y - x) / |T y - x|,    |do/dw| = a (|n'.o| / |T y - x|^2) / (|n.w| / |y - x|^2),
//! ```
//!
//! n and n' the normals of both planes and a = |det A| |A^-T n| the growth of areas between them, A the linear part of T. So R is
//! one to one between the directions that meet the source and those that meet the target, in closed form in both directions, and knows
//! neither the surfaces that paths will meet nor the way in which they are built. Put the box flat on a floor, and what falls
//! within it moves over the floor exactly as T says. Without a region A turns all directions, o = A w / |A w|, |do/dw| = |det A| / |A w|^3.
//!
//! A direction is only turned to the same side of the surface; others an edit leaves alone. What it turns is moved, not copied:
//! nothing selected goes into the source any more. Flux follows from radiance,
//!
//! ```text
//! L |o.n| do = L |w.n| dw  *  |do/dw| |o.n| / |w.n|,
//! ```
//!
//! so that a patch which T makes larger receives more; edits that keep energy divide by that factor.
//!
//! Invariants (tests): R and its inverse undo each other, Jacobians are those of differences, areas go by T on the region's plane.
//!
//! Hosts only: edits keep several choices per vertex, for which shaders have no storage.

use crate::math::affine::{determinant, transform_normal, transform_point, transform_vector};
use crate::math::{Rgb, float, vec3};
use crate::scene::SurfacePoint;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Most edits at a time.
pub const MAX_EDITS: usize = 8;

/// Which flow an edit turns.
pub mod flow {
    /// Light, behind the vertices that the selection reads from the emitter.
    pub const LIGHT: u32 = 0;
    /// Importance, behind those that it reads from the sensor.
    pub const IMPORTANCE: u32 = 1;
}

/// Shapes of a source.
pub mod source {
    /// No region: all directions are turned by the linear part of the map.
    pub const EVERYWHERE: u32 = 0;
    /// The cube from -1 to 1, of which the square z = 0 counts.
    pub const BOX: u32 = 1;
    /// The unit ball.
    pub const BALL: u32 = 2;
}

/// An edit. Its maps are those of the moment that is rendered.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Edit {
    /// One of [`flow`].
    pub flow: u32,
    /// One of [`source`].
    pub source: u32,
    /// The source: world to its cube or ball, three rows of four.
    pub to_unit: [f32; 12],
    /// And back.
    pub from_unit: [f32; 12],
    /// T, from the source to the target.
    pub map: [f32; 12],
    /// And back.
    pub inverse: [f32; 12],
    /// Factor on what is turned.
    pub factor: [f32; 3],
    /// 1 if energy is kept instead of radiance (of light that is turned).
    pub keeps_energy: u32,
}

/// A direction that an edit has redirected, and the Jacobian of that map of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Redirection {
    /// Unit direction.
    pub direction: Vec3,
    /// Solid angle of the redirected directions over that of the original ones.
    pub jacobian: f32,
}

struct Plane {
    point: Vec3,
    normal: Vec3,
}

impl Edit {
    /// The plane on which directions at `x` name points; none where the source has none for it.
    fn plane(&self, x: Vec3) -> Option<Plane> {
        let (point, normal) = if self.source == source::BALL {
            let u = transform_point(&self.to_unit, x);
            let length2 = u.length_squared();
            if !(length2 > 1.0) {
                return None;
            }
            (u / length2, u)
        } else {
            (Vec3::ZERO, Vec3::Z)
        };
        Some(Plane {
            point: transform_point(&self.from_unit, point),
            normal: transform_normal(&self.to_unit, normal).normalize(),
        })
    }

    /// The same plane where T takes it, and the growth of areas.
    fn target(&self, plane: &Plane) -> (Plane, f32) {
        let normal = transform_normal(&self.inverse, plane.normal);
        let length = normal.length();
        let image = Plane {
            point: transform_point(&self.map, plane.point),
            normal: normal / length,
        };
        (image, float::abs(determinant(&self.map)) * length)
    }

    /// Whether a point of the source's plane belongs to it.
    fn holds(&self, y: Vec3) -> bool {
        let p = transform_point(&self.to_unit, y);
        if self.source == source::BALL {
            p.length_squared() <= 1.0
        } else {
            float::abs(p.x) <= 1.0 && float::abs(p.y) <= 1.0
        }
    }

    /// R^-1: where what leaves `x` along the unit direction `w` goes; none if it does not meet the source.
    pub fn redirect(&self, x: Vec3, w: Vec3) -> Option<Redirection> {
        if self.source == source::EVERYWHERE {
            return redirect_linearly(&self.map, w);
        }
        let plane = self.plane(x)?;
        let t = distance(&plane, x, w)?;
        let y = x + w * t;
        if !self.holds(y) {
            return None;
        }
        let (image, growth) = self.target(&plane);
        let v = transform_point(&self.map, y) - x;
        let length2 = v.length_squared();
        let direction = v / float::sqrt(length2);
        let seen = float::abs(image.normal.dot(direction)) / length2;
        let was = float::abs(plane.normal.dot(w)) / (t * t);
        some(direction, growth * seen / was)
    }

    /// R: where what leaves `x` along the unit direction `o` would have gone; none if it does not meet the target.
    pub fn origin(&self, x: Vec3, o: Vec3) -> Option<Redirection> {
        if self.source == source::EVERYWHERE {
            return redirect_linearly(&self.inverse, o);
        }
        let plane = self.plane(x)?;
        let (image, growth) = self.target(&plane);
        let t = distance(&image, x, o)?;
        let y = transform_point(&self.inverse, x + o * t);
        if !self.holds(y) {
            return None;
        }
        let v = y - x;
        let length2 = v.length_squared();
        let direction = v / float::sqrt(length2);
        let seen = float::abs(image.normal.dot(o)) / (t * t);
        let was = float::abs(plane.normal.dot(direction)) / length2;
        some(direction, was / (growth * seen))
    }

    /// [`Edit::redirect`] at a surface point, to the same side.
    pub fn redirect_at(&self, point: &SurfacePoint, w: Vec3) -> Option<Redirection> {
        let redirected = self.redirect(point.position, w)?;
        keeps_side(point, w, redirected.direction).then_some(redirected)
    }

    /// [`Edit::origin`] at a surface point, from the same side.
    pub fn origin_at(&self, point: &SurfacePoint, o: Vec3) -> Option<Redirection> {
        let redirected = self.origin(point.position, o)?;
        keeps_side(point, o, redirected.direction).then_some(redirected)
    }

    /// What the turned BSDF times the cosine towards the light is over that of the direction w, for `jacobian` = |dw/do|.
    pub fn value(&self, point: &SurfacePoint, w: Vec3, o: Vec3, jacobian: f32) -> Rgb {
        let factor = vec3(self.factor);
        if self.flow == flow::IMPORTANCE {
            return factor * jacobian;
        }
        if self.keeps_energy == 0 {
            return factor;
        }
        let n = point.geometric_normal;
        factor * (jacobian * float::abs(n.dot(w)) / float::abs(n.dot(o)))
    }
}

/// Distance to a plane along a unit direction, if it is ahead.
fn distance(plane: &Plane, x: Vec3, direction: Vec3) -> Option<f32> {
    let t = plane.normal.dot(plane.point - x) / plane.normal.dot(direction);
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// The linear part of a map as a turn of all directions.
fn redirect_linearly(map: &[f32; 12], w: Vec3) -> Option<Redirection> {
    let v = transform_vector(map, w);
    let length = v.length();
    some(
        v / length,
        float::abs(determinant(map)) / (length * length * length),
    )
}

fn some(direction: Vec3, jacobian: f32) -> Option<Redirection> {
    let is_sound = direction.is_finite() && jacobian > 0.0 && jacobian.is_finite();
    is_sound.then_some(Redirection {
        direction,
        jacobian,
    })
}

/// Whether two directions are on the same side of both normals.
fn keeps_side(point: &SurfacePoint, a: Vec3, b: Vec3) -> bool {
    let same = |n: Vec3| n.dot(a) * n.dot(b) > 0.0;
    same(point.geometric_normal) && same(point.frame.n)
}
