//! Small scenes out of bytes, most of them with poles: surfaces that coincide or touch, materials at the ends of their ranges, lights
//! and lenses beside them. Whatever the mutation of full paths, nothing panics, no number is infinite or a NaN, and no path
//! without light becomes the state.
//!
//! One body for the fuzz target and for the test that feeds it random bytes.

use halflight::accel::Accel;
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::scene::SceneView;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::markov::{ChainAlgorithm, Splat, VeachChains};
use halflight_kernel::transport::settings::{ChainSettings, half_vector_flag, integrator_kind};
use std::fmt::Write;
use std::path::Path;

/// A mesh beside the scenes: an octahedron whose normals are those of a sphere, two corners off by a quarter turn.
pub const MESH: (&str, &str) = (
    "mesh.obj",
    "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nvn 1 0 0\nvn -1 0 0\nvn 0 1 0\nvn 0 -1 0\nvn 1 0 0\nvn 0 1 0\n\
     f 1//1 3//3 5//5\nf 2//2 4//4 5//5\nf 1//1 4//4 6//6\nf 2//2 3//3 6//6\nf 3//3 2//2 5//5\nf 4//4 1//1 5//5\nf 3//3 1//1 6//6\nf 4//4 2//2 6//6\n",
);

const MATERIALS: [&str; 12] = [
    r#"<bsdf type="roughconductor"><float name="alpha" value="A"/></bsdf>"#,
    r#"<bsdf type="roughconductor"><string name="distribution" value="ggx"/><float name="alpha_u" value="A"/><float name="alpha_v" value="B"/></bsdf>"#,
    r#"<bsdf type="roughdielectric"><float name="alpha" value="A"/><float name="int_ior" value="I"/></bsdf>"#,
    r#"<bsdf type="roughdielectric"><string name="distribution" value="ggx"/><float name="alpha" value="A"/><float name="int_ior" value="I"/></bsdf>"#,
    r#"<bsdf type="dielectric"><float name="int_ior" value="I"/></bsdf>"#,
    r#"<bsdf type="conductor"/>"#,
    r#"<bsdf type="diffuse"/>"#,
    r#"<bsdf type="plastic"/>"#,
    r#"<bsdf type="roughplastic"><float name="alpha" value="A"/></bsdf>"#,
    r#"<bsdf type="thindielectric"/>"#,
    r#"<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha" value="A"/></bsdf></bsdf></bsdf>"#,
    r#"<bsdf type="blendbsdf"><float name="weight" value="0.4"/><bsdf type="diffuse"/><bsdf type="roughconductor"><float name="alpha" value="A"/></bsdf></bsdf>"#,
];

const ALPHAS: [&str; 8] = ["0.0001", "0.001", "0.01", "0.05", "0.2", "0.5", "1", "0.3"];

const INDICES: [&str; 8] = [
    "1", "1.00001", "1.0004", "1.01", "1.5", "2.4", "0.6667", "1.33",
];

const LIGHTS: [&str; 6] = [
    r#"<shape type="rectangle"><transform name="to_world"><scale value="0.4"/><rotate x="1" angle="90"/><translate y="1.8"/></transform>
    <emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>"#,
    r#"<shape type="sphere"><point name="center" value="0.4, 1.6, 0.2"/><float name="radius" value="0.001"/>
    <emitter type="area"><rgb name="radiance" value="1e6"/></emitter></shape>"#,
    r#"<emitter type="point"><point name="position" value="0, 1.7, 0"/><rgb name="intensity" value="3, 2, 1"/></emitter>"#,
    r#"<emitter type="directional"><vector name="direction" value="0.2, -1, -0.4"/><rgb name="irradiance" value="3"/></emitter>"#,
    r#"<emitter type="constant"><rgb name="radiance" value="0.7"/></emitter>"#,
    r#"<emitter type="spot"><transform name="to_world"><lookat origin="0, 1.7, 0.5" target="0, 0, 0" up="0, 0, 1"/></transform>
    <rgb name="intensity" value="9"/></emitter>"#,
];

