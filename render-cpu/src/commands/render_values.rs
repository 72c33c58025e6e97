//! Values of the options of `halflight render`, read from text.

use crate::film::aov::{Aov, AovSet};
use crate::image::png_output::Exposure;
use std::time::Duration;

/// The name of a layer, or "all".
pub(super) fn parse_aov(text: &str) -> Result<AovSet, String> {
    if text.trim() == "all" {
        return Ok(AovSet::ALL);
    }
    text.trim()
        .parse()
        .map(|aov: Aov| AovSet::NONE.with(aov))
        .map_err(|e: crate::film::aov::UnknownAov| e.to_string())
}

/// FROM..TO with FROM below TO.
pub(super) fn parse_range(text: &str) -> Result<(u32, u32), String> {
    let form = || "expected FROM..TO with FROM < TO".to_string();
    let (from, to) = text.split_once("..").ok_or_else(form)?;
    let from: u32 = from.trim().parse().map_err(|_| form())?;
    let to: u32 = to.trim().parse().map_err(|_| form())?;
    if from < to {
        Ok((from, to))
    } else {
        Err(form())
    }
}

/// A positive number.
pub(super) fn parse_positive(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|v: &f32| *v > 0.0 && v.is_finite())
        .ok_or_else(|| "expected a number above zero".to_string())
}

/// Stops, or "auto".
pub(super) fn parse_exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Automatic);
    }
    text.parse()
        .ok()
        .filter(|ev: &f32| ev.abs() <= 64.0)
        .map(Exposure::Stops)
        .ok_or_else(|| "expected a number of stops from -64 to 64, or \"auto\"".to_string())
}

/// Hours, minutes and seconds: "1h30m", "90s", "45".
pub(super) fn parse_duration(text: &str) -> Result<Duration, String> {
    let form = || "expected a time such as 90s, 10m or 1h30m".to_string();
    let mut seconds = 0.0;
    let mut number = String::new();
    for c in text.trim().chars() {
        let unit = match c {
            '0'..='9' | '.' => {
                number.push(c);
                continue;
            }
            'h' => 3600.0,
            'm' => 60.0,
            's' => 1.0,
            _ => return Err(form()),
        };
        seconds += number.parse::<f64>().map_err(|_| form())? * unit;
        number.clear();
    }
    if !number.is_empty() {
        seconds += number.parse::<f64>().map_err(|_| form())?;
    }
    if seconds > 0.0 && seconds < 1e9 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(form())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read() {
        assert_eq!(parse_duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("1h30m"), Ok(Duration::from_secs(5400)));
        assert_eq!(parse_duration("2.5"), Ok(Duration::from_millis(2500)));
        for bad in ["", "s", "10x", "-3s", "1..5s", "nan", "0s"] {
            assert!(parse_duration(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sample_ranges_are_read() {
        assert_eq!(parse_range("16..48"), Ok((16, 48)));
        for bad in ["5..5", "9..3", "1-4", "..", "a..b"] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
    }
}
