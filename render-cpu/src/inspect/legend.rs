//! The scale of colours beside a picture: its values, and the bar that tells them.

use crate::compare::heatmap;
use crate::plot::canvas::{Canvas, DrawError, text_style};
use plotters::prelude::{Rectangle, Text};
use plotters::style::{Color, RGBColor};

/// Width of the legend in pixels.
pub(super) const WIDTH: u32 = 150;

/// Decades that a logarithmic scale shows below its largest value, unless the number is given.
const DECADES: f64 = 4.0;

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    /// Value of the first colour.
    pub least: f64,
    /// Value of the last.
    pub most: f64,
    /// Whether equal ratios of values are equal steps.
    pub is_logarithmic: bool,
}

impl ColorScale {
    /// From what is given of it, the rest by the values: the largest is that which a thousandth of them exceed.
    pub fn of(
        values: &[f64],
        least: Option<f64>,
        most: Option<f64>,
        is_logarithmic: bool,
    ) -> ColorScale {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let index = (sorted.len().saturating_sub(1)) as f64 * 0.999;
        let largest = sorted.get(index.round() as usize).copied().unwrap_or(1.0);
        let most = most.unwrap_or(if largest > 0.0 { largest } else { 1.0 });
        let least = least.unwrap_or(if is_logarithmic {
            most * 10_f64.powf(-DECADES)
        } else {
            0.0
        });
        ColorScale {
            least: least.min(most),
            most,
            is_logarithmic,
        }
    }

    /// Position of a value, 0 for the first colour and 1 for the last.
    pub fn position(&self, value: f64) -> f64 {
        if !value.is_finite() {
            return value;
        }
        let (value, least, most) = if self.is_logarithmic {
            let tiny = f64::MIN_POSITIVE;
            (
                value.max(tiny).ln(),
                self.least.max(tiny).ln(),
                self.most.ln(),
            )
        } else {
            (value, self.least, self.most)
        };
        if most > least {
            ((value - least) / (most - least)).clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(value >= most))
        }
    }

    /// The value at a position.
    pub fn value(&self, position: f64) -> f64 {
        if self.is_logarithmic {
            let least = self.least.max(f64::MIN_POSITIVE);
            least * (self.most / least).powf(position)
        } else {
            self.least + (self.most - self.least) * position
        }
    }

    /// Colour of a value.
    pub fn color(&self, value: f64) -> [u8; 3] {
        heatmap::color(self.position(value))
    }

    /// Draws the bar at the left end `x` of a canvas, with what it measures above.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas,
        x: u32,
        quantity: &str,
    ) -> Result<(), DrawError> {
        let height = canvas.size()[1] as i32;
        let (left, top, bottom) = (x as i32 + 14, 44, (height - 18).max(60));
        let [name, unit] = match quantity.split_once(',') {
            Some((name, unit)) => [name, unit.trim()],
            None => [quantity, ""],
        };
        canvas.draw(|area| {
            area.draw(&Text::new(name.to_owned(), (left, 6), text_style(14)))?;
            area.draw(&Text::new(unit.to_owned(), (left, 23), text_style(13)))?;
            for y in top..bottom {
                let position = f64::from(bottom - 1 - y) / f64::from((bottom - top - 1).max(1));
                let [r, g, b] = heatmap::color(position);
                let row =
                    Rectangle::new([(left, y), (left + 20, y + 1)], RGBColor(r, g, b).filled());
                area.draw(&row)?;
            }
            let labels = ((bottom - top) / 40).clamp(1, 8);
            for i in 0..=labels {
                let position = f64::from(i) / f64::from(labels);
                let y = bottom - 1 - (position * f64::from(bottom - top - 1)).round() as i32;
                let text = short(self.value(position));
                area.draw(&Text::new(text, (left + 27, y - 7), text_style(13)))?;
            }
            Ok(())
        })
    }
}

/// Three digits of a number.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if (0..=5).contains(&digits) {
        format!("{value:.*}", digits as usize)
    } else if (-3..0).contains(&digits) {
        format!("{value:.0}")
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_place_values_and_find_them_again() {
        for is_logarithmic in [false, true] {
            let scale = ColorScale::of(&[0.0, 1.0, 50.0], None, None, is_logarithmic);
            assert_eq!(scale.most, 50.0);
            assert_eq!(scale.position(50.0), 1.0);
            assert_eq!(scale.position(-1.0), 0.0);
            let value = scale.value(scale.position(7.0));
            assert!((value - 7.0).abs() < 1e-9, "{value}");
        }
        let log = ColorScale::of(&[], Some(0.01), Some(100.0), true);
        assert!((log.position(1.0) - 0.5).abs() < 1e-12);
        assert_eq!(log.color(f64::NAN), heatmap::NOT_FINITE);
    }

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (1.2345, "1.23"),
            (0.05, "0.0500"),
            (1234.5, "1234"),
            (1e-7, "1.00e-7"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }
}
