//! Surface points, in lanes.

use super::paths::QueuedPaths;
use super::segment::Segment;
use crate::math::affine::{transform_point, transform_vector};
use crate::math::{Frame, field};
use crate::path::PathExpressions;
use crate::scene::surface::detail;
use crate::scene::surface::quadric::sphere_point_with;
use crate::scene::surface::triangle::triangle_point_with;
use crate::scene::{HitBatch, SurfacePoint, Tables};
use crate::simd::lanes::{Vec3Lanes, gather};
use crate::simd::multiversioned;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// The surface points at which up to `N` paths have arrived.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct PointLanes<const N: usize> {
    position: Vec3Lanes<N>,
    position_error: [f32; N],
    geometric_normal: Vec3Lanes<N>,
    s: Vec3Lanes<N>,
    t: Vec3Lanes<N>,
    n: Vec3Lanes<N>,
    pub uv: [[f32; N]; 2],
    barycentric: [[f32; N]; 2],
    pub shape: [u32; N],
    pub primitive: [u32; N],
    pub material: [u32; N],
    pub emitter: [u32; N],
    /// The direction back along the ray, in the point's frame.
    pub wi: Vec3Lanes<N>,
}

impl<const N: usize> PointLanes<N> {
    /// Point `k < N`; without derivatives.
    #[inline(always)]
    pub fn get(&self, k: usize) -> SurfacePoint {
        SurfacePoint {
            position: self.position.get(k),
            position_error: self.position_error[k],
            geometric_normal: self.geometric_normal.get(k),
            frame: Frame {
                s: self.s.get(k),
                t: self.t.get(k),
                n: self.n.get(k),
            },
            uv: Vec2::new(self.uv[0][k], self.uv[1][k]),
            barycentric: Vec2::new(self.barycentric[0][k], self.barycentric[1][k]),
            shape: self.shape[k],
            primitive: self.primitive[k],
            material: self.material[k],
            emitter: self.emitter[k],
            ..SurfacePoint::ZERO
        }
    }

    /// Where the letters of point `k < N` begin; all points are of the world.
    #[inline(always)]
    pub fn first_letter(&self, expressions: &PathExpressions<'_>, k: usize) -> u32 {
        let position = if expressions.regions.is_empty() {
            Vec3::ZERO
        } else {
            self.position.get(k)
        };
        expressions.first_letter_of(self.shape[k], SurfacePoint::ZERO.instance, position)
    }

    #[inline(always)]
    fn set(&mut self, k: usize, point: &SurfacePoint) {
        self.position.set(k, point.position);
        self.position_error[k] = point.position_error;
        self.geometric_normal.set(k, point.geometric_normal);
        self.s.set(k, point.frame.s);
        self.t.set(k, point.frame.t);
        self.n.set(k, point.frame.n);
        self.uv[0][k] = point.uv.x;
        self.uv[1][k] = point.uv.y;
        self.barycentric[0][k] = point.barycentric.x;
        self.barycentric[1][k] = point.barycentric.y;
        self.shape[k] = point.shape;
        self.primitive[k] = point.primitive;
        self.material[k] = point.material;
        self.emitter[k] = point.emitter;
    }
}

multiversioned! {
    /// Points on triangles of the world; without `NORMALS` or `UVS` if no mesh has them.
    pub(super) fn on_triangles<; const NORMALS: bool, const UVS: bool, const N: usize>(
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        hits: &HitBatch<N>,
        points: &mut PointLanes<N>,
    ) {
        let tables = Tables {
            normals: if NORMALS { tables.normals } else { &[] },
            uvs: if UVS { tables.uvs } else { &[] },
            ..*tables
        };
        for k in queued.segment.padded::<N>() {
            let i = queued.entries[k];
            let point = triangle_point_with::<{ detail::TANGENTS }>(
                &tables,
                gather(&hits.primitive, i),
                gather(&hits.b1, i),
                gather(&hits.b2, i),
            );
            points.set(k, &point);
            let back: Vec3 = -queued.paths.rays.direction.gather(i);
            points.wi.set(k, point.frame.to_local(back));
        }
    }

    /// Points on spheres of the world, in a part of the queue's segment.
    pub(super) fn on_spheres<; const N: usize>(
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        hits: &HitBatch<N>,
        part: Segment,
        points: &mut PointLanes<N>,
    ) {
        let triangle_count = tables.triangles.len() as u32;
        for k in part.padded::<N>() {
            let i = queued.entries[k];
            let quadric = gather(&hits.primitive, i).wrapping_sub(triangle_count);
            let to_object = field(tables.quadrics, quadric, |q| q.to_object);
            let origin = transform_point(&to_object, queued.paths.rays.origin.gather(i));
            let direction = transform_vector(&to_object, queued.paths.rays.direction.gather(i));
            let p = origin + direction * gather(&hits.t, i);
            let point = sphere_point_with::<{ detail::TANGENTS }>(tables, quadric, p);
            // Slots of the first vector in front of the part hold points on triangles.
            if k >= part.first {
                points.set(k, &point);
                let back: Vec3 = -queued.paths.rays.direction.gather(i);
                points.wi.set(k, point.frame.to_local(back));
            }
        }
    }
}
