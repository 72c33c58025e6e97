//! Recorded paths as a tree of clusters (Kaplanyan 2017, section 9.1.1.2).
//!
//! All paths are one cluster. It is divided by what happens at the vertex next to one of the ends, by the kind of scattering
//! or by the object; each part is divided by the next vertex, and so on to the other end. Where a division has one part only, it
//! is left out and its vertex added to the cluster's own.
//!
//! Invariants (tests, against a grouping of all beginnings of all paths): weights of children sum to that of their parent, since
//! no path ends before its other end; the clusters are the different sets of paths that share a beginning.

use super::super::record_file::{PathRecord, kind_name};
use halflight_kernel::scene::NONE;
use halflight_kernel::transport::recorded::{RecordedVertex, vertex_kind};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::ops::Range;

/// What distinguishes vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ClusterBy {
    /// The kind of scattering.
    Expression,
    /// The object, by its name if it has one.
    Object,
}

/// At which end clusters begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ClusterFrom {
    /// The emitter.
    Light,
    /// The sensor.
    Sensor,
}

/// Paths that share the vertices at one end.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// What those vertices are that it has beyond its parent's, one after the other.
    pub labels: Vec<String>,
    /// Number of all vertices that its paths share.
    pub shared: usize,
    /// Its paths, as indices into [`ClusterTree::order`].
    pub range: Range<usize>,
    /// Sum of the weights of its paths.
    pub weight: f64,
    /// The heaviest first, equally heavy ones by their labels.
    pub children: Vec<Cluster>,
}

/// All clusters of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterTree {
    /// Indices of the paths, those of each cluster next to each other.
    pub order: Vec<u32>,
    /// All paths.
    pub root: Cluster,
}

/// What a vertex is called in clusters.
pub fn label(record: &PathRecord, vertex: &RecordedVertex, by: ClusterBy) -> String {
    if by == ClusterBy::Expression {
        return kind_name(vertex.kind).to_owned();
    }
    let (kind, names) = match vertex.kind {
        vertex_kind::SENSOR => return "sensor".to_owned(),
        vertex_kind::LIGHT | vertex_kind::LIGHT_AT_INFINITY => ("light", &record.header.emitters),
        _ => ("object", &record.header.shapes),
    };
    let name = names.get(vertex.object as usize).filter(|n| !n.is_empty());
    match name {
        Some(name) if kind == "light" => format!("light {name}"),
        Some(name) => name.clone(),
        None if vertex.object == NONE => kind.to_owned(),
        None => {
            let materials = (kind == "object").then_some(&record.header.materials);
            let material = materials.and_then(|m| m.get(vertex.object as usize));
            match material.filter(|m| !m.is_empty()) {
                Some(material) => format!("object {} ({material})", vertex.object),
                None => format!("{kind} {}", vertex.object),
            }
        }
    }
}

impl ClusterTree {
    /// The clusters of some paths of a record, given by their indices.
    pub fn of(
        record: &PathRecord,
        paths: Vec<u32>,
        by: ClusterBy,
        from: ClusterFrom,
    ) -> ClusterTree {
        let mut numbers: HashMap<String, u32> = HashMap::new();
        let mut labels: Vec<String> = Vec::new();
        // Labels of a record are few: each kind and object is named once.
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        let mut number = |vertex: &RecordedVertex| {
            *known
                .entry((vertex.kind, vertex.object))
                .or_insert_with(|| {
                    let name = label(record, vertex, by);
                    *numbers.entry(name.clone()).or_insert_with(|| {
                        labels.push(name);
                        labels.len() as u32 - 1
                    })
                })
        };
        let words: HashMap<u32, Vec<u32>> = paths
            .iter()
            .map(|path| {
                let mut word: Vec<u32> = record.paths[*path as usize]
                    .vertices
                    .iter()
                    .map(&mut number)
                    .collect();
                if from == ClusterFrom::Light {
                    word.reverse();
                }
                (*path, word)
            })
            .collect();
        let division = Division {
            record,
            words: &words,
            labels: &labels,
        };
        let mut order = paths;
        let root = division.cluster(&mut order, 0, 0);
        ClusterTree { order, root }
    }

    /// The paths of a cluster.
    pub fn paths(&self, cluster: &Cluster) -> &[u32] {
        &self.order[cluster.range.clone()]
    }

    /// The clusters that are not divided any more: of paths that are the same all along.
    pub fn leaves(&self) -> Vec<&Cluster> {
        let mut leaves = Vec::new();
        let mut stack = vec![&self.root];
        while let Some(cluster) = stack.pop() {
            if cluster.children.is_empty() {
                leaves.push(cluster);
            }
            stack.extend(cluster.children.iter().rev());
        }
        leaves
    }

    /// The tree for other programs: labels, number and weight of the paths of each cluster.
    pub fn json(&self) -> Value {
        fn of(cluster: &Cluster) -> Value {
            json!({
                "labels": cluster.labels,
                "paths": cluster.range.len(),
                "weight": cluster.weight,
                "children": cluster.children.iter().map(of).collect::<Vec<_>>(),
            })
        }
        of(&self.root)
    }
}

/// What does not change while clusters are divided.
struct Division<'a> {
    record: &'a PathRecord,
    /// Numbers of labels of each path, from the end where clusters begin.
    words: &'a HashMap<u32, Vec<u32>>,
    labels: &'a [String],
}

impl Division<'_> {
    fn label_at(&self, path: u32, index: usize) -> Option<u32> {
        self.words[&path].get(index).copied()
    }

    /// The cluster of paths that share `shared` vertices with each other and `above` with their parent; `begin` is the place of
    /// the first of them in the order. They are brought into that order.
    fn cluster(&self, paths: &mut [u32], above: usize, begin: usize) -> Cluster {
        let mut shared = above;
        let first = paths.first().copied();
        while let Some(label) = first.and_then(|f| self.label_at(f, shared))
            && paths
                .iter()
                .all(|p| self.label_at(*p, shared) == Some(label))
        {
            shared += 1;
        }
        let shared_labels = first.map_or(&[][..], |f| &self.words[&f][above..shared]);
        let weight = |paths: &[u32]| -> f64 {
            paths
                .iter()
                .map(|p| f64::from(self.record.paths[*p as usize].weight))
                .sum()
        };
        let mut cluster = Cluster {
            labels: shared_labels
                .iter()
                .map(|l| self.labels[*l as usize].clone())
                .collect(),
            shared,
            range: begin..begin + paths.len(),
            weight: weight(paths),
            children: Vec::new(),
        };
        let mut groups: HashMap<Option<u32>, Vec<u32>> = HashMap::new();
        for path in &*paths {
            groups
                .entry(self.label_at(*path, shared))
                .or_default()
                .push(*path);
        }
        if groups.len() < 2 {
            return cluster;
        }
        let mut groups: Vec<(Option<u32>, f64, Vec<u32>)> = groups
            .into_iter()
            .map(|(label, paths)| (label, weight(&paths), paths))
            .collect();
        let name = |label: Option<u32>| label.map(|l| &self.labels[l as usize]);
        groups.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| name(a.0).cmp(&name(b.0))));
        let mut at = 0;
        for (_, _, mut group) in groups {
            cluster
                .children
                .push(self.cluster(&mut group, shared, begin + at));
            paths[at..at + group.len()].copy_from_slice(&group);
            at += group.len();
        }
        cluster
    }
}
