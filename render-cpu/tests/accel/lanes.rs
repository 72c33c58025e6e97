//! Tests of nodes and of leaf entries with vectors of any width.

use crate::geometry::{Random, rays_around};
use glam::Vec3;
use halflight_kernel::math::Ray;
use halflight_kernel::scene::{NONE, intersect};

/// The three node tests find the same children, up to rounding at the edges of boxes.
#[cfg(target_arch = "x86_64")]
#[test]
fn node_tests_agree() {
    use halflight::accel::single::avx2::Avx2;
    use halflight::accel::single::instruction_set::{InstructionSet, Portable, Sse2};
    use halflight::accel::single::node::Children;
    use obvhs::cwbvh::node::CwBvhNode;
    let mut random = Random(5);
    let boxes: Vec<_> = (0..3000)
        .map(|_| {
            let a = glam::Vec3A::from(random.point());
            obvhs::aabb::Aabb::from_points(&[a, a + glam::Vec3A::from(random.point()) * 0.1])
        })
        .collect();
    let nodes = obvhs::cwbvh::builder::build_cwbvh(
        &boxes,
        obvhs::BvhBuildParams::fast_build(),
        &mut std::time::Duration::default(),
    )
    .nodes;
    let has_avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    let (mut tested, mut hits, mut different) = (0, 0, 0);
    for ray in rays_around(1.0) {
        for node in nodes.iter().step_by(7) {
            fn children<T: InstructionSet>(node: &CwBvhNode, ray: &Ray) -> Children {
                T::children(node, &T::ray(ray.origin, ray.direction, 0.0), 10.0)
            }
            let portable = children::<Portable>(node, &ray);
            let mut others = vec![children::<Sse2>(node, &ray)];
            if has_avx2 {
                others.push(children::<Avx2>(node, &ray));
            }
            for other in others {
                tested += 8;
                hits += portable.hits.count_ones();
                different += (portable.hits ^ other.hits).count_ones();
                for k in 0..8 {
                    if portable.inner() & other.inner() & (1 << k) != 0 {
                        let error = (portable.near[k] - other.near[k]).abs();
                        assert!(error <= 2e-5, "{error}");
                    }
                }
            }
        }
    }
    assert!(
        hits > 1000 && different * 100_000 < tested,
        "{different} of {tested}, {hits} hit"
    );
}

/// Leaf entries of one triangle and of two give the kernel's own hits to the bit, with AVX2 and without; zeros among the edge functions,
/// slivers and coincident triangles included.
#[test]
fn leaf_entries_agree_with_the_kernel() {
    use halflight::accel::build::leaf_entry::LeafEntry;
    use halflight::accel::single::instruction_set::{InstructionSet, Portable};
    use halflight::accel::single::triangles::TriangleHit;
    const COUNT: usize = 24;
    let mut random = Random(11);
    let (mut hits, mut ties) = (0, 0);
    for case in 0..20_000u32 {
        let round = |v: Vec3| if case % 2 == 0 { (v * 2.0).round() } else { v };
        let mut entries: Vec<LeafEntry> = vec![];
        for i in 0..COUNT as u32 {
            let mut vertices = [(); 3].map(|()| round(random.point() * 2.0));
            if case % 5 < 2 && i % 3 == 2 {
                vertices = entries[i as usize - 1].vertices(0);
            }
            let name = (i * 5 + case) % COUNT as u32;
            if (i + case) % 4 < 2 {
                entries.push(LeafEntry::of(vertices.map(|v| v.to_array()), name));
                continue;
            }
            // Another one at an edge of it, in any rotation of both.
            let (k, m) = ((i / 3 % 3) as usize, (case / 7 % 3) as usize);
            let mut other = [
                vertices[(k + 1) % 3],
                vertices[k],
                round(random.point() * 2.0),
            ];
            other.rotate_right(m);
            let both = [vertices, other].map(|t| t.map(|v| v.to_array()));
            entries.push(LeafEntry::of_two(both, (k, m), [name, name + COUNT as u32]));
            assert_eq!(entries[i as usize].vertices(0), vertices);
            assert_eq!(entries[i as usize].vertices(1), other);
        }
        let origin = round(random.point() * 3.0);
        let direction = round(random.point() * 2.0);
        if direction == Vec3::ZERO {
            continue;
        }
        let sheared = intersect::ShearedRay::new(origin, direction);
        // As many as a node has, or fewer.
        let mask = case.wrapping_mul(2_654_435_761) >> (32 - COUNT);
        let mask = mask & if case % 3 == 0 { 0x0f_0f0f } else { !0 };
        let mut expected = TriangleHit::MISS;
        for entry in (0..COUNT).filter(|entry| mask & (1 << entry) != 0) {
            let entry = &entries[entry];
            for (triangle, primitive) in [(0, entry.primitive()), (1, entry.partner())] {
                if primitive == NONE {
                    continue;
                }
                let [p0, p1, p2] = entry.vertices(triangle);
                let found = intersect::intersect_triangle(&sheared, p0, p1, p2, 0.1, 20.0);
                let is_tie = found.t == expected.t && found.t < f32::MAX;
                ties += is_tie as u32;
                if found.t < expected.t || (is_tie && primitive < expected.primitive) {
                    expected = TriangleHit {
                        t: found.t,
                        b1: found.b1,
                        b2: found.b2,
                        primitive,
                    };
                }
            }
        }
        hits += (expected.t < f32::MAX) as u32;
        let portable = Portable::ray(origin, direction, 0.1);
        let found = Portable::nearest(&entries, mask, &portable, 20.0);
        assert_eq!(found, expected, "case {case}");
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            use halflight::accel::single::avx2::Avx2;
            let ray = Avx2::ray(origin, direction, 0.1);
            let found = Avx2::nearest(&entries, mask, &ray, 20.0);
            assert_eq!(found, expected, "case {case}");
        }
    }
    assert!(hits > 2000 && ties > 100, "{hits} hits, {ties} ties");
}
