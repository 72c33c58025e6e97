//! The device against the processor, and what is said when something is missing.

mod common;

use common::device;
use halflight::aov::AovSet;
use halflight::commands::scene_args::{SceneArgs, build_accel};
use halflight::film::Film;
use halflight::render::{Goal, RenderOptions, Sampling, ThreadSampling};
use halflight::scene::build::Scene;
use halflight_spirv::canary::loop_budget;
use halflight_spirv::module;
use halflight_spirv::sampling::{DeviceSampling, SamplingError};
use halflight_spirv::vulkan::{Instance, Memory, VulkanError};
use std::path::Path;

fn scene(name: &str, integrator: &str) -> Scene {
    let args = SceneArgs {
        scene: Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../render-cpu/scenes")
            .join(name),
        defines: Vec::new(),
        size: Some([48, 48]),
        width: None,
        crop: None,
        integrator: Some(integrator.to_string()),
        sampler: None,
        sensor: 0,
        strict: false,
    };
    args.load().expect("an example scene")
}

fn options() -> RenderOptions {
    RenderOptions {
        goal: Goal::Samples(4),
        seed: 7,
        first_sample: 0,
        adaptive: false,
    }
}

fn film() -> Film {
    Film::new(48, 48, [0, 0], AovSet::NONE).expect("a small film")
}

/// Same seeds, same numbers: mean absolute difference at most 1e-3 of the mean, at most 1 % of the pixels outside 1 %.
#[test]
fn occlusion_is_that_of_the_processor() {
    let Some(device) = device() else { return };
    for name in ["cornell-box.xml", "glass-sphere.xml", "material-ball.xml"] {
        let scene = scene(name, "ao");
        let accel = build_accel(&scene);
        let options = options();
        let mut on_device = film();
        DeviceSampling::new(&device, &scene, &accel, &options, false)
            .expect("a pipeline")
            .pass(&mut on_device, 4, None)
            .expect("a pass");
        let mut on_cpu = film();
        ThreadSampling {
            scene: &scene,
            accel: &accel,
            options: &options,
        }
        .pass(&mut on_cpu, 4, None)
        .expect("a pass");
        let (mut difference, mut sum, mut outside) = (0.0, 0.0, 0);
        for (a, b) in on_device.mean().iter().zip(&on_cpu.mean()) {
            difference += (a[0] - b[0]).abs();
            sum += b[0];
            outside += usize::from((a[0] - b[0]).abs() > 0.01 * b[0].abs().max(1e-3));
        }
        assert!(sum > 0.0, "{name} is black");
        assert!(difference <= 1e-3 * sum, "{name}: {}", difference / sum);
        assert!(outside * 100 <= 48 * 48, "{name}: {outside} pixels");
    }
}

#[test]
fn a_lost_device_leaves_complete_layers() {
    let Some(device) = device() else { return };
    let scene = scene("cornell-box.xml", "ao");
    let accel = build_accel(&scene);
    let mut sampling =
        DeviceSampling::new(&device, &scene, &accel, &options(), false).expect("a pipeline");
    sampling.simulate_loss_after(2);
    let mut film = film();
    let error = sampling
        .pass(&mut film, 4, None)
        .expect_err("a lost device");
    assert!(error.to_string().contains("was lost"), "{error}");
    assert!(film.statistics().iter().all(|p| p.count == 2));
}

#[test]
fn an_integrator_without_a_shader_is_named() {
    let Some(device) = device() else { return };
    let mut scene = scene("cornell-box.xml", "direct");
    scene.settings.kind = u32::MAX;
    let accel = build_accel(&scene);
    let error = DeviceSampling::new(&device, &scene, &accel, &options(), false).err();
    assert!(matches!(error, Some(SamplingError::NoShader(_))));
}

/// Mesa's software device ends loops after 65,535 iterations; none may end them much earlier.
#[test]
fn the_canary_counts_the_loop_budget() {
    let Some(device) = device() else { return };
    let budget = loop_budget(&device).expect("a count");
    assert!(budget >= 60_000, "{budget}");
}

#[test]
fn what_does_not_exist_or_fit_is_named_with_numbers() {
    let Some(device) = device() else { return };
    let error = Instance::new(false)
        .and_then(|i| i.select(Some("no such device")))
        .expect_err("no such device");
    assert!(matches!(error, VulkanError::UnknownDevice { .. }));
    assert!(error.to_string().contains(&device.description().name));
    let error = device
        .create_buffer("vertex positions", u64::MAX, Memory::Host)
        .err()
        .expect("too large");
    assert!(matches!(error, VulkanError::TooLarge { .. }), "{error}");
}

/// The module declares nothing that the host does not enable: Shader (1) and VulkanMemoryModel (5345).
#[test]
fn the_module_needs_what_the_host_enables() {
    let words = module::words();
    let known = [1, 5345];
    assert!(
        module::capabilities(&words)
            .iter()
            .all(|c| known.contains(c))
    );
    for entry in ["paths::scatter", "occlusion", "canary::canary"] {
        assert!(
            module::entry_points(&words).iter().any(|e| e == entry),
            "{entry}"
        );
    }
}

/// Fails when the kernel or the shaders are newer than the module: run `render-spirv/build-shaders`.
#[test]
fn the_module_is_as_new_as_its_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let sources = format!("{:016x}", module::source_hash(&root).expect("sources"));
    assert_eq!(
        module::stamp("sources"),
        sources,
        "stale module: run render-spirv/build-shaders"
    );
    assert_eq!(
        module::stamp("module"),
        format!("{:016x}", module::module_hash())
    );
}
