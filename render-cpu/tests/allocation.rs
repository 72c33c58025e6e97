//! Nothing inside a pixel's work allocates.

use halflight::accel::{Accel, CpuTraverse};
use halflight::processor;
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::sampler::{AnySampler, IndependentSampler, LaneSampler, SobolSampler};
use halflight_kernel::scene::SceneView;
use halflight_kernel::simd::SimdLevel;
use halflight_kernel::transport::wavefront::Wavefront;
use halflight_kernel::transport::{self, IntegratorSettings, aov, integrator_kind};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;

/// Counts the allocations of each thread by itself: those that built the tree may still be settling down.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn allocations() -> usize {
    ALLOCATIONS.with(Cell::get)
}

// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of paths in waves, that of the wave itself apart.
fn made_by_waves<S: LaneSampler>(
    simd: SimdLevel,
    view: &SceneView<'_, CpuTraverse<'_>>,
    settings: &IntegratorSettings,
    new: fn(u32, u32, u32) -> S,
) -> usize {
    let [width, height] = view.tables.camera.crop_size;
    let mut wave: Box<Wavefront<S, 1024>> = bytemuck::zeroed_box();
    let start = allocations();
    let mut count = 0;
    for i in 0..2000 {
        wave.push([i * 7919 % width, i * 104_729 % height], new(1, i, 0));
        if wave.is_full() || i == 1999 {
            let radiance = wave.run(simd, view, settings);
            count += radiance.len();
            assert!(radiance.iter().all(|radiance| radiance.is_finite()));
        }
    }
    let made = allocations() - start;
    assert_eq!(count, 2000);
    made
}

#[test]
fn no_sample_of_any_integrator_allocates() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let before = allocations();
    for name in [
        "cornell-box",
        "glass-sphere",
        "ring",
        "door-ajar",
        "material-ball",
    ] {
        let parsed =
            parse_scene(&folder.join(name).with_extension("xml"), &[], true).expect("a scene");
        let scene = build_scene(&parsed, &BuildOptions::default()).expect("tables");
        let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
        let tables = scene.tables.view();
        let traverse = accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        let [width, height] = tables.camera.crop_size;
        for kind in [
            integrator_kind::PATH,
            integrator_kind::DIRECT,
            integrator_kind::AMBIENT_OCCLUSION,
        ] {
            let mut settings = scene.settings;
            settings.kind = kind;
            let start = allocations();
            for i in 0..2000 {
                let pixel = [i * 7919 % width, i * 104_729 % height];
                for sampler in 0..2 {
                    let sampler = AnySampler::new(sampler, 1, i, 0);
                    let mut first = sampler;
                    let radiance = transport::sample_pixel(&view, &settings, &mut first, pixel);
                    assert!(radiance.is_finite(), "{name}: {radiance} at {pixel:?}");
                    let mut second = sampler;
                    aov::sample_pixel(&view, &mut second, pixel);
                }
            }
            let made = allocations() - start;
            assert_eq!(made, 0, "{name}, integrator {kind}");
        }
        for simd in [SimdLevel::BASE, processor::simd_level()] {
            let made = [
                made_by_waves(simd, &view, &scene.settings, IndependentSampler::new),
                made_by_waves(simd, &view, &scene.settings, SobolSampler::new),
            ];
            assert_eq!(made, [0, 0], "{name}, waves of {simd:?}");
        }
    }
    assert!(allocations() > before, "the counter counts nothing");
}
