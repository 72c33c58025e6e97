//! Waves of any number of slots, full or not, used once or again, in any mixture of pixels.

use crate::files::Files;
use crate::materials::WITHOUT_VARIANT;
use crate::room::{CONSTANT, LAMP, POINT, Room};
use crate::samples::{all_simd_levels, assert_same, in_waves, lit_share, one_by_one, starts};
use crate::view::with_view;
use halflight_kernel::sampler::{IndependentSampler, SobolSampler};
use halflight_kernel::transport::wavefront::Wavefront;

/// Rooms of little in common.
fn rooms() -> [Room; 3] {
    let textured = r#"<bsdf type="roughplastic"><texture name="diffuse_reflectance" type="bitmap">
        <string name="filename" value="color.png"/></texture></bsdf>"#;
    [
        Room {
            emitters: format!("{LAMP}{POINT}{CONSTANT}"),
            shapes: format!(
                r#"<shape type="sphere"><float name="radius" value="0.5"/>{}</shape>"#,
                WITHOUT_VARIANT[1]
            ),
            ..Room::with_material(textured)
        },
        Room::with_material(r#"<bsdf type="dielectric"/>"#),
        Room {
            emitters:
                r#"<emitter type="envmap"><string name="filename" value="sky.hdr"/></emitter>"#
                    .into(),
            ..Room::with_material(r#"<bsdf type="roughconductor"/>"#)
        },
    ]
}

/// All rooms in one wave after the other, by waves of at most each of the `sizes`.
fn agree<const N: usize>(sizes: &[usize]) {
    let files = Files::new();
    let mut wave: Box<Wavefront<IndependentSampler, N>> = bytemuck::zeroed_box();
    for room in rooms() {
        let text = room.text();
        let scene = room.build(&files);
        let settings = &scene.settings;
        with_view(&scene, |view| {
            let starts = starts(view, IndependentSampler::new);
            let expected = one_by_one(view, settings, &starts);
            assert!(lit_share(&expected) > 0.4, "{text}");
            for &size in sizes {
                for simd in all_simd_levels() {
                    let found = in_waves(&mut wave, size, simd, view, settings, &starts);
                    let what = format!("{simd:?}, {N} slots, {size} paths, {text}");
                    assert_same(&what, &starts, &found, &expected);
                }
            }
        });
    }
}

#[test]
fn waves_that_are_not_full() {
    agree::<512>(&[1, 2, 15, 16, 17, 33, 100, 121]);
    agree::<1024>(&[7, 160, 633]);
}

#[test]
fn slots_for_few_paths() {
    assert_eq!(Wavefront::<IndependentSampler, 64>::CAPACITY, 4);
    agree::<64>(&[1, 3, 4]);
    // The last slots are no whole vector.
    assert_eq!(Wavefront::<IndependentSampler, 40>::CAPACITY, 2);
    agree::<40>(&[1, 2]);
}

#[test]
fn a_wave_without_paths_has_no_samples() {
    let files = Files::new();
    let mut wave: Box<Wavefront<SobolSampler, 512>> = bytemuck::zeroed_box();
    let scene = rooms()[0].build(&files);
    let settings = &scene.settings;
    with_view(&scene, |view| {
        for simd in all_simd_levels() {
            assert!(wave.run(simd, view, settings).is_empty());
        }
    });
}

#[test]
fn paths_beyond_the_capacity_are_left_out() {
    type Small = Wavefront<SobolSampler, 512>;
    let files = Files::new();
    let mut wave: Box<Small> = bytemuck::zeroed_box();
    let scene = rooms()[0].build(&files);
    let settings = &scene.settings;
    with_view(&scene, |view| {
        let starts = starts(view, SobolSampler::new);
        let expected = one_by_one(view, settings, &starts[..Small::CAPACITY]);
        assert!(lit_share(&expected) > 0.0);
        for simd in all_simd_levels() {
            for &(pixel, sampler) in &starts {
                wave.push(pixel, sampler);
            }
            assert!(wave.is_full());
            let found = wave.run(simd, view, settings).to_vec();
            assert_same("full", &starts, &found, &expected);
            assert!(!wave.is_full());
        }
    });
}

#[test]
fn the_order_of_paths_is_of_no_matter() {
    let files = Files::new();
    let mut wave: Box<Wavefront<SobolSampler, 1024>> = bytemuck::zeroed_box();
    for room in rooms() {
        let scene = room.build(&files);
        let settings = &scene.settings;
        with_view(&scene, |view| {
            let mut starts = starts(view, SobolSampler::new);
            // A step without a common divisor with their number.
            let count = starts.len();
            starts = (0..count).map(|i| starts[i * 577 % count]).collect();
            let expected = one_by_one(view, settings, &starts);
            assert!(lit_share(&expected) > 0.4);
            for simd in all_simd_levels() {
                let found = in_waves(&mut wave, usize::MAX, simd, view, settings, &starts);
                assert_same("shuffled", &starts, &found, &expected);
            }
        });
    }
}
