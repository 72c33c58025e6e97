//! The distance to the k-th nearest photon: the radius with which a pixel starts (Kaplanyan 2017, section 5.2; Jensen 1996).
//!
//! A disk of radius r around a vertex in a density of p photons per area holds pi r^2 p of them on average. So the distance
//! within which k are found is small where photons are dense, as in caustics, and large where they are rare: the relative
//! noise of all first estimates is about the same, 1 / sqrt(k).

use super::cache::PhotonCache;
use super::estimate::for_photons_within;
use crate::math::float;
use glam::Vec3;

/// k in the thesis.
pub const USUAL_NEAREST: u32 = 10;

/// Most photons that can be asked for.
pub const MOST_NEAREST: u32 = 64;

/// The squared distances of the nearest photons so far, ascending.
struct Nearest {
    distances2: [f32; MOST_NEAREST as usize],
    wanted: usize,
    found: usize,
}

impl Nearest {
    /// Keeps a squared distance if it is among the nearest.
    #[inline]
    fn add(&mut self, distance2: f32) {
        if self.found == self.wanted && distance2 >= self.distances2[self.wanted - 1] {
            return;
        }
        let mut index = self.found.min(self.wanted - 1);
        while index > 0 && self.distances2[index - 1] > distance2 {
            self.distances2[index] = self.distances2[index - 1];
            index -= 1;
        }
        self.distances2[index] = distance2;
        self.found = (self.found + 1).min(self.wanted);
    }
}

/// The distance from `center` to the photon that is the `wanted`-th nearest (1 to [`MOST_NEAREST`]), `largest` where fewer lie
/// closer than that.
pub fn nearest_distance(cache: &PhotonCache<'_>, center: Vec3, wanted: u32, largest: f32) -> f32 {
    let wanted = wanted.max(1).min(MOST_NEAREST) as usize;
    // A cell of the table holds a few photons; then four times the area each time.
    let cells = 1 << (super::cache::LEVELS - cache.grid.table_level);
    let mut radius = (cells as f32 / cache.grid.cells_per_length).min(largest);
    loop {
        let mut nearest = Nearest {
            distances2: [0.0; MOST_NEAREST as usize],
            wanted,
            found: 0,
        };
        for_photons_within(cache, center, radius, |_, distance2| nearest.add(distance2));
        if nearest.found == wanted {
            return float::sqrt(nearest.distances2[wanted - 1]);
        }
        if !(radius < largest) {
            return largest;
        }
        radius = (2.0 * radius).min(largest);
    }
}
