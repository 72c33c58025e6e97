//! Shapes: meshes and analytic surfaces into the geometry tables, groups and their instances.

mod analytic;
mod heightfield;
mod library;
mod load;
mod placement;
mod surfaces;

use super::builder::{Builder, name_last, name_of};
use super::texture::MeshAttributes;
use crate::accel::GroupRange;
use crate::mesh::Mesh;
use crate::scene::error::SceneError;
use crate::scene::transform::{self, TransformError};
use crate::scene::xml::{Object, ObjectKind};
use glam::DMat4;
use halflight_kernel::scene::emitter::fill_shape_areas;
use halflight_kernel::scene::{
    Instance, NONE, Quadric, Shape, Triangle, emitter_kind, material_flag, quadric_kind,
    scene_flag, shape_flag,
};
use placement::{append, mean_edge, transform_mesh};
use std::sync::Arc;

/// Deeper nesting of groups is a mistake.
const MAX_GROUP_DEPTH: usize = 8;

impl Builder {
    /// All shapes below the scene, then the groups that their instances place.
    pub(super) fn add_shapes(&mut self, root: &Object) -> Result<(), SceneError> {
        let mut placed = Vec::new();
        for child in root.children_of(ObjectKind::Shape) {
            self.add_shape(child.object, true, 0, &mut placed)?;
        }
        self.tables.groups[0] = GroupRange {
            triangles: 0..self.tables.triangles.len() as u32,
            quadrics: 0..self.tables.quadrics.len() as u32,
        };
        self.tables
            .instances
            .push(instance(DMat4::IDENTITY, 0, root)?);
        for (object, group_object) in placed {
            let to_world = object.get_transform("to_world")?;
            if transform::inverse(&to_world) == Err(TransformError::Singular) {
                object.property_warn("to_world", "flattens the instance; it is left out")?;
                group_object.ignore();
                continue;
            }
            let group = self.group(&group_object)?;
            self.tables
                .instances
                .push(instance(to_world, group, &object)?);
            let count = self.tables.instances.len();
            name_last(&mut self.names.instances, count, &name_of(&object));
        }
        self.pass_over_groups(root)?;
        if self
            .tables
            .materials
            .iter()
            .any(|m| m.flags & material_flag::HAS_NULL != 0)
        {
            self.tables.info.flags |= scene_flag::HAS_NULL;
        }
        Ok(())
    }

    /// Groups that no instance places are definitions that nothing uses, or, without an id, that nothing can use.
    fn pass_over_groups(&self, root: &Object) -> Result<(), SceneError> {
        for child in root.children_of(ObjectKind::Shape) {
            let group = child.object;
            if group.plugin == "shapegroup" && !self.groups.contains_key(&group.index) {
                group.ignore();
                if group.id.is_none() {
                    group.warn("no instance can place a group without an id; it is left out")?;
                }
            }
        }
        Ok(())
    }

    /// The index of a shape group, built at its first instance.
    fn group(&mut self, object: &Arc<Object>) -> Result<u32, SceneError> {
        if let Some(&index) = self.groups.get(&object.index) {
            return Ok(index);
        }
        object.touch();
        let first = (
            self.tables.triangles.len() as u32,
            self.tables.quadrics.len() as u32,
        );
        let mut nested = Vec::new();
        for child in object.children_of(ObjectKind::Shape) {
            self.add_shape(child.object, false, 1, &mut nested)?;
        }
        if !nested.is_empty() {
            return Err(object.error("instances cannot be nested in a shape group"));
        }
        let index = self.tables.groups.len() as u32;
        self.tables.groups.push(GroupRange {
            triangles: first.0..self.tables.triangles.len() as u32,
            quadrics: first.1..self.tables.quadrics.len() as u32,
        });
        self.groups.insert(object.index, index);
        Ok(index)
    }