const SENSORS: [(&str, &str); 3] = [
    ("perspective", ""),
    (
        "thinlens",
        r#"<float name="aperture_radius" value="0.2"/><float name="focus_distance" value="3"/>"#,
    ),
    ("orthographic", ""),
];

/// Choices out of the input, the first of each where it is at its end.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[usize::from(self.byte()) % choices.len()]
    }

    /// In [-1, 1], often on a coarse grid, so that surfaces coincide.
    fn place(&mut self) -> f32 {
        let byte = self.byte();
        if byte & 1 == 0 {
            f32::from(byte >> 5) / 3.5 - 1.0
        } else {
            f32::from(byte) / 127.5 - 1.0
        }
    }

    fn material(&mut self) -> String {
        self.of(&MATERIALS)
            .replace("\"A\"", &format!("\"{}\"", self.of(&ALPHAS)))
            .replace("\"B\"", &format!("\"{}\"", self.of(&ALPHAS)))
            .replace("\"I\"", &format!("\"{}\"", self.of(&INDICES)))
    }

    fn shape(&mut self) -> String {
        let kind = self.byte() % 5;
        let [x, y, z] = [self.place(), self.place() + 1.0, self.place()];
        let scale = self.of(&[0.5, 0.3, 0.9, 0.05, 1.0, 2.5]);
        let turns = self.of(&[0.0, 90.0, 90.001, 89.0, 30.0, 180.0]);
        let flat = self.of(&[1.0, 0.001, 0.2]);
        let material = self.material();
        if kind == 0 {
            return format!(
                r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" value="{scale}"/>{material}</shape>"#
            );
        }
        let (shape, file) = match kind {
            1 => ("rectangle", ""),
            2 => ("cube", ""),
            3 => ("obj", r#"<string name="filename" value="mesh.obj"/>"#),
            _ => ("disk", ""),
        };
        format!(
            r#"<shape type="{shape}">{file}<transform name="to_world"><scale x="{scale}" y="{flat}" z="{scale}"/>
            <rotate x="1" y="0.2" angle="{turns}"/><translate x="{x}" y="{y}" z="{z}"/></transform>{material}</shape>"#
        )
    }

    fn scene(&mut self) -> String {
        let mut text = String::from("<scene version=\"3.0.0\">");
        let (sensor, own) = self.of(&SENSORS);
        let _ = write!(
            text,
            r#"<sensor type="{sensor}">{own}{}<transform name="to_world"><lookat origin="0.1, 1, 3.5" target="0, 0.9, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="6"/></film></sensor>"#,
            if sensor == "orthographic" {
                ""
            } else {
                r#"<float name="fov" value="60"/>"#
            },
        );
        text += self.of(&LIGHTS);
        // A floor and a wall, so that there are paths.
        let wall = self.material();
        let _ = write!(
            text,
            r#"<bsdf type="twosided" id="floor">{}</bsdf>
            <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform><ref id="floor"/></shape>
            <shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-1.5"/></transform>{wall}</shape>"#,
            self.of(&[
                MATERIALS[6],
                r#"<bsdf type="roughconductor"><float name="alpha" value="0.1"/></bsdf>"#
            ]),
        );
        for _ in 0..1 + self.byte() % 5 {
            text += &self.shape();
        }
        text + "</scene>"
    }

    /// Chains of one mutation in one of its forms beside the bidirectional one, or of all.
    fn chains(&mut self) -> ChainSettings {
        let flags = self.of(&[
            0,
            half_vector_flag::ORIGINAL,
            half_vector_flag::PROJECTED,
            half_vector_flag::ORIGINAL | half_vector_flag::PROJECTED,
            half_vector_flag::GLOBAL_ROUGHNESS,
            half_vector_flag::EQUAL_STEPS,
            half_vector_flag::UNSTRATIFIED,
            half_vector_flag::ORIGINAL | half_vector_flag::UNSTRATIFIED,
            half_vector_flag::FROM_LIGHT,
            half_vector_flag::FROM_SENSOR | half_vector_flag::ORIGINAL,
        ]);
        let [manifold, half_vector] = self.of(&[[0.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]);
        let others = self.of(&[0.0, 0.0, 0.0, 1.0]);
        ChainSettings {
            bidirectional_weight: 0.25,
            lens_weight: others,
            caustic_weight: others,
            multi_chain_weight: others,
            manifold_weight: manifold,
            half_vector_weight: half_vector,
            half_vector_flags: flags,
            half_vector_step: self.of(&[0.2, 1.0, 3.0, 0.001]),
            lambda: self.of(&[50.0, 2.0, 1000.0]),
            ..ChainSettings::DEFAULT
        }
    }
}

/// What a scene came to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reached {
    /// Chains that started.
    pub chains: u32,
    /// Proposals that could become the state.
    pub proposals: u32,
    /// Walks that found a path, and jumps.
    pub walks: u64,
}

