//! Of the edges of a path that nothing samples one and only one is connected with a blurred end, by words of D and S.

use halflight_kernel::path::specular_chain::{SpecularChain, is_chosen, state};

mod common;
use common::Random;

/// Whether the walk along the vertices from an end in `start` is chosen, joined after `count` of them.
fn subpath(start: u32, vertices: &[bool], edges: &[f32]) -> SpecularChain {
    let mut chain = SpecularChain::start(start, edges[0]);
    for (is_specular, edge) in vertices.iter().zip(&edges[1..]) {
        chain = SpecularChain {
            edge: *edge,
            ..chain.scattered(*is_specular)
        };
    }
    chain
}

/// The state of a subpath whose last vertex is given apart, `None` for the start itself.
fn end(start: u32, vertices: &[bool], edges: &[f32]) -> SpecularChain {
    match vertices.split_last() {
        None => SpecularChain::start(start, 0.0),
        Some((last, rest)) => subpath(start, rest, edges).ending(*last),
    }
}

#[test]
fn one_edge_is_chosen_of_a_path_that_nothing_samples() {
    let mut random = Random(12);
    let mut unsampled = 0;
    for _ in 0..20_000 {
        let count = 1 + (random.next_1d() * 7.0) as usize;
        let vertices: Vec<bool> = (0..count).map(|_| random.next_1d() < 0.7).collect();
        // Equal lengths are as likely as not.
        let edges: Vec<f32> = (0..=count)
            .map(|_| 1.0 + (random.next_1d() * 3.0).floor())
            .collect();
        let merges = random.next_1d() < 0.3;
        let start = state::IS_ROUGH | if merges { state::MERGES } else { 0 };
        let rough = |i: usize| i == 0 || i == count + 1 || !vertices[i - 1];
        let is_sampled =
            (0..=count).any(|i| rough(i) && rough(i + 1)) || merges && vertices.contains(&false);
        let backward: Vec<bool> = vertices.iter().rev().copied().collect();
        let back_edges: Vec<f32> = edges.iter().rev().copied().collect();
        let mut chosen = 0;
        for s in 0..=count {
            let light = end(start, &vertices[..s], &edges);
            let camera = end(start, &backward[..count - s], &back_edges);
            if rough(s) == rough(s + 1) {
                continue;
            }
            // The start's own last edge does not exist.
            let wins = is_chosen(&light, &camera, edges[s]);
            chosen += usize::from(wins);
            if wins {
                let candidates = (0..=count).filter(|i| rough(*i) != rough(*i + 1));
                let longest = candidates.map(|i| edges[i]).fold(0.0, f32::max);
                assert!(edges[s] == longest, "{vertices:?} {edges:?}");
            }
        }
        assert_eq!(chosen, usize::from(!is_sampled), "{vertices:?} {edges:?}");
        unsampled += usize::from(!is_sampled);
    }
    assert!(unsampled > 3000, "{unsampled}");
}

#[test]
fn what_a_ray_can_hit_is_sampled() {
    let light = end(state::SAMPLED, &[true], &[1.0, 1.0]);
    let camera = end(state::IS_ROUGH, &[], &[1.0]);
    assert!(!is_chosen(&light, &camera, 1.0));
}
