//! The command `halflight` as its users meet it: exit codes, files, messages.

mod bad_input;
mod chains;
mod comparing;
mod going_on;
mod images;
mod interruption;
mod looking;
mod lost_lines;
mod materials;
mod outputs;
mod paths;
mod previews;
mod rendering;
#[path = "../common/room.rs"]
mod room;
#[path = "../common/skip.rs"]
mod skip;
mod viewers;
mod wrong_values;

use room::room;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A small room with a light, a glossy floor and a glass ball.
pub const SCENE: &str = room!(
    settings: r#"<default name="spp" value="4"/>
    <integrator type="path"><integer name="max_depth" value="8"/></integrator>"#,
    sensor: r#"<sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>"#,
    width: "24",
    height: "16",
    ball: "dielectric"
);

/// A folder with the scene in it, and the command run there.
pub struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// A new folder with the scene in it.
    pub fn with_scene() -> Place {
        let place = Place {
            folder: tempfile::tempdir().expect("a temporary folder"),
        };
        place.write("scene.xml", SCENE);
        place
    }

    /// A file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file in it.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("a writable folder");
    }

    /// The command, to be run in it.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
        command.args(arguments).current_dir(self.folder.path());
        // Whoever runs the tests may have Ctrl-C ignored, which the command would respect.
        #[cfg(unix)]
        // SAFETY: setting the default action of a signal is allowed between fork and exec.
        unsafe {
            use std::os::unix::process::CommandExt;
            command.pre_exec(|| {
                libc::signal(libc::SIGINT, libc::SIG_DFL);
                Ok(())
            });
        }
        command
    }

    /// Runs the command.
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the command runs")
    }

    /// Runs and insists on success; returns standard output.
    pub fn succeed(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(
            output.status.success(),
            "{arguments:?} failed: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).expect("text")
    }

    /// All channels of an EXR, bit for bit.
    pub fn channels(&self, name: &str) -> Vec<(String, Vec<u32>)> {
        read(&self.path(name))
            .channels
            .into_iter()
            .map(|(name, values)| (name, values.into_iter().map(f32::to_bits).collect()))
            .collect()
    }

    /// The names of all files in the folder.
    pub fn files(&self) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(self.folder.path())
            .expect("a folder")
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }
}

/// Reads an image.
pub fn read(path: &Path) -> halflight::image::ExrImage {
    halflight::image::read_exr(path).expect("an image")
}