    fn add_shape(
        &mut self,
        object: &Arc<Object>,
        in_world: bool,
        depth: usize,
        placed: &mut Vec<(Arc<Object>, Arc<Object>)>,
    ) -> Result<(), SceneError> {
        if depth > MAX_GROUP_DEPTH {
            return Err(object.error("shapes are nested too deeply"));
        }
        match object.plugin.as_str() {
            // Built where it is placed.
            "shapegroup" => object.touch(),
            "instance" => {
                let group = object
                    .single_child_of(ObjectKind::Shape)?
                    .filter(|child| child.plugin == "shapegroup")
                    .ok_or_else(|| object.error("needs a reference to a shape group"))?
                    .clone();
                placed.push((object.clone(), group));
            }
            "merge" => {
                object.touch();
                for child in object.children_of(ObjectKind::Shape) {
                    self.add_shape(child.object, in_world, depth + 1, placed)?;
                }
            }
            "obj" | "ply" | "serialized" => {
                let to_world = object.get_transform("to_world")?;
                let mesh = load::mesh(object)?;
                if mesh.triangles.is_empty() {
                    object.ignore();
                    return Ok(());
                }
                for (part, bsdf) in surfaces::parts(object, mesh, &mut self.libraries_read)? {
                    self.add_mesh(object, part, bsdf, to_world, in_world)?;
                }
            }
            "rectangle" | "cube" => {
                let to_world = object.get_transform("to_world")?;
                let mesh = if object.plugin == "cube" {
                    analytic::cube(to_world)
                } else {
                    analytic::rectangle(to_world)
                };
                let bsdf = surfaces::only(object)?;
                self.add_mesh(object, mesh, bsdf, to_world, in_world)?;
            }
            "heightfield" => {
                let to_world = object.get_transform("to_world")?;
                let mesh = heightfield::mesh(object)?;
                let bsdf = surfaces::only(object)?;
                self.add_mesh(object, mesh, bsdf, to_world, in_world)?;
            }
            "sphere" | "disk" | "cylinder" => {
                let Some((kind, to_world)) = analytic::quadric(object)? else {
                    object.ignore();
                    return Ok(());
                };
                self.add_quadric(object, kind, to_world, in_world)?;
            }
            other => object.warn(format!(
                "shapes of type \"{other}\" are not supported; it is left out"
            ))?,
        }
        Ok(())
    }

    /// Appends a mesh under a transform.
    fn add_mesh(
        &mut self,
        object: &Arc<Object>,
        mut mesh: Mesh,
        bsdf: Option<Arc<Object>>,
        to_world: DMat4,
        in_world: bool,
    ) -> Result<(), SceneError> {
        let overflow =
            || object.error("the scene has more vertices or triangles than 32-bit indices reach");
        let tables = &mut self.tables;
        let first_vertex = u32::try_from(tables.positions.len()).map_err(|_| overflow())?;
        let first_triangle = u32::try_from(tables.triangles.len()).map_err(|_| overflow())?;
        u32::try_from(tables.positions.len() + mesh.positions.len()).map_err(|_| overflow())?;
        u32::try_from(tables.triangles.len() + mesh.triangles.len()).map_err(|_| overflow())?;

        transform_mesh(object, &mut mesh, to_world)?;
        if mesh.triangles.is_empty() {
            object.ignore();
            return Ok(());
        }
        append(&mut tables.positions, &mut mesh.positions);
        let mut normal_offset = NONE;
        if !mesh.normals.is_empty() {
            normal_offset = (tables.normals.len() as u32).wrapping_sub(first_vertex);
            append(&mut tables.normals, &mut mesh.normals);
        }
        let mut uv_offset = NONE;
        if !mesh.uvs.is_empty() {
            uv_offset = (tables.uvs.len() as u32).wrapping_sub(first_vertex);
            append(&mut tables.uvs, &mut mesh.uvs);
        }
        let shape = tables.shapes.len() as u32;
        tables
            .triangles
            .extend(mesh.triangles.iter().map(|t| Triangle {
                vertices: t.map(|i| i + first_vertex),
                shape,
            }));

        let mut attributes = MeshAttributes {
            first_vertex,
            first_triangle,
            mean_edge: mean_edge(
                &tables.positions,
                &tables.triangles[first_triangle as usize..],
            ),
            ..MeshAttributes::default()
        };
        for (list, into) in [
            (&mesh.vertex_attributes, &mut attributes.vertex),
            (&mesh.face_attributes, &mut attributes.face),
        ] {
            for attribute in list {
                let word = u32::try_from(tables.data.len()).map_err(|_| overflow())?;
                tables.data.extend_from_slice(&attribute.values);
                into.push((attribute.name.clone(), word, attribute.channels));
            }
        }
        let mut flags = self.shape_flags(object)?;
        if mesh.face_normals {
            flags |= shape_flag::FACE_NORMALS;
        }
        self.push_shape(
            object,
            Shape {
                material: 0,
                emitter: NONE,
                flags,
                normal_offset,
                uv_offset,
                first_vertex,
                first_primitive: first_triangle,
                primitive_count: mesh.triangles.len() as u32,
            },
            Some(&attributes),
            bsdf,
            in_world,
        )
    }

