//! Scattering functions: bytes are the parameters of a few lobes and a pair of directions. Everything must be finite and not
//! negative, samples of unit length. Run with `cargo fuzz run bsdf`, see `Cargo.toml`.
#![no_main]

#[path = "../../kernel/tests/common/hostile_lobes.rs"]
mod hostile_lobes;

use glam::Vec2;
use halflight_kernel::bsdf::diffracting_conductor::fill_table;
use halflight_kernel::bsdf::diffraction_table::{FineScale, WORDS};
use halflight_kernel::bsdf::{Bsdf, Lobe, local_beckmann_roughness};
use halflight_kernel::scene::MAX_LOBES;
use hostile_lobes::Bytes;
use libfuzzer_sys::fuzz_target;
use std::sync::OnceLock;

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
