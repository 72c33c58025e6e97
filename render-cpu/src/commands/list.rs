//! `halflight list`: the names that scene files and command lines may use.

use crate::integrators::INTEGRATORS;
use crate::say::{print, print_line};
use crate::scene::ior::conductor_names;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::io;
use std::process::ExitCode;

/// List the plugins and metals that scenes may name.
#[derive(Args, Clone, Debug)]
pub struct ListArgs {
    /// What to list.
    pub what: Listed,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Kinds of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Listed {
    /// Algorithms.
    Integrators,
    /// Sequences of random numbers.
    Samplers,
    /// Cameras.
    Sensors,
    /// Materials.
    Bsdfs,
    /// Lights.
    Emitters,
    /// Surfaces.
    Shapes,
    /// Images and patterns on surfaces.
    Textures,
    /// Values of `material` of conductors.
    Metals,
}

/// A name and what it stands for.
pub type Entry = (&'static str, &'static str);

const SAMPLERS: &[Entry] = &[
    ("independent", "random numbers"),
    (
        "sobol",
        "Sobol' points, scrambled; for ldsampler, multijitter, stratified, orthogonal, halton and hammersley too",
    ),
];

const SENSORS: &[Entry] = &[
    ("perspective", "a pinhole camera"),
    ("thinlens", "a camera with depth of field"),
    ("orthographic", "a camera of parallel rays"),
    (
        "spherical",
        "all directions, by longitude and latitude; also equirectangular, panoramic and environment",
    ),
    ("radiancemeter", "radiance along one ray"),
    ("irradiancemeter", "irradiance on a shape"),
];

const BSDFS: &[Entry] = &[
    ("diffuse", "Lambert"),
    ("roughdiffuse", "Oren and Nayar"),
    ("conductor", "a smooth metal"),
    ("roughconductor", "a metal of microfacets"),
    ("dielectric", "smooth glass or water"),
    ("thindielectric", "a pane of glass"),
    ("roughdielectric", "frosted glass"),
    ("plastic", "a diffuse base under a smooth dielectric"),
    ("roughplastic", "a diffuse base under a rough dielectric"),
    ("ctd", "a metal whose finer roughness diffracts"),
    ("merl", "measured isotropic reflectance"),
    ("measured", "measured reflectance of the RGL database"),
    ("phong", "the modified Phong model"),
    ("ward", "Ward's anisotropic model"),
    ("difftrans", "diffuse transmission"),
    ("hk", "single scattering in a thin layer"),
    ("principled", "Disney's model"),
    ("principledthin", "Disney's model for thin sheets"),
    ("coating", "a smooth dielectric layer above another BSDF"),
    (
        "roughcoating",
        "a rough dielectric layer above another BSDF",
    ),
    ("mixturebsdf", "a sum of BSDFs"),
    ("blendbsdf", "two BSDFs, mixed by a texture"),
    ("mask", "a BSDF with opacity"),
    ("twosided", "BSDFs for both sides"),
    ("normalmap", "a BSDF with normals from a texture"),
    ("bumpmap", "a BSDF with heights from a texture"),
    ("null", "nothing"),
];

const EMITTERS: &[Entry] = &[
    ("area", "a shape that glows"),
    ("point", "a point"),
    ("spot", "a spot light"),
    ("projector", "an image, projected"),
    ("directional", "parallel light"),
    ("collimated", "a beam without width"),
    ("constant", "the same radiance from all sides"),
    ("envmap", "an image of the surroundings"),
    ("sky", "the sky of a day"),
    ("sun", "the sun of a day"),
    ("sunsky", "both"),
];

const SHAPES: &[Entry] = &[
    ("obj", "a mesh in Wavefront's format"),
    ("ply", "a mesh in the Stanford format"),
    ("serialized", "a mesh in Mitsuba's format"),
    ("rectangle", "a square of side 2"),
    ("cube", "a cube of side 2"),
    ("disk", "a disk"),
    ("sphere", "a sphere"),
    ("cylinder", "a cylinder without lids"),
    ("heightfield", "heights from an image"),
    ("shapegroup", "shapes to be placed by instances"),
    ("instance", "a group of shapes at a place"),
    ("merge", "shapes, one after the other"),
];

const TEXTURES: &[Entry] = &[
    ("bitmap", "an image"),
    ("checkerboard", "two colours"),
    ("gridtexture", "lines on a ground"),
    ("wireframe", "the edges of triangles"),
    ("vertexcolors", "colours of vertices"),
    ("mesh_attribute", "an attribute of vertices or faces"),
    ("scale", "another texture, scaled"),
];

impl Listed {
    /// The names, with what they stand for.
    pub fn entries(self) -> Vec<Entry> {
        match self {
            Listed::Integrators => INTEGRATORS
                .iter()
                .flat_map(|i| {
                    std::iter::once((i.name, i.about))
                        .chain(i.aliases.iter().map(|name| (*name, i.about)))
                })
                .collect(),
            Listed::Samplers => SAMPLERS.to_vec(),
            Listed::Sensors => SENSORS.to_vec(),
            Listed::Bsdfs => BSDFS.to_vec(),
            Listed::Emitters => EMITTERS.to_vec(),
            Listed::Shapes => SHAPES.to_vec(),
            Listed::Textures => TEXTURES.to_vec(),
            Listed::Metals => conductor_names()
                .map(|name| (name, ""))
                .chain([("none", "a perfect mirror")])
                .collect(),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// If the list cannot be printed.
pub fn run(args: &ListArgs) -> io::Result<ExitCode> {
    let entries = args.what.entries();
    if args.json {
        let list: Vec<_> = entries
            .iter()
            .map(|(name, about)| json!({ "name": name, "about": about }))
            .collect();
        print_line(format_args!("{:#}", json!(list)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = String::new();
    for (name, about) in entries {
        text.push_str(format!("{name:<18}{about}").trim_end());
        text.push('\n');
    }
    print(text)?;
    Ok(ExitCode::SUCCESS)
}
