//! Why images cannot be merged.

use super::metadata::InvalidSampleRange;

/// Why images cannot be merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MergeError {
    /// Of another scene, algorithm or size.
    #[error("{name}: its {what} is {found}, that of {first} is {expected}")]
    OtherImage {
        /// The image.
        name: String,
        /// The first image.
        first: String,
        /// What differs.
        what: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The scene has changed between the images.
    #[error(
        "{name} and {first} are not of the same scene: what {scene} holds, its camera or the size of its film has changed between them"
    )]
    OtherScene {
        /// The image.
        name: String,
        /// The first image.
        first: String,
        /// The scene.
        scene: String,
    },
    /// They differ in what is known by its digest alone.
    #[error("{name} and {first} are not shares of one image: they differ in the {what}")]
    OtherContent {
        /// The image.
        name: String,
        /// The first image.
        first: String,
        /// What differs.
        what: String,
    },
    /// The crops are too far apart.
    #[error("{name}: an image that holds its pixels and those of the others is too large")]
    TooLarge {
        /// The image.
        name: String,
    },
    /// The images share samples.
    #[error(
        "{name} and {other} hold the same samples ({range}): merged they would count twice; render them with other seeds or --samples"
    )]
    SharedSamples {
        /// The image.
        name: String,
        /// The image it shares samples with.
        other: String,
        /// The range that both hold a part of.
        range: String,
    },
    /// The passes of an image depend on each other.
    #[error(
        "{name}: each pass of {integrator} takes its radii from all before it, so that images of different passes are not shares of one image"
    )]
    DependentPasses {
        /// The image.
        name: String,
        /// Its algorithm.
        integrator: String,
    },
    /// A layer that merging needs is not there.
    #[error("{name}: merging needs the layer \"{layer}\"")]
    MissingLayer {
        /// The image.
        name: String,
        /// The layer.
        layer: String,
    },
    /// A value that no samples have.
    #[error("{name}: {what} at pixel ({x}, {y})")]
    InvalidPixel {
        /// The image.
        name: String,
        /// What is wrong.
        what: String,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
    /// Metadata that cannot be read.
    #[error("{name}: {source}")]
    Metadata {
        /// The image.
        name: String,
        /// Why.
        source: InvalidSampleRange,
    },
}
