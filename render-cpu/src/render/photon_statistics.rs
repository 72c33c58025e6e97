//! Statistics of photons that a film keeps for each pixel, as numbers of its layer [`Aov::Bandwidth`].
//!
//! They are kept as other layers are, so that checkpoints hold them.

use super::film_tiles::Tile;
use crate::film::Film;
use crate::film::aov::{Aov, BANDWIDTH_NUMBERS};
use halflight_kernel::scene::Tables;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::photon::adaptive::next_radii;
use halflight_kernel::transport::photon::statistics::{PhotonPass, PhotonStatistics};

/// The statistics in a film, read.
pub(super) struct PixelStatistics<'a> {
    width: usize,
    numbers: &'a [f64],
    per_pixel: usize,
    offset: usize,
}

impl<'a> PixelStatistics<'a> {
    /// Of all pixels; none if the film does not keep them.
    pub fn new(film: &'a Film) -> PixelStatistics<'a> {
        let aovs = film.aovs();
        PixelStatistics {
            width: film.width() as usize,
            numbers: if aovs.contains(Aov::Bandwidth) {
                film.aov_sums()
            } else {
                &[]
            },
            per_pixel: film.sums_per_pixel(),
            offset: aovs.offset(Aov::Bandwidth),
        }
    }

    /// Of the pixels of a tile, by rows.
    pub fn of_tile(&self, tile: Tile) -> impl Iterator<Item = PhotonStatistics> + '_ {
        tile.pixels(self.width).map(|pixel| {
            let start = pixel * self.per_pixel + self.offset;
            let numbers = self.numbers.get(start..start + BANDWIDTH_NUMBERS);
            numbers.map_or_else(PhotonStatistics::default, statistics_of)
        })
    }
}

/// The statistics of a pixel's numbers.
fn statistics_of(numbers: &[f64]) -> PhotonStatistics {
    let number = |i: usize| numbers[i] as f32;
    PhotonStatistics {
        passes: number(1),
        photons: number(2),
        mean: number(3),
        square: number(4),
        laplacian: number(5),
        laplacian_square: number(6),
        density: number(7),
        value: number(8),
    }
}

/// Adds what a pass of `emitted` light walks has found to the statistics among a pixel's numbers, and keeps the bandwidth of the next
/// pass; `first` is the pixel's radius of the first.
pub(super) fn update(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    numbers: &mut [f64],
    sums: &PhotonPass,
    emitted: u32,
    first: f32,
) {
    let mut statistics = statistics_of(numbers);
    statistics.update(sums, emitted as f32);
    let next = next_radii(tables, settings, &statistics, first);
    keep(numbers, &statistics, next.radius);
}

/// Keeps statistics, and the bandwidth that follows from them.
fn keep(numbers: &mut [f64], statistics: &PhotonStatistics, bandwidth: f32) {
    let s = statistics;
    let kept = [
        bandwidth,
        s.passes,
        s.photons,
        s.mean,
        s.square,
        s.laplacian,
        s.laplacian_square,
        s.density,
        s.value,
    ];
    for (number, kept) in numbers.iter_mut().zip(kept) {
        // A checkpoint holds finite numbers only.
        *number = if kept.is_finite() {
            f64::from(kept)
        } else {
            0.0
        };
    }
}
