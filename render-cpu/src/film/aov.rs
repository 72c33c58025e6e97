//! Arbitrary output variables: which layers an image carries, and the surface features of one camera sample.
//!
//! `albedo`, `normal`, `depth`, `position` and `uv` are accumulated per sample; `variance` and `samples` are read off
//! the radiance statistics: they need no work while rendering and are only a choice of what is written.

use std::fmt;
use std::str::FromStr;

/// Numbers that [`Aov::Bandwidth`] keeps of a pixel: the bandwidth, and the statistics that it comes from.
pub const BANDWIDTH_NUMBERS: usize = 9;

/// One output variable beside radiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Aov {
    /// Directional albedo of the first surface, RGB.
    Albedo,
    /// Shading normal in world space.
    Normal,
    /// Distance along the camera ray, in scene units.
    Depth,
    /// Position in world space.
    Position,
    /// Texture coordinates.
    Uv,
    /// Share of the samples whose camera ray meets a surface.
    Alpha,
    /// Variance of the pixel's mean radiance, RGB.
    Variance,
    /// Number of samples of the pixel.
    Samples,
    /// Radius of the pixel's next density estimate, in scene units: of adaptive photon mapping, whose statistics are kept with it.
    Bandwidth,
    /// Mean probability of acceptance of the mutations of paths that the pixel sees.
    Acceptance,
    /// Mean number of iterations of their walks on manifolds.
    Iterations,
    /// Share of them that jump to another sub-manifold.
    Jumps,
    /// Number of them: where chains spend their time.
    Mutations,
    /// Share of the radiance that regularised connections found, and the mean tau or radius with which they did.
    Regularization,
}

impl Aov {
    /// Every output variable, in the order of the accumulators.
    pub const ALL: [Self; 14] = [
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::Position,
        Self::Uv,
        Self::Alpha,
        Self::Variance,
        Self::Samples,
        Self::Bandwidth,
        Self::Acceptance,
        Self::Iterations,
        Self::Jumps,
        Self::Mutations,
        Self::Regularization,
    ];

    /// The variables that Markov chains of full paths have.
    pub const OF_CHAINS: [Self; 4] = [
        Self::Acceptance,
        Self::Iterations,
        Self::Jumps,
        Self::Mutations,
    ];

    /// Name on the command line and of the EXR layer.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Uv => "uv",
            Self::Alpha => "alpha",
            Self::Variance => "variance",
            Self::Samples => "samples",
            Self::Bandwidth => "bandwidth",
            Self::Acceptance => "acceptance",
            Self::Iterations => "iterations",
            Self::Jumps => "jumps",
            Self::Mutations => "mutations",
            Self::Regularization => "regularization",
        }
    }

    /// Suffixes of the layer's EXR channels; empty for those that are one channel, see [`Self::channel`].
    pub const fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo | Self::Variance => &["R", "G", "B"],
            Self::Normal | Self::Position => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Uv => &["U", "V"],
            Self::Regularization => &["share", "scale"],
            Self::Alpha
            | Self::Samples
            | Self::Bandwidth
            | Self::Acceptance
            | Self::Iterations
            | Self::Jumps
            | Self::Mutations => &[],
        }
    }

    /// Name of the EXR channel of a layer that is one channel of its own.
    pub const fn channel(self) -> Option<&'static str> {
        match self {
            Self::Alpha => Some("A"),
            Self::Samples => Some("samples"),
            Self::Bandwidth
            | Self::Acceptance
            | Self::Iterations
            | Self::Jumps
            | Self::Mutations => Some(self.name()),
            _ => None,
        }
    }

    /// Numbers accumulated per pixel; zero for what the radiance statistics hold already.
    pub const fn accumulators(self) -> usize {
        match self {
            Self::Albedo | Self::Normal | Self::Position => 3,
            Self::Uv => 2,
            Self::Depth | Self::Alpha => 1,
            Self::Variance | Self::Samples => 0,
            Self::Bandwidth => BANDWIDTH_NUMBERS,
            // Luminance that is regularised, and the sum of its products with the logarithm of tau or the radius.
            Self::Regularization => 2,
            // A sum, and the number of what it is a sum of.
            Self::Acceptance | Self::Iterations | Self::Jumps => 2,
            Self::Mutations => 1,
        }
    }

    const fn bit(self) -> u16 {
        1 << self as u8
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no output variable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown output variable \"{0}\" (known: albedo, normal, depth, position, uv, alpha, variance, samples, bandwidth, acceptance, iterations, jumps, mutations, regularization, or all)"
)]
pub struct UnknownAov(pub String);

