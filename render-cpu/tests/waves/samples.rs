//! The samples of a scene's film, from single paths and from waves of any size.

use crate::view::{View, with_view};
use halflight::processor;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::math::Rgb;
use halflight_kernel::regularize::settings::{Regularization, RegularizationSettings, flag};
use halflight_kernel::sampler::{IndependentSampler, LaneSampler, SobolSampler};
use halflight_kernel::simd::SimdLevel;
use halflight_kernel::transport::wavefront::Wavefront;
use halflight_kernel::transport::{
    IntegratorSettings, integrator_kind, regularized_path, sample_pixel, sample_pixel_with,
};
use std::path::Path;

/// Samples per pixel.
const SAMPLES: u32 = 2;
const SEED: u32 = 3;

/// Makes a sampler of seed, pixel and sample.
pub type NewSampler<S> = fn(u32, u32, u32) -> S;
/// A pixel in absolute film coordinates, and the numbers of its sample.
pub type Start<S> = ([u32; 2], S);

/// The tables of a scene file whose other files are in `folder`; `strict` refuses what it would warn of.
pub fn scene(text: &str, folder: &Path, strict: bool) -> Scene {
    let parsed = parse_scene_from_str(text, &folder.join("test.xml"), &[], strict)
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    build_scene(&parsed, &BuildOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Starts of all samples of the window.
pub fn starts<S>(view: &View<'_>, new: NewSampler<S>) -> Vec<Start<S>> {
    let camera = &view.tables.camera;
    let ([left, top], [width, height]) = (camera.crop_offset, camera.crop_size);
    let mut starts = Vec::new();
    for y in top..top + height {
        for x in left..left + width {
            let pixel = y * camera.film_size[0] + x;
            starts.extend((0..SAMPLES).map(|sample| ([x, y], new(SEED, pixel, sample))));
        }
    }
    starts
}

/// What single paths give.
pub fn one_by_one<S: LaneSampler>(
    view: &View<'_>,
    settings: &IntegratorSettings,
    starts: &[Start<S>],
) -> Vec<Rgb> {
    let sample = |&(pixel, sampler): &Start<S>| {
        let mut numbers = sampler;
        sample_pixel(view, settings, &mut numbers, pixel)
    };
    starts.iter().map(sample).collect()
}

/// The regularisations of scenes that are compared with it: of microfacets, of path space.
fn regularizations() -> [RegularizationSettings; 2] {
    let none = RegularizationSettings::NONE;
    [
        RegularizationSettings { tau: 30.0, ..none },
        RegularizationSettings {
            radius: 0.05,
            flags: flag::RELATIVE_RADIUS,
            ..none
        },
    ]
}

/// Compares samples whose connections are regularised, each by its number, as [`compare`] does.
fn compare_regularized<S: LaneSampler>(
    view: &View<'_>,
    settings: &IntegratorSettings,
    starts: &[Start<S>],
    text: &str,
) {
    for regularization in regularizations() {
        let settings = IntegratorSettings {
            regularization,
            ..*settings
        };
        let radius = view.tables.info.radius;
        let of_start = |i: usize| {
            let sample = i as u32 % SAMPLES;
            Regularization::of_sample(&regularization, radius, sample)
        };
        let expected: Vec<_> = starts
            .iter()
            .enumerate()
            .map(|(i, &(pixel, mut numbers))| {
                sample_pixel_with(view, &mut numbers, pixel, |sampler, ray| {
                    regularized_path::radiance(view, &settings, of_start(i), sampler, ray)
                })
            })
            .collect();
        let mut wave: Box<Wavefront<S, 512>> = bytemuck::zeroed_box();
        for simd in all_simd_levels() {
            let mut found = Vec::new();
            for (i, &(pixel, sampler)) in starts.iter().enumerate() {
                wave.push_regularized(pixel, 1, |_| sampler, |_| of_start(i));
                if wave.is_full() || i + 1 == starts.len() {
                    found.extend_from_slice(wave.run_regularized(simd, view, &settings).0);
                }
            }
            let what = format!("{simd:?}, {regularization:?}, {text}");
            assert_same(&what, starts, &found, &expected);
        }
    }
}

/// What waves of at most `size` paths give.
pub fn in_waves<S: LaneSampler, const N: usize>(
    wave: &mut Wavefront<S, N>,
    size: usize,
    simd: SimdLevel,
    view: &View<'_>,
    settings: &IntegratorSettings,
    starts: &[Start<S>],
) -> Vec<Rgb> {
    let mut found = Vec::new();
    for paths in starts.chunks(size.min(Wavefront::<S, N>::CAPACITY)) {
        for &(pixel, sampler) in paths {
            assert!(!wave.is_full());
            wave.push(pixel, sampler);
        }
        found.extend_from_slice(wave.run(simd, view, settings));
    }
    found
}

/// Both kinds of loops over lanes; the same one twice where the processor has no other.
pub fn all_simd_levels() -> [SimdLevel; 2] {
    [SimdLevel::BASE, processor::simd_level()]
}

/// Fails where a bit differs.
pub fn assert_same<S>(what: &str, starts: &[Start<S>], found: &[Rgb], expected: &[Rgb]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let bits = |color: &Rgb| color.to_array().map(f32::to_bits);
    let mut unequal = (0..found.len()).filter(|&i| bits(&found[i]) != bits(&expected[i]));
    if let Some(i) = unequal.next() {
        panic!(
            "{} of {} samples differ; the first, number {i} at {:?}, is {:?} instead of {:?}: {what}",
            unequal.count() + 1,
            found.len(),
            starts[i].0,
            found[i],
            expected[i],
        );
    }
}

/// The share of samples with light.
pub fn lit_share(samples: &[Rgb]) -> f32 {
    let lit = samples.iter().filter(|color| color.max_element() > 0.0);
    lit.count() as f32 / samples.len() as f32
}

/// Compares all samples of a scene; returns the share that is lit.
fn compare<S: LaneSampler>(
    view: &View<'_>,
    settings: &IntegratorSettings,
    new: NewSampler<S>,
    text: &str,
) -> f32 {
    let starts = starts(view, new);
    let expected = one_by_one(view, settings, &starts);
    let mut small: Box<Wavefront<S, 512>> = bytemuck::zeroed_box();
    let mut large: Box<Wavefront<S, 1024>> = bytemuck::zeroed_box();
    for simd in all_simd_levels() {
        let found = in_waves(&mut small, usize::MAX, simd, view, settings, &starts);
        let what = format!("{simd:?}, 512 slots, {text}");
        assert_same(&what, &starts, &found, &expected);
        let found = in_waves(&mut large, usize::MAX, simd, view, settings, &starts);
        let what = format!("{simd:?}, 1024 slots, {text}");
        assert_same(&what, &starts, &found, &expected);
    }
    if settings.kind == integrator_kind::PATH {
        compare_regularized(view, settings, &starts, text);
    }
    lit_share(&expected)
}

/// Compares all samples of a scene, with both samplers; returns the smaller share that is lit.
pub fn agrees(scene: &Scene, text: &str) -> f32 {
    let mut share = 0.0;
    let settings = &scene.settings;
    with_view(scene, |view| {
        let independent = compare(view, settings, IndependentSampler::new, text);
        share = independent.min(compare(view, settings, SobolSampler::new, text));
    });
    share
}
