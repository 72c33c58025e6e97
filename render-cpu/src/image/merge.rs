//! Merging images of one scene that hold different samples.
//!
//! Per pixel, image i has n_i samples (layer `samples`) and their mean m_i; with a layer `variance`, the variance of
//! that mean V_i, so the sum of squared deviations is M_i = V_i n_i (n_i - 1). The merged pixel is the one that all
//! samples together would have made (Chan, Golub and LeVeque 1979), up to the rounding of the layers to f32:
//!
//! n = sum n_i,  m = sum n_i m_i / n,  M = sum M_i + sum n_i (m_i - m)^2,  V = M / (n (n - 1)).
//!
//! All other layers are means over the same samples and are weighted alike. Images must be of the same scene and size,
//! and must hold different samples: two images of one seed with overlapping sample ranges are not independent, and
//! their merged image would claim more than it knows.

use crate::image::ExrImage;
use crate::image::exr_output::{ChannelValues, LayeredImage};
use crate::image::metadata::{ImageMetadata, InvalidSampleRange, join_ranges};

/// Why images cannot be merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MergeError {
    /// Another size or crop.
    #[error("{name}: its {what} is {found}, that of {first} is {expected}")]
    OtherImage {
        /// The image.
        name: String,
        /// The first image.
        first: String,
        /// What differs.
        what: &'static str,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The images share samples.
    #[error(
        "{name} and {other} hold the same samples ({range}): merged they would count twice; render them with other seeds or --samples"
    )]
    SharedSamples {
        /// The image.
        name: String,
        /// The image it shares samples with.
        other: String,
        /// The range that both hold a part of.
        range: String,
    },
    /// A layer that merging needs is not there.
    #[error("{name}: merging needs the layer \"{layer}\"")]
    MissingLayer {
        /// The image.
        name: String,
        /// The layer.
        layer: String,
    },
    /// A value that no samples have.
    #[error("{name}: {what} at pixel ({x}, {y})")]
    InvalidPixel {
        /// The image.
        name: String,
        /// What is wrong.
        what: String,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
    /// Metadata that cannot be read.
    #[error("{name}: {source}")]
    Metadata {
        /// The image.
        name: String,
        /// Why.
        source: InvalidSampleRange,
    },
}

/// A channel's mean so far, and the sum of squared deviations if the images carry variances.
struct MergedChannel {
    name: String,
    mean: Vec<f64>,
    m2: Option<Vec<f64>>,
}

/// Images merged so far.
pub struct Merger {
    first: String,
    width: usize,
    height: usize,
    origin: [i32; 2],
    full_size: [u32; 2],
    metadata: ImageMetadata,
    /// Name and metadata of every image.
    images: Vec<(String, ImageMetadata)>,
    counts: Vec<f64>,
    channels: Vec<MergedChannel>,
    warnings: Vec<String>,
    force: bool,
}

const SAMPLES: &str = "samples";
const VARIANCE: &str = "variance.";

impl Merger {
    /// Starts with one image. `force` merges, with a warning, even what shares samples or names
    /// another scene (a path that differs between machines).
    ///
    /// # Errors
    /// If the image has not what merging needs.
    pub fn new(name: &str, image: &ExrImage, force: bool) -> Result<Self, MergeError> {
        let metadata = metadata(name, image)?;
        let (width, height) = (image.width as usize, image.height as usize);
        let counts = sample_counts(name, image)?;
        let mut channels = Vec::new();
        for (channel, values) in &image.channels {
            if channel == SAMPLES || channel.starts_with(VARIANCE) {
                continue;
            }
            let mean = to_f64(name, values, width)?;
            let m2 = image
                .channel(&variance_of(channel))
                .map(|v| deviations(name, v, &counts, width))
                .transpose()?;
            channels.push(MergedChannel {
                name: channel.clone(),
                mean,
                m2,
            });
        }
        let mut merger = Self {
            first: name.to_owned(),
            width,
            height,
            origin: image.origin,
            full_size: image.display_size,
            images: vec![(name.to_owned(), metadata.clone())],
            metadata,
            counts,
            channels,
            warnings: Vec::new(),
            force,
        };
        merger.warn_without_ranges(name);
        Ok(merger)
    }

