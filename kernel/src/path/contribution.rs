//! What one strategy adds to a pixel: a weighted value, and the segment along which its light must not be blocked.
//!
//! A value is returned, not written: the caller traces the segment ([`super::visibility`]) and decides where the
//! sum is kept. Strategies with at least two camera vertices add to the pixel from which the camera walk started; the others
//! are splats, which name their own film position.

use super::evaluation::Interaction;
use crate::math::{Ray, Rgb};
use crate::scene::NONE;
use glam::{Vec2, Vec3};

/// The weighted contribution of one strategy, were its segment unoccluded.
#[derive(Clone, Copy, Debug)]
pub struct Contribution {
    /// Weighted contribution to the pixel's radiance.
    pub value: Rgb,
    /// The segment that must be unoccluded.
    pub ray: Ray,
    /// Film position of a splat, in pixels of the whole film.
    pub film: Vec2,
    /// Vertices of the light subpath.
    pub s: u32,
    /// Vertices of the camera subpath; strategies with 0 or 1 are splats.
    pub t: u32,
    /// The emitter that next event estimation chose (s = 1 and t > 1), [`NONE`] otherwise.
    pub emitter: u32,
    /// By how much its connection is regularised: tau, or the radius of the blur; zero where the model is evaluated as it is.
    pub blur: f32,
}

impl Contribution {
    /// No contribution.
    pub const NONE: Contribution = Contribution {
        value: Vec3::ZERO,
        ray: Ray {
            origin: Vec3::ZERO,
            direction: Vec3::Z,
            t_min: 0.0,
            t_max: 0.0,
        },
        film: Vec2::ZERO,
        s: 0,
        t: 0,
        emitter: NONE,
        blur: 0.0,
    };

    /// Whether the value is positive in any channel.
    #[inline]
    pub fn is_some(&self) -> bool {
        self.value.max_element() > 0.0
    }

    /// A share of it.
    #[inline]
    #[must_use]
    pub fn times(mut self, share: f32) -> Contribution {
        self.value *= share;
        self
    }

    /// Whether it belongs to the pixels around [`Contribution::film`], not to that of the camera walk.
    #[inline]
    pub fn is_splat(&self) -> bool {
        self.t < 2
    }
}

/// What takes the contributions of walks, and may look at the surfaces that they come from.
pub trait Contributions {
    /// Takes what a walk has found by itself: light that meets the lens, or an emitter that is seen directly.
    fn add(&mut self, contribution: Contribution);

    /// Takes what connects the vertex where a walk has arrived to an emitter or to the lens.
    fn add_at(&mut self, contribution: Contribution, _at: &Interaction<'_>) {
        self.add(contribution);
    }

    /// Takes what connects a vertex of a light walk to one of a camera walk.
    fn add_between(
        &mut self,
        contribution: Contribution,
        _light: &Interaction<'_>,
        _camera: &Interaction<'_>,
    ) {
        self.add(contribution);
    }
}

impl<F: FnMut(Contribution)> Contributions for F {
    #[inline]
    fn add(&mut self, contribution: Contribution) {
        self(contribution);
    }
}
