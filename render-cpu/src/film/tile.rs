//! Parts of a film that one thread works on: a pixel, a rectangle of pixels.

use super::PixelStatistics;
use super::aov::{Aov, AovSample, AovSet, BANDWIDTH_NUMBERS};
use glam::Vec3;

/// A sample whose largest component is brought down to `clamp`, its colour kept. What is not finite stays so.
#[inline]
fn limited(sample: Vec3, clamp: f32) -> Vec3 {
    let most = sample.abs().max_element();
    if most > clamp {
        sample * (clamp / most)
    } else {
        sample
    }
}

/// One pixel of a film, to add samples to.
#[derive(Debug)]
pub struct PixelMut<'a> {
    /// Radiance statistics of the pixel.
    pub statistics: &'a mut PixelStatistics,
    pub(super) aov_sums: &'a mut [f64],
    pub(super) aovs: AovSet,
    pub(super) clamp: f32,
}

impl PixelMut<'_> {
    /// Adds one radiance sample, already multiplied by its signed filter weight.
    #[inline]
    pub fn add_sample(&mut self, radiance: Vec3) {
        self.statistics.add(limited(radiance, self.clamp));
    }

    /// Adds radiance samples, one after the other.
    pub fn add_samples(&mut self, radiance: &[Vec3]) {
        // A copy, so that sums of one sample need not be stored for the next.
        let mut statistics = *self.statistics;
        for &sample in radiance {
            statistics.add(limited(sample, self.clamp));
        }
        *self.statistics = statistics;
    }

    /// Adds the parts of a sample whose whole is `radiance`, which is added by itself: they are clamped as it is, and count as
    /// black where it is not finite.
    #[inline]
    pub fn add_parts(&mut self, radiance: Vec3, parts: &[Vec3]) {
        let most = radiance.abs().max_element();
        let scale = if most > self.clamp {
            self.clamp / most
        } else {
            1.0
        };
        if !radiance.is_finite() {
            return;
        }
        let sums = &mut self.aov_sums[self.aovs.accumulators()..];
        let values = bytemuck::cast_slice::<Vec3, f32>(parts);
        if !self.aovs.contains(Aov::Variance) {
            // All of them, by vectors, even where most are zero.
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += f64::from(value * scale);
            }
            return;
        }
        let sums = sums.chunks_exact_mut(self.aovs.sums_per_part());
        for (sums, values) in sums.zip(values.chunks_exact(3)) {
            for c in 0..3 {
                let part = f64::from(values[c] * scale);
                sums[c] += part;
                sums[3 + c] += part * part;
            }
        }
    }

    /// Adds how much of a sample of `radiance`, which is added by itself, is regularised, if the film keeps it: luminance, and
    /// its product with the logarithm of tau or of the radius. It is clamped as the sample is.
    pub fn add_regularized(&mut self, radiance: Vec3, regularized: [f32; 2]) {
        if !self.aovs.contains(Aov::Regularization) || !radiance.is_finite() {
            return;
        }
        let most = radiance.abs().max_element();
        let scale = if most > self.clamp {
            self.clamp / most
        } else {
            1.0
        };
        let start = self.aovs.offset(Aov::Regularization);
        for (sum, value) in self.aov_sums[start..start + 2].iter_mut().zip(regularized) {
            if value.is_finite() {
                *sum += f64::from(value * scale);
            }
        }
    }

    /// What [`Aov::Bandwidth`] keeps of the pixel, if the film has it.
    pub fn bandwidth_numbers(&mut self) -> Option<&mut [f64]> {
        let start = self.aovs.offset(Aov::Bandwidth);
        self.aovs
            .contains(Aov::Bandwidth)
            .then(|| &mut self.aov_sums[start..start + BANDWIDTH_NUMBERS])
    }

    /// Adds what mutations of the pixel's paths came to: the sums of their probabilities of acceptance, of their walks and
    /// iterations and of jumps, and their number.
    pub fn add_chain_steps(&mut self, steps: &ChainSteps) {
        for aov in Aov::OF_CHAINS {
            if !self.aovs.contains(aov) {
                continue;
            }
            let numbers = match aov {
                Aov::Acceptance => [steps.acceptance, steps.mutations],
                Aov::Iterations => [steps.iterations, steps.walks],
                Aov::Jumps => [steps.jumps, steps.mutations],
                _ => [steps.mutations, 0.0],
            };
            let start = self.aovs.offset(aov);
            let sums = &mut self.aov_sums[start..start + aov.accumulators()];
            for (sum, number) in sums.iter_mut().zip(numbers) {
                *sum += f64::from(number);
            }
        }
    }

    /// Adds the surface features of one sample; call it once per [`Self::add_sample`] if
    /// [`AovSet::needs_surface`]. Features that are not finite count as zero.
    pub fn add_aovs(&mut self, sample: &AovSample) {
        let mut at = 0;
        for aov in self.aovs.iter() {
            let values: &[f32] = match aov {
                Aov::Albedo => &sample.albedo,
                Aov::Normal => &sample.normal,
                Aov::Depth => std::slice::from_ref(&sample.depth),
                Aov::Position => &sample.position,
                Aov::Uv => &sample.uv,
                Aov::Alpha if sample.depth > 0.0 => &[1.0],
                Aov::Alpha => &[0.0],
                // No features of the surface; those that have numbers come after all that are.
                _ => &[],
            };
            for &value in values {
                if value.is_finite() {
                    self.aov_sums[at] += f64::from(value);
                }
                at += 1;
            }
        }
    }
}

/// Sums over mutations of the paths that a pixel sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainSteps {
    /// Probabilities of acceptance.
    pub acceptance: f32,
    /// Walks on manifolds.
    pub walks: f32,
    /// Their iterations.
    pub iterations: f32,
    /// Jumps between sub-manifolds.
    pub jumps: f32,
    /// Mutations.
    pub mutations: f32,
}

/// A rectangle of a film that one thread works on.
#[derive(Debug)]
pub struct FilmTile<'a> {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) aovs: AovSet,
    pub(super) clamp: f32,
    pub(super) sums_per_pixel: usize,
    pub(super) rows: Vec<(&'a mut [PixelStatistics], &'a mut [f64])>,
}

impl FilmTile<'_> {
    /// First column of the tile within the film.
    pub fn x(&self) -> u32 {
        self.x
    }

    /// First row of the tile within the film.
    pub fn y(&self) -> u32 {
        self.y
    }

    /// Width in pixels; the last tile of a row may be narrower.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels; the tiles of the last row may be lower.
    pub fn height(&self) -> u32 {
        self.rows.len() as u32
    }

    /// One pixel to add samples to; coordinates are relative to the film, as those of [`crate::film::Film::pixel_mut`].
    ///
    /// # Panics
    /// If the pixel is outside of the tile.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> PixelMut<'_> {
        let i = (x - self.x) as usize;
        let n = self.sums_per_pixel;
        let (statistics, aov_sums) = &mut self.rows[(y - self.y) as usize];
        PixelMut {
            statistics: &mut statistics[i],
            aov_sums: &mut aov_sums[i * n..(i + 1) * n],
            aovs: self.aovs,
            clamp: self.clamp,
        }
    }
}
