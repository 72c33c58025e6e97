//! The last step: bounds of the scene and the probabilities of choosing each emitter.

use super::builder::Builder;
use crate::accel::GroupRange;
use crate::mesh::MIN_SHARE;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use glam::Vec3;
use halflight_kernel::math::affine::transform_point;
use halflight_kernel::scene::{emitter, emitter_kind, quadric_kind};
use halflight_kernel::transport::integrator_kind;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

/// The corners of a box without a point.
const NOTHING: (Vec3, Vec3) = (Vec3::splat(f32::MAX), Vec3::splat(-f32::MAX));

impl Builder {
    /// Fills in what depends on the scene as a whole.
    pub(super) fn finish(&mut self, root: &Object, integrator: u32) -> Result<(), SceneError> {
        // Definitions at the top are there to be referred to; one that nothing uses is no mistake, but one that nothing can use is.
        for kind in [
            ObjectKind::Bsdf,
            ObjectKind::Texture,
            ObjectKind::Spectrum,
            ObjectKind::Sampler,
            ObjectKind::RFilter,
            ObjectKind::Film,
            ObjectKind::Medium,
            ObjectKind::Volume,
            ObjectKind::Phase,
        ] {
            for child in root.children_of(kind) {
                let object = child.object;
                if object.id.is_none() && !object.touched() {
                    object.ignore();
                    object.warn("nothing uses it here, nor can without an id; it is left out")?;
                }
            }
        }
        self.bound();
        self.select_emitters();
        let needs_light = integrator != integrator_kind::AMBIENT_OCCLUSION;
        if self.tables.emitters.is_empty() && needs_light {
            root.warn("the scene has no emitter; the image will be black")?;
        }
        Ok(())
    }

    /// The bounding sphere of everything, instances included.
    fn bound(&mut self) {
        let (mut low, mut high) = NOTHING;
        for instance in &self.tables.instances {
            let group = &self.tables.groups[instance.group as usize];
            let triangles = self.triangle_bounds(group, &instance.to_world);
            low = low.min(triangles.0);
            high = high.max(triangles.1);
            let mut add = |p: Vec3| {
                let p = transform_point(&instance.to_world, p);
                low = low.min(p);
                high = high.max(p);
            };
            for q in group.quadrics.clone() {
                let quadric = &self.tables.quadrics[q as usize];
                let z = match quadric.kind {
                    quadric_kind::SPHERE => [-1.0, 1.0],
                    quadric_kind::CYLINDER => [0.0, 1.0],
                    _ => [0.0, 0.0],
                };
                for corner in 0..8 {
                    let pick = |bit: u32| corner >> bit & 1 == 1;
                    add(transform_point(
                        &quadric.to_world,
                        Vec3::new(
                            if pick(0) { 1.0 } else { -1.0 },
                            if pick(1) { 1.0 } else { -1.0 },
                            z[usize::from(pick(2))],
                        ),
                    ));
                }
            }
        }
        if low.x <= high.x {
            self.tables.info.center = ((low + high) * 0.5).to_array();
            self.tables.info.radius = ((high - low).length() * 0.5).max(f32::MIN_POSITIVE);
        }
    }

    /// The corners of the box of a group's triangles in the world.
    fn triangle_bounds(&self, group: &GroupRange, to_world: &[f32; 12]) -> (Vec3, Vec3) {
        let range = group.triangles.start as usize..group.triangles.end as usize;
        let triangles = self.tables.triangles[range].par_iter();
        let points = triangles.with_min_len(MIN_SHARE).map(|triangle| {
            let world_position = |vertex: u32| {
                let p = Vec3::from_array(self.tables.positions[vertex as usize]);
                transform_point(to_world, p)
            };
            let [a, b, c] = triangle.vertices.map(world_position);
            (a.min(b).min(c), a.max(b).max(c))
        });
        points.reduce(|| NOTHING, |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Probabilities of choosing each emitter.
    fn select_emitters(&mut self) {
        // Nothing to choose from, and the power of an environment takes a walk over its image.
        if let [only] = &mut self.tables.emitters[..]
            && only.kind == emitter_kind::ENVIRONMENT
        {
            emitter::fill_selection(&mut self.tables.emitters, &[1.0]);
            return;
        }
        let view = self.tables.view();
        let powers: Vec<f32> = (0..self.tables.emitters.len())
            .map(|i| emitter::power(&view, i as u32))
            .collect();
        emitter::fill_selection(&mut self.tables.emitters, &powers);
    }
}
