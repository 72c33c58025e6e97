//! Ratios of acceptance of the perturbations against densities per area, by differences.
//!
//! A perturbation is a map from its random numbers u to the vertices that it moves. Of the product area measure over the vertices
//! that are no discrete events, with those in between given by them, its density is
//!
//! ```text
//! T(x -> y) = 1 / |det d(y_i) / du|,
//! ```
//!
//! y_i the moved ones of them in the planes that touch their surfaces there, and that of the way back the same at x, with the numbers
//! that lead there. What the path carries is given per film position and per direction at each such vertex to the one before, so
//! that per area it is
//!
//! ```text
//! f(x) prod_i d c_i / dA_i,
//! ```
//!
//! c_i the direction at the next such vertex, the film position for the last, with that next vertex where it is: what discrete events
//! lie in between, their deltas too, is in the same measure on both sides. All derivatives are central differences in double precision
//! of paths that are followed again; no Jacobian, solid angle or index of the kernel is in them.

use crate::brightness::POINT;
use crate::proposals::{Perturbation, Proposal, WIDE, camera, room, with_proposals};
use crate::replay::{Ray, Replay};
use crate::scenes::scene;
use crate::steps;
use crate::tracing::{Trace, with_tracer};
use glam::DVec3;
use halflight_kernel::scene::records::Camera;
use halflight_kernel::transport::markov::veach::ChainPath;
use halflight_kernel::transport::markov::veach::caustic_perturbation::{LightChain, light_chain};
use halflight_kernel::transport::markov::veach::lens_perturbation::sensor_chain;

/// Step of the differences of numbers.
const STEP: f64 = 1e-5;

/// A way from one path to another.
struct Way<'a> {
    camera: &'a Camera,
    kind: Perturbation,
    chain: Option<LightChain>,
    from: &'a ChainPath,
    to: &'a ChainPath,
    replay: Replay<'a>,
}

impl Way<'_> {
    /// The numbers that lead there.
    fn numbers(&self) -> Option<Vec<[f64; 2]>> {
        let ends = [self.from, self.to];
        match self.chain {
            Some(chain) => steps::from_light(self.camera, chain, ends),
            None => steps::from_sensor(self.camera, self.kind, ends),
        }
    }

    /// Where numbers lead the moved vertices that are no discrete events: their indices and positions.
    fn moved(&self, numbers: &[[f64; 2]]) -> Vec<(usize, DVec3)> {
        let (from, replay) = (self.from, &self.replay);
        if let Some(chain) = self.chain {
            let LightChain { start, end } = chain;
            let old = steps::exact(from.next_direction(start));
            let angles = steps::caustic_angles(self.camera, from, chain);
            let ray = Ray {
                origin: steps::position(from, start),
                direction: steps::turned(old, numbers[0], angles),
            };
            return vec![(end, replay.follow(ray, start + 1..=end))];
        }
        let film = from.film.as_dvec2() + steps::step(numbers[0], steps::film_steps(self.camera));
        let mut ray = replay.ray(film);
        let mut turns = numbers[1..].iter();
        let mut moved = vec![];
        let last = sensor_chain(from).last;
        for j in (last + 1..from.edges()).rev() {
            if !from.vertices[j].is_smooth() {
                ray = replay.scatter(ray, j);
                continue;
            }
            let origin = replay.meet(ray, j);
            let old = match self.kind {
                Perturbation::AnchoredMultiChain => {
                    (steps::position(from, j - 1) - origin).normalize()
                }
                _ => steps::exact(from.previous_direction(j)),
            };
            let turn = turns.next().expect("numbers of each turn");
            let direction = steps::turned(old, *turn, steps::chain_angles(self.kind));
            moved.push((j, origin));
            ray = Ray { origin, direction };
        }
        moved.push((last, replay.meet(ray, last)));
        moved
    }

    /// Whether numbers lead there, but for rounding.
    fn leads_there(&self, numbers: &[[f64; 2]]) -> bool {
        self.moved(numbers).into_iter().all(|(i, at)| {
            let [from, to] = [self.from, self.to].map(|path| steps::position(path, i));
            at.distance(to) < 1e-4 + 0.005 * from.distance(to)
        })
    }

    /// The logarithm of T, by the numbers that the two paths tell.
    fn ln_density(&self) -> Option<f64> {
        let numbers = self.numbers()?;
        if !self.leads_there(&numbers) {
            return None;
        }
        let mut columns = vec![];
        for n in 0..2 * numbers.len() {
            let coordinates = |step: f64| -> Vec<f64> {
                let mut numbers = numbers.clone();
                numbers[n / 2][n % 2] += step;
                let moved = self.moved(&numbers).into_iter();
                moved
                    .flat_map(|(i, at)| self.replay.on_plane(i, at))
                    .collect()
            };
            let (before, after) = (coordinates(-STEP), coordinates(STEP));
            let differences = after.iter().zip(before);
            columns.push(differences.map(|(a, b)| (a - b) / (2.0 * STEP)).collect());
        }
        Some(-ln_determinant(columns))
    }
}

