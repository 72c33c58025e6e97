//! The device against the processor, and what is said when something is missing.

mod common;

use common::device;
use halflight::commands::scene_args::{SceneArgs, build_accel};
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSet};
use halflight::render::{Backend, CpuBackend, Goal, RenderOptions, Stop};
use halflight::scene::build::Scene;
use halflight_spirv::canary::loop_budget;
use halflight_spirv::device_backend::{BackendError, DeviceBackend};
use halflight_spirv::vulkan::{Device, Instance, Memory, VulkanError, choose};
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
        edit: None,
        edit_time: None,
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
        DeviceBackend::new(&device, &scene, &accel, &options, false)
            .expect("a pipeline")
            .pass(&mut on_device, 4, None, &Stop::NEVER)
            .expect("a pass");
        let mut on_cpu = film();
        CpuBackend::new(&scene, &accel, &options)
            .pass(&mut on_cpu, 4, None, &Stop::NEVER)
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
    let mut backend =
        DeviceBackend::new(&device, &scene, &accel, &options(), false).expect("a pipeline");
    backend.simulate_loss_after(2);
    let mut film = film();
    let error = backend
        .pass(&mut film, 4, None, &Stop::NEVER)
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
    let error = DeviceBackend::new(&device, &scene, &accel, &options(), false).err();
    assert!(matches!(error, Some(BackendError::NoShader(_))));
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

/// Devices that lack something, in the words of the ones that there are.
#[test]
fn a_missing_feature_and_a_missing_device_are_named() {
    assert_eq!(choose(&[], None).err(), Some(VulkanError::NoDevice));
    let Some(device) = device() else { return };
    let mut description = device.description().clone();
    description.missing.push("the feature vulkanMemoryModel");
    let error = choose(&[description], None).expect_err("a feature is missing");
    let text = error.to_string();
    assert!(
        matches!(error, VulkanError::MissingFeature { .. }),
        "{text}"
    );
    assert!(text.contains("vulkanMemoryModel") && text.contains(&device.description().name));
}

/// A device whose shaders see buffers of a few bytes only, and one without memory, refuse the scene with numbers.
#[test]
fn scenes_beyond_a_devices_limits_are_refused_with_numbers() {
    let Some(device) = device() else { return };
    let scene = scene("cornell-box.xml", "ao");
    let accel = build_accel(&scene);
    let mut description = device.description().clone();
    description.max_buffer = 64;
    let small = Device::new(device.instance(), description).expect("a device");
    let error = DeviceBackend::new(&small, &scene, &accel, &options(), false).err();
    let Some(BackendError::Device(VulkanError::TooLarge { bytes, limit, .. })) = error else {
        panic!("{error:?}");
    };
    assert!(bytes > 64 && limit == 64);
    let small = Device::new(device.instance(), device.description().clone()).expect("a device");
    small.limit_memory(2000);
    let error = DeviceBackend::new(&small, &scene, &accel, &options(), false).err();
    let Some(BackendError::Device(VulkanError::OutOfMemory { bytes, used, .. })) = error else {
        panic!("{error:?}");
    };
    assert!(bytes + used > 2000 && used <= 2000, "{bytes} {used}");
    // What had room before the failure is free again.
    assert_eq!(small.memory_used(), 0);
}

/// The layers of the first surface: means of the same samples.
#[test]
fn surface_features_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let layers = [Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Position, Aov::Uv];
    let aovs = layers.into_iter().fold(AovSet::NONE, AovSet::with);
    for name in ["cornell-box.xml", "material-ball.xml", "door-ajar.xml"] {
        let scene = scene(name, "ao");
        let accel = build_accel(&scene);
        let options = options();
        let mut on_device = Film::new(48, 48, [0, 0], aovs).expect("a film");
        DeviceBackend::new(&device, &scene, &accel, &options, true)
            .expect("a pipeline")
            .pass(&mut on_device, 2, None, &Stop::NEVER)
            .expect("a pass");
        let mut on_cpu = Film::new(48, 48, [0, 0], aovs).expect("a film");
        CpuBackend::new(&scene, &accel, &options)
            .pass(&mut on_cpu, 2, None, &Stop::NEVER)
            .expect("a pass");
        for layer in layers {
            let (mut difference, mut sum, mut outside) = (0.0, 0.0, 0);
            for pixel in 0..48 * 48 {
                let mut is_outside = false;
                for channel in 0..layer.channels().len() {
                    let a = on_device.aov_mean(layer, channel, pixel);
                    let b = on_cpu.aov_mean(layer, channel, pixel);
                    difference += (a - b).abs();
                    sum += b.abs();
                    is_outside |= (a - b).abs() > 0.01 * b.abs().max(1e-3);
                }
                outside += usize::from(is_outside);
            }
            assert!(sum > 0.0, "{name}: {} is zero", layer.name());
            println!(
                "{name} {}: {:.1e}, {outside} pixels",
                layer.name(),
                difference / sum
            );
            assert!(
                difference <= 1e-3 * sum,
                "{name} {}: {}",
                layer.name(),
                difference / sum
            );
            assert!(
                outside * 100 <= 48 * 48,
                "{name} {}: {outside} pixels",
                layer.name()
            );
        }
    }
}
