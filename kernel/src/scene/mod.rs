//! Scenes as plain tables, and what is computed from them: surfaces, textures, emitters, cameras, ray traversal.
//!
//! A front end fills vectors of the [`records`] and lends them as [`Tables`]; with a ray traverser they make a
//! [`SceneView`], the only thing that transport algorithms see.

#[cfg(not(target_arch = "spirv"))]
pub mod batch;
pub mod bitmap;
pub mod bvh2;
pub mod camera;
pub mod emitter;
pub mod features;
pub mod field_of_view;
pub mod film_position;
pub mod hit;
pub mod intersect;
#[cfg(not(target_arch = "spirv"))]
pub mod irradiance_meter;
pub mod records;
pub mod spherical_camera;
pub mod surface;
pub mod texture;
pub mod traverse;
pub mod view;

#[cfg(not(target_arch = "spirv"))]
pub use batch::{HitBatch, RayBatch};
pub use bvh2::{Bvh2Traverse, BvhNode};
pub use hit::Hit;
pub use intersect::{offset_origin, segment};
pub use records::*;
pub use surface::{SurfacePoint, surface_at, surface_at_primitive};
pub use traverse::Traverse;
pub use view::{SceneView, Tables};
