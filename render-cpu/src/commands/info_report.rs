//! What `halflight info` finds in a scene, as numbers and names.

use super::info_cost::Cost;
use crate::accel::Accel;
use crate::render::record::sampler_name;
use crate::scene::build::{Scene, all_sensors};
use crate::scene::xml::{ObjectKind, ParsedScene};
use halflight_kernel::scene::{camera_kind, emitter_kind, lobe_kind};
use serde::Serialize;

/// A name and how often it occurs.
#[derive(Debug, Serialize)]
pub(super) struct Count {
    pub name: String,
    pub count: usize,
}

/// A parameter of the scene file.
#[derive(Debug, Serialize)]
pub(super) struct Parameter {
    pub name: String,
    pub default: String,
    /// From the command line.
    pub value: Option<String>,
}

/// An object that can be named on the command line.
#[derive(Debug, Serialize)]
pub(super) struct Named {
    pub plugin: String,
    pub id: Option<String>,
}

/// Trees over the scene.
#[derive(Debug, Serialize)]
pub(super) struct Trees {
    pub nodes: usize,
    pub depth: usize,
    pub primitives: usize,
    pub skipped: usize,
    pub bytes: usize,
    pub seconds: f64,
}

/// All of it.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub scene: String,
    pub camera: &'static str,
    pub size: [u32; 2],
    pub crop_offset: [u32; 2],
    pub crop_size: [u32; 2],
    pub integrator: String,
    pub samples_per_pixel: u32,
    pub sampler: &'static str,
    /// As the scene file has it.
    pub sampler_name: String,
    pub seed: u32,
    pub parameters: Vec<Parameter>,
    pub sensors: Vec<Named>,
    pub bsdfs: Vec<Named>,
    pub center: [f32; 3],
    pub radius: f32,
    pub shapes: usize,
    pub triangles: usize,
    pub vertices: usize,
    pub analytic: usize,
    pub groups: usize,
    pub instances: usize,
    pub materials: usize,
    pub lobes: Vec<Count>,
    pub textures: usize,
    pub texel_bytes: usize,
    pub emitters: Vec<Count>,
    pub table_bytes: usize,
    pub plugins: Vec<Count>,
    pub files: Vec<String>,
    pub ray_tracing: Trees,
    pub cost: Cost,
    pub warnings: Vec<String>,
}

impl Report {
    /// Of a scene with its trees; `defines` are those of the command line.
    pub fn new(
        name: String,
        parsed: &ParsedScene,
        defines: &[(String, String)],
        scene: &Scene,
        accel: &Accel,
        cost: Cost,
    ) -> Report {
        let tables = &scene.tables;
        let camera = &tables.camera;
        let trees = accel.statistics();
        let named = |kind: ObjectKind, with_id: bool| -> Vec<Named> {
            let children = parsed.root.children_of(kind).map(|child| Named {
                plugin: child.object.plugin.clone(),
                id: child.object.id.clone(),
            });
            children.filter(|n| !with_id || n.id.is_some()).collect()
        };
        let given = |name: &str| {
            let define = defines.iter().rev().find(|(known, _)| known == name);
            define.map(|(_, value)| value.clone())
        };
        let parameters = parsed.parameters.iter().map(|p| Parameter {
            name: p.name.clone(),
            default: p.default.clone(),
            value: given(&p.name),
        });
        let plugins = scene.plugins.iter().map(|(name, count)| Count {
            name: name.clone(),
            count: *count,
        });
        Report {
            scene: name,
            camera: match camera.kind {
                camera_kind::THIN_LENS => "thin lens",
                camera_kind::ORTHOGRAPHIC => "orthographic",
                camera_kind::SPHERICAL => "spherical",
                camera_kind::IRRADIANCE_METER => "irradiance meter",
                _ => "perspective",
            },
            size: camera.film_size,
            crop_offset: camera.crop_offset,
            crop_size: camera.crop_size,
            integrator: scene.integrator.clone(),
            samples_per_pixel: scene.spp,
            sampler: sampler_name(scene.sampler),
            sampler_name: scene.sampler_name.clone(),
            seed: scene.seed,
            parameters: parameters.collect(),
            sensors: all_sensors(&parsed.root)
                .into_iter()
                .map(|(sensor, _)| Named {
                    plugin: sensor.plugin.clone(),
                    id: sensor.id.clone(),
                })
                .collect(),
            bsdfs: named(ObjectKind::Bsdf, true),
            center: tables.info.center,
            radius: tables.info.radius,
            shapes: tables.shapes.len(),
            triangles: tables.triangles.len(),
            vertices: tables.positions.len(),
            analytic: tables.quadrics.len(),
            groups: tables.groups.len() - 1,
            instances: tables.instances.len() - 1,
            materials: tables.materials.len(),
            lobes: counts(tables.lobes.iter().map(|lobe| lobe_name(lobe.kind))),
            textures: tables.textures.len(),
            texel_bytes: size_of_val(tables.texels.as_slice()),
            emitters: counts(tables.emitters.iter().map(|e| emitter_name(e.kind))),
            table_bytes: tables.memory_bytes(),
            plugins: plugins.collect(),
            files: parsed
                .files
                .iter()
                .map(|f| f.display().to_string())
                .collect(),
            ray_tracing: Trees {
                nodes: trees.nodes,
                depth: trees.depth,
                primitives: trees.primitives,
                skipped: trees.skipped,
                bytes: trees.bytes,
                seconds: trees.build_time.as_secs_f64(),
            },
            cost,
            warnings: scene.warnings.iter().map(ToString::to_string).collect(),
        }
    }
}

