//! The films of all tasks into one, as a tree.
//!
//! ```text
//!   tasks      0 1 2 ... 31 | 32 33 ... 63 | 64 ...      each film checked against the digest in its record
//!   merge-1         0              1           2         fan_in films each, one after the other
//!   merge-2                 0                            and so on, until one is left: the image
//! ```
//!
//! A node holds two films at a time, whatever the number of tasks; nodes of a level do not need each other, so that they run
//! as tasks too. A node that is there, made from the same digests, is not made again: after a task was repeated only its
//! ancestors are. The shape of the tree depends on the plan alone, and so does the image, to the last bit.

use super::error::FarmError;
use super::folder::Folder;
use super::plan::Plan;
use super::record::Record;
use crate::film::Film;
use crate::film::aov::Aov;
use crate::film::checkpoint::{Progress, save_checkpoint};
use crate::image::exr_output::{LayeredImage, write_exr};
use crate::image::metadata::ImageMetadata;
use crate::image::png_output::write_png;
use crate::render::record::{FIRST_SAMPLE, SEED, identity, scene_name};
use std::ops::Range;

/// The films of the level below that a node merges.
fn inputs(plan: &Plan, level: usize, index: u32) -> Range<u32> {
    let below = plan.levels()[level - 1];
    let first = index * plan.fan_in;
    first..below.min(first + plan.fan_in)
}

/// Makes a node of a level from 1 on; the last level has one node, and writes the image too.
///
/// # Errors
/// When there is no such node, films of the level below are missing or torn, or a file cannot be written.
pub fn merge_node(folder: &Folder, plan: &Plan, level: usize, index: u32) -> Result<(), FarmError> {
    let levels = plan.levels();
    if level == 0 || level >= levels.len() || index >= levels[level] {
        return Err(FarmError::Request(format!(
            "the merge has no node {index} on level {level}; its levels have {levels:?} films, tasks included"
        )));
    }
    let sources = inputs(plan, level, index);
    let records = records_of(folder, level, &sources)?;
    let digests: Vec<String> = records.iter().map(|r| r.sha256.clone()).collect();
    let path = folder.film(level, index);
    let is_last = level + 1 == levels.len();
    if let Some(record) = Record::read(&path)?
        && record.inputs == digests
        && (!is_last || plan.output.exists())
        && record.is_of(&path)?
    {
        return Ok(());
    }
    let (progress, film) = merge_films(folder, level, sources, &records)?;
    save_checkpoint(&path, &progress, &film)?;
    Record::write(
        &path,
        progress.next_sample,
        progress.render_seconds,
        digests,
    )?;
    if is_last {
        write_image(plan, &progress, &film)?;
    }
    Ok(())
}

/// Makes all nodes, level by level, and the image.
///
/// # Errors
/// As [`merge_node`]; what all tasks lack is told at once.
pub fn merge_all(folder: &Folder, plan: &Plan) -> Result<(), FarmError> {
    check_tasks(folder, plan)?;
    for (level, &count) in plan.levels().iter().enumerate().skip(1) {
        for index in 0..count {
            merge_node(folder, plan, level, index)?;
        }
    }
    Ok(())
}

/// Makes sure that all tasks have films of the recorded length, and keeps nothing of what it finds.
fn check_tasks(folder: &Folder, plan: &Plan) -> Result<(), FarmError> {
    let (mut missing, mut torn) = (Vec::new(), Vec::new());
    for index in 0..plan.tasks {
        let film = folder.film(0, index);
        match Record::read(&film)? {
            None => missing.push(index),
            Some(record) if !record.has_length(&film) => torn.push(film),
            Some(_) => {}
        }
    }
    if missing.is_empty() && torn.is_empty() {
        Ok(())
    } else {
        Err(FarmError::Incomplete { missing, torn })
    }
}

