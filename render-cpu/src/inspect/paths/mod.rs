//! Recorded paths as something to look at: clusters ([`cluster`]), bundles ([`bundle`]), a picture with arrows ([`picture`]), and
//! which of them an expression matches ([`matching`]).

pub mod bundle;
pub mod cluster;
pub mod matching;
pub mod picture;
mod stroke;

use super::record_file::{PathRecord, RecordedPath};
use glam::Vec3;
use halflight_kernel::transport::recorded::vertex_kind;

/// The positions of all vertices of a record, from the sensor to the light, where light from infinity begins at a finite distance.
#[derive(Clone, Debug)]
pub struct Places {
    /// By path.
    pub paths: Vec<Vec<Vec3>>,
    /// Diagonal of the box around all vertices but those at infinity.
    pub extent: f32,
}

impl Places {
    /// Light from infinity is placed half the [`Places::extent`] from the vertex that it meets.
    pub fn of(record: &PathRecord) -> Places {
        let is_finite =
            |path: &RecordedPath, i: usize| path.vertices[i].kind != vertex_kind::LIGHT_AT_INFINITY;
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for path in &record.paths {
            for (i, vertex) in path.vertices.iter().enumerate() {
                if is_finite(path, i) {
                    low = low.min(Vec3::from_array(vertex.position));
                    high = high.max(Vec3::from_array(vertex.position));
                }
            }
        }
        let extent = if low.x <= high.x {
            (high - low).length()
        } else {
            0.0
        };
        let of_path = |path: &RecordedPath| {
            let mut before = Vec3::ZERO;
            let position = |i: usize| {
                let position = Vec3::from_array(path.vertices[i].position);
                let placed = if is_finite(path, i) {
                    position
                } else {
                    before + position * (0.5 * extent)
                };
                before = placed;
                placed
            };
            (0..path.vertices.len()).map(position).collect()
        };
        Places {
            paths: record.paths.iter().map(of_path).collect(),
            extent,
        }
    }
}
