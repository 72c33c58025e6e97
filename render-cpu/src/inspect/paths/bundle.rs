//! Bundles: many paths as one, with a weight, a path that stands for them, and how far they spread.
//!
//! With x_i vertex i of a path and w its weight, a bundle has the weights' sum W, the mean m_i = sum w x_i / W, and the spread
//! s_i = sqrt(sum w |x_i - m_i|^2 / W) in scene units. The path that stands for it is that whose vertices are nearest to the
//! means, by the sum of squares.
//!
//! Paths over the same kinds of vertices may still be far apart, as all that leave a lamp and meet a floor. So the bundles of a
//! picture are divided where they spread most, in turn, until there are enough: a cut through the mean, across the
//! coordinate of largest variance (Heckbert 1982, for colours), which makes the sum of W s_i^2 less at every step.

use super::super::record_file::PathRecord;
use super::Places;
use glam::DVec3;
use std::collections::BinaryHeap;

/// Many paths as one.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Indices of its paths, in their order in the record.
    pub paths: Vec<u32>,
    /// Sum of their weights.
    pub weight: f64,
    /// Mean of each vertex that all of them have, from the sensor.
    pub means: Vec<DVec3>,
    /// How far each of these vertices spreads, in scene units.
    pub spread: Vec<f64>,
    /// Index of the path that stands for all.
    pub representative: u32,
    /// Vertex and axis of the largest variance.
    widest: (usize, usize),
}

impl Bundle {
    /// The bundle of some paths, of which at least the shortest's number of vertices is shared.
    pub fn of(record: &PathRecord, places: &Places, mut paths: Vec<u32>) -> Bundle {
        paths.sort_unstable();
        let shared = paths
            .iter()
            .map(|p| places.paths[*p as usize].len())
            .min()
            .unwrap_or(0);
        let position = |path: u32, i: usize| places.paths[path as usize][i].as_dvec3();
        let weight_of = |path: u32| f64::from(record.paths[path as usize].weight);
        let weight: f64 = paths.iter().map(|p| weight_of(*p)).sum();
        let share = |path: u32| {
            if weight > 0.0 {
                weight_of(path) / weight
            } else {
                0.0
            }
        };
        let means: Vec<DVec3> = (0..shared)
            .map(|i| paths.iter().map(|p| share(*p) * position(*p, i)).sum())
            .collect();
        let variances: Vec<DVec3> = (0..shared)
            .map(|i| {
                paths
                    .iter()
                    .map(|p| share(*p) * (position(*p, i) - means[i]).powf(2.0))
                    .sum()
            })
            .collect();
        let axes = variances.iter().enumerate();
        let axes = axes.flat_map(|(i, v)| (0..3).map(move |axis| (v[axis], (i, axis))));
        let widest = axes
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map_or((0, 0), |(_, at)| at);
        let distance = |path: u32| -> f64 {
            (0..shared)
                .map(|i| (position(path, i) - means[i]).length_squared())
                .sum()
        };
        let nearest = paths.iter().map(|p| (distance(*p), *p));
        let representative = nearest
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(0, |(_, p)| p);
        Bundle {
            weight,
            spread: variances.iter().map(|v| v.element_sum().sqrt()).collect(),
            means,
            representative,
            paths,
            widest,
        }
    }

    /// Weight times squared spread of all vertices.
    pub fn scatter(&self) -> f64 {
        self.weight * self.spread.iter().map(|s| s * s).sum::<f64>()
    }

    /// The two parts on either side of the mean; none if nothing spreads.
    fn divided(&self, record: &PathRecord, places: &Places) -> Option<[Bundle; 2]> {
        let (vertex, axis) = self.widest;
        let mean = self.means.get(vertex)?[axis];
        let is_below = |p: &u32| f64::from(places.paths[*p as usize][vertex][axis]) < mean;
        let (below, above): (Vec<u32>, Vec<u32>) = self.paths.iter().partition(|p| is_below(p));
        if below.is_empty() || above.is_empty() {
            return None;
        }
        Some([below, above].map(|paths| Bundle::of(record, places, paths)))
    }
}

/// A bundle in the order of its scatter.
struct Widest(Bundle);

impl PartialEq for Widest {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Widest {}

impl PartialOrd for Widest {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Widest {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let scatter = self.0.scatter().total_cmp(&other.0.scatter());
        scatter.then_with(|| other.0.representative.cmp(&self.0.representative))
    }
}

/// Bundles of paths that are grouped already, divided where they spread most until there are `count` (more, if there are more
/// groups). The heaviest is the first.
pub fn bundles(
    record: &PathRecord,
    places: &Places,
    groups: Vec<Vec<u32>>,
    count: usize,
) -> Vec<Bundle> {
    let groups = groups.into_iter().filter(|g| !g.is_empty());
    let mut open: BinaryHeap<Widest> = groups
        .map(|paths| Widest(Bundle::of(record, places, paths)))
        .collect();
    let mut closed = Vec::new();
    while open.len() + closed.len() < count
        && let Some(Widest(bundle)) = open.pop()
    {
        match bundle.divided(record, places) {
            Some(parts) => open.extend(parts.map(Widest)),
            None => closed.push(bundle),
        }
    }
    closed.extend(open.into_iter().map(|b| b.0));
    closed.sort_by(|a, b| {
        b.weight
            .total_cmp(&a.weight)
            .then(a.representative.cmp(&b.representative))
    });
    closed
}
