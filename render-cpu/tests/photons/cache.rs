//! The cache finds each photon within a radius once, as a look at all of them does.

use glam::Vec3;
use halflight::render::{PhotonList, SortedPhotons};
use halflight_kernel::transport::photon::cache::{Photon, PhotonQuery};
use halflight_kernel::transport::photon::estimate::for_photons_within;
use halflight_kernel::transport::photon::tracing::PhotonStore;
use proptest::prelude::*;

/// Photon number `i`, told apart by its depth.
fn photon(i: usize) -> Photon {
    Photon {
        depth: i as u32,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Lists of the positions, cut into pieces.
fn lists(positions: &[Vec3], piece: usize) -> Vec<PhotonList> {
    let mut lists = Vec::new();
    for (k, chunk) in positions.chunks(piece.max(1)).enumerate() {
        let mut list = PhotonList::default();
        for (i, &position) in chunk.iter().enumerate() {
            list.push(position, &photon(k * piece.max(1) + i));
        }
        lists.push(list);
    }
    lists
}

/// Photons within the radius, found by the cache and by looking at all.
fn both_ways(
    sorted: &SortedPhotons,
    positions: &[Vec3],
    center: Vec3,
    radius: f32,
) -> [Vec<u32>; 2] {
    let cache = sorted.view();
    let mut found = Vec::new();
    for_photons_within(&cache, center, radius, |index, distance2| {
        let photon = cache.photons[index as usize].depth;
        let distance = (positions[photon as usize] - center).length_squared();
        assert_eq!(distance, distance2);
        found.push(photon);
    });
    found.sort_unstable();
    let all = (0..positions.len() as u32)
        .filter(|&i| (positions[i as usize] - center).length_squared() < radius * radius);
    [found, all.collect()]
}

/// Positions in space, on a plane, in clusters, or all the same, far from the origin or near it.
fn positions() -> impl Strategy<Value = Vec<Vec3>> {
    let shape = (
        0..4_u32,
        prop_oneof![Just(0.0_f32), Just(1e3), Just(-40.0)],
        1e-3..1e3_f32,
    );
    (
        shape,
        prop::collection::vec(prop::array::uniform3(-1.0..1.0_f32), 0..900),
    )
        .prop_map(|((shape, offset, scale), points)| {
            points
                .into_iter()
                .enumerate()
                .map(|(i, [x, y, z])| {
                    let p = match shape {
                        0 => Vec3::new(x, y, z),
                        1 => Vec3::new(x, 0.25, z),
                        2 => Vec3::new(x, y, z) * 1e-3 + Vec3::splat((i % 3) as f32),
                        _ => Vec3::new(0.1, 0.2, 0.3),
                    };
                    p * scale + Vec3::splat(offset)
                })
                .collect()
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Radii from far below a cell to far above the cube, centres on photons, between them, and far away.
    #[test]
    fn queries_find_what_brute_force_finds(
        positions in positions(),
        piece in 1..400_usize,
        radius in -6.0..1.5_f32,
        at in 0..900_usize,
        shift in prop::array::uniform3(-1.0..1.0_f32),
    ) {
        let sorted = SortedPhotons::new(&lists(&positions, piece));
        let low = positions.iter().copied().fold(Vec3::MAX, Vec3::min);
        let high = positions.iter().copied().fold(Vec3::MIN, Vec3::max);
        let side = if positions.is_empty() { 1.0 } else { (high - low).max_element().max(1e-3) };
        let radius = side * 10.0_f32.powf(radius);
        for scale in [0.0, 0.5, 1.0, 30.0] {
            let center = positions.get(at).copied().unwrap_or(low)
                + Vec3::from_array(shift) * (radius * scale);
            if center.is_finite() {
                let [found, all] = both_ways(&sorted, &positions, center, radius);
                prop_assert_eq!(found, all);
            }
        }
        let nothing = both_ways(&sorted, &positions, Vec3::ZERO, 0.0);
        prop_assert!(nothing[0].is_empty());
    }
}

fn scattered(count: usize) -> Vec<Vec3> {
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    (0..count)
        .map(|i| {
            let p = Vec3::new(next(), next(), next());
            // Half of them in a spot.
            if i % 2 == 0 { p * 0.01 } else { p }
        })
        .collect()
}

/// The order does not depend on how the photons were divided among lists, nor on the threads.
#[test]
fn order_depends_on_the_photons_alone() {
    let positions = scattered(20_000);
    let order = |piece: usize, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let sorted = pool.install(|| SortedPhotons::new(&lists(&positions, piece)));
        let cache = sorted.view();
        assert!(cache.keys.is_sorted());
        let photons: Vec<u32> = cache.photons.iter().map(|p| p.depth).collect();
        (
            cache.starts.to_vec(),
            cache.keys.to_vec(),
            cache.positions.to_vec(),
            photons,
        )
    };
    let whole = order(usize::MAX, 1);
    for (piece, threads) in [(1000, 1), (1000, 4), (77, 3)] {
        assert_eq!(order(piece, threads), whole, "{piece} {threads}");
    }
}

/// No query looks at much more than it has to: photons on a plane, radii of all sizes.
#[test]
fn queries_look_at_few_photons_in_vain() {
    let mut positions = scattered(100_000);
    positions.iter_mut().for_each(|p| p.z = 0.0);
    let sorted = SortedPhotons::new(&lists(&positions, 4096));
    let cache = sorted.view();
    for radius in [0.003, 0.01, 0.05, 0.2] {
        let center = Vec3::new(0.5, 0.5, 0.0);
        let mut query = PhotonQuery::new(&cache, center, radius);
        let (mut seen, mut ranges) = (0, 0);
        while query.advance(&cache) {
            seen += query.end - query.start;
            ranges += 1;
        }
        let expected = 50_000.0 * std::f32::consts::PI * radius * radius;
        assert!(
            (seen as f32) < 8.0 * expected + 50.0,
            "{radius}: {seen} for {expected}"
        );
        assert!(ranges <= 27, "{radius}: {ranges}");
    }
    // What the documentation says of memory.
    assert!(
        sorted.memory_bytes() <= 80 * positions.len(),
        "{}",
        sorted.memory_bytes()
    );
}
