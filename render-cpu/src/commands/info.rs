//! `halflight info`: the contents of a scene, without rendering it.

use super::scene_args::{SceneArgs, build_accel};
use crate::render::record::sampler_name;
use crate::scene::build::Scene;
use clap::Args;
use halflight_kernel::scene::{camera_kind, emitter_kind, lobe_kind};
use std::error::Error;
use std::process::ExitCode;

/// Show what a scene holds.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
}

/// Runs the command.
///
/// # Errors
/// What is wrong with the scene.
pub fn run(args: &InfoArgs) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let scene = args.scene.load()?;
    let accel = build_accel(&scene);
    print_scene(&scene);
    let trees = accel.statistics();
    println!(
        "\nray tracing\n  {} nodes, depth {}, {} primitives, {:.1} MiB, built in {:.3} s",
        trees.nodes,
        trees.depth,
        trees.primitives,
        mebibytes(trees.bytes),
        trees.build_time.as_secs_f64()
    );
    if trees.skipped > 0 {
        println!(
            "  {} primitives without usable coordinates are left out",
            trees.skipped
        );
    }
    println!("\nnot supported or not used as written");
    if scene.warnings.is_empty() {
        println!("  nothing");
    }
    for warning in &scene.warnings {
        println!("  {warning}");
    }
    Ok(ExitCode::SUCCESS)
}

fn print_scene(scene: &Scene) {
    let tables = &scene.tables;
    let camera = &tables.camera;
    println!(
        "camera       {}, {} x {} pixels, crop {} x {} at ({}, {})",
        match camera.kind {
            camera_kind::THIN_LENS => "thin lens",
            camera_kind::ORTHOGRAPHIC => "orthographic",
            _ => "perspective",
        },
        camera.film_size[0],
        camera.film_size[1],
        camera.crop_size[0],
        camera.crop_size[1],
        camera.crop_offset[0],
        camera.crop_offset[1]
    );
    println!(
        "integrator   {}, {} samples per pixel, {} sampler{}, seed {}",
        scene.integrator,
        scene.spp,
        sampler_name(scene.sampler),
        match scene.sampler_name.as_str() {
            name if name == sampler_name(scene.sampler) => String::new(),
            name => format!(" in place of \"{name}\""),
        },
        scene.seed
    );
    println!(
        "bounds       centre ({:.4}, {:.4}, {:.4}), radius {:.4}",
        tables.info.center[0], tables.info.center[1], tables.info.center[2], tables.info.radius
    );
    println!(
        "geometry     {} shapes, {} triangles, {} vertices, {} analytic, {} groups, {} instances",
        tables.shapes.len(),
        tables.triangles.len(),
        tables.positions.len(),
        tables.quadrics.len(),
        tables.groups.len() - 1,
        tables.instances.len() - 1
    );
    println!(
        "materials    {} of {} lobes: {}",
        tables.materials.len(),
        tables.lobes.len(),
        count_names(tables.lobes.iter().map(|lobe| lobe_name(lobe.kind)))
    );
    println!(
        "textures     {}, {:.1} MiB of texels",
        tables.textures.len(),
        mebibytes(size_of_val(tables.texels.as_slice()))
    );
    println!(
        "emitters     {}: {}",
        tables.emitters.len(),
        count_names(tables.emitters.iter().map(|e| emitter_name(e.kind)))
    );
    println!(
        "memory       {:.1} MiB of tables",
        mebibytes(tables.memory_bytes())
    );
    println!("\nplugins");
    for (name, count) in &scene.plugins {
        println!("  {count:5}  {name}");
    }
}

/// "2 a, 1 b", in order of first occurrence.
fn count_names(names: impl Iterator<Item = &'static str>) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for name in names {
        match counts.iter_mut().find(|entry| entry.0 == name) {
            Some(entry) => entry.1 += 1,
            None => counts.push((name, 1)),
        }
    }
    let parts: Vec<_> = counts
        .iter()
        .map(|(name, n)| format!("{n} {name}"))
        .collect();
    parts.join(", ")
}

fn mebibytes(bytes: usize) -> f64 {
    bytes as f64 / (1024.0 * 1024.0)
}

fn lobe_name(kind: u32) -> &'static str {
    match kind {
        lobe_kind::DIFFUSE => "diffuse",
        lobe_kind::CONDUCTOR => "conductor",
        lobe_kind::ROUGH_CONDUCTOR => "rough conductor",
        lobe_kind::DIELECTRIC => "dielectric",
        lobe_kind::THIN_DIELECTRIC => "thin dielectric",
        lobe_kind::ROUGH_DIELECTRIC => "rough dielectric",
        lobe_kind::PLASTIC => "plastic",
        lobe_kind::ROUGH_PLASTIC => "rough plastic",
        lobe_kind::NULL => "null",
        lobe_kind::COAT => "coat",
        lobe_kind::ROUGH_COAT => "rough coat",
        lobe_kind::MERL => "measured",
        lobe_kind::ROUGH_DIFFUSE => "rough diffuse",
        lobe_kind::DIFFRACTING_CONDUCTOR => "diffracting conductor",
        lobe_kind::PHONG => "Phong highlight",
        lobe_kind::WARD => "Ward highlight",
        lobe_kind::DIFFUSE_TRANSMISSION => "diffuse transmission",
        lobe_kind::PRINCIPLED_DIFFUSE => "principled diffuse",
        lobe_kind::SHEEN => "sheen",
        lobe_kind::SCHLICK_REFLECTION => "Schlick reflection",
        lobe_kind::CLEARCOAT => "clear coat",
        _ => "unknown",
    }
}

fn emitter_name(kind: u32) -> &'static str {
    match kind {
        emitter_kind::AREA => "area",
        emitter_kind::POINT => "point",
        emitter_kind::SPOT => "spot",
        emitter_kind::PROJECTOR => "projector",
        emitter_kind::DIRECTIONAL => "directional",
        emitter_kind::CONSTANT => "constant",
        emitter_kind::ENVIRONMENT => "environment",
        _ => "unknown",
    }
}
