//! The README names every plugin that scenes may hold, and a scene of ours uses every one that public scenes use beyond the
//! everyday ones.

use crate::scenes;
use halflight::commands::list::Listed;

#[test]
fn the_readme_names_every_plugin() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md"))
        .expect("the README");
    for listed in [
        Listed::Integrators,
        Listed::Sensors,
        Listed::Bsdfs,
        Listed::Emitters,
        Listed::Shapes,
        Listed::Textures,
    ] {
        for (name, _) in listed.entries() {
            // Those of volumes are path tracing, and need no mention.
            if name.starts_with("volpath") {
                continue;
            }
            let is_named = ["`", "|", "\\|", " "]
                .iter()
                .any(|end| readme.contains(&format!("{name}{end}")));
            assert!(is_named, "{listed:?}: {name}");
        }
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
