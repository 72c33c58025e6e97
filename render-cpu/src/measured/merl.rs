//! The binary files of the MERL database of measured reflectance.
//!
//! Little endian: three `i32`, the numbers of cells in theta_h, theta_d and phi_d (90, 90, 180), then three planes, red,
//! green and blue, of as many `f64`, phi_d fastest. Values are scaled by 1 / 1500, 1.15 / 1500 and 1.66 / 1500; a negative
//! value marks a cell that could not be measured and reads as zero. (Matusik, Pfister, Brand and McMillan 2003; the
//! meaning of the cells is that of [`halflight_kernel::bsdf::merl`].)
//!
//! Other numbers of cells are accepted up to [`MAX_CELLS`]; the length of the file must be exactly what they say, and every
//! value a plausible one. Nothing is reserved before the length is known to be right.

use glam::Vec3;
use halflight_kernel::bsdf::merl::HEADER;
use halflight_kernel::bsdf::merl_table::{fill_header, fill_sampling, table_words};
use std::f32::consts::{FRAC_PI_2, PI};

/// Scales of the channels.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// The database's own numbers of cells.
pub const DATABASE_CELLS: [usize; 3] = [90, 90, 180];

/// The most cells of a file: those of the database with each number doubled.
pub const MAX_CELLS: usize = 8 * 90 * 90 * 180;

/// The most cells along one axis: the sampling table grows with theta_h alone.
pub const MAX_CELLS_PER_AXIS: usize = 360;

/// The largest reflectance taken for a measurement; mirrors peak at some 10^4.
const MAX_VALUE: f32 = 1e9;

/// The longest file.
pub const MAX_BYTES: u64 = 12 + 24 * MAX_CELLS as u64;

/// Why bytes are no MERL file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MerlError {
    /// Not even a header.
    #[error("{0} bytes are too short for a header of 12")]
    NoHeader(usize),
    /// Numbers of cells that are not positive, or too many.
    #[error(
        "{0} x {1} x {2} cells: each must be from 1 to {MAX_CELLS_PER_AXIS} and all at most {MAX_CELLS}"
    )]
    Dimensions(i32, i32, i32),
    /// Another length than the cells need.
    #[error("{found} bytes where {expected} belong to the cells of the header")]
    Length {
        /// Length of the file.
        found: usize,
        /// What the header says.
        expected: usize,
    },
    /// A value that is NaN, infinite or beyond every measurement.
    #[error("the value at byte {0} is no reflectance")]
    Value(usize),
}

/// A measured material.
#[derive(Clone, Debug, PartialEq)]
pub struct Merl {
    /// Numbers of cells in theta_h, theta_d and phi_d.
    pub cells: [usize; 3],
    /// RGB of each cell, phi_d fastest.
    pub values: Vec<[f32; 3]>,
    /// Cells that were not measured in some channel.
    pub invalid: usize,
}

impl Merl {
    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(bytes: &[u8]) -> Result<Merl, MerlError> {
        let header = bytes.get(..12).ok_or(MerlError::NoHeader(bytes.len()))?;
        let word = |i: usize| {
            let b = &header[4 * i..4 * i + 4];
            i32::from_le_bytes([b[0], b[1], b[2], b[3]])
        };
        let dimensions = [word(0), word(1), word(2)];
        let wrong = MerlError::Dimensions(dimensions[0], dimensions[1], dimensions[2]);
        let mut cells = [0; 3];
        let mut count = 1_usize;
        for (cell, dimension) in cells.iter_mut().zip(dimensions) {
            *cell = usize::try_from(dimension).map_err(|_| wrong.clone())?;
            count = count.saturating_mul(*cell);
        }
        if count == 0 || count > MAX_CELLS || cells.iter().any(|&n| n > MAX_CELLS_PER_AXIS) {
            return Err(wrong);
        }
        let expected = 12 + 24 * count;
        if bytes.len() != expected {
            return Err(MerlError::Length {
                found: bytes.len(),
                expected,
            });
        }
        let mut values = vec![[0.0_f32; 3]; count];
        let mut invalid = vec![false; count];
        for channel in 0..3 {
            let plane = &bytes[12 + 8 * count * channel..];
            for (i, b) in plane.chunks_exact(8).take(count).enumerate() {
                let raw = f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
                let value = (raw * SCALES[channel]) as f32;
                // A NaN fails the comparison.
                if !(value.abs() <= MAX_VALUE) {
                    return Err(MerlError::Value(12 + 8 * (count * channel + i)));
                }
                if value < 0.0 {
                    invalid[i] = true;
                } else {
                    values[i][channel] = value;
                }
            }
        }
        Ok(Merl {
            cells,
            values,
            invalid: invalid.iter().filter(|&&i| i).count(),
        })
    }

    /// The file of `reflectance`, a function of theta_h, theta_d and phi_d, at the centres of the database's cells; what
    /// it has no value for is marked as invalid.
    pub fn file_of(reflectance: impl Fn(Vec3) -> Option<Vec3>) -> Vec<u8> {
        let [n_h, n_d, n_p] = DATABASE_CELLS;
        let count = n_h * n_d * n_p;
        let mut bytes: Vec<u8> = DATABASE_CELLS
            .iter()
            .flat_map(|&n| (n as i32).to_le_bytes())
            .collect();
        bytes.resize(12 + 24 * count, 0);
        let centre = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
        for i in 0..count {
            let (h, d, p) = (i / (n_p * n_d), i / n_p % n_d, i % n_p);
            let root = centre(h, n_h);
            let angles = Vec3::new(
                root * root * FRAC_PI_2,
                centre(d, n_d) * FRAC_PI_2,
                centre(p, n_p) * PI,
            );
            let value = reflectance(angles);
            for channel in 0..3 {
                let raw = value.map_or(-1.0, |v| f64::from(v[channel]) / SCALES[channel]);
                let at = 12 + 8 * (count * channel + i);
                bytes[at..at + 8].copy_from_slice(&raw.to_le_bytes());
            }
        }
        bytes
    }

    /// The table that the kernel reads: values, distributions for sampling, albedos.
    pub fn table(&self) -> Vec<f32> {
        let mut table = vec![0.0; table_words(self.cells)];
        fill_header(self.cells, &mut table);
        let values = self.values.as_flattened();
        table[HEADER..HEADER + values.len()].copy_from_slice(values);
        fill_sampling(&mut table);
        table
    }
}
