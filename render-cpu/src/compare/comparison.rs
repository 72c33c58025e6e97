//! All metrics of two image files at once.
//!
//! Pixels that are not finite in one of the images are excluded from the metrics, which they would make infinite; their number
//! is a metric of its own, so that they do not go unnoticed.

use crate::compare::metrics::RgbImage;
use crate::compare::metrics::cielab::cie76;
use crate::compare::metrics::flip::{hdr_flip, ldr_flip, mean};
use crate::compare::metrics::mse::mse;
use crate::compare::metrics::psnr::psnr;
use crate::compare::metrics::relative_mse::{
    relative_mse, relative_variance, trimmed_relative_mse,
};
use crate::compare::metrics::residual_rms::residual_rms;
use crate::compare::metrics::ssim::ssim;
use crate::compare::metrics::ztest::{self, Estimate, Outcome};
use crate::image::ExrImage;
use std::fmt;
use std::str::FromStr;

/// A metric of the difference between two images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Mean squared error.
    Mse,
    /// Relative mean squared error.
    RelativeMse,
    /// The same without the worst pixels.
    TrimmedRelativeMse,
    /// Share of the reference's own variance in the relative mean squared error.
    ReferenceVariance,
    /// Root mean square of relative residuals.
    ResidualRms,
    /// Peak signal to noise ratio in decibel.
    Psnr,
    /// Mean colour difference of 1976.
    Cie76,
    /// Structural similarity.
    Ssim,
    /// Mean LDR-FLIP.
    Flip,
    /// Mean HDR-FLIP.
    HdrFlip,
    /// Severity of the z-test; above 1 it rejects.
    ZTest,
    /// Number of pixels that are not finite.
    NonFinite,
}

impl Metric {
    /// Every metric, in the order of a table.
    pub const ALL: [Self; 12] = [
        Self::Mse,
        Self::RelativeMse,
        Self::TrimmedRelativeMse,
        Self::ReferenceVariance,
        Self::ResidualRms,
        Self::Psnr,
        Self::Cie76,
        Self::Ssim,
        Self::Flip,
        Self::HdrFlip,
        Self::ZTest,
        Self::NonFinite,
    ];

    /// Name in tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mse => "mse",
            Self::RelativeMse => "relative-mse",
            Self::TrimmedRelativeMse => "trimmed-relative-mse",
            Self::ReferenceVariance => "reference-variance",
            Self::ResidualRms => "residual-rms",
            Self::Psnr => "psnr",
            Self::Cie76 => "cie76",
            Self::Ssim => "ssim",
            Self::Flip => "flip",
            Self::HdrFlip => "hdr-flip",
            Self::ZTest => "z-test",
            Self::NonFinite => "non-finite",
        }
    }

    /// Whether larger values are better.
    pub const fn larger_is_better(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim)
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Metric {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|m| m.name() == name)
            .ok_or_else(|| {
                let names: Vec<_> = Self::ALL.iter().map(|m| m.name()).collect();
                format!("unknown metric \"{name}\" (known: {})", names.join(", "))
            })
    }
}

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The sizes differ.
    #[error("the images differ in size: {0} x {1} and {2} x {3} pixels")]
    OtherSize(u32, u32, u32, u32),
    /// There is no colour.
    #[error("{name}: no channels R, G, B; it holds {channels}")]
    NoColour {
        /// The image.
        name: String,
        /// What it has instead.
        channels: String,
    },
    /// No pixels are left to compare.
    #[error("no pixel is finite in both images")]
    NothingFinite,
}

/// What is known beside the files.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Strictness of the z-test.
    pub ztest: ztest::Settings,
    /// Independent runs behind the reference's variance; otherwise its samples per pixel, otherwise 16.
    pub reference_runs: Option<u32>,
    /// Samples per pixel of the reference; otherwise those of its samples layer.
    pub reference_spp: Option<f64>,
}

/// Number of runs assumed behind a variance whose number of runs is unknown.
pub const ASSUMED_RUNS: u32 = 16;

