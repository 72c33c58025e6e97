//! Colours and spectra to linear sRGB.
//!
//! A spectrum becomes a triplet by integration against the CIE 1931 colour matching functions and conversion from XYZ
//! to linear sRGB (white point D65), as Mitsuba 3 does in its RGB variants:
//!
//!   X = sum_i s(l_i) e(l_i) x(l_i) / sum_i y(l_i),   l_i = 360 nm + 470 nm i / 999,   i = 0 ... 999
//!
//! e is 1 for what is emitted and the illuminant D65 for what is reflected (or is an index of refraction), since a
//! white surface must come out white. So s = 1 is the colour of equal energy where light is emitted, (1.2048, 0.9483,
//! 0.9089), and white, (0.9990, 0.9989, 0.9988), where it is reflected: Mitsuba normalises D65 by a constant that is
//! 0.11 % too large, and so do we, for the sake of comparison. A test holds numbers of Mitsuba 3.9.1, to 1e-4.
//!
//! Spectral radiance in W/(m^2 sr nm) gives channels in the same unit.

mod cie;
mod source;

pub(crate) use source::read_samples;
pub use source::{ColorUse, Converted, from_property, is_constant};

use cie::{FIRST_WAVELENGTH, LAST_WAVELENGTH};

/// XYZ to linear sRGB (ITU-R BT.709 primaries, D65), row by row.
const XYZ_TO_SRGB: [[f64; 3]; 3] = [
    [3.240479, -1.537150, -0.498535],
    [-0.969256, 1.875991, 0.041556],
    [0.055648, -0.204043, 1.057311],
];

/// The scale of D65: the constant of Mitsuba 3, whose table has the mean 98.8878 over the quadrature below, weighted by y.
const D65_SCALE: f64 = 1.0 / 98.997_417_518_762_55;

/// Samples of the quadrature.
const STEPS: usize = 1000;

/// XYZ to linear sRGB.
pub fn xyz_to_srgb(xyz: [f64; 3]) -> [f64; 3] {
    XYZ_TO_SRGB.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
}

/// The sRGB transfer function inverted: encoded to linear (IEC 61966-2-1).
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB transfer function: linear to encoded (IEC 61966-2-1).
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The illuminant of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illuminant {
    /// It is light itself, or equal energy at every wavelength.
    EqualEnergy,
    /// Daylight, the white of sRGB.
    D65,
}

/// The colour of a function of the wavelength in nanometres; not clamped.
pub fn spectrum_to_srgb(illuminant: Illuminant, spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    let mut normalization = 0.0;
    for i in 0..STEPS {
        let fraction = i as f64 / (STEPS - 1) as f64;
        let wavelength = FIRST_WAVELENGTH + fraction * (LAST_WAVELENGTH - FIRST_WAVELENGTH);
        let [x, y, z, d65] = cie::matching_functions_and_d65(wavelength);
        let light = match illuminant {
            Illuminant::EqualEnergy => 1.0,
            Illuminant::D65 => d65 * D65_SCALE,
        };
        let value = spectrum(wavelength) * light;
        for (sum, function) in xyz.iter_mut().zip([x, y, z]) {
            *sum += value * function;
        }
        normalization += y;
    }
    xyz_to_srgb(xyz.map(|sum| sum / normalization))
}

/// That samples over the wavelength can be interpolated: two or more, wavelengths positive and strictly increasing.
///
/// # Errors
/// A sentence that says what is wrong.
pub fn check_samples(samples: &[(f64, f64)]) -> Result<(), String> {
    if samples.len() < 2 {
        return Err("a spectrum needs two or more wavelengths".into());
    }
    if samples[0].0 <= 0.0 {
        return Err(format!("the wavelength {} is not positive", samples[0].0));
    }
    for pair in samples.windows(2) {
        if pair[0].0 >= pair[1].0 {
            return Err(format!(
                "the wavelengths must increase, but {} follows {}",
                pair[1].0, pair[0].0
            ));
        }
    }
    Ok(())
}

/// The colour of samples over the wavelength, linear in between, zero outside; not clamped. The samples must pass
/// [`check_samples`].
pub fn samples_to_srgb(illuminant: Illuminant, samples: &[(f64, f64)]) -> [f64; 3] {
    spectrum_to_srgb(illuminant, |wavelength| interpolate(samples, wavelength))
}

fn interpolate(samples: &[(f64, f64)], wavelength: f64) -> f64 {
    let after = samples.partition_point(|sample| sample.0 <= wavelength);
    if after == 0 {
        return 0.0;
    }
    let (x0, y0) = samples[after - 1];
    match samples.get(after) {
        Some(&(x1, y1)) => y0 + (y1 - y0) * ((wavelength - x0) / (x1 - x0)),
        None if wavelength == x0 => y0,
        None => 0.0,
    }
}

/// Spectral radiance of a black body in W/(m^2 sr nm) at a wavelength in nanometres and a temperature in kelvin:
///
///   L = 2 h c^2 / l^5 / (exp(h c / (l k T)) - 1)
pub fn planck(wavelength: f64, temperature: f64) -> f64 {
    const PLANCK: f64 = 6.626_070_15e-34;
    const LIGHT: f64 = 299_792_458.0;
    const BOLTZMANN: f64 = 1.380_649e-23;
    let metres = wavelength * 1e-9;
    let exponent = PLANCK * LIGHT / (metres * BOLTZMANN * temperature);
    // Per metre of wavelength to per nanometre.
    let per_nanometre = 1e-9;
    2.0 * PLANCK * LIGHT * LIGHT / metres.powi(5) / exponent.exp_m1() * per_nanometre
}

/// The colour of a black body at a temperature in kelvin, in W/(m^2 sr nm) per channel; not clamped.
pub fn blackbody_to_srgb(temperature: f64) -> [f64; 3] {
    spectrum_to_srgb(Illuminant::EqualEnergy, |wavelength| {
        planck(wavelength, temperature)
    })
}
