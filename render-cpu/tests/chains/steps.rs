//! The laws of the steps of perturbations, in double precision: the numbers that lead from one path to another, computed from the two
//! paths alone, and the steps that numbers lead to.
//!
//! Lengths are high exp(-ln(high / low) u), azimuths 2 pi u. Numbers come in the order in which a perturbation draws them: those of
//! the film step, and of a turn at each vertex that discrete events follow; the caustic perturbation turns once.

use crate::proposals::Perturbation;
use glam::{DVec2, DVec3, Vec3};
use halflight_kernel::scene::records::Camera;
use halflight_kernel::transport::markov::veach::ChainPath;
use halflight_kernel::transport::markov::veach::caustic_perturbation::LightChain;
use halflight_kernel::transport::markov::veach::lens_perturbation::sensor_chain;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Lowest and highest length.
pub type Range = [f64; 2];

const DEGREE: f64 = PI / 180.0;

pub fn position(path: &ChainPath, i: usize) -> DVec3 {
    path.vertices[i].point.position.as_dvec3()
}

/// A unit direction, whose length is rounded no more: small angles with it would be wrong.
pub fn exact(direction: Vec3) -> DVec3 {
    direction.as_dvec3().normalize()
}

/// Of film steps, in pixels.
pub fn film_steps(camera: &Camera) -> Range {
    let [width, height] = camera.crop_size.map(f64::from);
    [0.1, (0.05 * width * height / PI).sqrt()]
}

/// Angles of the multi-chain perturbation.
pub fn chain_angles(kind: Perturbation) -> Range {
    let degrees = match kind {
        Perturbation::AnchoredMultiChain => [0.02, 2.0],
        _ => [1e-4, 0.1],
    };
    degrees.map(|angle| angle * DEGREE)
}

/// Angles of the caustic perturbation of a path.
pub fn caustic_angles(camera: &Camera, path: &ChainPath, chain: LightChain) -> Range {
    let length = |from: usize, to: usize| -> f64 {
        (from..to)
            .map(|i| position(path, i).distance(position(path, i + 1)))
            .sum()
    };
    let pixel = 2.0 * f64::from(camera.tan_half_width) / f64::from(camera.film_size[0]);
    let scale = pixel * length(chain.end, path.edges()) / length(chain.start, chain.end);
    let steps = film_steps(camera);
    steps.map(|r| r * scale.min(FRAC_PI_2 / steps[1]))
}

/// Vertices at which perturbations from the sensor turn the direction, in their order.
pub fn turning(x: &ChainPath) -> impl Iterator<Item = usize> {
    let first = sensor_chain(x).last + 1;
    (first..x.edges())
        .rev()
        .filter(|&j| x.vertices[j].is_smooth())
}

/// A step on the film.
pub fn step([u, v]: [f64; 2], range: Range) -> DVec2 {
    DVec2::from_angle(TAU * v) * length(u, range)
}

/// A direction turned.
pub fn turned(direction: DVec3, [u, v]: [f64; 2], range: Range) -> DVec3 {
    let (sin, cos) = length(u, range).sin_cos();
    let (s, t) = direction.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (TAU * v).sin_cos();
    direction * cos + (s * cos_phi + t * sin_phi) * sin
}

fn length(u: f64, [low, high]: Range) -> f64 {
    high * (-(high / low).ln() * u).exp()
}

/// u of a length, nothing outside of the range.
fn number_of(length: f64, [low, high]: Range) -> Option<f64> {
    let u = (high / length).ln() / (high / low).ln();
    (0.0..1.0).contains(&u).then_some(u)
}

fn azimuth(step: DVec2) -> f64 {
    (step.to_angle() / TAU).rem_euclid(1.0)
}

/// Numbers of the turn of one direction into another.
fn turn(from: DVec3, to: DVec3, range: Range) -> Option<[f64; 2]> {
    let (s, t) = from.any_orthonormal_pair();
    let local = DVec2::new(s.dot(to), t.dot(to));
    let u = number_of(local.length().atan2(from.dot(to)), range)?;
    Some([u, azimuth(local)])
}

/// Numbers with which the perturbations from the sensor lead from a path to another.
pub fn from_sensor(
    camera: &Camera,
    kind: Perturbation,
    [from, to]: [&ChainPath; 2],
) -> Option<Vec<[f64; 2]>> {
    let moved = (to.film - from.film).as_dvec2();
    let mut numbers = vec![[
        number_of(moved.length(), film_steps(camera))?,
        azimuth(moved),
    ]];
    for j in turning(from) {
        let before = match kind {
            Perturbation::AnchoredMultiChain => {
                (position(from, j - 1) - position(to, j)).normalize()
            }
            _ => exact(from.previous_direction(j)),
        };
        let after = exact(to.previous_direction(j));
        numbers.push(turn(before, after, chain_angles(kind))?);
    }
    Some(numbers)
}

/// The same of the caustic perturbation.
pub fn from_light(
    camera: &Camera,
    chain: LightChain,
    [from, to]: [&ChainPath; 2],
) -> Option<Vec<[f64; 2]>> {
    let [before, after] = [from, to].map(|path| exact(path.next_direction(chain.start)));
    let angles = caustic_angles(camera, from, chain);
    turn(before, after, angles).map(|numbers| vec![numbers])
}
