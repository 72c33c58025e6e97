//! Metadata of a rendered image: the attributes of its EXR file.
//!
//! Attributes are text, named `scene`, `integrator`, `sampler`, `seed`, `sampleRanges`, `software`, `owner`, `sceneDigest` and
//! `settings` and `mutations` (JSON), so that every EXR tool shows them, or numbers: `spp`, `renderSeconds`, `samplesPerPixel`. `sceneDigest` and
//! `settings` tell images that belong together. `sampleRanges` is the record that makes merging safe: which samples
//! of which seeds the image holds, as in `1:0..64 2:0..64`.

use super::camera_attributes::CameraAttributes;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Samples `from` (included) to `to` (excluded) of the random sequence of one seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleRange {
    /// Seed of the random sequence.
    pub seed: u64,
    /// First sample.
    pub from: u32,
    /// One after the last sample (of the pixel that has most, if the run was adaptive).
    pub to: u32,
}

impl SampleRange {
    /// Whether the two ranges hold a sample in common; such images are not independent and must not be merged.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.seed == other.seed && self.from.max(other.from) < self.to.min(other.to)
    }
}

impl fmt::Display for SampleRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}..{}", self.seed, self.from, self.to)
    }
}

/// A text that is no `SEED:FROM..TO`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no sample range of the form SEED:FROM..TO")]
pub struct InvalidSampleRange(pub String);

impl FromStr for SampleRange {
    type Err = InvalidSampleRange;

    fn from_str(text: &str) -> Result<Self, InvalidSampleRange> {
        let parse = || {
            let (seed, range) = text.split_once(':')?;
            let (from, to) = range.split_once("..")?;
            Some(Self {
                seed: seed.parse().ok()?,
                from: from.parse().ok()?,
                to: to.parse().ok()?,
            })
        };
        parse()
            .filter(|range| range.from <= range.to)
            .ok_or_else(|| InvalidSampleRange(text.to_owned()))
    }
}

/// Joins ranges of the same seed that touch, and sorts them.
pub fn join_ranges(ranges: &[SampleRange]) -> Vec<SampleRange> {
    let mut sorted = ranges.to_vec();
    sorted.sort_unstable();
    let mut joined: Vec<SampleRange> = Vec::new();
    for range in sorted {
        match joined.last_mut() {
            Some(last) if last.seed == range.seed && last.to == range.from => last.to = range.to,
            _ => joined.push(range),
        }
    }
    joined
}

/// A matrix of sixteen numbers.
fn matrix(text: &str) -> Option<[f32; 16]> {
    let numbers: Result<Vec<f32>, _> = text.split_whitespace().map(str::parse).collect();
    numbers.ok()?.try_into().ok()
}

/// How an image was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageMetadata {
    /// Name of the scene, as given.
    pub scene: String,
    /// Light-transport algorithm.
    pub integrator: String,
    /// Random or quasi-random sequence.
    pub sampler: String,
    /// Program and version.
    pub software: String,
    /// Samples per pixel, on average.
    pub spp: f64,
    /// The samples that the image holds.
    pub sample_ranges: Vec<SampleRange>,
    /// Seconds spent rendering, all runs together.
    pub render_seconds: f64,
    /// Samples of every pixel, where all have as many.
    pub samples_per_pixel: Option<u32>,
    /// Who the image belongs to; empty if unknown.
    pub owner: String,
    /// Where the camera stood, as OpenEXR has it.
    pub camera: CameraAttributes,
    /// Digest of the scene's content; empty where it is not known.
    pub scene_digest: String,
    /// What else decides the radiance that an image estimates, by name, and the sampler.
    pub settings: BTreeMap<String, String>,
    /// What became of the mutations of Markov chains in the last run, as JSON; empty where there were none.
    pub mutations: String,
}

impl ImageMetadata {
    /// The metadata as attributes: names and values.
    pub fn attributes(&self) -> Vec<(&'static str, String)> {
        let mut attributes = vec![
            ("software", self.software.clone()),
            ("scene", self.scene.clone()),
            ("integrator", self.integrator.clone()),
            ("sampler", self.sampler.clone()),
        ];
        if !self.owner.is_empty() {
            attributes.push(("owner", self.owner.clone()));
        }
        if !self.scene_digest.is_empty() {
            attributes.push(("sceneDigest", self.scene_digest.clone()));
        }
        if !self.settings.is_empty() {
            let json = serde_json::json!(self.settings).to_string();
            attributes.push(("settings", json));
        }
        if !self.mutations.is_empty() {
            attributes.push(("mutations", self.mutations.clone()));
        }
        if !self.sample_ranges.is_empty() {
            let join = |items: Vec<String>| items.join(" ");
            let mut seeds: Vec<_> = self.sample_ranges.iter().map(|r| r.seed).collect();
            seeds.dedup();
            attributes.push(("seed", join(seeds.iter().map(u64::to_string).collect())));
            attributes.push((
                "sampleRanges",
                join(
                    self.sample_ranges
                        .iter()
                        .map(SampleRange::to_string)
                        .collect(),
                ),
            ));
        }
        attributes
    }

    /// The metadata that are numbers: names and values.
    pub fn numbers(&self) -> Vec<(&'static str, f64)> {
        let mut numbers = vec![("spp", self.spp), ("renderSeconds", self.render_seconds)];
        if let Some(samples) = self.samples_per_pixel {
            numbers.push(("samplesPerPixel", samples.into()));
        }
        numbers
    }

    /// The metadata of attributes, looked up by name; what is missing stays at its default.
    ///
    /// # Errors
    /// If the sample ranges are there but cannot be read: such a file must not be merged by guess.
    pub fn from_attributes(
        find: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, InvalidSampleRange> {
        let text = |name| find(name).unwrap_or_default();
        let number = |name| {
            find(name)
                .and_then(|t| t.parse().ok())
                .filter(|n: &f64| n.is_finite())
                .unwrap_or(0.0)
        };
        let sample_ranges = text("sampleRanges")
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            scene: text("scene"),
            integrator: text("integrator"),
            sampler: text("sampler"),
            software: text("software"),
            spp: number("spp"),
            sample_ranges,
            render_seconds: number("renderSeconds"),
            samples_per_pixel: find("samplesPerPixel").and_then(|t| t.parse().ok()),
            owner: text("owner"),
            camera: CameraAttributes {
                world_to_camera: find("worldToCamera").and_then(|t| matrix(&t)),
                world_to_ndc: find("worldToNDC").and_then(|t| matrix(&t)),
            },
            scene_digest: text("sceneDigest"),
            settings: serde_json::from_str(&text("settings")).unwrap_or_default(),
            mutations: text("mutations"),
        })
    }
}
