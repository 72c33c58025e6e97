//! Walks that do not come back, and jumps, in a hollow mirror, where several paths have the same half vectors: what the mutations
//! take for reversible, and what a jump adds to the ratio of densities, against the walks themselves and densities per area.

use crate::scenes::{LAMP, PINHOLE, scene};
use crate::tracing::{Trace, with_lit_paths, with_tracer};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::Bsdf;
use halflight_kernel::manifold::ChainJacobian;
use halflight_kernel::manifold::half_vector_form::SLOPE;
use halflight_kernel::manifold::mutation::{density_factor, mutate, mutation_kind};
use halflight_kernel::manifold::walk::{WalkOptions, walk};
use halflight_kernel::sampler::Sampler;
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::markov::algorithm::WalkCounts;
use halflight_kernel::transport::markov::half_vector::closing::{Closing, Jump, Moved, held};
use halflight_kernel::transport::markov::half_vector::measure::segment_factor;
use halflight_kernel::transport::markov::half_vector::path_chain::PathChain;
use halflight_kernel::transport::markov::half_vector::reconnection::{
    Method, Segment, leads_back, options_of, reconnect,
};
use halflight_kernel::transport::markov::half_vector::settings::roughness_kind;
use halflight_kernel::transport::markov::veach::ChainPath;

const N: usize = 4;