/// Logarithm of the absolute value of a determinant, by elimination with pivots.
fn ln_determinant(mut rows: Vec<Vec<f64>>) -> f64 {
    let mut sum = 0.0;
    for i in 0..rows.len() {
        let largest =
            (i..rows.len()).max_by(|a, b| rows[*a][i].abs().total_cmp(&rows[*b][i].abs()));
        rows.swap(i, largest.expect("a row"));
        let pivot = rows[i].clone();
        sum += pivot[i].abs().ln();
        for row in &mut rows[i + 1..] {
            let factor = row[i] / pivot[i];
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(v, p)| *v -= factor * p);
        }
    }
    sum
}

/// Logarithm of f(y) T(y -> x) / (f(x) T(x -> y)) per area; nothing where the numbers that were drawn, or those of the way back, are not
/// those by the laws of steps.
fn expected(tracer: &Trace<'_>, proposal: &Proposal<'_>) -> Option<f64> {
    let Proposal { kind, x, y, .. } = *proposal;
    let camera = &tracer.view.tables.camera;
    let chain = light_chain(tracer, x).filter(|_| kind == Perturbation::Caustic);
    let way = |from, to| Way {
        camera,
        kind,
        chain,
        from,
        to,
        replay: Replay::new(camera, to),
    };
    let ln_carried = |path: &ChainPath| {
        f64::from(path.luminance()).ln() - Replay::new(camera, path).ln_areas_per_direction()
    };
    let (there, back) = (way(x, y), way(y, x));
    if !there.leads_there(&proposal.numbers) {
        return None;
    }
    Some(ln_carried(y) - ln_carried(x) + back.ln_density()? - there.ln_density()?)
}

#[test]
fn perturbations_have_the_ratios_of_densities_per_area() {
    let lens =
        r#"<float name="aperture_radius" value="0.1"/><float name="focus_distance" value="3"/>"#;
    // Angles of caustic perturbations reach their limit.
    let wide = WIDE.replace(r#""40""#, r#""150""#);
    let all = &Perturbation::ALL[..];
    let cameras = [
        ("pinhole", camera("perspective", WIDE), all),
        ("thin lens", camera("thinlens", &[lens, WIDE].concat()), all),
        ("wide angle", camera("perspective", &wide), &all[3..]),
    ];
    for (name, camera, kinds) in &cameras {
        let scene = scene(&[camera, room().as_str(), POINT].concat(), &[]);
        let mut errors: [Vec<f64>; 4] = Default::default();
        with_tracer(&scene, |tracer| {
            with_proposals(tracer, 1500, |proposal| {
                if proposal.ratio > 0.0 {
                    let expected = expected(tracer, proposal);
                    let error = expected.map(|ln| (f64::from(proposal.ratio).ln() - ln).abs());
                    errors[proposal.kind as usize].push(error.unwrap_or(f64::INFINITY));
                }
            });
        });
        for kind in *kinds {
            let errors = &mut errors[*kind as usize];
            errors.sort_by(f64::total_cmp);
            // Where curved surfaces spread light most, they spread rounding.
            let [median, high] = [50, 99].map(|percent| errors[errors.len() * percent / 100]);
            println!(
                "{name}, {kind:?}: {} ratios, errors {median:.1e}, {high:.1e}",
                errors.len()
            );
            assert!(errors.len() > 50, "{name}, {kind:?}");
            assert!(median < 1e-4 && high < 0.01, "{name}, {kind:?}");
        }
    }
}
