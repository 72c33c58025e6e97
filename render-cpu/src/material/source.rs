//! The BSDF that a name or a file denotes, as XML.
//!
//! A BSDF of a scene file is extracted as text, with the definitions at the top level of that file that it may refer to, and
//! inserted into the preview scene, where it is read as it would be in its own file. Definitions in included files are not
//! found.

use super::examples::EXAMPLES;
use crate::scene::error::{SceneError, suggestion};
use crate::scene::ior;
use crate::scene::xml::read_repaired;
use std::path::{Path, PathBuf};

/// The longest scene file that is looked through.
const MAX_SCENE_BYTES: u64 = 64 << 20;

/// A BSDF as text.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// What to call it.
    pub name: String,
    /// The element, `<bsdf .../>` or `<ref .../>`.
    pub bsdf: String,
    /// Elements that it may refer to.
    pub definitions: String,
    /// Version of the scene format.
    pub version: String,
    /// The file beside which relative files are sought.
    pub file: PathBuf,
}

/// Why there is no BSDF.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The name is no plugin, conductor or file.
    #[error("\"{name}\" is neither a material nor a file{hint}")]
    Unknown {
        /// The name.
        name: String,
        /// What may have been meant.
        hint: String,
    },
    /// The file could not be read.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is no text, or an image.
    #[error("{0}")]
    Text(#[from] SceneError),
    /// The file is no XML.
    #[error("{}: {source}", file.display())]
    Xml {
        /// The file.
        file: PathBuf,
        /// Where and why.
        source: roxmltree::Error,
    },
    /// The file holds no such BSDF.
    #[error("{}: no bsdf{}", file.display(), id.as_ref().map_or(String::new(), |id| format!(" with the id \"{id}\"")))]
    NoBsdf {
        /// The file.
        file: PathBuf,
        /// The id asked for.
        id: Option<String>,
    },
}

/// The BSDF that `name` denotes: a file, an example of the gallery, or a conductor; `id` chooses in a scene file.
///
/// # Errors
/// When there is none.
pub fn find(name: &str, id: Option<&str>) -> Result<Source, SourceError> {
    let path = Path::new(name);
    // What is no scene has no ids.
    let alone = |source: Source| match id {
        None => Ok(source),
        Some(id) => Err(SourceError::NoBsdf {
            file: path.to_owned(),
            id: Some(id.to_owned()),
        }),
    };
    if let Some(example) = EXAMPLES.iter().find(|e| e.name.eq_ignore_ascii_case(name)) {
        return alone(inline(example.name, example.bsdf));
    }
    if path.is_file() {
        let has_extension = |wanted: &str| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(wanted))
        };
        return if has_extension("binary") {
            alone(measured(path, "merl")?)
        } else if has_extension("bsdf") {
            alone(measured(path, "measured")?)
        } else {
            scene_bsdf(path, id)
        };
    }
    if ior::conductor(name).is_some() {
        let bsdf = format!(
            "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"{}\"/></bsdf>",
            escaped(name)
        );
        return alone(inline(name, &bsdf));
    }
    let known = EXAMPLES
        .iter()
        .map(|e| e.name)
        .chain(ior::conductor_names());
    let hint = match suggestion(name, known) {
        Some(near) => format!(", did you mean \"{near}\"?"),
        None => String::new(),
    };
    Err(SourceError::Unknown {
        name: name.to_owned(),
        hint,
    })
}

/// A BSDF that refers to nothing.
pub(super) fn inline(name: &str, bsdf: &str) -> Source {
    Source {
        name: name.to_owned(),
        bsdf: bsdf.to_owned(),
        definitions: String::new(),
        version: "3.0.0".to_owned(),
        file: PathBuf::from("material.xml"),
    }
}

/// A file of measured reflectance, for a plugin.
fn measured(path: &Path, plugin: &str) -> Result<Source, SourceError> {
    let absolute = path.canonicalize().map_err(|source| SourceError::Io {
        file: path.to_owned(),
        source,
    })?;
    let bsdf = format!(
        "<bsdf type=\"{plugin}\"><string name=\"filename\" value=\"{}\"/></bsdf>",
        escaped(&absolute.to_string_lossy())
    );
    Ok(inline(&file_name(path), &bsdf))
}

/// A BSDF of a scene file: the one with the id, or the first.
fn scene_bsdf(path: &Path, id: Option<&str>) -> Result<Source, SourceError> {
    let text = read_repaired(path, MAX_SCENE_BYTES)?;
    let document = roxmltree::Document::parse(&text).map_err(|source| SourceError::Xml {
        file: path.to_owned(),
        source,
    })?;
    let root = document.root_element();
    let chosen = root
        .descendants()
        .find(|node| {
            node.has_tag_name("bsdf") && id.is_none_or(|id| node.attribute("id") == Some(id))
        })
        .ok_or_else(|| SourceError::NoBsdf {
            file: path.to_owned(),
            id: id.map(str::to_owned),
        })?;
    let is_top_level = chosen.parent() == Some(root);
    let mut definitions = String::new();
    for node in root.children().filter(roxmltree::Node::is_element) {
        let tag = node.tag_name().name();
        if matches!(tag, "default" | "bsdf" | "texture" | "spectrum" | "alias")
            && (node != chosen || node.has_attribute("id"))
        {
            definitions.push_str(&text[node.range()]);
            definitions.push('\n');
        }
    }
    let bsdf = match chosen.attribute("id") {
        Some(id) if is_top_level => format!("<ref id=\"{}\"/>", escaped(id)),
        _ => text[chosen.range()].to_owned(),
    };
    let name = chosen
        .attribute("id")
        .or(chosen.attribute("type"))
        .unwrap_or("bsdf");
    Ok(Source {
        name: format!("{name} of {}", file_name(path)),
        bsdf,
        definitions,
        version: root.attribute("version").unwrap_or("3.0.0").to_owned(),
        file: path.to_owned(),
    })
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// `text` as the value of an attribute.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}
