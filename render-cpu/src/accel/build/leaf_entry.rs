//! Leaf entries: primitives as the traversal reads them, in the order of the tree's leaves.
//!
//! The entries of the leaves of a node follow one another. An entry is a triangle, or two that share an edge
//! ([`super::pairs`]), or the number of another primitive: four rows of a vertex and a word, a cache line, so that rows of several
//! entries are loaded whole and turned into columns, whichever entries they are. Sixteen rays test an entry each, a single
//! ray tests all that its node has for it.
//!
//! The triangles of an entry with vertices a, b, c, d are abc and acd. Each keeps the order of its own vertices, which
//! barycentric coordinates refer to, as a rotation r: its vertex j is vertex (j + 3 - r) % 3 of those.

use super::group_tree::GroupTree;
use super::pairs::shared_edge;
use glam::Vec3;
use halflight_kernel::scene::{NONE, Tables};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

/// Entries that are not worth a second thread.
const MIN_SHARE: usize = 1 << 12;

/// Which vertices of an entry are those of its triangles, by triangles and their rotations; there is no rotation by three.
const CORNERS: [[[u8; 3]; 4]; 2] = [
    [[0, 1, 2], [2, 0, 1], [1, 2, 0], [0, 1, 2]],
    [[0, 2, 3], [3, 0, 2], [2, 3, 0], [0, 2, 3]],
];

/// What a leaf holds one or more of.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct LeafEntry {
    /// The vertices, NaN where there is no triangle. The fourth numbers of the first two rows are the bits of the primitives,
    /// that of the third those of both rotations, the second one above the lowest two bits.
    rows: [[f32; 4]; 4],
}

impl LeafEntry {
    /// The entry of a primitive, as in [`halflight_kernel::scene::Hit::primitive`], or of an instance after those, and of the
    /// triangle that is its partner or [`NONE`].
    pub fn new(tables: &Tables<'_>, primitive: u32, partner: u32) -> LeafEntry {
        let Some(first) = tables.triangles.get(primitive as usize) else {
            return LeafEntry::of([[f32::NAN; 3]; 3], primitive);
        };
        let vertices = |corners: [u32; 3]| corners.map(|v| tables.positions[v as usize]);
        let second = tables.triangles.get(partner as usize);
        let edge = second.and_then(|second| shared_edge(first.vertices, second.vertices));
        let (Some(second), Some(edge)) = (second, edge) else {
            return LeafEntry::of(vertices(first.vertices), primitive);
        };
        let both = [vertices(first.vertices), vertices(second.vertices)];
        // Most quadrilaterals are fans of two triangles, which need no rotation in the right order.
        if edge == (0, 2) {
            LeafEntry::of_two([both[1], both[0]], (2, 0), [partner, primitive])
        } else {
            LeafEntry::of_two(both, edge, [primitive, partner])
        }
    }

    /// A triangle with its number.
    pub fn of([a, b, c]: [[f32; 3]; 3], primitive: u32) -> LeafEntry {
        LeafEntry::with([a, b, c, [f32::NAN; 3]], [primitive, NONE], [0, 0])
    }

    /// Two triangles with their numbers, which share the edge that begins at these vertices ([`shared_edge`]).
    pub fn of_two(
        [first, second]: [[[f32; 3]; 3]; 2],
        edge: (usize, usize),
        primitives: [u32; 2],
    ) -> LeafEntry {
        // The edge leads from c to a, and back.
        let (a, c) = ((edge.0 + 1) % 3, edge.1);
        let corner = |k: usize| first[(a + k) % 3];
        let vertices = [corner(0), corner(1), corner(2), second[(c + 2) % 3]];
        LeafEntry::with(vertices, primitives, [a as u32, c as u32])
    }

    fn with(vertices: [[f32; 3]; 4], primitives: [u32; 2], rotations: [u32; 2]) -> LeafEntry {
        let mut rows = vertices.map(|[x, y, z]| [x, y, z, 0.0]);
        rows[0][3] = f32::from_bits(primitives[0]);
        rows[1][3] = f32::from_bits(primitives[1]);
        rows[2][3] = f32::from_bits(rotations[0] | rotations[1] << 2);
        LeafEntry { rows }
    }

    /// The first primitive.
    #[inline(always)]
    pub fn primitive(&self) -> u32 {
        self.rows[0][3].to_bits()
    }

    /// The second primitive, a triangle, or [`NONE`].
    #[inline(always)]
    pub fn partner(&self) -> u32 {
        self.rows[1][3].to_bits()
    }

    /// The rows of the vertices of triangle 0 or 1, in their order.
    #[inline(always)]
    pub fn corners(&self, triangle: usize) -> [&[f32; 4]; 3] {
        let rotation = (self.rotations() >> (2 * triangle)) as usize & 3;
        CORNERS[triangle][rotation].map(|vertex| &self.rows[usize::from(vertex & 3)])
    }

    /// The vertices of triangle 0 or 1.
    #[inline(always)]
    pub fn vertices(&self, triangle: usize) -> [Vec3; 3] {
        self.corners(triangle)
            .map(|&[x, y, z, _]| Vec3::new(x, y, z))
    }

    /// The rotations of both triangles, two bits each.
    #[inline(always)]
    pub fn rotations(&self) -> u32 {
        self.rows[2][3].to_bits()
    }

    /// A vertex and a word.
    #[inline(always)]
    pub fn row(&self, vertex: usize) -> &[f32; 4] {
        &self.rows[vertex]
    }
}

/// The entries of a tree.
pub fn leaf_entries(tables: &Tables<'_>, tree: &GroupTree) -> Vec<LeafEntry> {
    let mut entries = Vec::new();
    let share = tree.entries.par_iter().with_min_len(MIN_SHARE);
    share
        .map(|&[primitive, partner]| LeafEntry::new(tables, primitive, partner))
        .collect_into_vec(&mut entries);
    entries
}
