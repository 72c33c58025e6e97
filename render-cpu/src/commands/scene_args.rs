//! Arguments of every command that loads a scene.

use crate::accel::Accel;
use crate::scene::build::{BuildOptions, Crop, FilmOverride, Scene, build_scene};
use crate::scene::error::SceneError;
use crate::scene::xml::{ParsedScene, decode, parse_scene, parse_scene_from_str};
use clap::Args;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Name of a scene that is read from standard input.
const STANDARD_INPUT: &str = "-";

/// Longest scene that is read from there.
const MAX_INPUT_BYTES: u64 = 1 << 30;

/// A scene file and what the command line changes about it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// Mitsuba scene file (XML of version 0.6, 2 or 3); - for standard input, beside the working directory's files.
    pub scene: PathBuf,
    /// Value of a `$name` in the scene file.
    #[arg(help_heading = "Scene", short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = parse_define)]
    pub defines: Vec<(String, String)>,
    /// Size of the image in pixels.
    #[arg(help_heading = "Pixels", long, value_name = "WxH", value_parser = parse_size, conflicts_with = "width")]
    pub size: Option<[u32; 2]>,
    /// Width of the image in pixels; the height follows in proportion.
    #[arg(help_heading = "Pixels", long, value_name = "W")]
    pub width: Option<u32>,
    /// Part of the image to render, in pixels of the whole image.
    #[arg(help_heading = "Pixels", long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    pub crop: Option<Crop>,
    /// Algorithm instead of the scene's: path, mnee, direct, ao, ptracer, bdpt, bdmnee, pssmlt, mmlt, mlt, memlt, hslt, erpt, meerpt, sppm, mcppm, appm, vcm, vm or bpm.
    #[arg(help_heading = "Algorithm", long, value_name = "NAME")]
    pub integrator: Option<String>,
    /// Random numbers instead of the scene's: independent or sobol.
    #[arg(help_heading = "Algorithm", long, value_name = "NAME")]
    pub sampler: Option<String>,
    /// Which of several sensors, from 0.
    #[arg(help_heading = "Scene", long, value_name = "N", default_value_t = 0)]
    pub sensor: usize,
    /// A file with edits of light transport: a scene file that holds nothing but `<edit>`s.
    #[arg(help_heading = "Paths", long, value_name = "FILE")]
    pub edit: Option<PathBuf>,
    /// The moment at which the keyframes of edits are taken. Default: 0.
    #[arg(help_heading = "Paths", long, value_name = "T", value_parser = parse_time)]
    pub edit_time: Option<f64>,
    /// Stop at the first thing that would otherwise be a warning.
    #[arg(help_heading = "Scene", long)]
    pub strict: bool,
}

impl SceneArgs {
    /// Reads the scene and builds its tables.
    ///
    /// # Errors
    /// What is wrong with the scene or the arguments.
    pub fn load(&self) -> Result<Scene, SceneError> {
        self.build(&self.parse()?)
    }

    /// Reads the scene, from standard input where its name is `-`.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn parse(&self) -> Result<ParsedScene, SceneError> {
        if self.scene != Path::new(STANDARD_INPUT) {
            return parse_scene(&self.scene, &self.defines, self.strict);
        }
        let name = Path::new("standard input");
        let mut bytes = Vec::new();
        io::stdin()
            .lock()
            .take(MAX_INPUT_BYTES)
            .read_to_end(&mut bytes)
            .map_err(|e| SceneError::file(name, format!("cannot be read: {e}")))?;
        let (text, note) = decode(name, bytes)?;
        if let Some((line, what)) = note {
            tracing::warn!("standard input:{line}: {what}");
        }
        parse_scene_from_str(&text, name, &self.defines, self.strict)
    }

    /// Builds the tables of the scene.
    ///
    /// # Errors
    /// What is wrong with the scene or the arguments.
    pub fn build(&self, parsed: &ParsedScene) -> Result<Scene, SceneError> {
        build_scene(
            parsed,
            &BuildOptions {
                film: FilmOverride {
                    size: self.size,
                    width: self.width,
                    crop: self.crop,
                },
                integrator: self.integrator.clone(),
                sampler: self.sampler.clone(),
                sensor: self.sensor,
                edit: self.edit.clone(),
                edit_time: self.edit_time,
            },
        )
    }
}

/// The ray tracer over a scene.
pub fn build_accel(scene: &Scene) -> Accel {
    Accel::build(scene.tables.view(), &scene.tables.groups)
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_string(), value.to_string())),
        _ => Err("expected NAME=VALUE".to_string()),
    }
}

/// `N` numbers with separators between them.
pub(super) fn parse_numbers<const N: usize>(
    text: &str,
    separator: &[char],
    form: &str,
) -> Result<[u32; N], String> {
    let mut numbers = [0; N];
    let mut parts = text.split(separator);
    for number in &mut numbers {
        *number = parts
            .next()
            .and_then(|part| part.trim().parse().ok())
            .ok_or_else(|| format!("expected {form}"))?;
    }
    match parts.next() {
        None => Ok(numbers),
        Some(_) => Err(format!("expected {form}")),
    }
}

/// Makes sure that the pixels X, Y, W, H are of the whole image, and some of them in the image that is rendered.
///
/// # Errors
/// If they are not.
pub(super) fn check_window([x, y, w, h]: [u32; 4], scene: &Scene) -> Result<(), String> {
    let camera = &scene.tables.camera;
    let ([left, top], [width, height]) = (camera.crop_offset, camera.crop_size);
    let meet = |a: u32, a_length: u32, b: u32, b_length: u32| {
        a_length > 0 && a < b + b_length && b < a.saturating_add(a_length)
    };
    if !meet(x, w, left, width) || !meet(y, h, top, height) {
        return Err(format!(
            "the pixels {x},{y},{w},{h} are not in the image, {left},{top},{width},{height}"
        ));
    }
    let [columns, rows] = camera.film_size;
    if x.saturating_add(w) > columns || y.saturating_add(h) > rows {
        return Err(format!(
            "the pixels {x},{y},{w},{h} reach beyond the image of {columns} x {rows} pixels"
        ));
    }
    Ok(())
}

fn parse_time(text: &str) -> Result<f64, String> {
    let time = text.parse().ok().filter(|t: &f64| t.is_finite());
    time.ok_or_else(|| "expected a finite number".to_owned())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    parse_numbers(text, &['x', 'X'], "WIDTHxHEIGHT")
}

fn parse_crop(text: &str) -> Result<Crop, String> {
    let [x, y, w, h] = parse_numbers(text, &[','], "X,Y,WIDTH,HEIGHT")?;
    Ok(Crop {
        offset: [x, y],
        size: [w, h],
    })
}
