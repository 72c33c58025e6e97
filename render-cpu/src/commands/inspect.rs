//! `halflight inspect`: tools that look at the light of a scene.

use super::inspect_args::{InspectArgs, Quantity, Tool};
use super::output_file;
use super::scene_args::build_accel;
use crate::expression::{PartsRequest, PathParts};
use crate::film::aov::AovSet;
use crate::film::luminance;
use crate::image::png_output::{Exposure, tone_map, write_png_bytes};
use crate::inspect::paths::{Places, picture};
use crate::inspect::spherical_plot::SphericalPlot;
use crate::inspect::{ColorScale, false_color};
use crate::plot::canvas::Canvas;
use crate::processor::set_threads;
use crate::render::render_film;
use crate::say::{note, print_line};
use glam::DVec3;
use halflight_kernel::scene::SceneView;
use serde_json::json;
use std::error::Error;
use std::process::ExitCode;

/// Runs the command.
///
/// # Errors
/// What keeps the picture from being made or written, in one sentence.
pub fn run(args: &InspectArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let name = args.output.display();
    let Some(tool) = args.tool else {
        return super::inspect_page::run(args, quiet);
    };
    if let (Some(min), Some(max)) = (args.min, args.max)
        && min >= max
    {
        return Err("--min must be below --max".into());
    }
    output_file::check(&args.output, &["png"], args.inputs())?;
    if tool == Tool::SphericalPlot && args.at.is_none() && args.pixel.is_none() {
        return Err("--tool spherical-plot needs a place: --at X,Y,Z or --pixel X,Y".into());
    }
    set_threads(args.threads)?;
    let mut scene = args.scene.load()?;
    let is_measured = tool != Tool::FalseColor || args.quantity == Quantity::Irradiance;
    if is_measured {
        // These are measured by path tracing, whatever the scene's image is made by.
        scene.settings.kind = halflight_kernel::transport::integrator_kind::PATH;
    }
    let request = PartsRequest {
        layers: Vec::new(),
        only: args.only.clone(),
    };
    // Arrows of some paths stand over the image of all.
    let parts = PathParts::new(&request, &scene.tables.view(), &scene.names)?;
    if !matches!(tool, Tool::Paths | Tool::Volume) {
        scene.divide(&request)?;
    }
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    if is_measured {
        args.leave_out_edits(&mut scene);
    }
    let scale = |values: &[f64]| ColorScale::of(values, args.min, args.max, args.log);
    let mut summary = String::new();
    let (canvas, numbers) = match tool {
        Tool::FalseColor => {
            let (film, quantity) = match args.quantity {
                Quantity::Irradiance => (
                    false_color::irradiance_film(&scene, args.spp, args.seed)?,
                    "irradiance, W/m²",
                ),
                Quantity::Radiance => {
                    let film = render_film(&scene, &args.options(), AovSet::NONE)?;
                    (film, "radiance, W/(m² sr)")
                }
            };
            let mean = film.mean();
            let values: Vec<f64> = mean.iter().map(|p| luminance(*p)).collect();
            let scale = scale(&values);
            let canvas = false_color::draw(&mean, film.width(), |_| scale, quantity)?;
            let average = values.iter().sum::<f64>() / values.len() as f64;
            (
                canvas,
                json!({"from": scale.least, "to": scale.most, "mean": average}),
            )
        }
        Tool::SphericalPlot => {
            let accel = build_accel(&scene);
            let tables = scene.tables.view();
            let traverse = accel.traverse(tables);
            let view = SceneView {
                tables,
                traverse: &traverse,
            };
            let probe = args.probe(&view)?.ok_or("a spherical plot needs a place")?;
            let expressions = scene.parts.view();
            let plot = SphericalPlot::measure(
                &view,
                &scene.settings,
                expressions.as_ref(),
                &probe,
                args.rows as usize,
                args.spp,
                args.seed,
            );
            let values: Vec<f64> = plot.radiance.iter().map(|p| luminance(*p)).collect();
            let scale = scale(&values);
            let [x, y, z] = probe.position.to_array();
            let title = format!("at {x:.3}, {y:.3}, {z:.3}");
            let from = DVec3::from_array(args.view.map(f64::from));
            if !(from.length() > 0.0) {
                return Err("--view: expected a direction".into());
            }
            let canvas = plot.draw(scale, 480, from, &title)?;
            let integral = plot.integral();
            (
                canvas,
                json!({"from": scale.least, "to": scale.most, "position": [x, y, z], "integral": integral}),
            )
        }
        Tool::Paths => {
            let accel = build_accel(&scene);
            let tables = scene.tables.view();
            let traverse = accel.traverse(tables);
            let view = SceneView {
                tables,
                traverse: &traverse,
            };
            let record = args.path.load(&view, &scene, &parts, args.spp, args.seed)?;
            let film = render_film(&scene, &args.options(), AovSet::NONE)?;
            let places = Places::of(&record);
            let tree = args.path.tree(&record);
            let groups = args.path.groups(&record, &tree, &places);
            let canvas = picture::draw(&view, &film.mean(), &record, &places, &groups)?;
            let bundles: usize = groups.iter().map(|g| g.bundles.len()).sum();
            summary = format!("{} paths as {bundles} bundles", record.paths.len());
            (canvas, tree.json())
        }
        Tool::Volume => {
            let accel = build_accel(&scene);
            let tables = scene.tables.view();
            let traverse = accel.traverse(tables);
            let view = SceneView {
                tables,
                traverse: &traverse,
            };
            let expressions = parts.view();
            let volume_args = &args.volume;
            let volume = volume_args.measure(&view, &scene, expressions.as_ref(), args.seed)?;
            let film = volume.film(&view, &scene, args.spp, args.seed)?;
            let values = volume.luminance();
            let sum: f64 = values.iter().map(|v| f64::from(*v)).sum();
            let mean = sum / values.len() as f64;
            let most = values.iter().fold(0.0, |a: f32, b| a.max(*b));
            let [nx, ny, nz] = volume.grid.counts;
            summary = format!("{nx} x {ny} x {nz} voxels, mean fluence rate {mean:.4e} W/m²");
            let pixels = tone_map(&film.mean(), Exposure::Stops(0.0));
            let size = [film.width(), film.height()];
            let mut canvas = Canvas::new(size[0], size[1]);
            canvas.paste(&pixels, size, 0, 0);
            (
                canvas,
                json!({
                    "low": volume.grid.low.to_array(), "high": volume.grid.high.to_array(),
                    "voxels": volume.grid.counts, "mean": mean, "most": most,
                    "scattering": volume.grid.scattering, "extinction": volume.grid.extinction,
                }),
            )
        }
    };
    let [width, height] = canvas.size();
    write_png_bytes(&args.output, width, height, canvas.rgb())?;
    if args.json {
        print_line(format_args!("{numbers:#}"))?;
    }
    if !quiet {
        if summary.is_empty() {
            summary = format!("{} to {}", numbers["from"], numbers["to"]);
        }
        note(format_args!("{name}: {summary}"));
    }
    Ok(ExitCode::SUCCESS)
}
