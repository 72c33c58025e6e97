//! Which options of `halflight inspect` belong to which tools: those of another tool change nothing, and are refused.

use super::inspect_args::{InspectArgs, Quantity, Tool};
use crate::scene::build::Scene;
use crate::scene::edits::SceneEdits;
use clap::ArgMatches;
use clap::parser::ValueSource;

/// What an option belongs to.
struct OwnOption {
    /// Its name on the command line, and in what clap has read.
    names: [&'static str; 2],
    tools: &'static [Tool],
    /// Whether it is of the page for a browser too.
    is_of_page: bool,
}

const fn option(
    name: &'static str,
    id: &'static str,
    tools: &'static [Tool],
    is_of_page: bool,
) -> OwnOption {
    OwnOption {
        names: [name, id],
        tools,
        is_of_page,
    }
}

const SCALES: &[Tool] = &[Tool::FalseColor, Tool::SphericalPlot];
const ALL: &[Tool] = &[
    Tool::FalseColor,
    Tool::SphericalPlot,
    Tool::Paths,
    Tool::Volume,
];

const OPTIONS: &[OwnOption] = &[
    option("--quantity", "quantity", &[Tool::FalseColor], false),
    option("--log", "log", SCALES, false),
    option("--min", "min", SCALES, false),
    option("--max", "max", SCALES, false),
    option("--at", "at", &[Tool::SphericalPlot], true),
    option("--pixel", "pixel", &[Tool::SphericalPlot], true),
    option("--rows", "rows", &[Tool::SphericalPlot], true),
    option("--view", "view", &[Tool::SphericalPlot], false),
    option("--paths", "paths", &[Tool::Paths], true),
    option("--record-count", "record_count", &[Tool::Paths], true),
    option("--pixels", "pixels", &[Tool::Paths], true),
    option("--cluster", "cluster", &[Tool::Paths], false),
    option("--from", "from", &[Tool::Paths], false),
    option("--bundles", "bundles", &[Tool::Paths], false),
    option("--box", "bounds", &[Tool::Volume], true),
    option("--voxels", "voxels", &[Tool::Volume], true),
    option("--walks", "walks", &[Tool::Volume], true),
    option("--scattering", "scattering", &[Tool::Volume], true),
    option("--extinction", "extinction", &[Tool::Volume], true),
    option("--image", "image", &[], true),
    option("--triangles", "triangles", &[], true),
    option("--json", "json", ALL, false),
];

/// Options that change nothing in a page without one of others.
const WITHIN_PAGE: &[(&str, &[&str])] = &[
    ("--rows", &["--at", "--pixel"]),
    ("--voxels", &["--box"]),
    ("--walks", &["--box"]),
    ("--scattering", &["--box"]),
    ("--extinction", &["--box"]),
];

fn name(tool: Tool) -> &'static str {
    match tool {
        Tool::FalseColor => "--tool false-color",
        Tool::SphericalPlot => "--tool spherical-plot",
        Tool::Paths => "--tool paths",
        Tool::Volume => "--tool volume",
    }
}

impl InspectArgs {
    /// Makes sure that what the command line gives is of the tool; `matches` is what clap has read of the command.
    ///
    /// # Errors
    /// The first option that is not, and whose it is.
    pub fn check(&self, matches: &ArgMatches) -> Result<(), String> {
        let is_given = |option: &OwnOption| {
            matches.value_source(option.names[1]) == Some(ValueSource::CommandLine)
        };
        let given: Vec<&OwnOption> = OPTIONS.iter().filter(|o| is_given(o)).collect();
        for option in &given {
            let is_own = match self.tool {
                Some(tool) => option.tools.contains(&tool),
                None => option.is_of_page,
            };
            if is_own {
                continue;
            }
            let tools = option.tools.iter().map(|tool| name(*tool));
            let owners: Vec<&str> = tools.chain(option.is_of_page.then_some("pages")).collect();
            let tool = self.tool.map_or("pages", name);
            return Err(format!(
                "{} is of {}, not of {tool}",
                option.names[0],
                owners.join(", ")
            ));
        }
        if self.tool.is_none() {
            let has = |name: &str| given.iter().any(|o| o.names[0] == name);
            let lost = WITHIN_PAGE
                .iter()
                .find(|(option, needs)| has(option) && !needs.iter().any(|need| has(need)));
            if let Some((option, needs)) = lost {
                let needs = needs.join(" or ");
                return Err(format!("{option} goes with {needs} in a page"));
            }
        }
        let shows_image =
            self.tool == Some(Tool::FalseColor) && self.quantity == Quantity::Radiance;
        let scene = &self.scene;
        if !shows_image && (scene.edit.is_some() || scene.edit_time.is_some()) {
            let what = self.tool.map_or("a page shows", |_| "this tool looks at");
            return Err(format!(
                "--edit: {what} light as it is; edited images are shown by --tool false-color with --quantity radiance"
            ));
        }
        Ok(())
    }

    /// Looks at the light of a scene without the edits that it holds.
    pub(super) fn leave_out_edits(&self, scene: &mut Scene) {
        if !scene.edits.is_empty() {
            let name = self.scene.scene.display();
            tracing::warn!("{name}: light is shown as it is, without the scene's edits");
            scene.edits = SceneEdits::default();
        }
    }
}
