//! `halflight info`: the contents of a scene, without rendering it.

use super::info_cost::cost;
use super::info_report::{Count, Named, Report};
use super::scene_args::{SceneArgs, build_accel};
use crate::say::{print, print_line};
use clap::Args;
use std::error::Error;
use std::fmt::{self, Write};
use std::process::ExitCode;

/// Show what a scene holds.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// What is wrong with the scene.
pub fn run(args: &InfoArgs) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let parsed = args.scene.parse()?;
    let mut scene = args.scene.build(&parsed)?;
    let accel = build_accel(&scene);
    let cost = cost(&mut scene, &accel);
    let name = args.scene.scene.display().to_string();
    let report = Report::new(name, &parsed, &args.scene.defines, &scene, &accel, cost);
    if args.json {
        print_line(serde_json::to_string_pretty(&report)?)?;
    } else {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = describe(&report, args.scene.sensor, &mut text);
        print(text)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(r: &Report, sensor: usize, out: &mut String) -> fmt::Result {
    let ([w, h], [cw, ch], [x, y]) = (r.size, r.crop_size, r.crop_offset);
    writeln!(
        out,
        "camera       {}, {w} x {h} pixels, crop {cw} x {ch} at ({x}, {y})",
        r.camera
    )?;
    let instead = if r.sampler_name == r.sampler {
        String::new()
    } else {
        format!(" in place of \"{}\"", r.sampler_name)
    };
    writeln!(
        out,
        "integrator   {}, {} samples per pixel, {} sampler{instead}, seed {}",
        r.integrator, r.samples_per_pixel, r.sampler, r.seed
    )?;
    let [cx, cy, cz] = r.center;
    writeln!(
        out,
        "bounds       centre ({cx:.4}, {cy:.4}, {cz:.4}), radius {:.4}",
        r.radius
    )?;
    writeln!(
        out,
        "geometry     {} shapes, {} triangles, {} vertices, {} analytic, {} groups, {} instances",
        r.shapes, r.triangles, r.vertices, r.analytic, r.groups, r.instances
    )?;
    let lobes = r.lobes.iter().map(|lobe| lobe.count).sum::<usize>();
    writeln!(
        out,
        "materials    {} of {lobes} lobes: {}",
        r.materials,
        list(&r.lobes)
    )?;
    writeln!(
        out,
        "textures     {}, {:.1} MiB of texels",
        r.textures,
        mebibytes(r.texel_bytes)
    )?;
    let emitters = r.emitters.iter().map(|e| e.count).sum::<usize>();
    writeln!(out, "emitters     {emitters}: {}", list(&r.emitters))?;
    writeln!(
        out,
        "memory       {:.1} MiB of tables, {:.1} MiB of film",
        mebibytes(r.table_bytes),
        mebibytes(r.cost.film_bytes)
    )?;
    if let (Some(rate), Some(seconds)) = (r.cost.samples_per_second, r.cost.seconds) {
        writeln!(
            out,
            "cost         {:.3} million {} per second here, about {} for the image",
            rate / 1e6,
            r.cost.unit,
            duration(seconds)
        )?;
    }
    if !r.parameters.is_empty() {
        writeln!(out, "\nparameters (-D NAME=VALUE)")?;
    }
    for parameter in &r.parameters {
        let value = match &parameter.value {
            Some(value) => format!(", {value} here"),
            None => String::new(),
        };
        writeln!(out, "  {} = {}{value}", parameter.name, parameter.default)?;
    }
    if r.sensors.len() > 1 {
        writeln!(out, "\nsensors (--sensor N)")?;
        for (i, named) in r.sensors.iter().enumerate() {
            let mark = if i == sensor { ", in use" } else { "" };
            writeln!(out, "  {i}  {}{mark}", title(named))?;
        }
    }
    if !r.bsdfs.is_empty() {
        writeln!(out, "\nBSDFs (halflight material SCENE --id ID)")?;
        for named in &r.bsdfs {
            writeln!(out, "  {}", title(named))?;
        }
    }
    writeln!(out, "\nplugins")?;
    for plugin in &r.plugins {
        writeln!(out, "  {:5}  {}", plugin.count, plugin.name)?;
    }
    let trees = &r.ray_tracing;
    writeln!(
        out,
        "\nray tracing\n  {} nodes, depth {}, {} primitives, {:.1} MiB, built in {:.3} s",
        trees.nodes,
        trees.depth,
        trees.primitives,
        mebibytes(trees.bytes),
        trees.seconds
    )?;
    if trees.skipped > 0 {
        writeln!(
            out,
            "  {} primitives without usable coordinates are left out",
            trees.skipped
        )?;
    }
    writeln!(out, "\nnot supported or not used as written")?;
    if r.warnings.is_empty() {
        writeln!(out, "  nothing")?;
    }
    for warning in &r.warnings {
        writeln!(out, "  {warning}")?;
    }
    Ok(())
}

/// "2 a, 1 b".
fn list(counts: &[Count]) -> String {
    let parts: Vec<_> = counts
        .iter()
        .map(|entry| format!("{} {}", entry.count, entry.name))
        .collect();
    parts.join(", ")
}

fn title(named: &Named) -> String {
    match &named.id {
        Some(id) => format!("{id} ({})", named.plugin),
        None => named.plugin.clone(),
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s >= 3600.0 => format!("{:.1} h", s / 3600.0),
        s if s >= 60.0 => format!("{:.1} min", s / 60.0),
        s => format!("{s:.1} s"),
    }
}

fn mebibytes(bytes: usize) -> f64 {
    bytes as f64 / (1024.0 * 1024.0)
}
