//! One image by many tasks: division, interruptions, torn files, merges.

mod division;
mod failures;

use halflight::farm::folder::Folder;
use halflight::farm::plan::{Division, Plan, PlannedScene, Request};
use halflight::farm::task::{TaskOutcome, run_task};
use halflight::film::aov::{Aov, AovSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A sphere on a floor under a bright square.
pub const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="5"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="45"/>
        <transform name="to_world"><lookat origin="0, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="21"/></sampler>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.4, 0.3, 0.2"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="0" y="0.8" z="0"/><float name="radius" value="0.7"/>
        <bsdf type="conductor"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
        <emitter type="area"><rgb name="radiance" value="9, 8, 7"/></emitter>
    </shape>
</scene>
"#;

/// A folder with the scene in it, and a farm.
pub struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// A new folder with the scene in it.
    pub fn with_scene() -> Place {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("scene.xml"), SCENE).expect("a writable folder");
        Place { folder }
    }

    /// A file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The scene.
    pub fn scene(&self) -> PlannedScene {
        PlannedScene {
            file: self.path("scene.xml"),
            ..PlannedScene::default()
        }
    }

    /// What is asked for.
    pub fn request(&self, tasks: u32) -> Request {
        Request {
            output: self.path("out.exr"),
            tasks,
            spp: None,
            seed: Some(5),
            division: Division::Samples,
            layers: AovSet::NONE.with(Aov::Variance).with(Aov::Normal),
            fan_in: 3,
        }
    }

    /// A planned farm.
    pub fn farm(&self, request: &Request) -> (Folder, Plan) {
        let plan = Plan::new(self.scene(), request).expect("a plan");
        let folder = Folder::of_output(&plan.output);
        folder.create(&plan).expect("a folder");
        assert_eq!(folder.plan().expect("the plan"), plan);
        (folder, plan)
    }
}

/// Renders a task to its end.
pub fn render(folder: &Folder, plan: &Plan, index: u32) -> TaskOutcome {
    let never = AtomicBool::new(false);
    run_task(folder, plan, index, Duration::from_secs(30), &never).expect("a task")
}

/// The channels of an image file.
pub fn channels(path: &Path) -> Vec<(String, Vec<f32>)> {
    halflight::image::read_exr(path).expect("an image").channels
}
