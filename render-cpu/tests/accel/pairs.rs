//! Which triangles make pairs.

use crate::geometry::{Geometry, Random, rays_around, world};
use glam::Vec3;
use halflight::accel::build::pairs::shared_edge;
use halflight::accel::{Accel, build};
use halflight_kernel::scene::{NONE, Triangle};

/// The leaf entries of the world's tree; each triangle lies in one.
fn entries(g: &Geometry) -> Vec<[u32; 2]> {
    let found = build::paired_bounds(&g.tables(), &g.groups[0], None);
    let skipped = found.skipped;
    let mut entries = build::GroupTree::build(found).entries;
    let mut triangles: Vec<u32> = entries
        .iter()
        .flatten()
        .copied()
        .filter(|&t| t != NONE)
        .collect();
    triangles.sort_unstable();
    triangles.dedup();
    assert_eq!(triangles.len() + skipped, g.triangles.len());
    entries.sort_unstable();
    entries
}

/// The pairs among [`entries`].
fn pairs(g: &Geometry) -> Vec<[u32; 2]> {
    let pairs: Vec<[u32; 2]> = entries(g)
        .into_iter()
        .filter(|entry| entry[1] != NONE)
        .collect();
    for pair in &pairs {
        let [a, b] = pair.map(|t| g.triangles[t as usize].vertices);
        assert!(shared_edge(a, b).is_some(), "{pair:?}");
    }
    pairs
}

/// Cells of a grid, in whatever order their halves come, make a pair each.
#[test]
fn quadrilaterals_are_pairs() {
    const SIDE: usize = 20;
    let corner = |i: usize, j: usize| Vec3::new(i as f32, j as f32, (i * j % 3) as f32 * 0.1);
    let cell = |i: usize, j: usize| {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
        [[a, b, c], [a, c, d]]
    };
    let cells: Vec<_> = (0..SIDE * SIDE).map(|k| cell(k / SIDE, k % SIDE)).collect();
    for is_apart in [false, true] {
        let mut g = Geometry {
            positions: (0..(SIDE + 1) * (SIDE + 1))
                .map(|k| corner(k / (SIDE + 1), k % (SIDE + 1)).to_array())
                .collect(),
            ..Geometry::default()
        };
        let mut add = |triangle: [Vec3; 3]| {
            let vertices = triangle.map(|p| p.x as u32 * (SIDE as u32 + 1) + p.y as u32);
            g.triangles.push(Triangle { vertices, shape: 0 });
        };
        if is_apart {
            (0..2).for_each(|half| cells.iter().for_each(|cell| add(cell[half])));
        } else {
            cells.iter().flatten().for_each(|&triangle| add(triangle));
        }
        g.close_group();
        g.place(0, glam::Affine3A::IDENTITY);
        let pairs = pairs(&g);
        assert_eq!(pairs.len(), SIDE * SIDE);
        for [a, b] in pairs {
            let expected = if is_apart {
                a + (SIDE * SIDE) as u32
            } else {
                a ^ 1
            };
            assert_eq!(b, expected);
        }
        let accel = Accel::build(g.tables(), &g.groups);
        assert_eq!(accel.statistics().primitives, 2 * SIDE * SIDE);
        g.check(&rays_around(10.0));
    }
}

/// Neighbours that turn the other way, whose common box is larger than both of theirs, or that cannot be traced stay alone.
#[test]
fn some_neighbours_are_no_pairs() {
    let (a, b, c) = (Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0));
    let pair = |triangles: [[Vec3; 3]; 2]| {
        let mut g = world(|g| triangles.into_iter().for_each(|t| g.triangle(t)));
        let pairs = pairs(&g).len();
        if entries(&g).len() == 2 - pairs {
            g.check(&rays_around(1.0));
        }
        pairs
    };
    let first = [a, b, c];
    assert_eq!(pair([first, [a, c, Vec3::Y]]), 1);
    assert_eq!(pair([first, [c, a, Vec3::Y]]), 0);
    // Each is flat in its own plane, together they fill space.
    assert_eq!(pair([first, [b, a, Vec3::new(0.5, 0.0, 1.0)]]), 0);
    for bad in [f32::NAN, f32::INFINITY, 1e20] {
        assert_eq!(pair([first, [a, c, Vec3::Y * bad]]), 0);
        assert_eq!(pair([[a, c, Vec3::Y * bad], first]), 0);
    }
}

/// Meshes whose vertices are in thousands of triangles take no longer than others, and are no other meshes.
#[test]
fn fans_and_pages() {
    const COUNT: usize = 30_000;
    let rim = |i: usize| Vec3::new((i as f32 * 1e-4).cos(), (i as f32 * 1e-4).sin(), 0.0);
    let mut random = Random(3);
    let mut fan = world(|g| (0..COUNT).for_each(|i| g.triangle([Vec3::ZERO, rim(i), rim(i + 1)])));
    // The centre is a vertex of its own once in a hundred triangles.
    assert!(pairs(&fan).len() > COUNT / 3);
    let mut pages = Geometry {
        positions: vec![[0.0; 3], [0.0, 1.0, 0.0]],
        ..Geometry::default()
    };
    for i in 0..COUNT as u32 {
        pages.positions.push(random.point().to_array());
        let spine = if i % 2 == 0 { [0, 1] } else { [1, 0] };
        pages.triangles.push(Triangle {
            vertices: [spine[0], spine[1], i + 2],
            shape: 0,
        });
    }
    pages.close_group();
    pages.place(0, glam::Affine3A::IDENTITY);
    pairs(&pages);
    fan.check(&rays_around(1.0)[..20]);
    pages.check(&rays_around(1.0)[..20]);
}