/// Outcome of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Width of the images.
    pub width: usize,
    /// Height of the images.
    pub height: usize,
    /// The metrics that could be computed, in the order of a table.
    pub values: Vec<(Metric, f64)>,
    /// The z-test, if both images have variances.
    pub ztest: Option<Outcome>,
    /// Why there is no z-test, otherwise.
    pub no_ztest: &'static str,
    /// The images, with zeros where one of them is not finite.
    image: RgbImage,
    reference: RgbImage,
    finite: Vec<bool>,
    flip: Vec<f64>,
    hdr_flip: Vec<f64>,
}

impl Comparison {
    /// Compares an image with a reference.
    ///
    /// # Errors
    /// If sizes differ, or channels are missing.
    pub fn new(
        image: (&str, &ExrImage),
        reference: (&str, &ExrImage),
        options: &Options,
    ) -> Result<Self, CompareError> {
        let (a, b) = (image.1, reference.1);
        if (a.width, a.height) != (b.width, b.height) {
            return Err(CompareError::OtherSize(
                a.width, a.height, b.width, b.height,
            ));
        }
        let mut mean_a = colour(image.0, a)?;
        let mut mean_b = colour(reference.0, b)?;
        let mut variances = layer(a, "variance.").zip(layer(b, "variance."));
        let finite_pixel = |p: &[f64; 3]| p.iter().all(|v| v.is_finite());
        let finite: Vec<bool> = (0..mean_a.pixels.len())
            .map(|i| {
                let variance = variances.as_ref().is_none_or(|(va, vb)| {
                    finite_pixel(&va.pixels[i]) && finite_pixel(&vb.pixels[i])
                });
                variance && finite_pixel(&mean_a.pixels[i]) && finite_pixel(&mean_b.pixels[i])
            })
            .collect();
        if !finite.contains(&true) {
            return Err(CompareError::NothingFinite);
        }
        let mut own_variance = layer(b, "variance.");
        let cleared = [&mut mean_a, &mut mean_b]
            .into_iter()
            .chain(own_variance.as_mut())
            .chain(variances.iter_mut().flat_map(|(a, b)| [a, b]));
        for image in cleared {
            for (p, _) in image
                .pixels
                .iter_mut()
                .zip(&finite)
                .filter(|(_, finite)| !**finite)
            {
                *p = [0.0; 3];
            }
        }

        let (outcome, no_ztest) = match &variances {
            None => (None, "no variance layer in both images"),
            Some((va, vb)) => run_ztest((a, &mean_a, va), (b, &mean_b, vb), options),
        };
        let (flip, hdr_flip) = (ldr_flip(&mean_a, &mean_b), hdr_flip(&mean_a, &mean_b));
        let mut values = Vec::new();
        for metric in Metric::ALL {
            let value = match metric {
                Metric::Mse => Some(mse(&mean_a, &mean_b)),
                Metric::RelativeMse => Some(relative_mse(&mean_a, &mean_b)),
                Metric::TrimmedRelativeMse => Some(trimmed_relative_mse(&mean_a, &mean_b)),
                Metric::ReferenceVariance => own_variance
                    .as_ref()
                    .map(|variance| relative_variance(variance, &mean_b)),
                Metric::ResidualRms => Some(residual_rms(&mean_a, &mean_b)),
                Metric::Psnr => Some(psnr(&mean_a, &mean_b)),
                Metric::Cie76 => Some(cie76(&mean_a, &mean_b)),
                Metric::Ssim => ssim(&mean_a, &mean_b),
                Metric::Flip => Some(mean(&flip)),
                Metric::HdrFlip => Some(mean(&hdr_flip)),
                Metric::ZTest => outcome.as_ref().map(Outcome::severity),
                Metric::NonFinite => Some(finite.iter().filter(|finite| !**finite).count() as f64),
            };
            values.extend(value.map(|value| (metric, value)));
        }
        Ok(Self {
            width: mean_a.width,
            height: mean_a.height,
            values,
            ztest: outcome,
            no_ztest,
            image: mean_a,
            reference: mean_b,
            finite,
            flip,
            hdr_flip,
        })
    }

