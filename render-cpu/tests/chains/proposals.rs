//! Proposals of the perturbations for paths of a room with a mirror at a wall, a ball of glass and a lamp.

use crate::tracing::{Trace, with_lit_paths};
use glam::DVec3;
use halflight_kernel::bsdf::Bsdf;
use halflight_kernel::sampler::Sampler;
use halflight_kernel::transport::markov::veach::ChainPath;
use halflight_kernel::transport::markov::veach::caustic_perturbation::{
    light_chain, propose_from_light,
};
use halflight_kernel::transport::markov::veach::lens_perturbation::{
    propose_from_sensor, sensor_chain,
};

/// A sphere of the room.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub center: DVec3,
    pub radius: f64,
}

/// Of glass.
pub const BALL: Sphere = Sphere {
    center: DVec3::new(0.0, 0.5, 0.1),
    radius: 0.42,
};

pub const LAMP: Sphere = Sphere {
    center: DVec3::new(-0.3, 1.6, 0.2),
    radius: 0.2,
};

/// Index of refraction of the ball.
pub const INDEX: f64 = 1.5;

/// The room, open to the camera.
pub fn room() -> String {
    let sphere = |sphere: Sphere, content: String| {
        let Sphere { center, radius } = sphere;
        format!(
            r#"<shape type="sphere"><point name="center" x="{}" y="{}" z="{}"/><float name="radius" value="{radius}"/>
            {content}</shape>"#,
            center.x, center.y, center.z
        )
    };
    let walls = r#"<bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.7"/></bsdf>
        <bsdf type="conductor" id="mirror"><string name="material" value="none"/></bsdf>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/></transform><ref id="grey"/></shape>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="2"/></transform><ref id="grey"/></shape>
        <shape type="rectangle"><transform name="to_world"><translate y="1" z="-1"/></transform><ref id="grey"/></shape>
        <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="-90"/><translate x="1" y="1"/></transform><ref id="mirror"/></shape>"#;
    let glass = format!(
        r#"<bsdf type="dielectric"><float name="int_ior" value="{INDEX}"/><float name="ext_ior" value="1"/></bsdf>"#
    );
    let lamp = r#"<emitter type="area"><rgb name="radiance" value="20"/></emitter>"#;
    [walls, &sphere(BALL, glass), &sphere(LAMP, lamp.to_string())].concat()
}

/// A camera before the room that has a film of 64 by 64 pixels.
pub fn camera(kind: &str, properties: &str) -> String {
    format!(
        r#"<sensor type="{kind}">{properties}<film type="hdrfilm"><integer name="width" value="64"/>
        <integer name="height" value="64"/><rfilter type="box"/></film></sensor>"#
    )
}

/// Sees the whole room.
pub const WIDE: &str = r#"<float name="fov" value="40"/><transform name="to_world">
    <lookat origin="-0.35, 1.15, 3.6" target="0.1, 0.9, 0" up="0, 1, 0"/></transform>"#;

/// A kind of proposals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Perturbation {
    Lens,
    /// About the directions that there were.
    MultiChain,
    /// About directions to vertices that there were.
    AnchoredMultiChain,
    Caustic,
}

impl Perturbation {
    pub const ALL: [Perturbation; 4] = [
        Perturbation::Lens,
        Perturbation::MultiChain,
        Perturbation::AnchoredMultiChain,
        Perturbation::Caustic,
    ];
}

/// A proposal.
pub struct Proposal<'a> {
    pub kind: Perturbation,
    pub x: &'a ChainPath,
    pub y: &'a ChainPath,
    /// Those that were drawn, in pairs, without the one that chooses the kind.
    pub numbers: Vec<[f64; 2]>,
    /// f(y) T(y -> x) / (f(x) T(x -> y)), zero if there is no y.
    pub ratio: f32,
}

/// Numbers of a function.
struct Called<'a>(&'a mut dyn FnMut() -> f32);

impl Sampler for Called<'_> {
    fn next_1d(&mut self) -> f32 {
        (self.0)()
    }
}

/// Makes `to` of `from` by the caustic perturbation or by those from the sensor; returns the ratio.
pub fn propose(
    tracer: &Trace<'_>,
    is_caustic: bool,
    from: &ChainPath,
    to: &mut ChainPath,
    numbers: &mut dyn FnMut() -> f32,
) -> f32 {
    let (mut bsdf, mut sampler) = (Bsdf::BLACK, Called(numbers));
    match light_chain(tracer, from) {
        Some(chain) if is_caustic => {
            propose_from_light(tracer, from, chain, to, &mut bsdf, &mut sampler)
        }
        _ => propose_from_sensor(tracer, from, to, &mut bsdf, &mut sampler),
    }
}

/// Calls `test` with proposals of every kind for the paths of as many candidates.
pub fn with_proposals(tracer: &Trace<'_>, candidates: u32, mut test: impl FnMut(&Proposal<'_>)) {
    with_lit_paths(tracer, candidates, |x, random| {
        if x.edges() < 2 {
            return;
        }
        for is_caustic in [false, true] {
            if is_caustic && light_chain(tracer, x).is_none() {
                continue;
            }
            let mut y = ChainPath::empty();
            let mut numbers = vec![];
            let ratio = propose(tracer, is_caustic, x, &mut y, &mut || {
                numbers.push(random.next_1d());
                numbers[numbers.len() - 1]
            });
            let kind = match (is_caustic, sensor_chain(x).turns) {
                (true, _) => Perturbation::Caustic,
                (false, 0) => Perturbation::Lens,
                _ if numbers.len() > 2 && numbers[2] < 0.5 => Perturbation::AnchoredMultiChain,
                _ => Perturbation::MultiChain,
            };
            let chooses = [Perturbation::MultiChain, Perturbation::AnchoredMultiChain];
            if chooses.contains(&kind) && numbers.len() > 2 {
                numbers.remove(2);
            }
            let pairs = numbers.chunks_exact(2);
            test(&Proposal {
                kind,
                x,
                y: &y,
                numbers: pairs.map(|pair| [pair[0].into(), pair[1].into()]).collect(),
                ratio,
            });
        }
    });
}
