//! What a state of a chain adds to the image.

use crate::math::{Rgb, luminance};
use arrayvec::ArrayVec;
use glam::Vec2;

/// Light at a film position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// In pixels of the whole film.
    pub film: Vec2,
    /// Its share of the mean of a pixel with a filter of area one, one sample per pixel.
    pub value: Rgb,
    /// 0 for the image, from 1 on for its parts by path expressions.
    pub image: u32,
}

/// Most splats of a state. Light walks with more vertices than this lose what comes after, far below all noise: the walk has
/// survived a hundred trials by then.
pub const MAX_SPLATS: usize = 256;

/// F and I of a state.
#[derive(Clone, Debug, Default)]
pub struct State {
    splats: ArrayVec<Splat, MAX_SPLATS>,
    target: f32,
}

impl State {
    /// Forgets all.
    #[inline]
    pub fn clear(&mut self) {
        self.splats.clear();
        self.target = 0.0;
    }

    /// Adds light that counts `importance` times in I; what falls on the position of the first splat is added to that.
    #[inline]
    pub fn add(&mut self, film: Vec2, value: Rgb, importance: f32) {
        let light = luminance(value);
        if !(light > 0.0) || !value.is_finite() {
            return;
        }
        match self.splats.first_mut() {
            Some(first) if first.film == film && first.image == 0 => first.value += value,
            _ => {
                let splat = Splat {
                    film,
                    value,
                    image: 0,
                };
                if self.splats.try_push(splat).is_err() {
                    return;
                }
            }
        }
        self.target += light * importance;
    }

    /// Adds light to one of the images of parts, which I does not count.
    #[inline]
    pub fn add_part(&mut self, film: Vec2, value: Rgb, image: u32) {
        if !(value.max_element() > 0.0) || !value.is_finite() {
            return;
        }
        let is_same = |splat: &&mut Splat| splat.image == image && splat.film == film;
        match self.splats.iter_mut().find(is_same) {
            Some(splat) => splat.value += value,
            None => {
                // As in [`State::add`].
                let _ = self.splats.try_push(Splat { film, value, image });
            }
        }
    }

    /// I: the luminance of all that it adds, each part as often as it counts.
    #[inline]
    pub fn target(&self) -> f32 {
        self.target
    }

    /// What it adds.
    #[inline]
    pub fn splats(&self) -> &[Splat] {
        &self.splats
    }

    /// Multiplies F and I.
    #[inline]
    pub fn scale(&mut self, factor: f32) {
        self.splats
            .iter_mut()
            .for_each(|splat| splat.value *= factor);
        self.target *= factor;
    }

    /// Passes on the splats times `factor`.
    #[inline]
    pub fn emit(&self, factor: f32, add: &mut impl FnMut(Splat)) {
        for splat in &self.splats {
            add(Splat {
                film: splat.film,
                value: splat.value * factor,
                image: splat.image,
            });
        }
    }
}