/// Calls `test` with paths of three edges, their chains, the whole as a segment, and half vectors far from theirs.
fn with_targets(mut test: impl FnMut(&Trace<'_>, &ChainPath, &PathChain, &Segment<N>, &[Vec2; N])) {
    let inside = PINHOLE
        .replace("0.1, 1, 3.5", "0.3, 1, 1.2")
        .replace("0, 0.9, 0", "-0.3, 0.7, -1");
    let bowl = r#"<shape type="sphere"><point name="center" value="0, 1, 0"/><float name="radius" value="2"/>
        <bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></bsdf></shape>"#;
    let scene = scene(&[&inside, LAMP, bowl].concat(), &[]);
    with_tracer(&scene, |tracer| {
        let mut bsdf = Bsdf::BLACK;
        let mut chain = PathChain::EMPTY;
        let reference = Vec3::new(0.36, 0.48, 0.8);
        with_lit_paths(tracer, 1500, |path, steps| {
            if path.edges() != 3 {
                return;
            }
            let tables = &tracer.view.tables;
            chain.set(tables, path, reference, roughness_kind::LOCAL, &mut bsdf);
            let Some(segment) = Segment::<N>::new(&chain, 0, 3, SLOPE) else {
                return;
            };
            let mut target = segment.jacobian.h;
            for h in &mut target[1..3] {
                *h += (steps.next_2d() - Vec2::splat(0.5)) * 1.2;
            }
            test(tracer, path, &chain, &segment, &target);
        });
    });
}

/// Whether the walk from a path to half vectors ends at another path.
fn leads_to<T: Traverse>(
    view: &SceneView<'_, T>,
    from: &[halflight_kernel::manifold::ChainVertex; N],
    target: &[Vec2; N],
    to: &[halflight_kernel::manifold::ChainVertex; N],
    options: &WalkOptions,
) -> bool {
    let jacobian = ChainJacobian::new(from, N, SLOPE);
    let back = walk(view, from, &jacobian, target, options);
    let far = back.vertices.iter().zip(to).any(|(a, b)| {
        (a.position - b.position).length() > options.reversibility_tolerance * options.scene_scale
    });
    back.is_converged() && !far
}

#[test]
fn paths_from_which_walks_do_not_come_back_are_no_proposals() {
    let mut counted = [0; 2];
    with_targets(|tracer, path, chain, segment, target| {
        let view = tracer.view;
        let radius = view.tables.info.radius;
        let options = options_of(chain, path.is_infinite(&view.tables), radius, SLOPE);
        let there = walk(view, &segment.vertices, &segment.jacobian, target, &options);
        if !there.is_converged() {
            return;
        }
        let back = &segment.jacobian.h;
        let returns = leads_to(view, &there.vertices, back, &segment.vertices, &options);
        let mut counts = WalkCounts::default();
        let method = Method::HalfVectors;
        let found = reconnect(view, segment, None, target, method, &options, &mut counts).unwrap();
        let jacobian = ChainJacobian::new(&found, N, SLOPE);
        let known = Some(&jacobian);
        let got = leads_back(
            view,
            segment,
            None,
            &found,
            known,
            back,
            method,
            &options,
            &mut counts,
        );
        assert_eq!(got, returns);
        let mutation = mutate(view, &segment.vertices, &segment.jacobian, target, &options);
        let expected = if returns {
            mutation_kind::WALK
        } else {
            mutation_kind::NOT_REVERSIBLE
        };
        assert_eq!(mutation.kind, expected);
        counted[usize::from(returns)] += 1;
    });
    println!("{} walks come back, {} do not", counted[1], counted[0]);
    assert!(counted.iter().all(|n| *n > 30), "{counted:?}");
}

/// With f M the density per half vectors, f times the areas per solid angle that per area of vertices, and the densities of the
/// predictions both ways per area: M(y) factor / M(x) = A(y) back / (A(x) there).
#[test]
fn jumps_count_densities_per_area() {
    let (mut jumps, mut spread) = (0, 0.0f32);
    with_targets(|tracer, x, chain, segment, target| {
        let tables = &tracer.view.tables;
        let Some(back) = held(x, chain, 0, SLOPE) else {
            return;
        };
        let mut all = back.clone();
        all[1..3].copy_from_slice(&target[1..3]);
        let closing = Closing {
            low: 0,
            high: 3,
            target: &all,
            back: &back,
            method: Method::HalfVectors,
            start: 0,
        };
        let (mut y, mut of_y) = (x.clone(), PathChain::EMPTY);
        let mut counts = WalkCounts::default();
        let pair = (&mut y, &mut of_y);
        let moved = closing.move_or_jump(tracer, x, chain, segment, pair, SLOPE, &mut counts);
        let Some(Moved {
            mut way_back,
            jump: Some(Jump { factor, .. }),
        }) = moved
        else {
            return;
        };
        if !closing.leads_back(tracer, [segment; 2], &mut way_back, &mut counts) {
            return;
        }
        let mut bsdf = Bsdf::BLACK;
        if !tracer.evaluate(&mut y, &mut bsdf) {
            return;
        }
        let reference = chain.vertices[1].reference;
        of_y.set(tables, &y, reference, roughness_kind::LOCAL, &mut bsdf);
        let Some(found) = Segment::<N>::new(&of_y, 0, 3, SLOPE) else {
            return;
        };
        let options = closing.options(tracer, x, chain, SLOPE);
        let own = mutate(
            tracer.view,
            &segment.vertices,
            &segment.jacobian,
            target,
            &options,
        );
        assert_eq!(own.kind, mutation_kind::JUMP);
        let measure = |path: &ChainPath, chain: &PathChain, segment: &Segment<N>| {
            segment_factor(
                tables,
                path,
                chain,
                &segment.vertices,
                &segment.jacobian,
                0,
                SLOPE,
            )
        };
        let got = measure(&y, &of_y, &found)
            .product(factor)
            .over(measure(x, chain, segment));
        let areas = |path: &ChainPath| -> f64 {
            (0..3)
                .map(|i| -f64::from(path.solid_angle_per_area(tables, i)).ln())
                .sum()
        };
        let densities = own.reverse_factor.over(own.forward_factor);
        let expected = areas(&y) - areas(x) + f64::from(densities.ln_abs());
        let ill = found.jacobian.condition().max(segment.jacobian.condition());
        if ill < 1e3 {
            let error = (f64::from(got.ln_abs()) - expected).abs();
            assert!(error < 0.02, "{error}");
            jumps += 1;
            // What would be missed without the factor.
            let carried = density_factor(&found.jacobian).over(density_factor(&segment.jacobian));
            spread += densities
                .ln_abs()
                .abs()
                .min(carried.product(densities).ln_abs().abs());
        }
    });
    println!(
        "{jumps} jumps, mean logarithm of the factor {}",
        spread / jumps as f32
    );
    assert!(jumps > 30 && spread / jumps as f32 > 0.1);
}
