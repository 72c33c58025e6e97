//! Triangles as the traversal reads them, in the order of the tree's leaves.
//!
//! The leaves of a node take consecutive places. A place is three rows of a vertex and a word each, so that rows of several
//! places are loaded whole and turned into columns, whichever places they are: sixteen rays test a triangle each, a single ray
//! tests all that its node has for it.

use super::build::GroupTree;
use glam::Vec3;
use halflight_kernel::scene::Tables;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

/// Places that are not worth a second thread.
const MIN_SHARE: usize = 1 << 12;

/// A place in a leaf.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Place {
    /// The vertices of a triangle; not numbers where another primitive is. The fourth of the first row is the primitive's bits.
    rows: [[f32; 4]; 3],
}

impl Place {
    /// The place of a primitive, as in [`halflight_kernel::scene::Hit::primitive`], or of an instance after those.
    pub fn new(tables: &Tables<'_>, primitive: u32) -> Place {
        let vertices = match tables.triangles.get(primitive as usize) {
            Some(triangle) => triangle.vertices.map(|v| tables.positions[v as usize]),
            None => [[f32::NAN; 3]; 3],
        };
        Place::of(vertices, primitive)
    }

    /// A triangle with its number.
    pub fn of(vertices: [[f32; 3]; 3], primitive: u32) -> Place {
        let mut rows = vertices.map(|[x, y, z]| [x, y, z, 0.0]);
        rows[0][3] = f32::from_bits(primitive);
        Place { rows }
    }

    /// The primitive.
    #[inline(always)]
    pub fn primitive(&self) -> u32 {
        self.rows[0][3].to_bits()
    }

    /// The vertices of the triangle.
    #[inline(always)]
    pub fn vertices(&self) -> [Vec3; 3] {
        self.rows.map(|[x, y, z, _]| Vec3::new(x, y, z))
    }

    /// A vertex and a word.
    #[inline(always)]
    pub fn row(&self, vertex: usize) -> &[f32; 4] {
        &self.rows[vertex]
    }
}

/// The places of a tree.
pub fn places(tables: &Tables<'_>, tree: &GroupTree) -> Vec<Place> {
    let mut places = Vec::new();
    let share = tree.primitives.par_iter().with_min_len(MIN_SHARE);
    share
        .map(|&primitive| Place::new(tables, primitive))
        .collect_into_vec(&mut places);
    places
}
