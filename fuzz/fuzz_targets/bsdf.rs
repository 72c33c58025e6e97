//! Scattering functions: bytes are the parameters of a few lobes and a pair of directions. Everything must be finite and not
//! negative, samples of unit length. Run with `cargo fuzz run bsdf`, see `Cargo.toml`.
#![no_main]

use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::diffracting_conductor::fill_table;
use halflight_kernel::bsdf::diffraction_table::{FineScale, WORDS};
use halflight_kernel::bsdf::{Bsdf, Lobe, MAX_LOBES, local_beckmann_roughness, mode};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::{NONE, lobe_kind};
use libfuzzer_sys::fuzz_target;
use std::sync::OnceLock;

/// A reader that ends in zeros.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    /// In [0, 1], both ends among the likely values.
    fn unit(&mut self) -> f32 {
        let x = u16::from_le_bytes([self.byte(), self.byte()]);
        f32::from(x) / f32::from(u16::MAX)
    }

    /// In [0, 1).
    fn number(&mut self) -> f32 {
        self.unit().min(1.0 - f32::EPSILON)
    }

    /// A unit vector, which may lie on the horizon or next to it.
    fn direction(&mut self) -> Vec3 {
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

    fn lobe(&mut self) -> Lobe {
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
        if self.byte() % 4 == 0 {
            l.frame = Frame::from_normal(self.direction());
            l.has_frame = true;
        }
        if self.byte() % 2 == 0 {
            l.mode = mode::IMPORTANCE;
        }
        l
    }
}

/// One table of a diffracting conductor.
fn table() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let scale = FineScale {
            wavelengths: [0.6114, 0.5491, 0.4642],
            sigma: 0.05,
            b: 1.0,
            c: 1.5,
        };
        let mut words = vec![0.0; WORDS];
        fill_table(&scale, 0.1, 1.0, &mut words);
        words
    })
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let count = 1 + usize::from(bytes.byte()) % 3;
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    for lobe in &mut lobes[..count] {
        *lobe = bytes.lobe();
    }
    let (wi, wo) = (bytes.direction(), bytes.direction());
    let u = [bytes.number(), bytes.number(), bytes.number()];
    let data = table();
    let bsdf = Bsdf::from_lobes(lobes, count as u32, data, wi);
    let (f, p) = bsdf.eval_cosine_pdf(data, wi, wo);
    assert!(
        f.is_finite() && f.min_element() >= 0.0,
        "{f} {lobes:?} {wi} {wo}"
    );
    assert!(p.is_finite() && p >= 0.0, "{p} {lobes:?} {wi} {wo}");
    let s = bsdf.sample(data, wi, u[0], Vec2::new(u[1], u[2]));
    assert!(
        s.pdf.is_finite() && s.pdf >= 0.0,
        "{s:?} {lobes:?} {wi} {u:?}"
    );
    if s.pdf > 0.0 {
        assert!(
            s.weight.is_finite() && s.weight.min_element() >= 0.0,
            "{s:?} {lobes:?} {wi} {u:?}"
        );
        assert!(
            (s.wo.length() - 1.0).abs() < 1e-4,
            "{s:?} {lobes:?} {wi} {u:?}"
        );
    }
    let roughness = local_beckmann_roughness(&bsdf, data, wi, wo);
    assert!(
        (0.0..=1e3).contains(&roughness),
        "{roughness} {lobes:?} {wi} {wo}"
    );
    let albedo = bsdf.albedo(data, wi);
    assert!(
        albedo.is_finite() && albedo.min_element() >= 0.0,
        "{albedo} {lobes:?}"
    );
});
