//! The photons of a pass, sorted by all threads for the kernel's [`PhotonCache`].
//!
//! A radix sort by the keys of the cells, in two steps. Each thread sorts pieces of the photons by the leading bits of their
//! keys; then each takes the photons that share these bits, from all pieces in turn, and sorts them by what is left. The
//! time is linear in the number of photons, and their order depends on nothing but the order in which they were found.
//!
//! Libraries of spatial indices were looked at first: `kiddo` and `rstar` build trees in O(n log n) on one thread, answer
//! queries into vectors, and lend nothing that a shader could walk over. This file is shorter than an adapter to one of them.

use glam::Vec3;
use halflight_kernel::path::PathStates;
use halflight_kernel::path::path_node::PathNode;
use halflight_kernel::path::retarget_states::EditStates;
use halflight_kernel::scene::NONE;
use halflight_kernel::transport::bidirectional::adaptive::NodeStore;
use halflight_kernel::transport::photon::cache::{LEVELS, Photon, PhotonCache, PhotonGrid};
use halflight_kernel::transport::photon::divided::DividedStore;
use halflight_kernel::transport::photon::metropolis::PhotonPath;
use halflight_kernel::transport::photon::tracing::PhotonStore;
use halflight_kernel::transport::retargeted::bounce::EditedStore;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator,
};

/// Leading bits of keys by which pieces are sorted first: three levels of cells.
const LEADING_BITS: u32 = 9;

/// Photons that share their leading bits.
const BUCKETS: usize = 1 << LEADING_BITS;

/// Bits of a key that are left.
const REST_BITS: u32 = 3 * LEVELS - LEADING_BITS;

/// Bits by which the rest is sorted at a time.
const DIGIT_BITS: u32 = 7;

/// Fewer photons than this are sorted by comparison.
const FEW: usize = 192;

/// Photons in the order in which they were found.
#[derive(Clone, Debug, Default)]
pub struct PhotonList {
    /// Where they are.
    pub positions: Vec<[f32; 3]>,
    /// What they are.
    pub photons: Vec<Photon>,
    /// States of their walks, where path expressions divide the image: those that [`Photon::record`] names.
    pub states: Vec<PathStates>,
    /// The same where edits turn light, each but once among neighbours.
    pub edit_states: Vec<EditStates>,
    /// Vertices of their walks, where regularisation depends on full paths.
    pub nodes: Vec<PathNode>,
    /// Which of the states of edits the next photon names.
    edited: u32,
}

/// So many of the last states are looked through for equal ones: most walks share them.
const NEIGHBOURS: usize = 16;

impl PhotonStore for PhotonList {
    fn push(&mut self, position: Vec3, photon: &Photon) {
        let record = if !self.nodes.is_empty() {
            self.nodes.len() as u32 - 1
        } else if self.edit_states.is_empty() {
            self.states.len().saturating_sub(1) as u32
        } else {
            self.edited
        };
        self.positions.push(position.to_array());
        self.photons.push(Photon { record, ..*photon });
    }
}

impl NodeStore for PhotonList {
    fn push_node(&mut self, node: &PathNode) -> u32 {
        self.nodes.push(*node);
        self.nodes.len() as u32 - 1
    }

    fn node_mut(&mut self, index: u32) -> Option<&mut PathNode> {
        self.nodes.get_mut(index as usize)
    }
}

impl EditedStore for PhotonList {
    fn set_states(&mut self, states: &EditStates) {
        let count = self.edit_states.len();
        let first = count.saturating_sub(NEIGHBOURS);
        let found = self.edit_states[first..].iter().position(|s| s == states);
        self.edited = match found {
            Some(i) => first + i,
            None => {
                self.edit_states.push(*states);
                count
            }
        } as u32;
    }
}

impl PhotonPath for PhotonList {
    fn clear(&mut self) {
        self.positions.clear();
        self.photons.clear();
    }

    fn any(&self, mut is_seen: impl FnMut(Vec3, &Photon) -> bool) -> bool {
        let mut all = self.positions.iter().zip(&self.photons);
        all.any(|(position, photon)| is_seen(Vec3::from_array(*position), photon))
    }

    fn append_to(&self, count: f32, other: &mut Self) {
        other.positions.extend_from_slice(&self.positions);
        other
            .photons
            .extend(self.photons.iter().map(|photon| Photon {
                throughput: photon.throughput.map(|flux| flux * count),
                ..*photon
            }));
    }
}

