//! The CIE 1931 colour matching functions of the 2 degree observer, and the illuminant D65.
//!
//! Tabulated every 5 nm from 360 to 830 nm in `data/cie1931.csv`, linear in between, zero outside.

use std::sync::OnceLock;

/// Nanometres.
pub const FIRST_WAVELENGTH: f64 = 360.0;
/// Nanometres.
pub const LAST_WAVELENGTH: f64 = 830.0;
const SPACING: f64 = 5.0;

/// x, y, z at a wavelength in nanometres, and the power of D65 relative to 560 nm, in percent.
pub fn matching_functions_and_d65(wavelength: f64) -> [f64; 4] {
    let position = (wavelength - FIRST_WAVELENGTH) / SPACING;
    let table = table();
    // Negated so that a NaN counts as outside.
    if !(position >= 0.0 && position <= (table.len() - 1) as f64) {
        return [0.0; 4];
    }
    let first = (position as usize).min(table.len() - 2);
    let t = position - first as f64;
    std::array::from_fn(|i| table[first][i] * (1.0 - t) + table[first + 1][i] * t)
}

fn table() -> &'static [[f64; 4]] {
    static TABLE: OnceLock<Vec<[f64; 4]>> = OnceLock::new();
    TABLE.get_or_init(|| parse(include_str!("../data/cie1931.csv")))
}

/// The rows of the file after the comment and the header; the first column is the wavelength.
fn parse(csv: &str) -> Vec<[f64; 4]> {
    csv.lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .filter_map(|line| {
            let mut numbers = line.split(',').skip(1).map(|number| number.parse().ok());
            let mut next = || numbers.next().flatten();
            Some([next()?, next()?, next()?, next()?])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_complete() {
        let intervals = (LAST_WAVELENGTH - FIRST_WAVELENGTH) / SPACING;
        assert_eq!(table().len(), intervals as usize + 1);
        // y peaks with 1 at 555 nm, and the three functions have the same integral.
        assert_eq!(matching_functions_and_d65(555.0)[1], 1.0);
        let integral = |i: usize| table().iter().map(|row| row[i]).sum::<f64>();
        for i in [0, 2] {
            assert!((integral(i) / integral(1) - 1.0).abs() < 1e-3);
        }
        assert_eq!(matching_functions_and_d65(359.9), [0.0; 4]);
        assert_eq!(matching_functions_and_d65(f64::NAN), [0.0; 4]);
        assert!(matching_functions_and_d65(830.0)[0] > 0.0);
        assert_eq!(matching_functions_and_d65(560.0)[3], 100.0);
    }
}
