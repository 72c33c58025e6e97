//! Triangles that share an edge, in pairs.
//!
//! A pair is one leaf of the tree: half as many boxes to build and to test, and a ray that comes to both triangles is
//! tested against four vertices and five edges instead of six and six. Most meshes are quadrilaterals cut in two, or
//! could be.
//!
//! Each triangle in turn takes the neighbour with which it fills the smallest box, among those over an edge that are free
//! and where that box is smaller than both of their own together. Neighbours are known by the numbers of their vertices.

use halflight_kernel::scene::{NONE, Triangle};
use obvhs::bvh2::node::Bvh2Node;

/// In [`TrianglePairs`].
const IS_SECOND: u32 = NONE - 1;

/// Most triangles at a vertex that are looked at.
const MAX_LOOKED_AT: usize = 32;

/// The pairs among the triangles of a group.
#[derive(Clone, Debug, Default)]
pub struct TrianglePairs {
    /// Number of the first triangle.
    first: u32,
    /// By triangles from that on: the partner, counted from there as well, of the first of a pair, [`IS_SECOND`] for the second,
    /// [`NONE`] for one that is alone.
    partners: Vec<u32>,
}

impl TrianglePairs {
    /// Pairs of triangles, whose numbers begin with `first` and whose boxes are those of the leaves. Triangles whose box is not
    /// a number stay alone.
    pub fn new(triangles: &[Triangle], leaves: &[Bvh2Node], first: u32) -> TrianglePairs {
        let fans = VertexTriangles::new(triangles);
        let mut partners = vec![NONE; triangles.len()];
        for (i, triangle) in triangles.iter().enumerate() {
            if partners[i] != NONE {
                continue;
            }
            let bounds = leaves[i].aabb();
            let area_alone = bounds.half_area();
            let (mut best, mut least) = (NONE, f32::MAX);
            // Each of the edges ends at one of any two vertices.
            for &j in fans.two_shortest(triangle).into_iter().flatten() {
                let other = j as usize;
                let is_free = other > i && partners[other] == NONE;
                if !is_free || shared_edge(triangle.vertices, triangles[other].vertices).is_none() {
                    continue;
                }
                let other = leaves[other].aabb();
                let area = bounds.union(other).half_area();
                if area < least && area < area_alone + other.half_area() {
                    (best, least) = (j, area);
                }
            }
            if best != NONE {
                partners[i] = best;
                partners[best as usize] = IS_SECOND;
            }
        }
        TrianglePairs { first, partners }
    }

    /// The second triangle of the pair of which a primitive is the first, or [`NONE`].
    pub fn of(&self, primitive: u32) -> u32 {
        match self.get(primitive) {
            NONE | IS_SECOND => NONE,
            partner => self.first + partner,
        }
    }

    /// Whether a primitive is the second of a pair.
    pub fn is_second(&self, primitive: u32) -> bool {
        self.get(primitive) == IS_SECOND
    }

    fn get(&self, primitive: u32) -> u32 {
        let index = primitive.wrapping_sub(self.first) as usize;
        self.partners.get(index).copied().unwrap_or(NONE)
    }
}

/// The edge that both triangles have, in opposite directions: where it begins in the first and where it begins in the second.
pub fn shared_edge(a: [u32; 3], b: [u32; 3]) -> Option<(usize, usize)> {
    for k in 0..3 {
        for m in 0..3 {
            if a[k] == b[(m + 1) % 3] && a[(k + 1) % 3] == b[m] {
                return Some((k, m));
            }
        }
    }
    None
}

/// The triangles at each vertex.
struct VertexTriangles {
    /// The least number of a vertex.
    lowest: u32,
    /// Where in `triangles` those of each vertex begin, and the end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl VertexTriangles {
    fn new(triangles: &[Triangle]) -> VertexTriangles {
        let vertices = || triangles.iter().flat_map(|triangle| triangle.vertices);
        let (mut lowest, mut highest) = (u32::MAX, 0);
        for v in vertices() {
            lowest = lowest.min(v);
            highest = highest.max(v);
        }
        let count = (highest as usize + 1).saturating_sub(lowest as usize);
        // Counted two indices on, moved to where the next one is to be filled in, which ends where it begins.
        let mut starts = vec![0; count + 2];
        for v in vertices() {
            starts[(v - lowest) as usize + 2] += 1;
        }
        for k in 2..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut list = vec![0; 3 * triangles.len()];
        for (i, v) in vertices().enumerate() {
            let next = &mut starts[(v - lowest) as usize + 1];
            list[*next as usize] = i as u32 / 3;
            *next += 1;
        }
        VertexTriangles {
            lowest,
            starts,
            triangles: list,
        }
    }

    /// Triangles at two vertices of one of them, where there are the fewest.
    fn two_shortest(&self, triangle: &Triangle) -> [&[u32]; 2] {
        let [mut a, mut b, mut c] = triangle.vertices.map(|v| {
            let at = (v - self.lowest) as usize;
            &self.triangles[self.starts[at] as usize..self.starts[at + 1] as usize]
        });
        if a.len() > c.len() {
            std::mem::swap(&mut a, &mut c);
        }
        if b.len() > c.len() {
            std::mem::swap(&mut b, &mut c);
        }
        [a, b].map(|fan| &fan[..fan.len().min(MAX_LOOKED_AT)])
    }
}
