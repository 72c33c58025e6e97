//! Arguments of what looks at recorded paths.

use super::scene_args::{check_window, parse_numbers};
use crate::expression::PathParts;
use crate::inspect::paths::Places;
use crate::inspect::paths::bundle::bundles;
use crate::inspect::paths::cluster::{ClusterBy, ClusterFrom, ClusterTree, label};
use crate::inspect::paths::matching::matched;
use crate::inspect::paths::picture::Group;
use crate::inspect::record::{Choice, record};
use crate::inspect::record_file::PathRecord;
use crate::scene::build::Scene;
use clap::Args;
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::recorded::{RecordedVertex, vertex_kind};
use std::error::Error;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

/// Share of the light below which a cluster has no bundles.
const LEAST_SHARE: f64 = 0.005;

/// Which recorded paths, and how they are grouped.
#[derive(Args, Clone, Debug)]
pub struct PathArgs {
    /// A record of the scene's paths, as --record of halflight render writes it (not its lines of JSON). Default: paths are recorded
    /// now.
    #[arg(help_heading = "Paths", long, value_name = "PATHS")]
    pub paths: Option<PathBuf>,
    /// Most paths that are recorded now.
    #[arg(help_heading = "Paths", long, value_name = "N", default_value_t = 10_000, conflicts_with = "paths",
        value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub record_count: u32,
    /// The paths of some pixels of the whole image alone.
    #[arg(help_heading = "Paths", long, value_name = "X,Y,W,H", value_parser = parse_window)]
    pub pixels: Option<[u32; 4]>,
    /// What distinguishes clusters of paths.
    #[arg(
        help_heading = "Paths",
        long,
        value_enum,
        value_name = "WHAT",
        default_value = "expression"
    )]
    pub cluster: ClusterBy,
    /// At which end clusters begin.
    #[arg(
        help_heading = "Paths",
        long,
        value_enum,
        value_name = "END",
        default_value = "light"
    )]
    pub from: ClusterFrom,
    /// Number of bundles that are drawn, of clusters with a two-hundredth of the light at least.
    #[arg(help_heading = "Paths", long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub bundles: u32,
}

impl PathArgs {
    /// The record: that of the file, or one that is made now from `samples` samples per pixel; of both what `parts` and
    /// the pixels leave.
    ///
    /// # Errors
    /// If the file cannot be read, or is of another scene.
    pub(super) fn load<T: Traverse + Sync>(
        &self,
        view: &SceneView<'_, T>,
        scene: &Scene,
        parts: &PathParts,
        samples: u32,
        seed: u32,
    ) -> Result<PathRecord, Box<dyn Error + Send + Sync>> {
        if let Some(window) = self.pixels {
            check_window(window, scene)?;
        }
        let Some(path) = &self.paths else {
            let choice = Choice {
                most: self.record_count as usize,
                samples,
                seed,
                first_sample: 0,
                pixels: self.pixels,
            };
            return Ok(record(view, scene, parts, &choice));
        };
        let name = path.display();
        let wrong = |what: String| Err(format!("{name}: {what}").into());
        let read = File::open(path).and_then(|f| PathRecord::read_bytes(&mut BufReader::new(f)));
        let mut found = match read {
            Ok(found) => found,
            Err(error) => return wrong(error.to_string()),
        };
        let [shapes, emitters] = [scene.tables.shapes.len(), scene.tables.emitters.len()];
        let is_there = |v: &RecordedVertex| match v.kind {
            vertex_kind::SENSOR => true,
            vertex_kind::LIGHT | vertex_kind::LIGHT_AT_INFINITY => (v.object as usize) < emitters,
            _ => (v.object as usize) < shapes,
        };
        if found.header.shapes != scene.names.shapes
            || found.header.emitters != scene.names.emitters
            || !found.paths.iter().flat_map(|p| &p.vertices).all(is_there)
        {
            return wrong("these are paths of another scene".to_owned());
        }
        if let Some([x, y, w, h]) = self.pixels {
            let is_inside = |p: [u32; 2]| p[0] >= x && p[1] >= y && p[0] - x < w && p[1] - y < h;
            found.paths.retain(|p| is_inside(p.pixel));
        }
        if let Some(expressions) = parts.view() {
            found.paths.retain(|p| matched(&expressions, p) & 1 != 0);
            found.header.expression = parts.request().only.clone();
        }
        found.header.count = found.paths.len();
        Ok(found)
    }

    /// The clusters of a record.
    pub(super) fn tree(&self, record: &PathRecord) -> ClusterTree {
        let all = (0..record.paths.len() as u32).collect();
        ClusterTree::of(record, all, self.cluster, self.from)
    }

    /// Its bundles, by the clusters whose paths are the same all along; none of those that hardly add light.
    pub(super) fn groups(
        &self,
        record: &PathRecord,
        tree: &ClusterTree,
        places: &Places,
    ) -> Vec<Group> {
        let leaves = tree.leaves();
        let paths: Vec<Vec<u32>> = leaves
            .iter()
            .map(|leaf| tree.paths(leaf).to_vec())
            .collect();
        let mut groups: Vec<Group> = (leaves.iter().zip(&paths))
            .map(|(leaf, paths)| {
                let first = paths.first().map(|p| &record.paths[*p as usize].vertices);
                let vertices = first.into_iter().flatten().rev();
                let labels: Vec<String> =
                    vertices.map(|v| label(record, v, self.cluster)).collect();
                Group {
                    label: labels.join(if self.cluster == ClusterBy::Object {
                        ", "
                    } else {
                        " "
                    }),
                    weight: leaf.weight,
                    bundles: Vec::new(),
                }
            })
            .collect();
        // Of each path, the group that its cluster is.
        let mut group_of = vec![0; record.paths.len()];
        for (group, members) in paths.iter().enumerate() {
            members.iter().for_each(|p| group_of[*p as usize] = group);
        }
        // Arrows of what hardly adds light would hide all others.
        let least = LEAST_SHARE * tree.root.weight;
        let drawn = paths
            .into_iter()
            .zip(&leaves)
            .filter(|(_, leaf)| leaf.weight >= least);
        let drawn = drawn.map(|(paths, _)| paths).collect();
        for bundle in bundles(record, places, drawn, self.bundles as usize) {
            groups[group_of[bundle.representative as usize]]
                .bundles
                .push(bundle);
        }
        groups.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        groups
    }
}

fn parse_window(text: &str) -> Result<[u32; 4], String> {
    parse_numbers(text, &[','], "X,Y,WIDTH,HEIGHT")
}
