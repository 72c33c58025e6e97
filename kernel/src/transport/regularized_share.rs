//! The share of a connection's light that regularisation has found, which a layer of the image shows.

use crate::math::{Rgb, luminance};

/// How much of the light of a connection is regularised.
#[derive(Clone, Copy, Debug)]
pub struct RegularizedShare {
    /// Share of its luminance.
    pub share: f32,
    /// tau, or the radius of the blur; zero without any.
    pub blur: f32,
}

impl RegularizedShare {
    /// Nothing of it.
    pub(super) const NONE: RegularizedShare = RegularizedShare {
        share: 0.0,
        blur: 0.0,
    };

    /// Blurred by `blur`, in which `part` of `whole` was found.
    #[inline]
    pub(super) fn new(part: Rgb, whole: Rgb, blur: f32) -> RegularizedShare {
        let (part, whole) = (luminance(part), luminance(whole));
        if part > 0.0 && whole > 0.0 {
            RegularizedShare {
                share: (part / whole).min(1.0),
                blur,
            }
        } else {
            RegularizedShare::NONE
        }
    }
}
