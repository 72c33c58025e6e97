//! Triangles as the traversal reads them: eight side by side, component by component.
//!
//! The triangles in the leaves of a node lie in consecutive places, of which the first is a multiple of eight; what is
//! left of the last eight is filled with triangles that nothing hits. The watertight test chooses its axes per ray,
//! which here is a choice of rows; [`super::block`] does it for a whole block.

use super::build::GroupTree;
use glam::Vec3;
use halflight_kernel::math::vec3;
use halflight_kernel::scene::Tables;
use obvhs::cwbvh::node::CwBvhNode;

/// Triangles in a block.
pub const BLOCK: usize = 8;

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
        let blocks = blocks.sum::<usize>();
        let mut packed = PackedLeaves {
            primitives: Vec::with_capacity(blocks * BLOCK),
            blocks: Vec::with_capacity(blocks),
            others: Vec::with_capacity(blocks),
        };
        for node in &mut tree.nodes {
            let count = places(node);
            let first = node.primitive_base_idx as usize;
            node.primitive_base_idx = packed.primitives.len() as u32;
            for places in tree.primitives[first..first + count].chunks(BLOCK) {
                let mut block = TriangleBlock::NOTHING;
                let mut others = 0;
                for place in 0..BLOCK {
                    let primitive = places.get(place).copied().unwrap_or(NO_PRIMITIVE);
                    packed.primitives.push(primitive);
                    let Some(triangle) = tables.triangles.get(primitive as usize) else {
                        others |= ((primitive != NO_PRIMITIVE) as u8) << place;
                        continue;
                    };
                    for (k, &vertex) in triangle.vertices.iter().enumerate() {
                        let position = vec3(tables.positions[vertex as usize]);
                        for axis in 0..3 {
                            block.axes[axis][k][place] = position[axis];
                        }
                    }
                }
                packed.blocks.push(block);
                packed.others.push(others);
            }
        }
        if packed.others.iter().all(|&places| places == 0) {
            packed.others = Vec::new();
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
