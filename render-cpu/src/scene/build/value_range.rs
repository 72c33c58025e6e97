//! The range of a texture's values, which depends on the parameter that takes it.

use crate::scene::color::ColorUse;

/// The range of a texture's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum ValueRange {
    /// From 0 to 1: reflectances and numbers.
    UnitInterval,
    /// Not bounded above: radiance, indices of refraction.
    Unbounded,
}

impl ValueRange {
    /// How the colours of patterns are read.
    pub(super) fn color_use(self) -> ColorUse {
        match self {
            ValueRange::UnitInterval => ColorUse::Reflectance,
            ValueRange::Unbounded => ColorUse::Unbounded,
        }
    }
}
