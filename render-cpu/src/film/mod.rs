//! The film: running statistics of every pixel.
//!
//! Filter importance sampling makes each pixel an estimator of its own (Ernst, Stamminger and Greiner 2006): sample
//! positions follow |f| of the reconstruction filter and carry the sign of f and its normalisation as a weight, so no
//! sample reaches a neighbour, pixels are statistically independent, and the variance of each mean can be estimated.
//!
//! Invariants that tests check: a film depends on the order of the samples within a pixel and on nothing else, so
//! tiles, threads and interruptions leave it bit-identical; two films merge to the film of all samples up to rounding.

pub mod adaptive;
pub mod aov;
pub mod chain_counts;
pub mod checkpoint;
pub mod exact_sum;
mod layer_values;
pub mod pending_samples;
mod pixel_statistics;
mod tile;

use aov::AovSet;
use chain_counts::ChainCounts;
use pending_samples::PendingSamples;

pub use layer_values::share_and_scale;
pub use pixel_statistics::{PixelStatistics, luminance};
pub use tile::{ChainSteps, FilmTile, PixelMut};

/// Why a film cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// A side is zero.
    #[error("an image of {0} x {1} pixels has no pixel")]
    Empty(u32, u32),
    /// More pixels than are sensible or than memory holds.
    #[error("an image of {0} x {1} pixels does not fit into memory")]
    TooLarge(u32, u32),
}

/// Statistics of all pixels of an image or of a crop of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    crop_offset: [u32; 2],
    aovs: AovSet,
    statistics: Vec<PixelStatistics>,
    /// Names of the parts into which path expressions divide the image.
    parts: Vec<String>,
    /// Sums of the enabled output variables and of the parts, [`Film::sums_per_pixel`] numbers per pixel.
    aov_sums: Vec<f64>,
    /// What a pass that was cut still owes.
    pending: Option<PendingSamples>,
    /// What the largest component of a sample is brought down to; infinite by default.
    clamp: f32,
    /// What became of the mutations of chains.
    chain_counts: ChainCounts,
}

impl Film {
    /// Most pixels of a film: 2^30, a square of 32768.
    pub const MAX_PIXELS: u64 = 1 << 30;

    /// A black film of `width` x `height` pixels whose first pixel is `crop_offset` of the whole image.
    ///
    /// # Errors
    /// If the film is empty or cannot be allocated.
    pub fn new(
        width: u32,
        height: u32,
        crop_offset: [u32; 2],
        aovs: AovSet,
    ) -> Result<Self, FilmError> {
        Film::with_parts(width, height, crop_offset, aovs, Vec::new())
    }

    /// [`Film::new`] that also keeps the parts of the image which path expressions name.
    ///
    /// # Errors
    /// If the film is empty or cannot be allocated.
    pub fn with_parts(
        width: u32,
        height: u32,
        crop_offset: [u32; 2],
        aovs: AovSet,
        parts: Vec<String>,
    ) -> Result<Self, FilmError> {
        if width == 0 || height == 0 {
            return Err(FilmError::Empty(width, height));
        }
        let too_large = || FilmError::TooLarge(width, height);
        let pixels = u64::from(width) * u64::from(height);
        if pixels > Self::MAX_PIXELS {
            return Err(too_large());
        }
        let pixels = usize::try_from(pixels).map_err(|_| too_large())?;
        let sums = pixels
            .checked_mul(aovs.sums_per_pixel(parts.len()))
            .ok_or_else(too_large)?;
        let mut statistics = Vec::new();
        statistics
            .try_reserve_exact(pixels)
            .map_err(|_| too_large())?;
        statistics.resize(pixels, PixelStatistics::default());
        let mut aov_sums = Vec::new();
        aov_sums.try_reserve_exact(sums).map_err(|_| too_large())?;
        aov_sums.resize(sums, 0.0);
        Ok(Self {
            width,
            height,
            crop_offset,
            aovs,
            parts,
            statistics,
            aov_sums,
            pending: None,
            clamp: f32::INFINITY,
            chain_counts: ChainCounts::default(),
        })
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Position of the film's first pixel in the whole image.
    pub fn crop_offset(&self) -> [u32; 2] {
        self.crop_offset
    }

    /// Output variables of the film.
    pub fn aovs(&self) -> AovSet {
        self.aovs
    }

    /// Statistics of all pixels, by rows.
    pub fn statistics(&self) -> &[PixelStatistics] {
        &self.statistics
    }

    /// Names of the parts of the image.
    pub fn parts(&self) -> &[String] {
        &self.parts
    }

    /// Sums that are kept of a pixel: those of output variables, then those of parts.
    pub fn sums_per_pixel(&self) -> usize {
        self.aovs.sums_per_pixel(self.parts.len())
    }

    /// Sums of the enabled output variables and of the parts, [`Film::sums_per_pixel`] numbers per pixel, by rows.
    pub fn aov_sums(&self) -> &[f64] {
        &self.aov_sums
    }

    /// Samples of a pass that was cut which pixels have still to get.
    pub fn pending(&self) -> Option<&PendingSamples> {
        self.pending.as_ref()
    }

    /// [`Film::pending`], to be taken or set.
    pub fn pending_mut(&mut self) -> &mut Option<PendingSamples> {
        &mut self.pending
    }

    /// Brings the largest component of every sample from now on down to `clamp`: fewer fireflies, and a bias.
    pub fn set_clamp(&mut self, clamp: f32) {
        self.clamp = clamp;
    }

    /// What became of the mutations of the chains of this run.
    pub fn chain_counts(&self) -> &ChainCounts {
        &self.chain_counts
    }

    /// To add to them.
    pub fn chain_counts_mut(&mut self) -> &mut ChainCounts {
        &mut self.chain_counts
    }

    /// Samples of every pixel, where all have as many.
    pub fn even_samples(&self) -> Option<u32> {
        let first = self.statistics.first()?.count;
        let is_even = self.statistics.iter().all(|p| p.count == first);
        is_even.then_some(first)
    }

    /// Samples per pixel, on average.
    pub fn mean_samples(&self) -> f64 {
        self.total_samples() as f64 / self.statistics.len() as f64
    }

    /// Both raw buffers, for a reader that restores a film.
    pub(crate) fn buffers_mut(&mut self) -> (&mut [PixelStatistics], &mut [f64]) {
        (&mut self.statistics, &mut self.aov_sums)
    }

    /// Index of a pixel of the film in its buffers.
    fn index(&self, x: u32, y: u32) -> usize {
        assert!(
            x < self.width && y < self.height,
            "pixel ({x}, {y}) is outside of {} x {}",
            self.width,
            self.height
        );
        y as usize * self.width as usize + x as usize
    }

    /// Statistics of one pixel; coordinates are relative to the crop.
    ///
    /// # Panics
    /// If the pixel is outside of the film.
    pub fn pixel(&self, x: u32, y: u32) -> &PixelStatistics {
        &self.statistics[self.index(x, y)]
    }

    /// One pixel to add samples to; coordinates are relative to the crop.
    ///
    /// # Panics
    /// If the pixel is outside of the film.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> PixelMut<'_> {
        let i = self.index(x, y);
        let n = self.sums_per_pixel();
        PixelMut {
            statistics: &mut self.statistics[i],
            aov_sums: &mut self.aov_sums[i * n..(i + 1) * n],
            aovs: self.aovs,
            clamp: self.clamp,
        }
    }