impl DividedStore for PhotonList {
    fn set_states(&mut self, states: &PathStates) {
        // Those that no photon has taken are replaced.
        let last = self.states.len().saturating_sub(1) as u32;
        if self
            .photons
            .last()
            .is_none_or(|photon| photon.record != last)
        {
            self.states.pop();
        }
        self.states.push(*states);
    }
}

/// The owner of a sorted cache.
#[derive(Clone, Debug)]
pub struct SortedPhotons {
    grid: PhotonGrid,
    starts: Vec<u32>,
    keys: Vec<u32>,
    positions: Vec<[f32; 3]>,
    photons: Vec<Photon>,
    states: Vec<PathStates>,
    edit_states: Vec<EditStates>,
    nodes: Vec<PathNode>,
}

/// A piece of the photons, sorted by their leading bits.
struct Piece {
    /// Key and index in the piece of each, packed.
    keys: Vec<u64>,
    /// Where each bucket begins.
    starts: Vec<u32>,
}

impl SortedPhotons {
    /// Sorts the photons of lists, one after the other; at most 2^32 - 1 of them.
    ///
    /// # Panics
    /// If there are more.
    pub fn new(lists: &[PhotonList]) -> SortedPhotons {
        let total: usize = lists.iter().map(|list| list.photons.len()).sum();
        let count = u32::try_from(total).ok().filter(|&n| n < u32::MAX);
        let count = count.expect("a pass has fewer than 2^32 photons");
        let nothing = (Vec3::MAX, Vec3::MIN);
        let (low, high) = lists
            .par_iter()
            .map(bounds)
            .reduce(|| nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let grid = if count == 0 {
            PhotonGrid::around(Vec3::ZERO, Vec3::ONE, 0)
        } else {
            PhotonGrid::around(low, high, count)
        };
        let pieces: Vec<Piece> = lists.par_iter().map(|l| Piece::new(&grid, l)).collect();

        // Room of each bucket in the sorted arrays.
        let mut sorted = SortedPhotons {
            grid,
            starts: vec![0; grid.table_cells() as usize + 1],
            keys: vec![0; total],
            positions: vec![[0.0; 3]; total],
            photons: vec![bytemuck::Zeroable::zeroed(); total],
            states: lists
                .iter()
                .flat_map(|list| &list.states)
                .copied()
                .collect(),
            edit_states: lists
                .iter()
                .flat_map(|list| &list.edit_states)
                .copied()
                .collect(),
            nodes: nodes_of(lists),
        };
        let mut first = 0;
        let first_states: Vec<u32> = lists
            .iter()
            .map(|list| {
                let before = first;
                let states = list.states.len().max(list.edit_states.len());
                first += states.max(list.nodes.len()) as u32;
                before
            })
            .collect();
        let mut buckets = Vec::with_capacity(BUCKETS);
        let (mut keys, mut positions, mut photons) = (
            sorted.keys.as_mut_slice(),
            sorted.positions.as_mut_slice(),
            sorted.photons.as_mut_slice(),
        );
        for bucket in 0..BUCKETS {
            let count = pieces.iter().map(|p| p.bucket(bucket).len()).sum();
            let (k, p, r);
            (k, keys) = keys.split_at_mut(count);
            (p, positions) = positions.split_at_mut(count);
            (r, photons) = photons.split_at_mut(count);
            buckets.push((k, p, r));
        }
        buckets.into_par_iter().enumerate().for_each_init(
            || (Vec::new(), Vec::new()),
            |(entries, scratch), (bucket, (keys, positions, photons))| {
                entries.clear();
                for (i, piece) in pieces.iter().enumerate() {
                    let of_piece = piece.bucket(bucket).iter();
                    entries.extend(of_piece.map(|&key| (key, i as u32)));
                }
                sort(entries, scratch);
                for (i, &(key, list)) in entries.iter().enumerate() {
                    let first_state = first_states[list as usize];
                    let (list, index) = (&lists[list as usize], key as u32 as usize);
                    keys[i] = (key >> 32) as u32;
                    positions[i] = list.positions[index];
                    photons[i] = list.photons[index];
                    photons[i].record += first_state;
                }
            },
        );
        fill_starts(&grid, &sorted.keys, &mut sorted.starts);
        sorted
    }

    /// The cache, lent.
    pub fn view(&self) -> PhotonCache<'_> {
        PhotonCache {
            grid: self.grid,
            starts: &self.starts,
            keys: &self.keys,
            positions: &self.positions,
            photons: &self.photons,
        }
    }

