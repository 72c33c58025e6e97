//! `halflight inspect SCENE -o PAGE.html`: the page for a browser.

use super::inspect_args::InspectArgs;
use super::output_file;
use super::scene_args::build_accel;
use crate::atomic_file::write_atomically;
use crate::expression::{PartsRequest, PathParts};
use crate::film::aov::AovSet;
use crate::image::picture::Picture;
use crate::inspect::false_color::irradiance_film;
use crate::inspect::page::Page;
use crate::inspect::spherical_plot::SphericalPlot;
use crate::processor::set_threads;
use crate::render::render_film;
use crate::say::note;
use halflight_kernel::scene::SceneView;
use halflight_kernel::transport::integrator_kind;
use std::error::Error;
use std::process::ExitCode;

/// Samples per pixel of irradiance: it has less noise than radiance, and is looked at less.
const IRRADIANCE_SAMPLES: u32 = 16;

/// Writes the page.
///
/// # Errors
/// What keeps it from being made or written, in one sentence.
pub(super) fn run(
    args: &InspectArgs,
    quiet: bool,
) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let name = args.output.display();
    if args
        .output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"))
    {
        return Err(format!("{name}: say with --tool what the picture shows; without one a page is written, and its name ends in .html").into());
    }
    output_file::check(&args.output, &["html"], args.inputs())?;
    set_threads(args.threads)?;
    let mut scene = args.scene.load()?;
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    args.leave_out_edits(&mut scene);
    let request = PartsRequest {
        layers: Vec::new(),
        only: args.only.clone(),
    };
    let parts = PathParts::new(&request, &scene.tables.view(), &scene.names)?;
    let [width, height] = scene.tables.camera.crop_size;
    let (image, source) = match &args.page.image {
        Some(path) => {
            let picture = Picture::load(path, None)?;
            if [picture.window.width, picture.window.height] != [width, height] {
                let found = picture.window;
                return Err(format!(
                    "{}: {} x {} pixels, where the scene's image has {width} x {height}",
                    path.display(),
                    found.width,
                    found.height
                )
                .into());
            }
            let file = path.file_name().unwrap_or_default();
            (picture.pixels, file.to_string_lossy().into_owned())
        }
        None => {
            let film = render_film(&scene, &args.options(), AovSet::NONE)?;
            let pixels = film.mean().iter().map(|p| p.map(|v| v as f32)).collect();
            (
                pixels,
                format!("{}, {} samples per pixel", scene.integrator, args.spp),
            )
        }
    };
    // Everything else is measured by path tracing, whatever the scene's image is made by.
    scene.settings.kind = integrator_kind::PATH;
    let irradiance = irradiance_film(&scene, args.spp.min(IRRADIANCE_SAMPLES), args.seed)?;
    let irradiance: Vec<[f32; 3]> = irradiance
        .mean()
        .iter()
        .map(|p| p.map(|v| v as f32))
        .collect();
    let accel = build_accel(&scene);
    let tables = scene.tables.view();
    let traverse = accel.traverse(tables);
    let view = SceneView {
        tables,
        traverse: &traverse,
    };
    let record = args.path.load(&view, &scene, &parts, args.spp, args.seed)?;
    let mut plots = Vec::new();
    if let Some(probe) = args.probe(&view)? {
        let expressions = parts.view();
        let (rows, seed) = (args.rows as usize, args.seed);
        let plot = SphericalPlot::measure(
            &view,
            &scene.settings,
            expressions.as_ref(),
            &probe,
            rows,
            args.spp,
            seed,
        );
        plots.push((probe, plot));
    }
    let volume_args = &args.volume;
    let volume = match volume_args.bounds {
        Some(_) => Some(volume_args.measure(&view, &scene, parts.view().as_ref(), args.seed)?),
        None => None,
    };
    let file = args.scene.scene.file_name().unwrap_or_default();
    let page = Page {
        title: file.to_string_lossy().into_owned(),
        scene: &scene,
        image: &image,
        note: source,
        irradiance: Some(&irradiance),
        record: &record,
        plots: &plots,
        volume: volume.as_ref().map(|volume| (volume, volume_args.walks)),
        most_triangles: args.page.triangles as usize,
    };
    write_atomically(&args.output, |stream| page.write(&view, stream))?;
    if !quiet {
        let bytes = args.output.metadata().map_or(0, |m| m.len());
        note(format_args!(
            "{name}: {} of {} paths, {:.1} MB; open it in a browser",
            record.header.count,
            record.header.found,
            bytes as f64 * 1e-6
        ));
    }
    Ok(ExitCode::SUCCESS)
}
