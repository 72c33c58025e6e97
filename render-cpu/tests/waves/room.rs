//! A room with things in it, of which each test changes a few.

use crate::files::Files;
use crate::samples::{agrees, scene};
use halflight::scene::build::Scene;

/// Parts of a scene file.
#[derive(Clone)]
pub struct Room {
    pub integrator: String,
    /// Of the sensor: its plugin, what it holds and what its film holds.
    pub sensor: [String; 3],
    /// Of the floor and the wall.
    pub walls: String,
    /// Of a cube, of a ball with shading normals and of an ellipsoid.
    pub material: String,
    pub emitters: String,
    /// More shapes, and definitions.
    pub shapes: String,
    /// The share of samples that is lit at least.
    pub least: f32,
}

/// A triangle mesh above.
pub const LAMP: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.7"/>
    <rotate x="1" angle="90"/><translate y="1.9" z="0.4"/></transform>
    <emitter type="area"><rgb name="radiance" value="8, 7, 5"/></emitter></shape>"#;

/// A point light beside the camera.
pub const POINT: &str = r#"<emitter type="point"><point name="position" x="1" y="1.2" z="2.5"/>
    <rgb name="intensity" value="2, 3, 4"/></emitter>"#;

/// Light from everywhere.
pub const CONSTANT: &str =
    r#"<emitter type="constant"><rgb name="radiance" value="0.3, 0.4, 0.5"/></emitter>"#;

impl Room {
    /// Grey walls, a lamp and a point light; a material is missing.
    pub fn new() -> Room {
        Room {
            integrator: path(r#"<integer name="max_depth" value="8"/>"#),
            sensor: [
                "perspective".into(),
                r#"<float name="fov" value="55"/>"#.into(),
                String::new(),
            ],
            walls: r#"<bsdf type="diffuse"/>"#.into(),
            material: r#"<bsdf type="diffuse"/>"#.into(),
            emitters: format!("{LAMP}{POINT}"),
            shapes: String::new(),
            least: 0.4,
        }
    }

    /// The room with things of a material.
    pub fn with_material(material: &str) -> Room {
        Room {
            material: material.into(),
            ..Room::new()
        }
    }

    /// The scene file.
    pub fn text(&self) -> String {
        let [sensor, inside, film] = &self.sensor;
        let (walls, material) = (&self.walls, &self.material);
        format!(
            r#"<scene version="3.0.0">{}
            <sensor type="{sensor}">{inside}
                <transform name="to_world"><lookat origin="0, 0.6, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
                <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/>{film}</film>
            </sensor>
            <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/>
                <translate y="-1"/></transform>{walls}</shape>
            <shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-2"/></transform>
                {walls}</shape>
            <shape type="cube"><transform name="to_world"><scale x="0.6" y="0.9" z="0.6"/><rotate y="1" angle="25"/>
                <translate x="-0.9" y="-0.1"/></transform>{material}</shape>
            <shape type="obj"><string name="filename" value="ball.obj"/><transform name="to_world">
                <scale value="0.8"/><translate x="0.9" y="-0.2" z="0.3"/></transform>{material}</shape>
            <shape type="sphere"><transform name="to_world"><scale x="0.3" y="0.4" z="0.25"/>
                <rotate x="1" y="2" z="-1" angle="40"/><translate x="0.1" y="-0.5" z="1.1"/></transform>{material}</shape>
            {}{}</scene>"#,
            self.integrator, self.shapes, self.emitters
        )
    }

    /// The tables.
    pub fn build(&self, files: &Files) -> Scene {
        // Not strict: images of skies are reflectances here, which is warned of.
        scene(&self.text(), files.folder(), false)
    }

    /// Compares all samples, of which enough must be lit.
    pub fn agrees(&self, files: &Files) {
        let share = self.lit_share(files);
        assert!(
            share >= self.least,
            "{share} of the samples are lit: {}",
            self.text()
        );
    }

    /// Compares all samples; returns the share that is lit.
    pub fn lit_share(&self, files: &Files) -> f32 {
        agrees(&self.build(files), &self.text())
    }
}

/// A path tracer with parameters.
pub fn path(parameters: &str) -> String {
    format!(r#"<integrator type="path">{parameters}</integrator>"#)
}