    /// A metric's value, if it could be computed.
    pub fn value(&self, metric: Metric) -> Option<f64> {
        self.values
            .iter()
            .find(|(m, _)| *m == metric)
            .map(|(_, value)| *value)
    }

    /// Errors per pixel, of a kind; not finite where the images are not.
    pub fn error_map(&self, kind: ErrorMap) -> Vec<f64> {
        let relative = |i: usize| {
            let channel = |c: usize| {
                let (a, b) = (self.image.pixels[i][c], self.reference.pixels[i][c]);
                (a - b).abs() / (b.abs() + 0.01)
            };
            (channel(0) + channel(1) + channel(2)) / 3.0
        };
        (0..self.finite.len())
            .map(|i| match kind {
                _ if !self.finite[i] => f64::NAN,
                ErrorMap::Flip => self.flip[i],
                ErrorMap::HdrFlip => self.hdr_flip[i],
                ErrorMap::Relative => relative(i),
            })
            .collect()
    }
}

/// What a heatmap shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ErrorMap {
    /// LDR-FLIP, 0 to 1.
    #[default]
    Flip,
    /// HDR-FLIP, 0 to 1.
    HdrFlip,
    /// |a - b| / (|b| + 0.01), mean of the channels, shown from 0 to 1.
    Relative,
}

fn run_ztest(
    (a, mean_a, variance_a): (&ExrImage, &RgbImage, &RgbImage),
    (b, mean_b, variance_b): (&ExrImage, &RgbImage, &RgbImage),
    options: &Options,
) -> (Option<Outcome>, &'static str) {
    let (samples_a, samples_b) = (samples(a), samples(b));
    let runs_a = samples_a.map_or(f64::from(ASSUMED_RUNS), |(least, _)| least);
    let runs_b = match (options.reference_runs, samples_b) {
        (Some(runs), _) => f64::from(runs),
        (None, Some((least, _))) => least,
        (None, None) => f64::from(ASSUMED_RUNS),
    };
    if runs_a < 2.0 || runs_b < 2.0 {
        return (None, "a variance of fewer than two samples is no variance");
    }
    let estimate = |mean, variance, runs, samples| Estimate {
        mean,
        variance,
        degrees_of_freedom: runs - 1.0,
        samples,
    };
    let outcome = ztest::ztest(
        estimate(mean_a, variance_a, runs_a, samples_a.map(|(_, mean)| mean)),
        estimate(
            mean_b,
            variance_b,
            runs_b,
            options.reference_spp.or(samples_b.map(|(_, mean)| mean)),
        ),
        options.ztest,
    );
    (Some(outcome), "")
}

/// Least and mean number of samples of an image's pixels.
fn samples(image: &ExrImage) -> Option<(f64, f64)> {
    let counts = image.sample_counts()?;
    let least = counts.iter().copied().fold(f32::INFINITY, f32::min);
    let mean = counts.iter().map(|&n| f64::from(n)).sum::<f64>() / counts.len() as f64;
    mean.is_finite().then_some((f64::from(least), mean))
}

fn colour(name: &str, image: &ExrImage) -> Result<RgbImage, CompareError> {
    layer(image, "").ok_or_else(|| {
        let channels: Vec<&str> = image
            .channels
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        CompareError::NoColour {
            name: name.to_owned(),
            channels: channels.join(", "),
        }
    })
}

/// The R, G, B channels of a layer.
pub(crate) fn layer(image: &ExrImage, prefix: &str) -> Option<RgbImage> {
    let [r, g, b] = ["R", "G", "B"].map(|c| image.channel(&format!("{prefix}{c}")));
    let (r, g, b) = (r?, g?, b?);
    let pixels = (0..r.len())
        .map(|i| [r[i], g[i], b[i]].map(f64::from))
        .collect();
    Some(RgbImage::new(
        image.width as usize,
        image.height as usize,
        pixels,
    ))
}
