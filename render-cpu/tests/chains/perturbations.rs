//! Perturbations lead back: the numbers that lead from y to x are computed from the two paths alone, by the laws of film steps and of
//! angles; they must lead there, and the ratio of that way must be one over the ratio of this.
//!
//! One camera sees a room with a mirror at a wall and a ball of glass, the other a few millimetres of the edge between mirror and
//! ceiling: there vertices lie so close together that the difference of their positions says little of the direction between them.

use crate::scenes::scene;
use crate::tracing::with_tracer;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::Bsdf;
use halflight_kernel::math::Frame;
use halflight_kernel::path::full_path::Blurring;
use halflight_kernel::path::tracer::Tracer;
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::Traverse;
use halflight_kernel::transport::markov::veach::caustic_perturbation::{
    LightChain, light_chain, propose_from_light,
};
use halflight_kernel::transport::markov::veach::lens_perturbation::{
    propose_from_sensor, sensor_chain,
};
use halflight_kernel::transport::markov::veach::{ChainPath, candidate};
use std::f32::consts::{PI, TAU};

const ROOM: &str = r#"<bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.7"/></bsdf>
    <bsdf type="conductor" id="mirror"><string name="material" value="none"/></bsdf>
    <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/></transform><ref id="grey"/></shape>
    <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="2"/></transform><ref id="grey"/></shape>
    <shape type="rectangle"><transform name="to_world"><translate y="1" z="-1"/></transform><ref id="grey"/></shape>
    <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="-90"/><translate x="1" y="1"/></transform><ref id="mirror"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0.5" z="0.1"/><float name="radius" value="0.42"/>
        <bsdf type="dielectric"/></shape>
    <shape type="sphere"><point name="center" x="-0.3" y="1.6" z="0.2"/><float name="radius" value="0.2"/>
        <emitter type="area"><rgb name="radiance" value="20"/></emitter></shape>"#;

/// Numbers of a function.
struct Called<'a>(&'a mut dyn FnMut() -> f32);

impl Sampler for Called<'_> {
    fn next_1d(&mut self) -> f32 {
        (self.0)()
    }
}

/// u of high exp(-ln(high / low) u), nothing outside of the range.
fn number_of(length: f32, [low, high]: [f32; 2]) -> Option<f32> {
    let u = (high / length).ln() / (high / low).ln();
    (0.0..1.0).contains(&u).then_some(u)
}

/// Numbers of the step from one direction to another.
fn turn(from: Vec3, to: Vec3, angles: [f32; 2]) -> Option<[f32; 2]> {
    let local = Frame::from_normal(from).to_local(to);
    let sin = local.truncate().length();
    let u = number_of(sin.atan2(local.z), angles)?;
    Some([u, azimuth(local.truncate())])
}

fn azimuth(step: Vec2) -> f32 {
    let u = step.y.atan2(step.x) / TAU;
    if u < 0.0 {
        (u + 1.0).min(0.999_999_9)
    } else {
        u
    }
}

fn film_steps(size: [u32; 2]) -> [f32; 2] {
    [0.1, (0.05 * (size[0] * size[1]) as f32 / PI).sqrt()]
}

/// Numbers of the lens and multi-chain perturbation that lead from `y` to `x`; `numbers` led there.
fn back_from_sensor<T: Traverse>(
    tracer: &Tracer<'_, T>,
    [x, y]: [&ChainPath; 2],
    numbers: &[f32],
) -> Option<Vec<f32>> {
    let step = x.film - y.film;
    let steps = film_steps(tracer.view.tables.camera.crop_size);
    let mut back = vec![number_of(step.length(), steps)?, azimuth(step)];
    let chain = sensor_chain(x);
    if chain.turns > 0 {
        back.push(numbers[2]);
    }
    for j in (chain.last + 1..x.edges())
        .rev()
        .filter(|&j| x.vertices[j].is_smooth())
    {
        let degree = PI / 180.0;
        let direction = x.previous_direction(j);
        back.extend(if numbers[2] < 0.5 {
            let towards = y.vertices[j - 1].point.position - x.vertices[j].point.position;
            turn(
                towards.normalize(),
                direction,
                [0.02 * degree, 2.0 * degree],
            )?
        } else {
            turn(
                y.previous_direction(j),
                direction,
                [1e-4 * degree, 0.1 * degree],
            )?
        });
    }
    Some(back)
}

/// The same of the caustic perturbation.
fn back_from_light<T: Traverse>(
    tracer: &Tracer<'_, T>,
    [x, y]: [&ChainPath; 2],
    LightChain { start, end }: LightChain,
) -> Option<Vec<f32>> {
    let camera = &tracer.view.tables.camera;
    let length = |from: usize, to: usize| -> f32 {
        y.vertices[from..=to]
            .windows(2)
            .map(|pair| pair[0].point.position.distance(pair[1].point.position))
            .sum()
    };
    let pixel = 2.0 * camera.tan_half_width / camera.film_size[0] as f32;
    let scale = pixel * length(end, y.edges()) / length(start, end);
    let angles = film_steps(camera.crop_size).map(|r| (r * scale).min(0.5 * PI));
    turn(y.next_direction(start), x.next_direction(start), angles).map(Vec::from)
}