/// Makes a scene out of bytes, beside the files in a folder, and chains on it.
pub fn check(bytes: &[u8], folder: &Path) -> Reached {
    let mut input = Input(bytes);
    let chains = input.chains();
    let text = input.scene();
    let parsed = parse_scene_from_str(&text, &folder.join("scene.xml"), &[], false)
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let scene = build_scene(&parsed, &BuildOptions::default())
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let settings = IntegratorSettings {
        kind: integrator_kind::VEACH_MLT,
        chains,
        ..scene.settings
    };
    let tables = scene.tables.view();
    let accel = Accel::build(tables, &scene.tables.groups);
    let traverse = accel.traverse(tables);
    let view = SceneView {
        tables,
        traverse: &traverse,
    };
    let chains = VeachChains::new(&view, &settings, 2, 7, 0);
    let mut reached = Reached::default();
    for candidate in 0..200 {
        let (mut member, mut lit) = (0, None);
        chains.candidate_weights(candidate, &mut |weight| {
            assert!(!weight.is_nan() && weight >= 0.0, "{weight}\n{text}");
            if weight > 0.0 && weight.is_finite() {
                lit = Some(member);
            }
            member += 1;
        });
        let Some(member) = lit else { continue };
        let mut chain = chains.start(candidate, member, candidate);
        assert!(observed(&chains, &chain), "a start without light\n{text}");
        reached.chains += 1;
        let mut check = |splat: Splat| {
            let is_light = splat.value.is_finite() && splat.value.max_element() > 0.0;
            assert!(is_light && splat.film.is_finite(), "{splat:?}\n{text}");
        };
        for _ in 0..12 {
            chains.step(&mut chain, 1.0, &mut check);
            let acceptance = last_acceptance(&chains, &chain);
            assert!((0.0..=1.0).contains(&acceptance), "{acceptance}\n{text}");
            assert!(observed(&chains, &chain), "a state without light\n{text}");
            reached.proposals += u32::from(acceptance > 0.0);
        }
        chains.finish(&mut chain, 1.0, &mut check);
        let counts = walk_counts(&chains, &chain);
        reached.walks += counts;
        if reached.chains >= 40 {
            break;
        }
    }
    reached
}

/// Whether the state of a chain carries light that a float holds.
fn observed<A: ChainAlgorithm>(_: &A, chain: &A::Chain) -> bool {
    A::observe(chain).is_none_or(|state| {
        state.luminance >= f32::MIN_POSITIVE
            && state.luminance < f32::INFINITY
            && state.film.is_finite()
            && state.edges > 0
    })
}

fn last_acceptance<A: ChainAlgorithm>(_: &A, chain: &A::Chain) -> f32 {
    A::last_step(chain).map_or(0.0, |last| last.acceptance)
}

fn walk_counts<A: ChainAlgorithm>(_: &A, chain: &A::Chain) -> u64 {
    let counts = A::counts(chain).iter();
    counts
        .map(|counts| counts.walks.found + counts.walks.jumps)
        .sum()
}
