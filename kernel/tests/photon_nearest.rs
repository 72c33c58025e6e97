//! Distances to the k-th nearest photon against all distances, sorted.

use glam::Vec3;
use halflight_kernel::transport::photon::cache::{Photon, PhotonCache, PhotonGrid};
use halflight_kernel::transport::photon::nearest::{MOST_NEAREST, nearest_distance};
use proptest::prelude::*;

/// Positions in the order of a cache, its keys and the starts of its cells.
struct Sorted {
    grid: PhotonGrid,
    starts: Vec<u32>,
    keys: Vec<u32>,
    positions: Vec<[f32; 3]>,
    photons: Vec<Photon>,
}

impl Sorted {
    fn new(positions: &[Vec3]) -> Sorted {
        let low = positions
            .iter()
            .copied()
            .reduce(Vec3::min)
            .unwrap_or(Vec3::ZERO);
        let high = positions
            .iter()
            .copied()
            .reduce(Vec3::max)
            .unwrap_or(Vec3::ZERO);
        let grid = PhotonGrid::around(low, high, positions.len() as u32);
        let mut sorted: Vec<(u32, Vec3)> = positions.iter().map(|p| (grid.key(*p), *p)).collect();
        sorted.sort_by_key(|(key, _)| *key);
        let below = |cell: u32| sorted.partition_point(|(key, _)| grid.table_cell(*key) < cell);
        Sorted {
            grid,
            starts: (0..=grid.table_cells())
                .map(|cell| below(cell) as u32)
                .collect(),
            keys: sorted.iter().map(|(key, _)| *key).collect(),
            positions: sorted.iter().map(|(_, p)| p.to_array()).collect(),
            photons: vec![bytemuck::Zeroable::zeroed(); positions.len()],
        }
    }

    fn view(&self) -> PhotonCache<'_> {
        PhotonCache {
            grid: self.grid,
            starts: &self.starts,
            keys: &self.keys,
            positions: &self.positions,
            photons: &self.photons,
        }
    }
}

fn point() -> impl Strategy<Value = Vec3> {
    // Dense near one corner, as in a caustic.
    (0.0_f32..1.0, 0.0_f32..1.0, 0.0_f32..1.0, 1_i32..6)
        .prop_map(|(x, y, z, power)| Vec3::new(x.powi(power), y.powi(power), z))
}

proptest! {
    #[test]
    fn the_distance_is_that_of_all_distances_in_order(
        positions in proptest::collection::vec(point(), 0..300),
        center in point(),
        wanted in 1..=MOST_NEAREST,
        largest in 0.01_f32..3.0,
    ) {
        let sorted = Sorted::new(&positions);
        let found = nearest_distance(&sorted.view(), center, wanted, largest);
        let mut distances: Vec<f32> = positions.iter().map(|p| (*p - center).length()).collect();
        distances.sort_by(f32::total_cmp);
        let expected = distances
            .get(wanted as usize - 1)
            .map_or(largest, |distance| distance.min(largest));
        prop_assert!((found - expected).abs() <= 1e-5 * expected, "{found}, not {expected}");
    }
}