impl FromStr for Aov {
    type Err = UnknownAov;

    fn from_str(name: &str) -> Result<Self, UnknownAov> {
        Self::ALL
            .into_iter()
            .find(|aov| aov.name() == name)
            .ok_or_else(|| UnknownAov(name.to_owned()))
    }
}

/// A set of output variables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AovSet(u16);

impl AovSet {
    /// No variable: radiance alone.
    pub const NONE: Self = Self(0);

    /// Whether the set holds nothing.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether the set holds `aov`.
    pub const fn contains(self, aov: Aov) -> bool {
        self.0 & aov.bit() != 0
    }

    /// Every variable that any algorithm has: all but the states of some.
    pub const ALL: Self = Self(Aov::Bandwidth.bit() - 1);

    /// The variables of both sets.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Sums that are kept of a part of the image: of its samples, and where variances are wanted, of their squares.
    pub fn sums_per_part(self) -> usize {
        if self.contains(Aov::Variance) { 6 } else { 3 }
    }

    /// Sums that are kept of a pixel: those of output variables, then those of parts.
    pub fn sums_per_pixel(self, parts: usize) -> usize {
        self.accumulators() + self.sums_per_part() * parts
    }

    /// The set with `aov` added.
    #[must_use]
    pub const fn with(self, aov: Aov) -> Self {
        Self(self.0 | aov.bit())
    }

    /// The variables of the set, in the order of the accumulators.
    pub fn iter(self) -> impl Iterator<Item = Aov> {
        Aov::ALL.into_iter().filter(move |&aov| self.contains(aov))
    }

    /// Whether a front end has to compute surface features for the film at all.
    pub const fn needs_surface(self) -> bool {
        self.offset(Aov::Bandwidth) > 0
    }

    /// Numbers accumulated per pixel.
    pub const fn accumulators(self) -> usize {
        self.offset_of_bit(Aov::ALL.len())
    }

    /// Where the accumulators of `aov` begin within those of a pixel.
    pub const fn offset(self, aov: Aov) -> usize {
        self.offset_of_bit(aov as usize)
    }

    const fn offset_of_bit(self, end: usize) -> usize {
        let mut offset = 0;
        let mut i = 0;
        while i < end {
            if self.contains(Aov::ALL[i]) {
                offset += Aov::ALL[i].accumulators();
            }
            i += 1;
        }
        offset
    }
}

impl FromIterator<Aov> for AovSet {
    fn from_iter<I: IntoIterator<Item = Aov>>(aovs: I) -> Self {
        aovs.into_iter().fold(Self::NONE, Self::with)
    }
}

impl fmt::Display for AovSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.iter().map(Aov::name).collect();
        f.write_str(&names.join(","))
    }
}

/// Surface features of one camera sample; the default, all zero, is a ray that hit nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AovSample {
    /// Directional albedo, linear sRGB.
    pub albedo: [f32; 3],
    /// Shading normal in world space.
    pub normal: [f32; 3],
    /// Distance along the camera ray, in scene units.
    pub depth: f32,
    /// Position in world space.
    pub position: [f32; 3],
    /// Texture coordinates.
    pub uv: [f32; 2],
}
