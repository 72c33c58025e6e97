//! Merging images of one scene that hold different samples.
//!
//! Per pixel, image i has n_i samples (layer `samples`) and their mean m_i; with a layer `variance`, the variance of
//! that mean V_i, so the sum of squared deviations is M_i = V_i n_i (n_i - 1). The merged pixel is the one that all
//! samples together would have made (Chan, Golub and LeVeque 1979), up to the rounding of the layers to f32:
//!
//! n = sum n_i,  m = sum n_i m_i / n,  M = sum M_i + sum n_i (m_i - m)^2,  V = M / (n (n - 1)).
//!
//! All other layers are means over the same samples and are weighted alike, or can be made such (`merge_shares.rs`). Images must be of the same scene and algorithm, by
//! the digest and the settings that they carry, and must hold different samples: two images of one seed with overlapping sample
//! ranges are not independent, and their merged image would claim more than it knows. Crops of one image come to their places
//! in it; they may hold the same samples where they have no pixel in common.
//!
//! Exact merging would take exact sums in every image, 120 bytes for each pixel beside the 12 of its radiance; so this is exact
//! to the rounding of the layers.

use crate::film::checkpoint::DIGEST;
use crate::image::ExrImage;
use crate::image::exr_output::{ChannelValues, LayeredImage};
use crate::image::merge_error::MergeError;
use crate::image::merge_layers::{
    SAMPLES, VARIANCE, deviations, metadata, sample_counts, to_f64, variance_of, window,
};
use crate::image::merge_shares::{from_means, to_means};
use crate::image::metadata::{ImageMetadata, join_ranges};
use crate::image::window::Window;
use std::collections::{BTreeMap, BTreeSet};

/// A channel's mean so far, and the sum of squared deviations if the images carry variances.
struct MergedChannel {
    name: String,
    mean: Vec<f64>,
    m2: Option<Vec<f64>>,
}

/// Images merged so far.
pub struct Merger {
    first: String,
    window: Window,
    full_size: [u32; 2],
    metadata: ImageMetadata,
    /// Name, metadata and pixels of every image.
    images: Vec<(String, ImageMetadata, Window)>,
    counts: Vec<f64>,
    channels: Vec<MergedChannel>,
    /// Whether some image has a layer of sample counts.
    has_samples: bool,
    warnings: Vec<String>,
    force: bool,
}

