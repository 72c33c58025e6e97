//! What the statistical tests share: random numbers, oracle tables, the chi-square test, furnace and reciprocity.

// Every test binary compiles this module and uses a part of it.
#![allow(dead_code)]

pub mod brute_force;
pub mod chi_square;
pub mod coated;
pub mod empty_tables;
pub mod furnace;
pub mod light_scene;
pub mod lit_scenes;
pub mod lobes;
pub mod measured;
pub mod oracle;
pub mod rough_cases;
pub mod tables;

use glam::{Vec2, Vec3};

/// A small generator for tests (SplitMix64, Steele, Lea and Flood 2014), independent of the kernel's samplers.
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn next_1d(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// Uniform in [0, 1)^2.
    pub fn next_2d(&mut self) -> Vec2 {
        let x = self.next_1d();
        Vec2::new(x, self.next_1d())
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next_1d();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let phi = std::f32::consts::TAU * self.next_1d();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// Uniform on the upper hemisphere.
    pub fn upper_direction(&mut self) -> Vec3 {
        let w = self.direction();
        Vec3::new(w.x, w.y, w.z.abs())
    }
}

/// The unit vector at `degrees` from the z axis, at azimuth `azimuth` in degrees.
pub fn direction_at(degrees: f32, azimuth: f32) -> Vec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    let (sa, ca) = azimuth.to_radians().sin_cos();
    Vec3::new(s * ca, s * sa, c)
}