    /// States of the photons' walks, by [`Photon::record`]; none where nothing divides the image.
    pub fn states(&self) -> &[PathStates] {
        &self.states
    }

    /// The same where edits turn light.
    pub fn edit_states(&self) -> &[EditStates] {
        &self.edit_states
    }

    /// Vertices of their walks, where regularisation depends on full paths; each has the index of the one before.
    pub fn nodes(&self) -> &[PathNode] {
        &self.nodes
    }

    /// Bytes that it takes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.starts.as_slice())
            + size_of_val(self.keys.as_slice())
            + size_of_val(self.positions.as_slice())
            + size_of_val(self.photons.as_slice())
            + size_of_val(self.states.as_slice())
            + size_of_val(self.edit_states.as_slice())
            + size_of_val(self.nodes.as_slice())
    }
}

/// Vertices of the walks of lists, one after the other.
fn nodes_of(lists: &[PhotonList]) -> Vec<PathNode> {
    let mut nodes = Vec::with_capacity(lists.iter().map(|list| list.nodes.len()).sum());
    for list in lists {
        let first = nodes.len() as u32;
        nodes.extend(list.nodes.iter().map(|node| {
            let mut node = *node;
            if node.vertex.previous != NONE {
                node.vertex.previous += first;
            }
            node
        }));
    }
    nodes
}

/// Corners of the box around the photons of a list.
fn bounds(list: &PhotonList) -> (Vec3, Vec3) {
    let mut corners = (Vec3::MAX, Vec3::MIN);
    for &position in &list.positions {
        let position = Vec3::from_array(position);
        corners = (corners.0.min(position), corners.1.max(position));
    }
    corners
}

impl Piece {
    fn new(grid: &PhotonGrid, list: &PhotonList) -> Piece {
        let keys: Vec<u32> = list
            .positions
            .iter()
            .map(|&p| grid.key(Vec3::from_array(p)))
            .collect();
        let mut starts = vec![0; BUCKETS + 1];
        for key in &keys {
            starts[(key >> REST_BITS) as usize + 1] += 1;
        }
        for i in 0..BUCKETS {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; keys.len()];
        for (i, key) in keys.iter().enumerate() {
            let next: &mut u32 = &mut next[(key >> REST_BITS) as usize];
            sorted[*next as usize] = u64::from(*key) << 32 | i as u64;
            *next += 1;
        }
        Piece {
            keys: sorted,
            starts,
        }
    }

    fn bucket(&self, bucket: usize) -> &[u64] {
        &self.keys[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

/// Sorts by the keys' lower bits; equal keys keep their order.
fn sort(entries: &mut Vec<(u64, u32)>, scratch: &mut Vec<(u64, u32)>) {
    if entries.len() < FEW {
        entries.sort_by_key(|(key, _)| key >> 32);
        return;
    }
    for digit in 0..REST_BITS / DIGIT_BITS {
        let shift = 32 + digit * DIGIT_BITS;
        let digit_of = |key: u64| (key >> shift) as usize & ((1 << DIGIT_BITS) - 1);
        let mut next = [0_usize; 1 << DIGIT_BITS];
        for (key, _) in entries.iter() {
            next[digit_of(*key)] += 1;
        }
        let mut sum = 0;
        for start in &mut next {
            sum += std::mem::replace(start, sum);
        }
        scratch.clear();
        scratch.resize(entries.len(), (0, 0));
        for entry in entries.iter() {
            let next = &mut next[digit_of(entry.0)];
            scratch[*next] = *entry;
            *next += 1;
        }
        std::mem::swap(entries, scratch);
    }
}

/// Where the photons of each of the table's cells begin.
fn fill_starts(grid: &PhotonGrid, keys: &[u32], starts: &mut [u32]) {
    let mut cell = 0;
    for (i, &key) in keys.iter().enumerate() {
        let of_photon = grid.table_cell(key) as usize;
        while cell <= of_photon {
            starts[cell] = i as u32;
            cell += 1;
        }
    }
    starts[cell..].fill(keys.len() as u32);
}
