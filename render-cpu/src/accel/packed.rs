//! Triangles as the traversal reads them: eight side by side, component by component.
//!
//! The triangles in the leaves of a node lie in consecutive places, of which the first is a multiple of eight; what is
//! left of the last eight is filled with triangles that nothing hits. The watertight test chooses its axes per ray,
//! which here is a choice of rows; [`super::block`] does it for a whole block.

use super::build::GroupTree;
use glam::Vec3;
use halflight_kernel::scene::Tables;
use obvhs::cwbvh::node::CwBvhNode;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

/// Triangles in a block.
pub const BLOCK: usize = 8;

/// Blocks that are not worth a second thread.
const MIN_SHARE: usize = 1 << 9;

/// What stands in places that hold no primitive.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// Eight triangles.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    /// `axes[component][vertex][place]`.
    pub axes: [[[f32; BLOCK]; 3]; 3],
}

impl TriangleBlock {
    /// Triangles that nothing hits.
    const NOTHING: TriangleBlock = TriangleBlock {
        axes: [[[f32::NAN; BLOCK]; 3]; 3],
    };

    /// The triangles among `primitives`; nothing hits what stands in the other places.
    fn new(tables: &Tables<'_>, primitives: &[u32; BLOCK]) -> TriangleBlock {
        let mut block = TriangleBlock::NOTHING;
        for (place, &primitive) in primitives.iter().enumerate() {
            let Some(triangle) = tables.triangles.get(primitive as usize) else {
                continue;
            };
            for (k, &vertex) in triangle.vertices.iter().enumerate() {
                let position = tables.positions[vertex as usize];
                for axis in 0..3 {
                    block.axes[axis][k][place] = position[axis];
                }
            }
        }
        block
    }

    /// The vertices of the triangle in a place.
    #[inline(always)]
    pub fn vertices(&self, place: usize) -> [Vec3; 3] {
        let [x, y, z] = &self.axes;
        let vertex = |k: usize| Vec3::new(x[k][place], y[k][place], z[k][place]);
        [vertex(0), vertex(1), vertex(2)]
    }
}

/// The leaves of a tree in blocks.
#[derive(Clone, Debug, Default)]
pub struct PackedLeaves {
    /// The primitive in each place, [`NO_PRIMITIVE`] where there is none.
    pub primitives: Vec<u32>,
    /// The triangles of eight places each; other primitives hold a triangle that nothing hits.
    pub blocks: Vec<TriangleBlock>,
    /// Which of the eight places of each block hold other primitives, a bit each; empty where there are only triangles.
    pub others: Vec<u8>,
}

impl PackedLeaves {
    /// Lays out the leaves of `tree`, whose nodes are made to point to the new places.
    pub fn new(tables: &Tables<'_>, tree: &mut GroupTree) -> PackedLeaves {
        let blocks = tree.nodes.iter().map(|node| places(node).div_ceil(BLOCK));
        let mut packed = PackedLeaves {
            primitives: Vec::with_capacity(blocks.sum::<usize>() * BLOCK),
            ..PackedLeaves::default()
        };
        for node in &mut tree.nodes {
            let count = places(node);
            let first = node.primitive_base_idx as usize;
            node.primitive_base_idx = packed.primitives.len() as u32;
            let leaves = &tree.primitives[first..first + count];
            packed.primitives.extend_from_slice(leaves);
            let end = packed.primitives.len().next_multiple_of(BLOCK);
            packed.primitives.resize(end, NO_PRIMITIVE);
        }
        let (blocks, _) = packed.primitives.as_chunks::<BLOCK>();
        let share = blocks.par_iter().with_min_len(MIN_SHARE);
        share
            .map(|primitives| TriangleBlock::new(tables, primitives))
            .collect_into_vec(&mut packed.blocks);
        let triangles = tables.triangles.len() as u32;
        let is_other = |primitive: u32| primitive >= triangles && primitive != NO_PRIMITIVE;
        if packed.primitives.iter().any(|&p| is_other(p)) {
            let bits = |places: &[u32; BLOCK]| {
                let places = places.iter().enumerate();
                places.fold(0, |bits, (k, &p)| bits | (u8::from(is_other(p)) << k))
            };
            packed.others = blocks.iter().map(bits).collect();
        }
        packed
    }
}

/// Places that the leaves of a node take. They are counted in unary in the top three bits of a leaf's entry, behind the first
/// place in the others; entries of inner children look alike.
fn places(node: &CwBvhNode) -> usize {
    (0..8)
        .filter(|k| node.imask & (1 << k) == 0)
        .map(|k| node.child_meta[k])
        .filter(|meta| meta >> 5 != 0)
        .map(|meta| (meta & 31) as usize + (meta >> 5).count_ones() as usize)
        .max()
        .unwrap_or(0)
}
