//! All surfaces of a scene as one mesh in world space: instances are placed, analytic shapes divided into triangles.

use crate::scene::tables::SceneTables;
use glam::Vec3;
use halflight_kernel::math::affine::transform_point;
use halflight_kernel::scene::{Quadric, quadric_kind};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// Steps around a sphere, a disk or a cylinder; half as many from pole to pole.
const STEPS: u32 = 48;

/// Triangles of shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatMesh {
    /// Corners.
    pub positions: Vec<[f32; 3]>,
    /// Triangles.
    pub indices: Vec<[u32; 3]>,
    /// Shape, first triangle and number of triangles; a shape has one for each of its instances.
    pub ranges: Vec<[u32; 3]>,
}

impl FlatMesh {
    /// Of all instances.
    pub fn of(tables: &SceneTables) -> FlatMesh {
        let mut mesh = FlatMesh::default();
        for instance in &tables.instances {
            let group = &tables.groups[instance.group as usize];
            let to_world = |p: Vec3| transform_point(&instance.to_world, p);
            let mut numbers: HashMap<u32, u32> = HashMap::new();
            for index in group.triangles.clone() {
                let triangle = &tables.triangles[index as usize];
                // Vertices of different shapes are different, so that each has one colour.
                let corners = triangle.vertices.map(|vertex| {
                    *numbers.entry(vertex).or_insert_with(|| {
                        let p = Vec3::from_array(tables.positions[vertex as usize]);
                        mesh.positions.push(to_world(p).to_array());
                        mesh.positions.len() as u32 - 1
                    })
                });
                mesh.add(triangle.shape, corners);
            }
            for index in group.quadrics.clone() {
                let quadric = &tables.quadrics[index as usize];
                let to_scene = |p: Vec3| to_world(transform_point(&quadric.to_world, p));
                mesh.add_quadric(quadric, to_scene);
            }
        }
        mesh
    }

    /// Adds a triangle of a shape.
    pub(super) fn add(&mut self, shape: u32, corners: [u32; 3]) {
        let first = self.indices.len() as u32;
        match self.ranges.last_mut() {
            Some(range) if range[0] == shape => range[2] += 1,
            _ => self.ranges.push([shape, first, 1]),
        }
        self.indices.push(corners);
    }

    fn add_quadric(&mut self, quadric: &Quadric, to_scene: impl Fn(Vec3) -> Vec3) {
        let rows = match quadric.kind {
            quadric_kind::SPHERE => STEPS / 2,
            _ => 1,
        };
        let first = self.positions.len() as u32;
        for row in 0..=rows {
            let v = row as f32 / rows as f32;
            for column in 0..=STEPS {
                let (sine, cosine) = (TAU * column as f32 / STEPS as f32).sin_cos();
                let local = match quadric.kind {
                    quadric_kind::SPHERE => {
                        let (radius, z) = (PI * v).sin_cos();
                        Vec3::new(radius * cosine, radius * sine, z)
                    }
                    quadric_kind::DISK => Vec3::new(v * cosine, v * sine, 0.0),
                    _ => Vec3::new(cosine, sine, v),
                };
                self.positions.push(to_scene(local).to_array());
            }
        }
        let at = |row: u32, column: u32| first + row * (STEPS + 1) + column;
        for row in 0..rows {
            for column in 0..STEPS {
                let corners = [
                    at(row, column),
                    at(row + 1, column),
                    at(row, column + 1),
                    at(row + 1, column + 1),
                ];
                self.add(quadric.shape, [corners[0], corners[1], corners[2]]);
                self.add(quadric.shape, [corners[2], corners[1], corners[3]]);
            }
        }
    }
}
