//! Small scenes in memory for tests of lights and cameras, and a brute-force ray tracer over them.

use super::brute_force;
use super::empty_tables::empty_tables;
use glam::{Affine3A, Vec3};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::IDENTITY;
use halflight_kernel::scene::*;

/// Owned tables.
pub struct Scene {
    /// See [`Tables`].
    pub positions: Vec<[f32; 3]>,
    /// See [`Tables`].
    pub normals: Vec<[f32; 3]>,
    /// See [`Tables`].
    pub uvs: Vec<[f32; 2]>,
    /// See [`Tables`].
    pub triangles: Vec<Triangle>,
    /// See [`Tables`].
    pub quadrics: Vec<Quadric>,
    /// See [`Tables`].
    pub shapes: Vec<Shape>,
    /// See [`Tables`].
    pub textures: Vec<Texture>,
    /// See [`Tables`].
    pub texels: Vec<u32>,
    /// See [`Tables`].
    pub data: Vec<f32>,
    /// See [`Tables`].
    pub emitters: Vec<Emitter>,
    /// See [`Tables`].
    pub camera: Camera,
    /// See [`Tables`].
    pub info: SceneInfo,
}

/// A pinhole of 4 by 4 pixels at the origin.
pub const CAMERA: Camera = Camera {
    kind: camera_kind::PERSPECTIVE,
    to_world: IDENTITY,
    to_camera: IDENTITY,
    film_size: [4, 4],
    crop_offset: [0, 0],
    crop_size: [4, 4],
    tan_half_width: 1.0,
    tan_half_height: 1.0,
    principal_point_offset: [0.0, 0.0],
    aperture_radius: 0.0,
    focus_distance: 1.0,
    clip: [1e-2, 1e4],
    filter: filter_kind::BOX,
    filter_parameters: [0.5, 0.0, 0.0],
    filter_table: 0,
    filter_table_size: 0,
    shape: NONE,
    shape_areas: NONE,
};

/// An emitter of the given kind with nothing else set.
pub fn emitter(kind: u32, radiance: RgbParameter) -> Emitter {
    Emitter {
        kind,
        radiance,
        to_world: IDENTITY,
        to_local: IDENTITY,
        parameters: [0.0; 4],
        shape: NONE,
        area: 0.0,
        distribution: NONE,
        width: 0,
        height: 0,
        selection_pdf: 1.0,
        selection_cdf: 1.0,
    }
}

/// Three rows of four of an affine map.
pub fn rows(m: Affine3A) -> [f32; 12] {
    let (x, y, z, t) = (
        m.matrix3.x_axis,
        m.matrix3.y_axis,
        m.matrix3.z_axis,
        m.translation,
    );
    [x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z]
}

/// The affine map of three rows of four.
pub fn affine(r: &[f32]) -> Affine3A {
    Affine3A::from_cols(
        Vec3::new(r[0], r[4], r[8]).into(),
        Vec3::new(r[1], r[5], r[9]).into(),
        Vec3::new(r[2], r[6], r[10]).into(),
        Vec3::new(r[3], r[7], r[11]).into(),
    )
}

/// The lines of numbers of an oracle table.
pub fn numbers(text: &str) -> Vec<Vec<f32>> {
    let rows: Vec<Vec<f32>> = text
        .lines()
        .skip(2)
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert!(
        rows.len() > 10,
        "an oracle table without rows tests nothing"
    );
    rows
}

impl Scene {
    /// Nothing.
    pub fn new() -> Scene {
        Scene {
            positions: vec![],
            normals: vec![],
            uvs: vec![],
            triangles: vec![],
            quadrics: vec![],
            shapes: vec![],
            textures: vec![],
            texels: vec![],
            data: vec![],
            emitters: vec![],
            camera: CAMERA,
            info: SceneInfo {
                center: [0.0; 3],
                radius: 10.0,
                environment: NONE,
                srgb_table: 0,
                flags: 0,
            },
        }
    }

