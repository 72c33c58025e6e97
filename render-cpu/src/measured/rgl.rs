//! Materials of the RGL database: the fields of their tensor files ([`super::tensor_file`]).
//!
//! | field | shape | what |
//! |---|---|---|
//! | `phi_i`, `theta_i` | n_phi; n_theta | measured incident directions; one or two azimuths mean an isotropic material |
//! | `ndf`, `sigma` | h, w | the distribution of normals and the projected area |
//! | `vndf` | n_phi, n_theta, h, w | the density of visible normals |
//! | `luminance` | n_phi, n_theta, n, n | what samples follow |
//! | `rgb` | n_phi, n_theta, 3, n, n | colours, or instead |
//! | `spectra`, `wavelengths` | n_phi, n_theta, n_l, n, n; n_l | spectra over wavelengths in nanometres, reflected under D65 |
//! | `jacobian` | 1 | whether values are to be multiplied by `ndf / (4 sigma)` |
//!
//! (Dupuy and Jakob 2018; the mathematics is in [`halflight_kernel::bsdf::measured`].) Spectra become linear sRGB when the file is
//! read, negative channels zero.

use super::tensor_file::{Field, TensorError, read};
use crate::scene::color::{Illuminant, check_samples, samples_to_srgb};
use halflight_kernel::bsdf::measured_table::{Measurement, Plane, fill_table, table_words};
use std::f32::consts::TAU;

/// The longest file: ten times the largest of the database.
pub const MAX_BYTES: u64 = 1 << 30;

/// The most values along an axis of a grid, which a table says by a float.
const MAX_SIDE: usize = 1 << 16;

/// A measured material.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgl {
    azimuths: Vec<f32>,
    elevations: Vec<f32>,
    normals: Grid,
    areas: Grid,
    visible: Grid,
    luminance: Grid,
    colors: Vec<f32>,
    is_relative: bool,
}

/// Values with the width and the height of each grid.
#[derive(Clone, Debug, PartialEq)]
struct Grid {
    values: Vec<f32>,
    size: [usize; 2],
}

impl Grid {
    fn plane(&self) -> Plane<'_> {
        Plane {
            values: &self.values,
            width: self.size[0],
            height: self.size[1],
        }
    }
}

impl Rgl {
    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(bytes: &[u8]) -> Result<Rgl, TensorError> {
        let fields = read(bytes)?;
        let find = |name: &str| {
            fields
                .iter()
                .find(|f| f.name == name)
                .ok_or_else(|| TensorError::Field(format!("there is no field \"{name}\"")))
        };
        let azimuths = axis(find("phi_i")?)?;
        let elevations = axis(find("theta_i")?)?;
        let directions = [azimuths.len(), elevations.len()];
        let luminance = grid(find("luminance")?, &directions)?;
        let [width, height] = luminance.size;
        let colors = match find("rgb") {
            Ok(rgb) => {
                shaped(rgb, &[directions[0], directions[1], 3, height, width])?;
                rgb.floats()?
            }
            Err(_) => spectral(
                find("spectra")?,
                find("wavelengths")?,
                directions,
                luminance.size,
            )?,
        };
        let jacobian = find("jacobian")?;
        let is_relative = match jacobian.bytes()? {
            [flag] => *flag != 0,
            _ => return Err(jacobian.wrong("should be one byte")),
        };
        Ok(Rgl {
            normals: grid(find("ndf")?, &[])?,
            areas: grid(find("sigma")?, &[])?,
            visible: grid(find("vndf")?, &directions)?,
            azimuths,
            elevations,
            luminance,
            colors,
            is_relative,
        })
    }

    /// The table that the kernel reads.
    pub fn table(&self) -> Vec<f32> {
        let is_isotropic = self.azimuths.len() <= 2;
        let covered = match self.azimuths[..] {
            [first, .., last] => last - first,
            _ => TAU,
        };
        let measurement = Measurement {
            azimuths: &self.azimuths,
            elevations: &self.elevations,
            is_isotropic,
            symmetry: if is_isotropic {
                1
            } else {
                (TAU / covered).round().clamp(1.0, 4.0) as u32
            },
            is_relative: self.is_relative,
            normals: self.normals.plane(),
            areas: self.areas.plane(),
            visible: self.visible.plane(),
            luminance: self.luminance.plane(),
            colors: &self.colors,
        };
        let mut table = vec![0.0; table_words(&measurement)];
        fill_table(&measurement, &mut table);
        table
    }
}

/// Ascending numbers.
fn axis(field: &Field<'_>) -> Result<Vec<f32>, TensorError> {
    let values = field.floats()?;
    if field.shape.len() != 1 || values.is_empty() || values.len() > MAX_SIDE {
        return Err(field.wrong("should be a list of angles"));
    }
    if values.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(field.wrong("should hold ascending angles"));
    }
    Ok(values)
}

/// That a field has a shape.
fn shaped(field: &Field<'_>, shape: &[usize]) -> Result<(), TensorError> {
    if field.shape == shape {
        return Ok(());
    }
    let list = |numbers: &[usize]| {
        let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
        numbers.join(" x ")
    };
    Err(field.wrong(&format!(
        "has {} values, not {}",
        list(&field.shape),
        list(shape)
    )))
}

/// A grid for each of some directions.
fn grid(field: &Field<'_>, directions: &[usize]) -> Result<Grid, TensorError> {
    let sides = field
        .shape
        .len()
        .checked_sub(2)
        .map(|at| field.shape.split_at(at));
    match sides {
        Some((outer, &[height, width]))
            if outer == directions
                && (2..=MAX_SIDE).contains(&width)
                && (2..=MAX_SIDE).contains(&height) =>
        {
            Ok(Grid {
                values: field.floats()?,
                size: [width, height],
            })
        }
        _ => Err(field.wrong("should be a grid of at least 2 x 2 values for each direction")),
    }
}

/// Colours of spectra.
fn spectral(
    spectra: &Field<'_>,
    wavelengths: &Field<'_>,
    [azimuths, elevations]: [usize; 2],
    [width, height]: [usize; 2],
) -> Result<Vec<f32>, TensorError> {
    let lengths = wavelengths.floats()?;
    let count = lengths.len();
    shaped(spectra, &[azimuths, elevations, count, height, width])?;
    let mut samples: Vec<(f64, f64)> = lengths.iter().map(|l| (f64::from(*l), 0.0)).collect();
    check_samples(&samples).map_err(|what| wavelengths.wrong(&format!("is wrong: {what}")))?;
    // Conversion is linear: the colour of each wavelength alone, once.
    let mut weights = Vec::with_capacity(count);
    for i in 0..count {
        samples[i].1 = 1.0;
        weights.push(samples_to_srgb(Illuminant::D65, &samples));
        samples[i].1 = 0.0;
    }
    let values = spectra.floats()?;
    let cells = width * height;
    let mut colors = Vec::with_capacity(azimuths * elevations * 3 * cells);
    for direction in values.chunks_exact((count * cells).max(1)) {
        for channel in 0..3 {
            for cell in 0..cells {
                let sum: f64 = (0..count)
                    .map(|l| weights[l][channel] * f64::from(direction[l * cells + cell]))
                    .sum();
                colors.push(sum.max(0.0) as f32);
            }
        }
    }
    Ok(colors)
}