    /// Cuts the film into square tiles that can be worked on at the same time, in row order of the tiles.
    ///
    /// # Panics
    /// If `size` is zero.
    pub fn tiles_mut(&mut self, size: u32) -> Vec<FilmTile<'_>> {
        self.blocks_mut(size, size)
    }

    /// Cuts the film into bands of whole rows that can be worked on at the same time, from top to bottom.
    ///
    /// # Panics
    /// If `rows` is zero.
    pub fn bands_mut(&mut self, rows: u32) -> Vec<FilmTile<'_>> {
        self.blocks_mut(self.width, rows)
    }

    fn blocks_mut(&mut self, size: u32, rows: u32) -> Vec<FilmTile<'_>> {
        assert!(size > 0 && rows > 0, "tiles need a size");
        let (aovs, clamp) = (self.aovs, self.clamp);
        let n = self.sums_per_pixel();
        let width = self.width as usize;
        let across = width.div_ceil(size as usize);
        let mut tiles: Vec<FilmTile<'_>> = Vec::new();
        let mut sums = self.aov_sums.as_mut_slice();
        for (y, row) in self.statistics.chunks_mut(width).enumerate() {
            let (mut row_sums, rest) = sums.split_at_mut(width * n);
            sums = rest;
            if y % rows as usize == 0 {
                for tile in 0..across {
                    let x = tile as u32 * size;
                    tiles.push(FilmTile {
                        x,
                        y: y as u32,
                        width: size.min(self.width - x),
                        aovs,
                        clamp,
                        sums_per_pixel: n,
                        rows: Vec::new(),
                    });
                }
            }
            let band = tiles.len() - across;
            for (tile, statistics) in row.chunks_mut(size as usize).enumerate() {
                let (aov_sums, rest) = row_sums.split_at_mut(statistics.len() * n);
                row_sums = rest;
                tiles[band + tile].rows.push((statistics, aov_sums));
            }
        }
        tiles
    }

    /// Mean radiance of every pixel, by rows.
    pub fn mean(&self) -> Vec<[f64; 3]> {
        self.statistics.iter().map(|p| p.mean).collect()
    }

    /// Estimated variance of the mean of every pixel, by rows.
    pub fn variance_of_mean(&self) -> Vec<[f64; 3]> {
        self.statistics
            .iter()
            .map(PixelStatistics::variance_of_mean)
            .collect()
    }

    /// Samples of all pixels together.
    pub fn total_samples(&self) -> u64 {
        self.statistics.iter().map(|p| u64::from(p.count)).sum()
    }

    /// Samples of all pixels together that were not finite.
    pub fn total_rejected(&self) -> u64 {
        self.statistics.iter().map(|p| u64::from(p.rejected)).sum()
    }

    /// The remaining noise, as one number for a progress display: the average over the pixels of the standard deviation of
    /// the mean luminance over that luminance (at least 0.01), each at most 1, so that a few pixels with rare bright samples
    /// do not dominate. 1 where there is no estimate yet.
    pub fn relative_noise(&self) -> f64 {
        let mut sum = 0.0;
        for p in &self.statistics {
            sum += if p.count < 2 {
                1.0
            } else {
                (p.luminance_variance_of_mean().sqrt() / luminance(p.mean).max(0.01)).min(1.0)
            };
        }
        sum / self.statistics.len() as f64
    }

    /// Adds the samples of another film of the same layout.
    ///
    /// # Panics
    /// If size, crop or output variables differ.
    pub fn merge(&mut self, other: &Self) {
        assert!(
            (self.width, self.height, self.crop_offset, self.aovs)
                == (other.width, other.height, other.crop_offset, other.aovs)
                && self.parts == other.parts,
            "films of different layout do not merge"
        );
        for (a, b) in self.statistics.iter_mut().zip(&other.statistics) {
            a.merge(b);
        }
        for (a, b) in self.aov_sums.iter_mut().zip(&other.aov_sums) {
            *a += b;
        }
        self.chain_counts.merge(&other.chain_counts);
    }
}
