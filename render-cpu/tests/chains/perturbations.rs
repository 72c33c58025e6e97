//! Perturbations lead back: the numbers that lead from y to x are computed from the two paths alone, by the laws of film steps and of
//! angles; they must lead there, and the ratio of that way must be one over the ratio of this.
//!
//! One camera sees a room with a mirror at a wall and a ball of glass, the other a few millimetres of the edge between mirror and
//! ceiling: there vertices lie so close together that the difference of their positions says little of the direction between them.

use crate::proposals::{Perturbation, WIDE, camera, propose, room, with_proposals};
use crate::scenes::scene;
use crate::steps;
use crate::tracing::with_tracer;
use halflight_kernel::transport::markov::veach::ChainPath;
use halflight_kernel::transport::markov::veach::caustic_perturbation::light_chain;

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
    let edge = r#"<float name="fov" value="0.05"/><transform name="to_world"><lookat origin="-0.35, 1.15, 3.6" target="1, 1.9995, 0.1" up="0, 1, 0"/></transform>"#;
    for (name, properties) in [("wide", WIDE), ("edge", edge)] {
        let scene = scene(&[camera("perspective", properties), room()].concat(), &[]);
        let mut counts: [Counts; 4] = Default::default();
        with_tracer(&scene, |tracer| {
            let camera = &tracer.view.tables.camera;
            with_proposals(tracer, 4000, |proposal| {
                let (kind, x, y) = (proposal.kind, proposal.x, proposal.y);
                let count = &mut counts[kind as usize];
                count.proposed += 1;
                if !(proposal.ratio > 0.0) {
                    return;
                }
                count.made += 1;
                let back = match light_chain(tracer, x) {
                    Some(chain) if kind == Perturbation::Caustic => {
                        steps::from_light(camera, chain, [y, x])
                    }
                    _ => steps::from_sensor(camera, kind, [y, x]),
                };
                // Numbers at the very ends of their ranges may round out of them.
                let Some(back) = back else { return };
                let mut back: Vec<f32> = back.iter().flatten().map(|u| *u as f32).collect();
                match kind {
                    Perturbation::MultiChain => back.insert(2, 0.75),
                    Perturbation::AnchoredMultiChain => back.insert(2, 0.25),
                    _ => {}
                }
                let mut left = back.into_iter();
                let mut again = ChainPath::empty();
                let is_caustic = kind == Perturbation::Caustic;
                let ratio = propose(tracer, is_caustic, y, &mut again, &mut || {
                    left.next().expect("as many numbers")
                });
                let is_inverse = (ratio * proposal.ratio - 1.0).abs() < 0.02;
                count.returned += u32::from(is_same(x, &again) && is_inverse);
            });
        });
        println!("{name}: {counts:?}");
        for (kind, count) in Perturbation::ALL.iter().zip(&counts) {
            // Directions to a vertex that near are not to be had.
            if name == "wide" || (*kind as usize) < 2 {
                assert!(count.made > 50, "{name}, {kind:?}: {count:?}");
            }
            let lost = count.made - count.returned;
            assert!(lost * 50 <= count.made, "{name}, {kind:?}: {count:?}");
        }
    }
}
