//! Nothing inside a pixel's work allocates.

#[path = "common/vertices.rs"]
mod vertices;

use halflight::accel::{Accel, CpuTraverse};
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::processor;
use halflight::render::{Goal, NoObserver, RenderOptions, RunState, render};
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene;
use halflight_kernel::sampler::{AnySampler, IndependentSampler, LaneSampler, SobolSampler};
use halflight_kernel::scene::SceneView;
use halflight_kernel::simd::SimdLevel;
use halflight_kernel::transport::bidirectional;
use halflight_kernel::transport::wavefront::Wavefront;
use halflight_kernel::transport::{self, IntegratorSettings, aov, integrator_kind};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use vertices::Vertices;

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

#[test]
fn no_sample_of_two_walks_allocates() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for name in ["cornell-box", "glass-sphere", "ring"] {
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
        let mut store = Vertices(Vec::with_capacity(4096));
        for kind in [
            integrator_kind::BIDIRECTIONAL,
            integrator_kind::LIGHT_TRACING,
        ] {
            let mut settings = scene.settings;
            settings.kind = kind;
            let mut splats = 0;
            let start = allocations();
            for i in 0..2000 {
                let pixel = [i * 7919 % width, i * 104_729 % height];
                let mut light = IndependentSampler::new(1, i, 0);
                let mut camera = IndependentSampler::new(2, i, 0);
                let seen = transport::camera_ray(&tables, &mut camera, pixel);
                store.0.clear();
                bidirectional::sample(
                    &view,
                    &settings,
                    &mut light,
                    &mut camera,
                    &seen,
                    &mut store,
                    |contribution| {
                        assert!(
                            contribution.value.is_finite(),
                            "{name}: {contribution:?} at {pixel:?}"
                        );
                        splats += u32::from(contribution.is_splat());
                    },
                );
            }
            assert_eq!(allocations() - start, 0, "{name}, integrator {kind}");
            assert!(splats > 0, "{name}: no light walk is seen");
        }
    }
}

/// Allocations of `layers` layers of a square film, on this thread and no other.
fn made_by_layers(side: u32, layers: u32) -> usize {
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="bdpt"/><sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 3" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="{side}"/><integer name="height" value="{side}"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="3"/></transform><bsdf type="diffuse"/></shape>
        <shape type="sphere"><point name="center" value="1, 1, 1"/><float name="radius" value="0.3"/>
        <emitter type="area"/></shape></scene>"#
    );
    let parsed =
        halflight::scene::xml::parse_scene_from_str(&text, Path::new("test.xml"), &[], true)
            .expect("a scene");
    let scene = build_scene(&parsed, &BuildOptions::default()).expect("tables");
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let options = RenderOptions {
        goal: Goal::Samples(layers),
        seed: 0,
        first_sample: 0,
        adaptive: false,
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    pool.install(|| {
        let mut film = Film::new(side, side, [0, 0], AovSet::NONE).expect("a film");
        let mut state = RunState::default();
        let stop = AtomicBool::new(false);
        let start = allocations();
        render(
            &scene,
            &accel,
            &options,
            &mut film,
            &mut state,
            &stop,
            &mut NoObserver,
        )
        .expect("an image");
        allocations() - start
    })
}

#[test]
fn splatting_allocates_by_tile_and_layer_and_not_by_sample() {
    let per_layer = |side: u32| {
        let (few, many) = (made_by_layers(side, 64), made_by_layers(side, 192));
        (many - few) as f64 / 128.0
    };
    let (small, large) = (per_layer(4), per_layer(32));
    // One tile each, of 16 and of 1024 samples: more splats only double the room of two lists a few times more.
    assert!(small > 0.0, "the counter counts nothing");
    assert!(
        large < small + 24.0,
        "{small} and {large} allocations per layer"
    );
}
