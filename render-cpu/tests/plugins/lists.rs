//! The README names every plugin that scenes may hold, and a scene of ours uses every one that public scenes use beyond the
//! everyday ones.

use crate::scenes;
use halflight::commands::list::Listed;
use halflight::integrators::INTEGRATORS;

#[test]
fn the_readme_names_every_plugin() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md"))
        .expect("the README");
    for listed in [
        Listed::Sensors,
        Listed::Bsdfs,
        Listed::Emitters,
        Listed::Shapes,
        Listed::Textures,
    ] {
        for (name, _) in listed.entries() {
            assert!(readme.contains(&format!("`{name}`")), "{listed:?}: {name}");
        }
    }
    // Among the values of an option or in the text.
    for integrator in INTEGRATORS {
        let name = integrator.name;
        let is_named = ["`", "|", "\\|", " "]
            .iter()
            .any(|end| readme.contains(&format!("{name}{end}")));
        assert!(is_named, "{name}");
    }
}

#[test]
fn a_scene_uses_every_plugin_of_public_scenes() {
    let texts: String = scenes()
        .iter()
        .map(|path| std::fs::read_to_string(path).expect("a scene"))
        .collect();
    for plugin in [
        "phong",
        "sunsky",
        "sky",
        "sun",
        "scale",
        "difftrans",
        "ward",
        "hk",
        "principled",
        "principledthin",
        "irradiancemeter",
        "radiancemeter",
        "collimated",
        "gridtexture",
        "wireframe",
        "vertexcolors",
        "heightfield",
        "spherical",
    ] {
        assert!(texts.contains(&format!("type=\"{plugin}\"")), "{plugin}");
    }
}
