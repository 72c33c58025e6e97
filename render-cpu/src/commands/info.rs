//! `halflight info`: the contents of a scene, without rendering it.

use super::scene_args::{SceneArgs, build_accel};
use crate::accel::Accel;
use crate::render::record::sampler_name;
use crate::say::print;
use crate::scene::build::Scene;
use clap::Args;
use halflight_kernel::scene::{camera_kind, emitter_kind, lobe_kind};
use std::error::Error;
use std::fmt::Write;
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
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = describe(&scene, &accel, &mut text);
    print(text)?;
    Ok(ExitCode::SUCCESS)
}

fn describe(scene: &Scene, accel: &Accel, out: &mut String) -> std::fmt::Result {
    describe_scene(scene, out)?;
    let trees = accel.statistics();
    writeln!(
        out,
        "\nray tracing\n  {} nodes, depth {}, {} primitives, {:.1} MiB, built in {:.3} s",
        trees.nodes,
        trees.depth,
        trees.primitives,
        mebibytes(trees.bytes),
        trees.build_time.as_secs_f64()
    )?;
    if trees.skipped > 0 {
        writeln!(
            out,
            "  {} primitives without usable coordinates are left out",
            trees.skipped
        )?;
    }
    writeln!(out, "\nnot supported or not used as written")?;
    if scene.warnings.is_empty() {
        writeln!(out, "  nothing")?;
    }
    for warning in &scene.warnings {
        writeln!(out, "  {warning}")?;
    }
    Ok(())
}

fn describe_scene(scene: &Scene, out: &mut String) -> std::fmt::Result {
    let tables = &scene.tables;
    let camera = &tables.camera;
    writeln!(
        out,
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
    )?;
    writeln!(
        out,
        "integrator   {}, {} samples per pixel, {} sampler{}, seed {}",
        scene.integrator,
        scene.spp,
        sampler_name(scene.sampler),
        match scene.sampler_name.as_str() {
            name if name == sampler_name(scene.sampler) => String::new(),
            name => format!(" in place of \"{name}\""),
        },
        scene.seed
    )?;
    writeln!(
        out,
        "bounds       centre ({:.4}, {:.4}, {:.4}), radius {:.4}",
        tables.info.center[0], tables.info.center[1], tables.info.center[2], tables.info.radius
    )?;
    writeln!(
        out,
        "geometry     {} shapes, {} triangles, {} vertices, {} analytic, {} groups, {} instances",
        tables.shapes.len(),
        tables.triangles.len(),
        tables.positions.len(),
        tables.quadrics.len(),
        tables.groups.len() - 1,
        tables.instances.len() - 1
    )?;
    writeln!(
        out,
        "materials    {} of {} lobes: {}",
        tables.materials.len(),
        tables.lobes.len(),
        count_names(tables.lobes.iter().map(|lobe| lobe_name(lobe.kind)))
    )?;
    writeln!(
        out,
        "textures     {}, {:.1} MiB of texels",
        tables.textures.len(),
        mebibytes(size_of_val(tables.texels.as_slice()))
    )?;
    writeln!(
        out,
        "emitters     {}: {}",
        tables.emitters.len(),
        count_names(tables.emitters.iter().map(|e| emitter_name(e.kind)))
    )?;
    writeln!(
        out,
        "memory       {:.1} MiB of tables",
        mebibytes(tables.memory_bytes())
    )?;
    writeln!(out, "\nplugins")?;
    for (name, count) in &scene.plugins {
        writeln!(out, "  {count:5}  {name}")?;
    }
    Ok(())
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