impl Merger {
    /// Starts with one image. `force` merges, with a warning, even what shares samples or names
    /// another scene (a path that differs between machines).
    ///
    /// # Errors
    /// If the image has not what merging needs.
    pub fn new(name: &str, image: &ExrImage, force: bool) -> Result<Self, MergeError> {
        let metadata = metadata(name, image)?;
        let width = image.width as usize;
        let counts = sample_counts(name, image)?;
        let mut channels = Vec::new();
        for (channel, values) in &image.channels {
            if channel == SAMPLES || channel.starts_with(VARIANCE) {
                continue;
            }
            let mean = to_f64(name, &to_means(image, channel, values), width)?;
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
        let window = window(image);
        let mut merger = Self {
            first: name.to_owned(),
            window,
            full_size: image.display_size,
            images: vec![(name.to_owned(), metadata.clone(), window)],
            metadata,
            counts,
            channels,
            has_samples: image.channel(SAMPLES).is_some(),
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
        let window = window(image);
        self.check_identity(name, image, &metadata)?;
        self.check_passes(name, &metadata)?;
        self.check_samples(name, &metadata, window)?;
        let union = self.window.union(&window);
        let union = union.ok_or_else(|| MergeError::TooLarge {
            name: name.to_owned(),
        })?;
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
            let means = to_means(image, &channel.name, values);
            let mean = to_f64(name, &means, window.width as usize)?;
            let m2 = image.channel(&variance_of(&channel.name));
            let m2 = m2
                .map(|v| deviations(name, v, &counts, window.width as usize))
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
        self.grow(union);
        let places: Vec<usize> = window.indices_in(&union).collect();
        let mut others = others.into_iter();
        self.channels.retain_mut(|channel| {
            let Some(Some((mean, m2))) = others.next() else {
                return false;
            };
            if m2.is_none() {
                channel.m2 = None;
            }
            for (i, &pixel) in places.iter().enumerate() {
                let (na, nb) = (self.counts[pixel], counts[i]);
                if nb == 0.0 {
                    continue;
                }
                let delta = mean[i] - channel.mean[pixel];
                channel.mean[pixel] += delta * (nb / (na + nb));
                if let (Some(sum), Some(m2)) = (&mut channel.m2, &m2) {
                    sum[pixel] += m2[i] + delta * delta * (na * nb / (na + nb));
                }
            }
            true
        });
        for (&pixel, count) in places.iter().zip(&counts) {
            self.counts[pixel] += count;
        }
        let (ours, theirs) = (&self.metadata.software, &metadata.software);
        if ours != theirs {
            self.warnings.push(format!(
                "{name} was made with software \"{theirs}\", {} with \"{ours}\"",
                self.first
            ));
        }
        self.has_samples |= image.channel(SAMPLES).is_some();
        self.metadata.render_seconds += metadata.render_seconds;
        let is_elsewhere = !self.images.iter().any(|(_, _, w)| w.meets(&window));
        for range in &metadata.sample_ranges {
            // Crops may hold the same samples of different pixels.
            if !is_elsewhere || !self.metadata.sample_ranges.contains(range) {
                self.metadata.sample_ranges.push(*range);
            }
        }
        self.images.push((name.to_owned(), metadata, window));
        self.warn_without_ranges(name);
        Ok(())
    }

    /// What the user should know.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The merged image.
    pub fn finish(mut self) -> LayeredImage {
        let pixels = self.counts.len();
        let mut found: BTreeMap<&str, &mut Vec<f64>> = (self.channels.iter_mut())
            .map(|c| (c.name.as_str(), &mut c.mean))
            .collect();
        from_means(|name| found.remove(name));
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
        let first = self.counts.first().copied().unwrap_or(0.0);
        let is_even = self.counts.iter().all(|&n| n == first);
        let samples_per_pixel = (is_even && !self.has_samples).then_some(first as u32);
        if samples_per_pixel.is_none() {
            let counts = self.counts.iter().map(|&n| n as u32).collect();
            channels.push((SAMPLES.to_owned(), ChannelValues::Count(counts)));
        }
        let metadata = ImageMetadata {
            spp: self.counts.iter().sum::<f64>() / pixels as f64,
            sample_ranges: join_ranges(&self.metadata.sample_ranges),
            samples_per_pixel,
            ..self.metadata
        };
        LayeredImage {
            width: self.window.width,
            height: self.window.height,
            offset: self.window.origin,
            full_size: self.full_size,
            channels,
            metadata,
        }
    }

    /// Makes space for more pixels.
    fn grow(&mut self, window: Window) {
        if window == self.window {
            return;
        }
        let pixels = window.width as usize * window.height as usize;
        let places: Vec<usize> = self.window.indices_in(&window).collect();
        let moved = |values: &mut Vec<f64>| {
            let mut larger = vec![0.0; pixels];
            for (value, &pixel) in values.iter().zip(&places) {
                larger[pixel] = *value;
            }
            *values = larger;
        };
        moved(&mut self.counts);
        for channel in &mut self.channels {
            moved(&mut channel.mean);
            channel.m2.iter_mut().for_each(moved);
        }
        self.window = window;
    }

    /// That the images are of one scene and algorithm.
    fn check_identity(
        &mut self,
        name: &str,
        image: &ExrImage,
        metadata: &ImageMetadata,
    ) -> Result<(), MergeError> {
        let size = |[w, h]: [u32; 2]| format!("{w} x {h}");
        let other = |what: &str, found: &str, expected: &str| MergeError::OtherImage {
            name: name.to_owned(),
            first: self.first.clone(),
            what: what.to_owned(),
            found: found.to_owned(),
            expected: expected.to_owned(),
        };
        let (found, expected) = (size(image.display_size), size(self.full_size));
        if found != expected {
            return Err(other("size", &found, &expected));
        }
        let ours = &self.metadata;
        let mut differences = Vec::new();
        for (what, found, expected) in [
            ("scene", &metadata.scene, &ours.scene),
            ("integrator", &metadata.integrator, &ours.integrator),
            ("sampler", &metadata.sampler, &ours.sampler),
        ] {
            if found != expected {
                differences.push(other(what, found, expected));
            }
        }
        let both_know = !metadata.scene_digest.is_empty() && !ours.scene_digest.is_empty();
        if both_know {
            if metadata.scene_digest != ours.scene_digest {
                differences.push(MergeError::OtherScene {
                    name: name.to_owned(),
                    first: self.first.clone(),
                    scene: metadata.scene.clone(),
                });
            }
            let mut contents = Vec::new();
            let names: BTreeSet<&String> = ours
                .settings
                .keys()
                .chain(metadata.settings.keys())
                .collect();
            for what in names {
                let of = |settings: &BTreeMap<String, String>| {
                    let value = settings.get(what).map_or("not set", String::as_str);
                    value.to_owned()
                };
                let (found, expected) = (of(&metadata.settings), of(&ours.settings));
                // What is named above is not named twice, and content is what is left to say.
                if found == expected || !differences.is_empty() {
                    continue;
                }
                match what.strip_suffix(DIGEST) {
                    Some(what) => contents.push(MergeError::OtherContent {
                        name: name.to_owned(),
                        first: self.first.clone(),
                        what: what.to_owned(),
                    }),
                    None => differences.push(other(what, &found, &expected)),
                }
            }
            if differences.is_empty() {
                differences = contents;
            }
        }
        let mut differences = differences.into_iter();
        match differences.next() {
            Some(error) if !self.force => return Err(error),
            Some(error) => self.warnings.push(error.to_string()),
            None if !both_know => self.warnings.push(format!(
                "{name} and {} do not both say which scene they are of: they are taken for images of the same",
                self.first
            )),
            None => {}
        }
        self.warnings
            .extend(differences.map(|error| error.to_string()));
        Ok(())
    }

    /// Radii of adaptive photon mapping follow from all passes before.
    fn check_passes(&mut self, name: &str, metadata: &ImageMetadata) -> Result<(), MergeError> {
        if metadata.integrator != "appm" {
            return Ok(());
        }
        let error = MergeError::DependentPasses {
            name: name.to_owned(),
            integrator: metadata.integrator.clone(),
        };
        if !self.force {
            return Err(error);
        }
        self.warnings.push(error.to_string());
        Ok(())
    }

    fn check_samples(
        &mut self,
        name: &str,
        metadata: &ImageMetadata,
        window: Window,
    ) -> Result<(), MergeError> {
        for (other, their, their_window) in &self.images {
            if !window.meets(their_window) {
                continue;
            }
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
            .is_some_and(|(_, metadata, _)| metadata.sample_ranges.is_empty())
        {
            self.warnings.push(format!(
                "{name} does not say which samples it holds: they are taken as new ones"
            ));
        }
    }
}
