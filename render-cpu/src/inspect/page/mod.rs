//! The inspector: a scene, its image and its recorded paths as one page for a browser, which asks no network for anything.
//!
//! The page is a template ([`TEMPLATE`]), built from the sources in `render-cpu/inspector` and committed with a stamp of them
//! ([`crate::source_stamp`]); the data replace a mark in it. They are a description in JSON and tables of numbers, each the
//! text of an element: little-endian words, deflated, in base64. Browsers decode such tables in a fraction of a second, where
//! numbers as text, or an object for each path, would take many.
//!
//! | table | content |
//! |---|---|
//! | `positions`, `indices` | vertices of the mesh, f32; triangles, u32 |
//! | `image`, `irradiance` | RGB of each pixel, f32 |
//! | `path-pixels`, `path-light`, `path-weights`, `path-counts` | of each path: pixel, 2 u32; light, 3 f32; weight, f32; number of vertices, u8 |
//! | `vertex-kinds`, `vertex-objects`, `vertex-positions`, `vertex-throughputs` | of each vertex: u8, u32, 3 f32, 3 f32 |
//! | `plot-0`, ... | luminance of each cell of a spherical plot, f32 |
//! | `volume` | luminance of the fluence rate of each voxel, x fastest, f32 |

mod albedo;
mod mesh;
mod table;
pub mod thin;

use super::record_file::PathRecord;
use super::spherical_plot::{Probe, SphericalPlot};
use super::volume::LightVolume;
use crate::expression::names;
use crate::film::luminance;
use crate::scene::build::Scene;
use halflight_kernel::scene::{Camera, SceneView, Traverse, camera_kind};
use mesh::FlatMesh;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::io::{self, Write};
use table::write_table;

/// The page without data.
pub const TEMPLATE: &str = include_str!("../../../inspector/dist/inspector.html");

/// Where the data go.
pub const MARK: &str = "<!-- data -->";

/// A page.
pub struct Page<'a> {
    /// What its title says.
    pub title: String,
    /// The scene.
    pub scene: &'a Scene,
    /// Mean of each pixel of the sensor's window.
    pub image: &'a [[f32; 3]],
    /// Where the image comes from.
    pub note: String,
    /// Irradiance at what each pixel sees, if it is known.
    pub irradiance: Option<&'a [[f32; 3]]>,
    /// Paths of the scene.
    pub record: &'a PathRecord,
    /// Spherical plots.
    pub plots: &'a [(Probe, SphericalPlot)],
    /// A box of medium, with the number of its light walks.
    pub volume: Option<(&'a LightVolume, u32)>,
    /// Meshes of more triangles are thinned out.
    pub most_triangles: usize,
}

