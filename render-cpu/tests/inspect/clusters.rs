//! Clusters and bundles of random paths against a grouping of all their beginnings.

use halflight::inspect::paths::Places;
use halflight::inspect::paths::bundle::{Bundle, bundles};
use halflight::inspect::paths::cluster::{Cluster, ClusterBy, ClusterFrom, ClusterTree};
use halflight::inspect::record_file::{PathRecord, RecordHeader, RecordedPath, kind_name};
use halflight_kernel::glam::DVec3;
use halflight_kernel::scene::NONE;
use halflight_kernel::transport::recorded::{RecordedVertex, vertex_kind};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

const SHAPES: [&str; 4] = ["floor", "", "ring", "floor"];
const EMITTERS: [&str; 2] = ["key", "sky"];

fn vertex(kind: u32, object: u32, position: [f32; 3]) -> RecordedVertex {
    RecordedVertex {
        position,
        kind,
        object,
        throughput: [1.0; 3],
    }
}

/// Paths of up to five surfaces, of few kinds and objects, so that many share a beginning.
fn record() -> impl Strategy<Value = PathRecord> {
    let place = prop::array::uniform3(-1.0f32..1.0);
    let surface = (0u32..6, 0u32..4, place.clone()).prop_map(|(k, o, p)| vertex(k, o, p));
    let light = (0u32..2, place.clone()).prop_map(|(i, p)| vertex(vertex_kind::LIGHT + i, i, p));
    let path = (
        prop::collection::vec(surface, 0..5),
        light,
        place,
        0.01f32..4.0,
    );
    let paths = path.prop_map(|(surfaces, light, sensor, weight)| RecordedPath {
        pixel: [0, 0],
        light: [weight; 3],
        weight,
        vertices: std::iter::once(vertex(vertex_kind::SENSOR, NONE, sensor))
            .chain(surfaces)
            .chain([light])
            .collect(),
    });
    prop::collection::vec(paths, 0..60).prop_map(|paths| PathRecord {
        header: RecordHeader {
            count: paths.len(),
            shapes: SHAPES.map(String::from).to_vec(),
            emitters: EMITTERS.map(String::from).to_vec(),
            ..RecordHeader::default()
        },
        paths,
    })
}

/// What a vertex counts as: written anew, without the tree's labels.
fn letter(v: &RecordedVertex, by: ClusterBy) -> String {
    match (by, v.kind) {
        (ClusterBy::Expression, kind) => kind_name(kind).to_owned(),
        (_, vertex_kind::SENSOR) => "the sensor".to_owned(),
        (_, 0..6) if SHAPES[v.object as usize].is_empty() => format!("number {}", v.object),
        (_, 0..6) => SHAPES[v.object as usize].to_owned(),
        _ => format!("emitter {}", v.object),
    }
}