    fn add_quadric(
        &mut self,
        object: &Arc<Object>,
        kind: u32,
        to_world: DMat4,
        in_world: bool,
    ) -> Result<(), SceneError> {
        let placed = to_world;
        let (to_world, to_object) = transform::rows_and_inverse(&to_world)
            .map_err(|e| object.property_error("to_world", e.to_string()))?;
        let quadric = self.tables.quadrics.len() as u32;
        self.tables.quadrics.push(Quadric {
            to_world,
            to_object,
            kind,
            shape: self.tables.shapes.len() as u32,
        });
        let mut flags = self.shape_flags(object)?;
        // A mirrored sphere keeps its outside outside; Mitsuba turns it inside out, and files rely on that.
        if kind == quadric_kind::SPHERE && transform::flips_orientation(&placed) {
            flags ^= shape_flag::FLIP_NORMALS;
        }
        self.push_shape(
            object,
            Shape {
                material: 0,
                emitter: NONE,
                flags,
                normal_offset: NONE,
                uv_offset: NONE,
                first_vertex: 0,
                first_primitive: quadric,
                primitive_count: 1,
            },
            None,
            surfaces::only(object)?,
            in_world,
        )
    }

    fn shape_flags(&self, object: &Object) -> Result<u32, SceneError> {
        Ok(if object.get_bool("flip_normals", false)? {
            shape_flag::FLIP_NORMALS
        } else {
            0
        })
    }

    /// Adds the record with its material and its emission.
    fn push_shape(
        &mut self,
        object: &Arc<Object>,
        mut shape: Shape,
        attributes: Option<&MeshAttributes>,
        bsdf: Option<Arc<Object>>,
        in_world: bool,
    ) -> Result<(), SceneError> {
        let mut emission = object.single_child_of(ObjectKind::Emitter)?.cloned();
        if let Some(other) = emission.take_if(|emission| emission.plugin != "area") {
            other.ignore();
            other.warn("only an \"area\" emitter can be part of a shape; it is left out")?;
        }
        let meters = object.children_of(ObjectKind::Sensor);
        let is_meter = meters
            .filter(|m| Some(m.object.index) == self.meter)
            .count()
            > 0;
        shape.material = match surfaces::is_index_matched(object, bsdf.as_ref())? {
            true => self.null_material(),
            false => self.material(bsdf.as_ref(), emission.is_some(), attributes)?,
        };
        let index = self.tables.shapes.len() as u32;
        if let Some(emission) = emission {
            if in_world {
                shape.emitter = self.tables.emitters.len() as u32;
            } else {
                emission.warn("shapes in a group cannot emit light; the emitter is left out")?;
            }
            self.tables.shapes.push(shape);
            self.name_last_shape(object);
            if in_world {
                self.add_area_emitter(&emission, index, attributes)?;
                debug_assert_eq!(
                    self.tables.emitters[shape.emitter as usize].kind,
                    emitter_kind::AREA
                );
            }
        } else {
            self.tables.shapes.push(shape);
            self.name_last_shape(object);
        }
        if is_meter {
            self.measure_irradiance_on(object, index, in_world)?;
        }
        Ok(())
    }

    /// Makes a shape, which is in the table already, the surface of the sensor.
    fn measure_irradiance_on(
        &mut self,
        object: &Object,
        shape: u32,
        in_world: bool,
    ) -> Result<(), SceneError> {
        if !in_world {
            return Err(object.error("a shape in a group cannot be an irradiance meter"));
        }
        if self.tables.camera.shape != NONE {
            return object.warn("only the first of its parts is the irradiance meter");
        }
        let count = self.tables.shapes[shape as usize].primitive_count as usize;
        let mut areas = vec![0.0; count];
        if !(fill_shape_areas(&self.tables.view(), shape, &mut areas) > 0.0) {
            return Err(object.error("an irradiance meter needs an area"));
        }
        self.tables.camera.shape = shape;
        self.tables.camera.shape_areas = self.tables.data.len() as u32;
        self.tables.data.extend_from_slice(&areas);
        Ok(())
    }

    fn name_last_shape(&mut self, object: &Object) {
        name_last(
            &mut self.names.shapes,
            self.tables.shapes.len(),
            &name_of(object),
        );
    }
}

/// An instance record of a group.
fn instance(to_world: DMat4, group: u32, object: &Object) -> Result<Instance, SceneError> {
    let (to_world, to_object) = transform::rows_and_inverse(&to_world)
        .map_err(|e| object.property_error("to_world", e.to_string()))?;
    Ok(Instance {
        to_world,
        to_object,
        root: 0,
        group,
    })
}
