//! A case: a room in which one thing differs.

use crate::agreement::{Algorithms, agree, report};
use crate::matrix::{BLOCK, DIFFUSE, DOWN, WARM, lamp, room};
use crate::scenes::{NamedFile, faceted_sphere, ripples, scene, sky};
use halflight::scene::build::Scene;

/// What a case changes of the room.
pub struct Case<'a> {
    pub name: &'a str,
    pub integrator: &'a str,
    pub sensor: &'a str,
    pub film: &'a str,
    pub lamp: String,
    pub material: &'a str,
    pub object: &'a str,
    pub algorithms: Algorithms,
    pub samples: u32,
}

impl Case<'_> {
    pub fn new(name: &str) -> Case<'_> {
        Case {
            name,
            integrator: "",
            sensor: "",
            film: r#"<rfilter type="box"/>"#,
            lamp: lamp(
                "rectangle",
                &format!(r#"<scale x="0.4" y="0.3"/>{DOWN}"#),
                WARM,
            ),
            material: DIFFUSE,
            object: BLOCK,
            algorithms: Algorithms::All,
            samples: 8,
        }
    }

    pub fn scene(&self) -> Scene {
        let kind = if self.sensor.contains("aperture_radius") {
            "thinlens"
        } else {
            "perspective"
        };
        let depth = if self.integrator.contains("max_depth") {
            ""
        } else {
            r#"<integer name="max_depth" value="5"/>"#
        };
        let text = format!(
            r#"<integrator type="path">{depth}<integer name="rr_depth" value="4"/>{}</integrator>
            <sensor type="{kind}"><float name="fov" value="45"/>{}
            <transform name="to_world"><lookat origin="0.3, 1.3, 3.2" target="-0.1, 0.6, -0.3" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="8"/>{}</film>
            </sensor>{}{}"#,
            self.integrator,
            self.sensor,
            self.film,
            self.lamp,
            room(self.material, self.object)
        );
        let files: [NamedFile<'_>; 3] = [
            ("sky.exr", &sky),
            ("ripples.exr", &ripples),
            ("sphere.obj", &faceted_sphere),
        ];
        scene(&text, &files)
    }

    fn agree(&self) -> Vec<Result<(), String>> {
        agree(self.name, &mut self.scene(), self.algorithms, self.samples)
    }
}

pub fn check<'a>(cases: impl IntoIterator<Item = Case<'a>>) {
    report(cases.into_iter().flat_map(|case| case.agree()));
}

/// A sphere in the middle of the room.
macro_rules! ball {
    ($material:literal) => {
        concat!(
            r#"<shape type="sphere"><point name="center" value="-0.2, 0.55, -0.3"/><float name="radius" value="0.4"/>"#,
            $material,
            "</shape>"
        )
    };
}

/// A sheet under the lamp, out of sight of most pixels.
macro_rules! sheet {
    ($material:literal) => {
        concat!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="0.6"/><rotate x="1" angle="90"/>
            <translate x="0.5" y="1.1" z="-0.8"/></transform>"#,
            $material,
            "</shape>"
        )
    };
}

pub(crate) use {ball, sheet};