fn all<'a>(cluster: &'a Cluster, found: &mut Vec<&'a Cluster>) {
    found.push(cluster);
    cluster.children.iter().for_each(|c| all(c, found));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn clusters_are_the_sets_of_paths_with_a_common_beginning(record in record(), by_object in any::<bool>(), from_light in any::<bool>()) {
        let by = if by_object { ClusterBy::Object } else { ClusterBy::Expression };
        let from = if from_light { ClusterFrom::Light } else { ClusterFrom::Sensor };
        let indices: Vec<u32> = (0..record.paths.len() as u32).collect();
        let tree = ClusterTree::of(&record, indices.clone(), by, from);
        let word = |path: &RecordedPath| -> Vec<String> {
            let letters = path.vertices.iter().map(|v| letter(v, by));
            if from_light { letters.rev().collect() } else { letters.collect() }
        };
        // All beginnings of all paths; of those with the same paths, the longest is the cluster's.
        let mut beginnings: BTreeMap<Vec<String>, BTreeSet<u32>> = BTreeMap::new();
        for (i, path) in record.paths.iter().enumerate() {
            let word = word(path);
            for length in 0..=word.len() {
                beginnings.entry(word[..length].to_vec()).or_default().insert(i as u32);
            }
        }
        let mut expected: BTreeMap<BTreeSet<u32>, usize> = BTreeMap::new();
        for (beginning, paths) in beginnings {
            let longest = expected.entry(paths).or_default();
            *longest = beginning.len().max(*longest);
        }
        let mut clusters = Vec::new();
        all(&tree.root, &mut clusters);
        let mut found: BTreeMap<BTreeSet<u32>, usize> = BTreeMap::new();
        for cluster in &clusters {
            let paths: BTreeSet<u32> = tree.paths(cluster).iter().copied().collect();
            prop_assert_eq!(paths.len(), cluster.range.len());
            let weight: f64 = paths.iter().map(|p| f64::from(record.paths[*p as usize].weight)).sum();
            prop_assert!((cluster.weight - weight).abs() < 1e-9);
            if !cluster.children.is_empty() {
                let sum: f64 = cluster.children.iter().map(|c| c.weight).sum();
                prop_assert!((cluster.weight - sum).abs() < 1e-9);
                prop_assert!(cluster.children.windows(2).all(|c| c[0].weight >= c[1].weight));
                prop_assert_eq!(cluster.children[0].range.start, cluster.range.start);
                prop_assert_eq!(cluster.children.last().unwrap().range.end, cluster.range.end);
            }
            found.insert(paths, cluster.shared);
        }
        if record.paths.is_empty() {
            prop_assert_eq!(clusters.len(), 1);
        } else {
            prop_assert_eq!(clusters.len(), expected.len());
            prop_assert_eq!(found, expected);
        }
        let mut order = tree.order.clone();
        order.sort_unstable();
        prop_assert_eq!(order, indices);
    }

    #[test]
    fn bundles_keep_the_weight_and_spread_less_the_more_there_are(record in record(), count in 1usize..30) {
        let places = Places::of(&record);
        let indices = || vec![(0..record.paths.len() as u32).collect::<Vec<_>>()];
        let weight = |found: &[Bundle]| found.iter().map(|b| b.weight).sum::<f64>();
        let scatter = |found: &[Bundle]| found.iter().map(Bundle::scatter).sum::<f64>();
        let few = bundles(&record, &places, indices(), count);
        prop_assert!(few.len() <= count.max(1));
        let total: f64 = record.paths.iter().map(|p| f64::from(p.weight)).sum();
        prop_assert!((weight(&few) - total).abs() < 1e-9);
        let mut own: Vec<u32> = few.iter().flat_map(|b| b.paths.clone()).collect();
        own.sort_unstable();
        prop_assert_eq!(own, indices().remove(0));
        for bundle in &few {
            // By hand: means, spreads, and the path that is nearest.
            let paths: Vec<&RecordedPath> = bundle.paths.iter().map(|p| &record.paths[*p as usize]).collect();
            let own: f64 = paths.iter().map(|p| f64::from(p.weight)).sum();
            let place = |p: u32, i: usize| places.paths[p as usize][i].as_dvec3();
            let shared = paths.iter().map(|p| p.vertices.len()).min().unwrap();
            prop_assert_eq!(bundle.means.len(), shared);
            let distance = |p: u32| (0..shared).map(|i| place(p, i).distance_squared(bundle.means[i])).sum::<f64>();
            for i in 0..shared {
                let weighted = |f: &dyn Fn(u32) -> DVec3| -> DVec3 {
                    bundle.paths.iter().map(|p| f(*p) * f64::from(record.paths[*p as usize].weight) / own).sum()
                };
                let mean = weighted(&|p| place(p, i));
                prop_assert!(mean.distance(bundle.means[i]) < 1e-9);
                let variance = weighted(&|p| DVec3::splat(place(p, i).distance_squared(mean))).x;
                prop_assert!((variance.sqrt() - bundle.spread[i]).abs() < 1e-6);
            }
            prop_assert!(bundle.paths.iter().all(|p| distance(bundle.representative) <= distance(*p)));
        }
        let first = record.paths.first().map_or(0, |p| p.vertices.len());
        if record.paths.iter().all(|p| p.vertices.len() == first) {
            // Otherwise parts may share more vertices than the whole, which then count as well.
            let more = bundles(&record, &places, indices(), count + 1);
            prop_assert!(scatter(&more) <= scatter(&few) * (1.0 + 1e-9) + 1e-12);
        }
    }
}

/// The example of the thesis: the last interactions first, then the ones before.
#[test]
fn the_example_of_the_thesis() {
    use halflight_kernel::path::expression::scattering::{
        DIFFUSE_REFLECTION as D, SPECULAR_REFLECTION as S,
    };
    let path = |surfaces: [u32; 3], weight| RecordedPath {
        pixel: [0, 0],
        light: [1.0; 3],
        weight,
        vertices: [
            vertex_kind::SENSOR,
            surfaces[2],
            surfaces[1],
            surfaces[0],
            vertex_kind::LIGHT,
        ]
        .map(|k| vertex(k, 0, [0.0; 3]))
        .to_vec(),
    };
    let record = PathRecord {
        header: RecordHeader::default(),
        paths: vec![
            path([D, D, D], 1.0),
            path([D, S, S], 2.5),
            path([D, S, D], 0.5),
        ],
    };
    let tree = ClusterTree::of(
        &record,
        vec![0, 1, 2],
        ClusterBy::Expression,
        ClusterFrom::Sensor,
    );
    assert_eq!(
        (tree.root.labels.as_slice(), tree.root.weight),
        (&["E".to_owned()][..], 4.0)
    );
    let [specular, diffuse] = &tree.root.children[..] else {
        panic!("{:?}", tree.root)
    };
    assert_eq!((tree.paths(specular), specular.labels.len()), (&[1][..], 4));
    assert_eq!(
        (diffuse.labels.as_slice(), diffuse.weight),
        (&["D^R".to_owned()][..], 1.5)
    );
    let seconds: Vec<&str> = diffuse
        .children
        .iter()
        .map(|c| c.labels[0].as_str())
        .collect();
    assert_eq!(seconds, ["D^R", "S^R"]);
}
