//! Small inputs of kinds that people have and that renderers fail at: each gives its right value, and what is left out or
//! replaced is said.
//!
//! Where two ways to say the same must give the same image, their tables are compared, which is exact. Where an image is
//! asked for, its value is known in closed form.

mod files;
mod films;
mod images;
mod integrators;
mod masks;
mod materials;
mod mesh_files;
mod meshes;
mod properties;
mod scalars;
mod texture_values;
mod versions;
mod xml;

use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;

/// A camera before the square [-1, 1]^2 in z = 0, which fills the film.
pub const SENSOR: &str = r#"<sensor type="perspective"><float name="fov" value="28.072486935852958"/>
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film>
    </sensor>"#;

/// A sky of radiance one.
pub const SKY: &str = r#"<emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#;

/// Files of a scene, in a folder of their own.
pub struct Files(tempfile::TempDir);

impl Files {
    /// A folder with the given files.
    pub fn new(files: &[(&str, &[u8])]) -> Files {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes).expect("a file");
        }
        Files(folder)
    }

    /// Loads a scene file of the given bytes.
    pub fn load(&self, bytes: &[u8], strict: bool) -> Result<Scene, String> {
        let path = self.0.path().join("scene.xml");
        std::fs::write(&path, bytes).expect("a scene file");
        let parsed = parse_scene(&path, &[], strict).map_err(|error| error.to_string())?;
        build_scene(&parsed, &BuildOptions::default()).map_err(|error| error.to_string())
    }

    /// Loads content beside camera and sky.
    pub fn scene(&self, version: &str, content: &str) -> Result<Scene, String> {
        self.load(text(version, content).as_bytes(), false)
    }

    /// The tables of content, which must load without a warning.
    #[track_caller]
    pub fn clean(&self, version: &str, content: &str) -> u64 {
        let scene = self
            .load(text(version, content).as_bytes(), true)
            .unwrap_or_else(|error| panic!("{content}: {error}"));
        scene.tables.fingerprint()
    }

    /// The tables of content that gives one warning, which holds the given words and its line; strictly it is an error.
    #[track_caller]
    pub fn warned(&self, version: &str, content: &str, words: &str) -> u64 {
        let text = text(version, content);
        let scene = self
            .load(text.as_bytes(), false)
            .unwrap_or_else(|error| panic!("{content}: {error}"));
        let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings.len(), 1, "{content}: {warnings:?}");
        assert!(warnings[0].contains(words), "{content}: {warnings:?}");
        assert!(warnings[0].contains("scene.xml:"), "{warnings:?}");
        let error = self
            .load(text.as_bytes(), true)
            .expect_err("strictly an error");
        assert!(error.contains(words), "{error}");
        scene.tables.fingerprint()
    }

    /// What is wrong with content.
    #[track_caller]
    pub fn error(&self, version: &str, content: &str) -> String {
        self.scene(version, content).expect_err("an error")
    }
}

/// A scene file.
pub fn text(version: &str, content: &str) -> String {
    format!("<scene version=\"{version}\">\n{SENSOR}\n{SKY}\n{content}\n</scene>")
}

/// The mean of the image.
pub fn mean(scene: &Scene, spp: u32) -> [f64; 3] {
    let options = RenderOptions {
        goal: Goal::Samples(spp),
        seed: 1,
        first_sample: 0,
        adaptive: false,
    };
    let film = render_film(scene, &options, AovSet::NONE).expect("a film");
    let pixels = film.mean();
    let sum = pixels
        .iter()
        .fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + pixel[c]));
    sum.map(|x| x / pixels.len() as f64)
}

/// That the mean of every channel is as expected.
#[track_caller]
pub fn assert_mean(scene: &Scene, spp: u32, expected: f64, tolerance: f64) {
    let mean = mean(scene, spp);
    for value in mean {
        assert!(
            (value - expected).abs() <= tolerance,
            "{mean:?}, not {expected}"
        );
    }
}