/// What became of proposals.
#[derive(Debug, Default)]
struct Counts {
    proposed: u32,
    made: u32,
    /// That lead back to x, with the ratio of the way back.
    returned: u32,
}

fn is_same(a: &ChainPath, b: &ChainPath) -> bool {
    a.edges() == b.edges()
        && a.vertices
            .iter()
            .zip(&b.vertices)
            .all(|(a, b)| a.event == b.event && a.point.position.distance(b.point.position) < 1e-3)
}

#[test]
fn perturbations_lead_back() {
    let wide = r#"<float name="fov" value="40"/><transform name="to_world"><lookat origin="-0.35, 1.15, 3.6" target="0.1, 0.9, 0" up="0, 1, 0"/></transform>"#;
    let edge = r#"<float name="fov" value="0.05"/><transform name="to_world"><lookat origin="-0.35, 1.15, 3.6" target="1, 1.9995, 0.1" up="0, 1, 0"/></transform>"#;
    for (name, camera) in [("wide", wide), ("edge", edge)] {
        let sensor = format!(
            r#"<sensor type="perspective">{camera}<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/><rfilter type="box"/></film></sensor>"#
        );
        let scene = scene(&[&sensor, ROOM].concat(), &[]);
        // Lens, multi-chain about a direction, multi-chain about a vertex, caustic.
        let mut counts: [Counts; 4] = Default::default();
        with_tracer(&scene, |tracer| {
            let mut bsdf = Bsdf::BLACK;
            for i in 0..4000 {
                let mut sensor = IndependentSampler::new(1, 0, i);
                let mut light = IndependentSampler::new(2, 0, i);
                let mut random = IndependentSampler::new(3, 0, i);
                candidate::paths(
                    tracer,
                    Blurring::NONE,
                    &mut sensor,
                    &mut light,
                    |x, weight| {
                        if !(weight > 0.0) || x.edges() < 2 {
                            return;
                        }
                        let moved = light_chain(tracer, x);
                        for is_from_light in [false, true] {
                            if is_from_light && moved.is_none() {
                                continue;
                            }
                            let mut propose =
                                |from: &ChainPath,
                                 to: &mut ChainPath,
                                 sampler: &mut dyn FnMut() -> f32| {
                                    let mut sampler = Called(sampler);
                                    match light_chain(tracer, from) {
                                        Some(moved) if is_from_light => propose_from_light(
                                            tracer,
                                            from,
                                            moved,
                                            to,
                                            &mut bsdf,
                                            &mut sampler,
                                        ),
                                        _ => propose_from_sensor(
                                            tracer,
                                            from,
                                            to,
                                            &mut bsdf,
                                            &mut sampler,
                                        ),
                                    }
                                };
                            let mut y = ChainPath::empty();
                            let mut numbers = vec![];
                            let there = propose(x, &mut y, &mut || {
                                numbers.push(random.next_1d());
                                numbers[numbers.len() - 1]
                            });
                            let kind = match (is_from_light, sensor_chain(x).turns) {
                                (true, _) => 3,
                                (false, 0) => 0,
                                _ if numbers.len() > 2 && numbers[2] < 0.5 => 2,
                                _ => 1,
                            };
                            let count = &mut counts[kind];
                            count.proposed += 1;
                            if !(there > 0.0) {
                                continue;
                            }
                            count.made += 1;
                            let back = match moved {
                                Some(moved) if is_from_light => {
                                    back_from_light(tracer, [x, &y], moved)
                                }
                                _ => back_from_sensor(tracer, [x, &y], &numbers),
                            };
                            // Numbers at the very ends of their ranges may round out of them.
                            let Some(back) = back else { continue };
                            let mut left = back.into_iter();
                            let mut again = ChainPath::empty();
                            let ratio = propose(&y, &mut again, &mut || {
                                left.next().expect("as many numbers")
                            });
                            let is_inverse = (ratio * there - 1.0).abs() < 0.02;
                            count.returned += u32::from(is_same(x, &again) && is_inverse);
                        }
                    },
                );
            }
        });
        println!("{name}: {counts:?}");
        for (kind, count) in counts.iter().enumerate() {
            // Directions to a vertex that near are not to be had.
            if name == "wide" || kind < 2 {
                assert!(count.made > 50, "{name}, {kind}: {count:?}");
            }
            let lost = count.made - count.returned;
            assert!(lost * 50 <= count.made, "{name}, {kind}: {count:?}");
        }
    }
}
