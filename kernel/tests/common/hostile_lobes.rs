//! Scattering parameters out of bytes, the awkward ones among the likely: for fuzz targets and for the tests that feed
//! them random bytes.

// Each target uses its part.
#![allow(dead_code)]

use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, mode};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::{NONE, lobe_kind};

/// A reader that ends in zeros.
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    /// In [0, 1], both ends among the likely values.
    pub fn unit(&mut self) -> f32 {
        let x = u16::from_le_bytes([self.byte(), self.byte()]);
        f32::from(x) / f32::from(u16::MAX)
    }

    /// In [0, 1).
    pub fn number(&mut self) -> f32 {
        self.unit().min(1.0 - f32::EPSILON)
    }

    /// Any finite number from zero on, most of them moderate.
    pub fn magnitude(&mut self) -> f32 {
        match self.byte() % 4 {
            0 => {
                let bits = [self.byte(), self.byte(), self.byte(), self.byte()];
                let x = f32::from_bits(u32::from_le_bytes(bits) & 0x7fff_ffff);
                if x.is_finite() { x } else { 0.0 }
            }
            1 => self.unit(),
            _ => 10.0_f32.powf(24.0 * self.unit() - 6.0),
        }
    }

    /// A unit vector, which may lie on the horizon or next to it.
    pub fn direction(&mut self) -> Vec3 {
        let kind = self.byte();
        let phi = std::f32::consts::TAU * self.unit();
        let z = 2.0 * self.unit() - 1.0;
        let z = match kind % 4 {
            0 => z * 1e-6,
            1 => z.signum(),
            _ => z,
        };
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// A lobe of any kind; a diffracting conductor reads the table at the start of the data, others none.
    pub fn lobe(&mut self) -> Lobe {
        let mut l = Lobe::NONE;
        // Plastics and coats may read tables of their own kind; here they have none.
        l.kind = match u32::from(self.byte()) % 14 {
            11 => lobe_kind::NULL,
            kind => kind,
        };
        l.distribution = u32::from(self.byte()) % 4;
        l.flags = u32::from(self.byte()) % 64;
        l.weight = self.unit();
        l.reflectance = Vec3::new(self.unit(), self.unit(), self.unit());
        l.specular_reflectance = Vec3::splat(self.unit());
        l.specular_transmittance = Vec3::splat(self.unit());
        // The index is 1, near 1, or in [1/3, 3].
        let eta = match self.byte() % 4 {
            0 => 1.0,
            1 => 1.0 + 1e-4 * (self.unit() - 0.5),
            _ => 3.0_f32.powf(2.0 * self.unit() - 1.0),
        };
        l.eta = Vec3::splat(eta);
        l.k = Vec3::splat(5.0 * self.unit());
        l.alpha = Vec2::new(self.unit().powi(3), self.unit().powi(3));
        l.exponent = 8.0 * self.unit();
        l.internal_reflectance = self.unit();
        l.table = if l.kind == lobe_kind::DIFFRACTING_CONDUCTOR {
            0
        } else {
            NONE
        };
        if self.byte().is_multiple_of(4) {
            l.frame = Frame::from_normal(self.direction());
            l.has_frame = true;
        }
        if self.byte().is_multiple_of(2) {
            l.mode = mode::IMPORTANCE;
        }
        l
    }
}
