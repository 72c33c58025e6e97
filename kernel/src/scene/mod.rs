//! Scenes as plain tables, and what can be asked of them.
//!
//! A front end fills vectors of the [`records`] and lends them as [`Tables`]; with a ray traverser they make a
//! [`SceneView`], the only thing that transport algorithms see.

pub mod records;
pub mod surface;
pub mod texture;
pub mod traverse;
pub mod view;

pub use records::*;
pub use surface::SurfacePoint;
pub use traverse::{Hit, Traverse};
pub use view::{SceneView, Tables};
