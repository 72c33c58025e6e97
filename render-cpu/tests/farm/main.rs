//! One image by many tasks: division, interruptions, torn files, merges.

mod division;
mod failures;
mod options;
#[path = "../common/room.rs"]
mod room;

use halflight::farm::folder::Folder;
use halflight::farm::plan::{Division, Plan, PlannedScene, Request};
use halflight::farm::task::{TaskOutcome, run_task};
use halflight::film::aov::{Aov, AovSet};
use room::room;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A sphere on a floor under a bright square.
pub const SCENE: &str = room!(
    settings: r#"<integrator type="path"><integer name="max_depth" value="5"/></integrator>"#,
    sensor: r#"<sampler type="independent"><integer name="sample_count" value="21"/></sampler>"#,
    width: "24",
    height: "16",
    ball: "conductor"
);

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
