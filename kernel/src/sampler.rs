//! Counter-based random numbers and Owen-scrambled Sobol' points.

use glam::Vec2;

/// A stream of numbers in [0, 1) for one sample of one pixel or chain.
pub trait Sampler {
    /// The next number in [0, 1).
    fn next_1d(&mut self) -> f32;
    /// The next point in [0, 1)^2, well distributed over the samples of the pixel where the sampler can.
    fn next_2d(&mut self) -> Vec2;
}