    /// Adds an image.
    ///
    /// # Errors
    /// If it is of another scene or size, shares samples with the others, or has not what merging needs.
    pub fn add(&mut self, name: &str, image: &ExrImage) -> Result<(), MergeError> {
        let metadata = metadata(name, image)?;
        self.check_layout(name, image, &metadata)?;
        self.check_samples(name, &metadata)?;
        let counts = sample_counts(name, image)?;

        // Everything is read before anything is changed.
        let mut others = Vec::with_capacity(self.channels.len());
        let mut dropped = Vec::new();
        for channel in &self.channels {
            let Some(values) = image.channel(&channel.name) else {
                if matches!(channel.name.as_str(), "R" | "G" | "B") {
                    return Err(MergeError::MissingLayer {
                        name: name.to_owned(),
                        layer: channel.name.clone(),
                    });
                }
                dropped.push(channel.name.clone());
                others.push(None);
                continue;
            };
            let mean = to_f64(name, values, self.width)?;
            let m2 = image.channel(&variance_of(&channel.name));
            let m2 = m2
                .map(|v| deviations(name, v, &counts, self.width))
                .transpose()?;
            if channel.m2.is_some() && m2.is_none() {
                dropped.push(variance_of(&channel.name));
            }
            others.push(Some((mean, m2)));
        }
        for layer in dropped {
            self.warnings
                .push(format!("{name} has no layer \"{layer}\": it is left out"));
        }
        let mut others = others.into_iter();
        self.channels.retain_mut(|channel| {
            let Some(Some((mean, m2))) = others.next() else {
                return false;
            };
            if m2.is_none() {
                channel.m2 = None;
            }
            for i in 0..mean.len() {
                let (na, nb) = (self.counts[i], counts[i]);
                if nb == 0.0 {
                    continue;
                }
                let delta = mean[i] - channel.mean[i];
                channel.mean[i] += delta * (nb / (na + nb));
                if let (Some(sum), Some(m2)) = (&mut channel.m2, &m2) {
                    sum[i] += m2[i] + delta * delta * (na * nb / (na + nb));
                }
            }
            true
        });
        for (sum, count) in self.counts.iter_mut().zip(&counts) {
            *sum += count;
        }
        for (what, ours, theirs) in [
            (
                "integrator",
                &self.metadata.integrator,
                &metadata.integrator,
            ),
            ("software", &self.metadata.software, &metadata.software),
        ] {
            if ours != theirs {
                self.warnings.push(format!(
                    "{name} was made with {what} \"{theirs}\", {} with \"{ours}\"",
                    self.first
                ));
            }
        }
        self.metadata.render_seconds += metadata.render_seconds;
        self.metadata.sample_ranges.extend(&metadata.sample_ranges);
        self.images.push((name.to_owned(), metadata));
        self.warn_without_ranges(name);
        Ok(())
    }

    /// What the user should know.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The merged image.
    pub fn finish(self) -> LayeredImage {
        let pixels = self.counts.len();
        let mut channels = Vec::new();
        for channel in self.channels {
            if let Some(m2) = channel.m2 {
                let variance = |(m2, n): (f64, &f64)| {
                    if *n > 1.0 {
                        (m2 / (n * (n - 1.0))) as f32
                    } else {
                        0.0
                    }
                };
                let values = m2.into_iter().zip(&self.counts).map(variance).collect();
                channels.push((variance_of(&channel.name), ChannelValues::Float(values)));
            }
            let values = channel.mean.into_iter().map(|v| v as f32).collect();
            channels.push((channel.name, ChannelValues::Float(values)));
        }
        let counts = self.counts.iter().map(|&n| n as u32).collect();
        channels.push((SAMPLES.to_owned(), ChannelValues::Count(counts)));
        let metadata = ImageMetadata {
            spp: self.counts.iter().sum::<f64>() / pixels as f64,
            sample_ranges: join_ranges(&self.metadata.sample_ranges),
            ..self.metadata
        };
        LayeredImage {
            width: self.width as u32,
            height: self.height as u32,
            offset: self.origin,
            full_size: self.full_size,
            channels,
            metadata,
        }
    }

