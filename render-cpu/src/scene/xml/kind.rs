//! What objects are: the elements that hold properties.

use std::fmt;

/// What an object is in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The names are those of the elements.
pub enum ObjectKind {
    Scene,
    Integrator,
    Sensor,
    Sampler,
    Film,
    RFilter,
    Shape,
    Bsdf,
    Emitter,
    Texture,
    Medium,
    Phase,
    Volume,
    /// `<spectrum type="...">`.
    Spectrum,
    /// Edits of light transport, which are Halflight's own.
    Edit,
    /// Elements of Mitsuba that Halflight does not support.
    Other,
}

impl ObjectKind {
    /// The kind for the name of an element, those of older versions included.
    pub fn from_element(name: &str) -> Option<ObjectKind> {
        Some(match name {
            "scene" => ObjectKind::Scene,
            "integrator" => ObjectKind::Integrator,
            "sensor" | "camera" => ObjectKind::Sensor,
            "sampler" => ObjectKind::Sampler,
            "film" => ObjectKind::Film,
            "rfilter" => ObjectKind::RFilter,
            "shape" => ObjectKind::Shape,
            "bsdf" => ObjectKind::Bsdf,
            "emitter" | "luminaire" => ObjectKind::Emitter,
            "texture" => ObjectKind::Texture,
            "medium" => ObjectKind::Medium,
            "phase" => ObjectKind::Phase,
            "volume" => ObjectKind::Volume,
            "spectrum" => ObjectKind::Spectrum,
            "edit" => ObjectKind::Edit,
            "subsurface" | "field" => ObjectKind::Other,
            _ => return None,
        })
    }
    /// The name of the element.
    pub fn element(self) -> &'static str {
        match self {
            ObjectKind::Scene => "scene",
            ObjectKind::Integrator => "integrator",
            ObjectKind::Sensor => "sensor",
            ObjectKind::Sampler => "sampler",
            ObjectKind::Film => "film",
            ObjectKind::RFilter => "rfilter",
            ObjectKind::Shape => "shape",
            ObjectKind::Bsdf => "bsdf",
            ObjectKind::Emitter => "emitter",
            ObjectKind::Texture => "texture",
            ObjectKind::Medium => "medium",
            ObjectKind::Phase => "phase",
            ObjectKind::Volume => "volume",
            ObjectKind::Spectrum => "spectrum",
            ObjectKind::Edit => "edit",
            ObjectKind::Other => "subsurface",
        }
    }
}

impl fmt::Display for ObjectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.element())
    }
}
