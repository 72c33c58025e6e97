//! The algorithms: their plugin names, their kind in the kernel, the driver that takes their samples.
//!
//! One table, from which scene files, the command line, comparisons and lists take what they know of an algorithm.

use halflight_kernel::transport::integrator_kind;

/// How an algorithm's samples are driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A sample is its pixel's alone.
    Pixels,
    /// A sample adds light to other pixels too.
    Splats,
    /// Samples of all pixels are taken in passes over what light walks left.
    Passes,
    /// A sample of all pixels is what a group of Markov chains finds.
    Chains,
}

/// An algorithm.
#[derive(Clone, Copy, Debug)]
pub struct Integrator {
    /// Its plugin name.
    pub name: &'static str,
    /// Other names that mean the same here.
    pub aliases: &'static [&'static str],
    /// What it does.
    pub about: &'static str,
    /// One of [`integrator_kind`].
    pub kind: u32,
    /// The driver of its kind.
    pub shape: Shape,
    /// Whether it estimates all light, so that it can be compared with others.
    pub is_complete: bool,
}

const fn integrator(
    name: &'static str,
    kind: u32,
    shape: Shape,
    about: &'static str,
) -> Integrator {
    Integrator {
        name,
        aliases: &[],
        about,
        kind,
        shape,
        is_complete: true,
    }
}

const fn also(aliases: &'static [&'static str], integrator: Integrator) -> Integrator {
    Integrator {
        aliases,
        ..integrator
    }
}

const fn incomplete(integrator: Integrator) -> Integrator {
    Integrator {
        is_complete: false,
        ..integrator
    }
}

use Shape::{Chains, Passes, Pixels, Splats};
use integrator_kind::*;

/// All algorithms.
pub const INTEGRATORS: &[Integrator] = &[
    also(
        &["volpath", "volpath_simple", "volpathmis"],
        integrator("path", PATH, Pixels, "path tracing"),
    ),
    integrator(
        "mnee",
        MANIFOLD_PATH,
        Pixels,
        "path tracing that connects to lights through glass",
    ),
    incomplete(integrator("direct", DIRECT, Pixels, "direct illumination")),
    incomplete(integrator(
        "ao",
        AMBIENT_OCCLUSION,
        Pixels,
        "ambient occlusion",
    )),
    integrator(
        "ptracer",
        LIGHT_TRACING,
        Splats,
        "path tracing from the lights",
    ),
    integrator("bdpt", BIDIRECTIONAL, Splats, "bidirectional path tracing"),
    integrator(
        "bdmnee",
        MANIFOLD_BIDIRECTIONAL,
        Splats,
        "bidirectional path tracing that connects to lights through glass",
    ),
    integrator(
        "pssmlt",
        PRIMARY_SAMPLE_MLT,
        Chains,
        "Metropolis light transport in the space of random numbers",
    ),
    integrator(
        "mmlt",
        PRIMARY_SAMPLE_MLT,
        Chains,
        "multiplexed Metropolis light transport",
    ),
    integrator(
        "mlt",
        VEACH_MLT,
        Chains,
        "Metropolis light transport in the space of paths",
    ),
    also(
        &["mept"],
        integrator(
            "memlt",
            VEACH_MLT,
            Chains,
            "manifold exploration Metropolis light transport",
        ),
    ),
    integrator(
        "hslt",
        VEACH_MLT,
        Chains,
        "half-vector space light transport",
    ),
    integrator(
        "erpt",
        VEACH_MLT,
        Chains,
        "energy redistribution path tracing",
    ),
    integrator(
        "meerpt",
        VEACH_MLT,
        Chains,
        "energy redistribution path tracing by manifold exploration",
    ),
    also(
        &["ppm"],
        integrator(
            "sppm",
            PROGRESSIVE_PHOTONS,
            Passes,
            "progressive photon mapping",
        ),
    ),
    integrator(
        "mcppm",
        METROPOLIS_PHOTONS,
        Passes,
        "progressive photon mapping with Metropolis photon tracing",
    ),
    integrator(
        "appm",
        ADAPTIVE_PHOTONS,
        Passes,
        "adaptive progressive photon mapping",
    ),
    integrator(
        "vcm",
        VERTEX_MERGING,
        Splats,
        "vertex connection and merging",
    ),
    also(
        &["bpm"],
        integrator(
            "vm",
            VERTEX_MERGING,
            Splats,
            "vertex merging alone (bidirectional photon mapping)",
        ),
    ),
];

/// The algorithm that a plugin name means.
pub fn find(name: &str) -> Option<&'static Integrator> {
    INTEGRATORS
        .iter()
        .find(|i| i.name == name || i.aliases.contains(&name))
}

/// Names for a message.
pub fn names(integrators: impl Iterator<Item = &'static Integrator>) -> String {
    let names: Vec<_> = integrators.map(|i| i.name).collect();
    names.join(", ")
}

/// The driver of a kind of integrator.
pub fn shape(kind: u32) -> Shape {
    INTEGRATORS
        .iter()
        .find(|i| i.kind == kind)
        .map_or(Pixels, |i| i.shape)
}

/// Whether a kind of integrator knows the paths of what it adds, so that path expressions divide its image.
pub fn divides_paths(kind: u32) -> bool {
    [
        PATH,
        BIDIRECTIONAL,
        LIGHT_TRACING,
        PROGRESSIVE_PHOTONS,
        ADAPTIVE_PHOTONS,
        VERTEX_MERGING,
        VEACH_MLT,
        PRIMARY_SAMPLE_MLT,
    ]
    .contains(&kind)
}

/// Whether a kind of integrator renders edits of light transport.
pub fn turns_paths(kind: u32) -> bool {
    [
        PATH,
        BIDIRECTIONAL,
        LIGHT_TRACING,
        PROGRESSIVE_PHOTONS,
        VERTEX_MERGING,
        PRIMARY_SAMPLE_MLT,
        VEACH_MLT,
    ]
    .contains(&kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_kinds_have_one_driver() {
        for (i, a) in INTEGRATORS.iter().enumerate() {
            assert_eq!(find(a.name).map(|i| i.name), Some(a.name));
            assert_eq!(shape(a.kind), a.shape, "{}", a.name);
            for b in &INTEGRATORS[i + 1..] {
                let of = |i: &Integrator| [&[i.name], i.aliases].concat();
                assert!(of(a).iter().all(|name| !of(b).contains(name)), "{}", a.name);
            }
        }
    }
}