/// The records of the films that a node of `level` needs.
fn records_of(
    folder: &Folder,
    level: usize,
    sources: &Range<u32>,
) -> Result<Vec<Record>, FarmError> {
    let (mut records, mut missing, mut torn) = (Vec::new(), Vec::new(), Vec::new());
    for source in sources.clone() {
        let film = folder.film(level - 1, source);
        match Record::read(&film)? {
            None => missing.push(source),
            Some(record) if !record.has_length(&film) => torn.push(film),
            Some(record) => records.push(record),
        }
    }
    if missing.is_empty() && torn.is_empty() {
        return Ok(records);
    }
    if level > 1 {
        // Nodes are no tasks.
        torn.extend(missing.drain(..).map(|i| folder.film(level - 1, i)));
    }
    Err(FarmError::Incomplete { missing, torn })
}

/// Films one after the other into one, each checked.
fn merge_films(
    folder: &Folder,
    level: usize,
    sources: Range<u32>,
    records: &[Record],
) -> Result<(Progress, Film), FarmError> {
    let mut merged: Option<(Progress, Film)> = None;
    let mut torn = Vec::new();
    for (source, record) in sources.zip(records) {
        let path = folder.film(level - 1, source);
        let Some((progress, film)) = record.load(&path)? else {
            torn.push(path);
            continue;
        };
        // From here on only what else is torn is of interest.
        if !torn.is_empty() {
            continue;
        }
        match &mut merged {
            None => merged = Some((progress, film)),
            Some((all, sum)) => {
                add_progress(all, &progress);
                sum.merge(&film);
            }
        }
    }
    match merged {
        Some(merged) if torn.is_empty() => Ok(merged),
        _ => Err(FarmError::Incomplete {
            missing: Vec::new(),
            torn,
        }),
    }
}

/// Progress of two films together. Settings name what differs between tasks, seeds and first samples, as lists.
fn add_progress(all: &mut Progress, other: &Progress) {
    all.passes = all.passes.saturating_add(other.passes);
    all.next_sample = all.next_sample.saturating_add(other.next_sample);
    all.render_seconds += other.render_seconds;
    for name in [SEED, FIRST_SAMPLE] {
        let of = |progress: &Progress| progress.settings.get(name).cloned().unwrap_or_default();
        let (mine, others) = (of(all), of(other));
        let last = mine.rsplit(' ').next().unwrap_or_default();
        if last != others {
            let first = mine.split(' ').next().unwrap_or_default();
            let end = others.rsplit(' ').next().unwrap_or_default();
            all.settings
                .insert(name.to_owned(), format!("{first} to {end}"));
        }
    }
}

/// Writes the image of the whole film.
fn write_image(plan: &Plan, progress: &Progress, film: &Film) -> Result<(), FarmError> {
    let (scene_digest, settings) = identity(&plan.settings);
    // As the image of one run: a layer of sample counts where it is asked for or where they differ.
    let wants_counts = plan.layers.iter().any(|name| name == Aov::Samples.name());
    let metadata = ImageMetadata {
        scene: scene_name(&plan.scene.file),
        integrator: plan.integrator.clone(),
        sampler: plan.sampler.clone(),
        software: concat!("halflight ", env!("CARGO_PKG_VERSION")).to_string(),
        spp: film.total_samples() as f64 / film.statistics().len() as f64 * f64::from(plan.unit),
        sample_ranges: plan.ranges(),
        render_seconds: progress.render_seconds,
        scene_digest,
        settings,
        samples_per_pixel: film.even_samples().filter(|_| !wants_counts),
        owner: plan.scene.look.owner.clone(),
        camera: plan.camera,
        ..ImageMetadata::default()
    };
    let image = LayeredImage::from_film(film, plan.full_size, metadata);
    let look = &plan.scene.look;
    write_exr(&plan.output, &image, look.half)?;
    if look.no_png {
        return Ok(());
    }
    let png = plan.output.with_extension("png");
    write_png(
        &png,
        film.width(),
        film.height(),
        &film.mean(),
        look.exposure,
    )?;
    Ok(())
}
