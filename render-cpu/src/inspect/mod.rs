//! Tools that look at the light of a scene (Kaplanyan 2017, section 9.1.2): false colours with a legend, and the radiance around
//! a point as a spherical plot, bundles of recorded paths as arrows, and a box of virtual medium; and a record of paths with their vertices. What they
//! look at can be restricted by a path expression.

pub mod false_color;
mod legend;
pub mod page;
pub mod paths;
mod pixel_film;
pub mod record;
pub mod record_file;
pub mod spherical_plot;
pub mod volume;

pub use legend::ColorScale;
