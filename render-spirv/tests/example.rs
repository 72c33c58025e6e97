//! The shader that shows readers how to call the kernel runs and gives what the kernel gives here.

mod common;

use common::device;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, rough_conductor};
use halflight_kernel::regularize::bounds;
use halflight_kernel::scene::{distribution, lobe_kind};
use halflight_spirv::module::{MODULES, words_of};
use halflight_spirv::probe_runner::{EntryPoint, run_once};
use std::path::Path;

#[test]
fn the_example_shader_gives_the_kernels_values() {
    let Some(device) = device() else { return };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let module = MODULES
        .iter()
        .find(|m| m.name == "example")
        .expect("a module");
    let words = words_of(&std::fs::read(module.path(&root)).expect("a file"));
    let mut pairs = Vec::new();
    for i in 0..640 {
        let (s, c) = (0.1 + 0.002 * i as f32).sin_cos();
        let (t, d) = (0.011 * i as f32).sin_cos();
        let tau = 0.5 * 1.02f32.powi(i);
        pairs.push([[s, 0.0, c, tau], [-s * d, s * t, c, 0.0]]);
    }
    let values: Vec<[f32; 4]> = run_once(
        &device,
        EntryPoint {
            module: &words,
            name: c"main_cs",
        },
        &[bytemuck::cast_slice(&pairs)],
        &(),
        10,
        pairs.len(),
    )
    .expect("a run");
    let mut bounded = 0;
    for ([[x, y, z, tau], [u, v, w, _]], value) in pairs.iter().zip(values) {
        let alpha = bounds::reflection_alpha(bounds::SMITH, distribution::GGX, *tau);
        bounded += usize::from(alpha > 0.05);
        let lobe = Lobe {
            kind: lobe_kind::ROUGH_CONDUCTOR,
            distribution: distribution::GGX,
            alpha: bounds::raise(Vec2::splat(0.05), alpha),
            eta: Vec3::new(0.143, 0.375, 1.442),
            k: Vec3::new(3.983, 2.386, 1.603),
            specular_reflectance: Vec3::ONE,
            ..Lobe::NONE
        };
        let f = rough_conductor::eval(&lobe, Vec3::new(*x, *y, *z), Vec3::new(*u, *v, *w));
        let (f, g) = (f, Vec3::new(value[0], value[1], value[2]));
        assert!(
            (f - g).abs().max_element() <= 1e-5 * f.max_element(),
            "{f} {g}"
        );
        assert!(
            g.max_element() > 0.0 && g.max_element() <= tau * 1.0001,
            "{g} {tau}"
        );
    }
    assert!(bounded > 100 && bounded < 600, "{bounded}");
}
