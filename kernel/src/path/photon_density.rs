//! How many photons a pass finds around a point, as the weights of merging need to know.
//!
//! Merging counts in the weights as if each of the n photons of a pass were a sample of the full path (see
//! [`super::weight`]). They share one camera subpath: where many are found, the noise of their sum is that of the camera
//! subpath, and more of them do not make it less. With f the part of the integrand that merging at x makes, p_c the density of
//! the camera subpath, p_l that of the photon's, A = pi r^2, and rho the photons per area and light walk, the second moment
//! of the sum over the pass is
//!
//! ```text
//! 1/n int f^2 / (p_c p_l A) + (1 - 1/n) int (int f dl)^2 / p_c
//!   <= int f^2 / p_c [ 1 / (n A p_l) + rho / p_l ] = int f^2 / (p_c p_l eta),   eta = n A / (1 + n A rho),
//! ```
//!
//! by the inequality of Cauchy and Schwarz with p_l / rho, the density of the photon's walk given that it arrives at x. So
//! eta is the area that one photon has to itself, and at most n A: what replaces n A in the weights. Jendersie and
//! Grosch (2018, "An improved multiple importance sampling heuristic for density estimates in light transport simulations")
//! found that densities of photons have to be known to tell merges of one path apart.
//!
//! Weights may depend on nothing but the path, so rho comes from a pilot pass that nothing else uses: counts in a hashed grid.
//! Cells that share an entry count together, which makes eta smaller than it could be and no weight wrong.
//! Invariant (tests): weights of all strategies of a path sum to one.

use crate::sampler::mix;
use crate::scene::Tables;
use glam::Vec3;

/// Photons of a pilot pass by cells.
#[derive(Clone, Copy, Debug)]
pub struct PhotonDensity<'a> {
    /// Photons in the cells of each entry.
    pub counts: &'a [u32],
    /// Number of entries, a power of two; zero where no density is known.
    pub entries: u32,
    /// Cells per unit of length.
    pub cells_per_length: f32,
    /// Photons per area and light walk that one counted photon stands for.
    pub per_count: f32,
}

impl<'a> PhotonDensity<'a> {
    /// Not known: merging counts all its photons as samples.
    #[inline]
    pub fn unknown(tables: &Tables<'a>) -> PhotonDensity<'a> {
        PhotonDensity {
            // Shaders have no empty slices; this one is not read.
            counts: tables.texels,
            entries: 0,
            cells_per_length: 0.0,
            per_count: 0.0,
        }
    }

    /// Photons per area and light walk around a position.
    #[inline]
    pub fn at(&self, position: Vec3) -> f32 {
        if self.entries == 0 {
            return 0.0;
        }
        let entry = entry_of(position * self.cells_per_length, self.entries);
        self.counts[entry as usize] as f32 * self.per_count
    }
}

/// The entry of a cell among a power of two of them, for a position in units of cells.
#[inline]
pub fn entry_of(position: Vec3, entries: u32) -> u32 {
    // Casts of negative numbers through i32; they saturate, in shaders they must not.
    let cell = position.floor().clamp(Vec3::splat(-1e9), Vec3::splat(1e9));
    let (x, y, z) = (
        cell.x as i32 as u32,
        cell.y as i32 as u32,
        cell.z as i32 as u32,
    );
    mix(x ^ mix(y ^ mix(z))) & (entries - 1)
}