    fn check_layout(
        &mut self,
        name: &str,
        image: &ExrImage,
        metadata: &ImageMetadata,
    ) -> Result<(), MergeError> {
        let size = |w: usize, h: usize| format!("{w} x {h}");
        let position = |p: [i32; 2]| format!("({}, {})", p[0], p[1]);
        let checks = [
            (
                "size",
                size(image.width as usize, image.height as usize),
                size(self.width, self.height),
            ),
            (
                "crop position",
                position(image.origin),
                position(self.origin),
            ),
            ("scene", metadata.scene.clone(), self.metadata.scene.clone()),
        ];
        for (what, found, expected) in checks {
            if found != expected {
                let error = MergeError::OtherImage {
                    name: name.to_owned(),
                    first: self.first.clone(),
                    what,
                    found,
                    expected,
                };
                if !(self.force && what == "scene") {
                    return Err(error);
                }
                self.warnings.push(error.to_string());
            }
        }
        Ok(())
    }

    fn check_samples(&mut self, name: &str, metadata: &ImageMetadata) -> Result<(), MergeError> {
        for (other, their) in &self.images {
            for range in &metadata.sample_ranges {
                if their.sample_ranges.iter().any(|r| r.overlaps(range)) {
                    let error = MergeError::SharedSamples {
                        name: name.to_owned(),
                        other: other.clone(),
                        range: range.to_string(),
                    };
                    if !self.force {
                        return Err(error);
                    }
                    self.warnings.push(error.to_string());
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    fn warn_without_ranges(&mut self, name: &str) {
        if self
            .images
            .last()
            .is_some_and(|(_, metadata)| metadata.sample_ranges.is_empty())
        {
            self.warnings.push(format!(
                "{name} does not say which samples it holds: they are taken as new ones"
            ));
        }
    }
}

/// Name of the channel with the variance of a channel.
fn variance_of(channel: &str) -> String {
    format!("{VARIANCE}{channel}")
}

fn metadata(name: &str, image: &ExrImage) -> Result<ImageMetadata, MergeError> {
    let find = |attribute: &str| image.attribute(attribute).map(str::to_owned);
    ImageMetadata::from_attributes(find).map_err(|source| MergeError::Metadata {
        name: name.to_owned(),
        source,
    })
}

fn sample_counts(name: &str, image: &ExrImage) -> Result<Vec<f64>, MergeError> {
    for layer in ["R", "G", "B", SAMPLES] {
        if image.channel(layer).is_none() {
            return Err(MergeError::MissingLayer {
                name: name.to_owned(),
                layer: layer.to_owned(),
            });
        }
    }
    let counts = to_f64(
        name,
        image.channel(SAMPLES).unwrap_or_default(),
        image.width as usize,
    )?;
    match counts.iter().position(|n| *n < 0.0 || n.fract() != 0.0) {
        Some(i) => Err(invalid(
            name,
            "a number of samples that is not whole",
            i,
            image.width as usize,
        )),
        None => Ok(counts),
    }
}

/// Sums of squared deviations from variances of means.
fn deviations(
    name: &str,
    variance: &[f32],
    counts: &[f64],
    width: usize,
) -> Result<Vec<f64>, MergeError> {
    let mut m2 = to_f64(name, variance, width)?;
    if let Some(i) = m2.iter().position(|v| *v < 0.0) {
        return Err(invalid(name, "a negative variance", i, width));
    }
    for (v, n) in m2.iter_mut().zip(counts) {
        *v *= n * (n - 1.0).max(0.0);
    }
    Ok(m2)
}

fn to_f64(name: &str, values: &[f32], width: usize) -> Result<Vec<f64>, MergeError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(invalid(name, "a value that is not finite", i, width)),
        None => Ok(values.iter().map(|&v| f64::from(v)).collect()),
    }
}

fn invalid(name: &str, what: &str, i: usize, width: usize) -> MergeError {
    MergeError::InvalidPixel {
        name: name.to_owned(),
        what: what.to_owned(),
        x: i % width,
        y: i / width,
    }
}