impl Page<'_> {
    /// Writes the page. `view` is that of the scene.
    ///
    /// # Errors
    /// If the stream does not take it.
    pub fn write<T: Traverse>(
        &self,
        view: &SceneView<'_, T>,
        stream: &mut impl Write,
    ) -> io::Result<()> {
        let (before, after) = TEMPLATE
            .split_once(MARK)
            .ok_or_else(|| io::Error::other("the template of the page has no place for data"))?;
        let whole = FlatMesh::of(&self.scene.tables);
        let colors = albedo::of_shapes(view, &whole);
        let of = whole.indices.len();
        let mesh = thin::thinned(whole, self.most_triangles);
        let description = self.description(&mesh, of, &colors);
        stream.write_all(before.as_bytes())?;
        // A name in the scene must not end the element.
        let text = description.to_string().replace('<', "\\u003c");
        writeln!(
            stream,
            "<script type=\"application/json\" id=\"scene\">{text}</script>"
        )?;
        write_table(stream, "positions", bytemuck::cast_slice(&mesh.positions))?;
        write_table(stream, "indices", bytemuck::cast_slice(&mesh.indices))?;
        write_table(stream, "image", bytemuck::cast_slice(self.image))?;
        if let Some(irradiance) = self.irradiance {
            write_table(stream, "irradiance", bytemuck::cast_slice(irradiance))?;
        }
        self.write_paths(stream)?;
        for (i, (_, plot)) in self.plots.iter().enumerate() {
            let values: Vec<f32> = plot.radiance.iter().map(|p| luminance(*p) as f32).collect();
            write_table(stream, &format!("plot-{i}"), bytemuck::cast_slice(&values))?;
        }
        if let Some((volume, _)) = self.volume {
            let values = volume.luminance();
            write_table(stream, "volume", bytemuck::cast_slice(&values))?;
        }
        stream.write_all(after.as_bytes())
    }

    fn write_paths(&self, stream: &mut impl Write) -> io::Result<()> {
        let paths = &self.record.paths;
        fn column<I, T: bytemuck::NoUninit>(
            stream: &mut impl Write,
            name: &str,
            values: impl Iterator<Item = I>,
            of: impl Fn(I) -> T,
        ) -> io::Result<()> {
            let values: Vec<T> = values.map(of).collect();
            write_table(stream, name, bytemuck::cast_slice(&values))
        }
        column(stream, "path-pixels", paths.iter(), |p| p.pixel)?;
        column(stream, "path-light", paths.iter(), |p| p.light)?;
        column(stream, "path-weights", paths.iter(), |p| p.weight)?;
        column(stream, "path-counts", paths.iter(), |p| {
            p.vertices.len() as u8
        })?;
        let vertices = || paths.iter().flat_map(|p| &p.vertices);
        column(stream, "vertex-kinds", vertices(), |v| v.kind as u8)?;
        column(stream, "vertex-objects", vertices(), |v| v.object)?;
        column(stream, "vertex-positions", vertices(), |v| v.position)?;
        column(stream, "vertex-throughputs", vertices(), |v| v.throughput)
    }

    fn description(&self, mesh: &FlatMesh, of: usize, colors: &[[f32; 3]]) -> Value {
        let tables = &self.scene.tables;
        let names = &self.scene.names;
        let camera = &tables.camera;
        let view = tables.view();
        let material =
            |shape: usize| names::name(&names.materials, tables.shapes[shape].material as usize);
        let shapes: Vec<Value> = (0..tables.shapes.len())
            .map(|i| {
                let is_light = (tables.shapes[i].emitter as usize) < tables.emitters.len();
                json!({"material": material(i), "color": colors[i], "is_light": is_light})
            })
            .collect();
        let emitters: Vec<Value> = (tables.emitters.iter())
            .map(|e| {
                let object = names::object_of_emitter(names, e.shape);
                json!({"object": object, "kind": names::light_letter(e.kind)})
            })
            .collect();
        let mut regions = Map::new();
        for name in names
            .shapes
            .iter()
            .filter(|n| !n.is_empty())
            .collect::<BTreeSet<_>>()
        {
            if let Some(region) = names::region(&view, names, name) {
                let value = json!({"kind": region.kind, "to_unit": region.to_unit});
                regions.insert(name.clone(), value);
            }
        }
        let header = &self.record.header;
        let plots: Vec<Value> = (self.plots.iter())
            .map(|(probe, plot)| {
                let frame = [probe.frame.s, probe.frame.t, probe.frame.n].map(|v| v.to_array());
                json!({
                    "position": probe.position.to_array(),
                    "frame": frame,
                    "is_on_surface": probe.is_on_surface,
                    "rows": plot.size[0],
                    "columns": plot.size[1],
                    "integral": plot.integral(),
                })
            })
            .collect();
        let volume = self.volume.map(|(volume, walks)| {
            let (grid, values) = (&volume.grid, volume.luminance());
            let sum: f64 = values.iter().map(|v| f64::from(*v)).sum();
            json!({
                "low": grid.low.to_array(),
                "high": grid.high.to_array(),
                "voxels": grid.counts,
                "walks": walks,
                "mean": sum / values.len() as f64,
            })
        });
        json!({
            "title": self.title,
            "center": tables.info.center,
            "radius": tables.info.radius,
            "image": {
                "size": camera.crop_size,
                "offset": camera.crop_offset,
                "film": camera.film_size,
                "has_irradiance": self.irradiance.is_some(),
                "note": self.note,
            },
            "camera": camera_json(camera),
            "names": {
                "shapes": names.shapes,
                "instances": names.instances,
                "materials": names.materials,
                "emitters": names.emitters,
            },
            "shapes": shapes,
            "emitters": emitters,
            "regions": regions,
            "ranges": mesh.ranges,
            "mesh": {"triangles": mesh.indices.len(), "of": of},
            "record": {
                "count": header.count,
                "found": header.found,
                "luminance": header.luminance,
                "samples": header.samples,
                "expression": header.expression,
            },
            "plots": plots,
            "volume": volume,
        })
    }
}

fn camera_json(camera: &Camera) -> Value {
    let kind = match camera.kind {
        camera_kind::PERSPECTIVE | camera_kind::THIN_LENS => "perspective",
        camera_kind::ORTHOGRAPHIC => "orthographic",
        _ => "other",
    };
    json!({
        "kind": kind,
        "to_world": camera.to_world,
        "tangents": [camera.tan_half_width, camera.tan_half_height],
    })
}