    /// The borrowed tables.
    pub fn tables(&self) -> Tables<'_> {
        Tables {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            triangles: &self.triangles,
            quadrics: &self.quadrics,
            shapes: &self.shapes,
            textures: &self.textures,
            texels: &self.texels,
            data: &self.data,
            emitters: &self.emitters,
            camera: self.camera,
            info: self.info,
            ..empty_tables()
        }
    }

    /// Adds a floating-point bitmap and returns its index.
    pub fn add_bitmap(
        &mut self,
        width: u32,
        height: u32,
        filter: u32,
        texel: impl Fn(u32, u32) -> [f32; 3],
    ) -> u32 {
        let first = self.texels.len() as u32;
        for j in 0..height {
            for i in 0..width {
                self.texels.extend(texel(i, j).map(f32::to_bits));
            }
        }
        self.textures.push(Texture {
            kind: texture_kind::BITMAP,
            data: [
                first,
                width,
                height,
                texel_format::RGB32F,
                filter,
                wrap_mode::REPEAT,
            ],
            to_uv: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            color0: RgbParameter::constant([1.0; 3]),
            color1: RgbParameter::constant([1.0; 3]),
        });
        self.textures.len() as u32 - 1
    }

    /// Adds an emitting quadric.
    pub fn add_quadric_light(
        &mut self,
        kind: u32,
        to_world: Affine3A,
        flags: u32,
        radiance: RgbParameter,
    ) {
        let shape = self.shapes.len() as u32;
        let quadric = self.quadrics.len() as u32;
        self.quadrics.push(Quadric {
            to_world: rows(to_world),
            to_object: rows(to_world.inverse()),
            kind,
            shape,
        });
        self.add_shape(quadric, 1, flags, NONE, radiance);
    }

    /// Adds an emitting mesh; uvs and normals are those of the vertices, or none.
    pub fn add_mesh_light(
        &mut self,
        positions: &[Vec3],
        uvs: &[[f32; 2]],
        triangles: &[[u32; 3]],
        flags: u32,
        radiance: RgbParameter,
    ) {
        let first_vertex = self.positions.len() as u32;
        let first_triangle = self.triangles.len() as u32;
        let uv_offset = if uvs.is_empty() {
            NONE
        } else {
            (self.uvs.len() as u32).wrapping_sub(first_vertex)
        };
        self.positions
            .extend(positions.iter().map(|p| p.to_array()));
        self.uvs.extend(uvs);
        let shape = self.shapes.len() as u32;
        self.triangles.extend(triangles.iter().map(|t| Triangle {
            vertices: t.map(|i| i + first_vertex),
            shape,
        }));
        self.add_shape(
            first_triangle,
            triangles.len() as u32,
            flags,
            uv_offset,
            radiance,
        );
    }

    fn add_shape(&mut self, first: u32, count: u32, flags: u32, uvs: u32, radiance: RgbParameter) {
        let shape = self.shapes.len() as u32;
        self.shapes.push(Shape {
            material: 0,
            emitter: self.emitters.len() as u32,
            flags,
            normal_offset: NONE,
            uv_offset: uvs,
            first_vertex: 0,
            first_primitive: first,
            primitive_count: count,
        });
        let mut areas = vec![0.0; count as usize];
        let mut record = emitter(emitter_kind::AREA, radiance);
        record.shape = shape;
        record.area = emitter::fill_shape_areas(&self.tables(), shape, &mut areas);
        record.distribution = self.data.len() as u32;
        self.data.extend(areas);
        self.emitters.push(record);
    }

    /// Adds an image environment.
    pub fn add_environment(
        &mut self,
        width: u32,
        height: u32,
        to_world: Affine3A,
        scale: f32,
        texel: impl Fn(u32, u32) -> [f32; 3],
    ) {
        let texture = self.add_bitmap(width, height, filter_mode::BILINEAR, texel);
        let mut record = emitter(
            emitter_kind::ENVIRONMENT,
            RgbParameter {
                value: [scale; 3],
                texture,
            },
        );
        record.to_world = rows(to_world);
        record.to_local = rows(to_world.inverse());
        (record.width, record.height) = emitter::environment_table_size(width, height);
        let words = emitter::environment_table_words(record.width, record.height);
        let mut table = vec![0.0; words as usize];
        emitter::fill_environment_distribution(&self.tables(), &record, &mut table);
        record.distribution = self.data.len() as u32;
        self.data.extend(table);
        self.info.environment = self.emitters.len() as u32;
        self.emitters.push(record);
    }

    /// Sets the probabilities of choosing the emitters.
    pub fn select(&mut self) {
        let powers: Vec<f32> = (0..self.emitters.len() as u32)
            .map(|i| emitter::power(&self.tables(), i))
            .collect();
        emitter::fill_selection(&mut self.emitters, &powers);
    }

    /// The nearest intersection, by trying everything.
    pub fn closest_hit(&self, ray: &Ray) -> Hit {
        brute_force::closest_hit(&self.tables(), ray)
    }
}

/// Places a camera.
pub fn place(camera: &mut Camera, to_world: Affine3A) {
    camera.to_world = rows(to_world);
    camera.to_camera = rows(to_world.inverse());
}