/// Names in the order of their first occurrence.
fn counts(names: impl Iterator<Item = &'static str>) -> Vec<Count> {
    let mut counts: Vec<Count> = Vec::new();
    for name in names {
        match counts.iter_mut().find(|entry| entry.name == name) {
            Some(entry) => entry.count += 1,
            None => counts.push(Count {
                name: name.to_owned(),
                count: 1,
            }),
        }
    }
    counts
}

fn lobe_name(kind: u32) -> &'static str {
    match kind {
        lobe_kind::DIFFUSE => "diffuse",
        lobe_kind::CONDUCTOR => "conductor",
        lobe_kind::ROUGH_CONDUCTOR => "rough conductor",
        lobe_kind::DIELECTRIC => "dielectric",
        lobe_kind::THIN_DIELECTRIC => "thin dielectric",
        lobe_kind::ROUGH_DIELECTRIC => "rough dielectric",
        lobe_kind::PLASTIC => "plastic",
        lobe_kind::ROUGH_PLASTIC => "rough plastic",
        lobe_kind::NULL => "null",
        lobe_kind::COAT => "coat",
        lobe_kind::ROUGH_COAT => "rough coat",
        lobe_kind::MERL => "measured",
        lobe_kind::MEASURED => "measured, adaptive directions",
        lobe_kind::ROUGH_DIFFUSE => "rough diffuse",
        lobe_kind::DIFFRACTING_CONDUCTOR => "diffracting conductor",
        lobe_kind::PHONG => "Phong highlight",
        lobe_kind::WARD => "Ward highlight",
        lobe_kind::DIFFUSE_TRANSMISSION => "diffuse transmission",
        lobe_kind::PRINCIPLED_DIFFUSE => "principled diffuse",
        lobe_kind::SHEEN => "sheen",
        lobe_kind::SCHLICK_REFLECTION => "Schlick reflection",
        lobe_kind::CLEARCOAT => "clear coat",
        lobe_kind::THIN_TRANSMISSION => "thin transmission",
        lobe_kind::HANRAHAN_KRUEGER => "scattering layer",
        _ => "unknown",
    }
}

fn emitter_name(kind: u32) -> &'static str {
    match kind {
        emitter_kind::AREA => "area",
        emitter_kind::POINT => "point",
        emitter_kind::SPOT => "spot",
        emitter_kind::PROJECTOR => "projector",
        emitter_kind::DIRECTIONAL => "directional",
        emitter_kind::CONSTANT => "constant",
        emitter_kind::ENVIRONMENT => "environment",
        emitter_kind::COLLIMATED => "collimated",
        _ => "unknown",
    }
}
