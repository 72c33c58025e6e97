//! Turns of directions: their inverses, Jacobians and what they do to areas.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use halflight_kernel::path::retarget::{Edit, flow, source};
use proptest::prelude::*;

fn rows(map: &DAffine3) -> [f32; 12] {
    let mut rows = [0.0; 12];
    for i in 0..3 {
        for j in 0..3 {
            rows[4 * i + j] = map.matrix3.col(j)[i] as f32;
        }
        rows[4 * i + 3] = map.translation[i] as f32;
    }
    rows
}

fn edit(kind: u32, from_unit: DAffine3, map: DAffine3) -> Edit {
    Edit {
        flow: flow::LIGHT,
        source: kind,
        to_unit: rows(&from_unit.inverse()),
        from_unit: rows(&from_unit),
        map: rows(&map),
        inverse: rows(&map.inverse()),
        factor: [1.0; 3],
        keeps_energy: 0,
    }
}

prop_compose! {
    /// A rotation and scale that is far from singular, and a translation.
    fn affine(reach: f64)(
        axis in prop::array::uniform3(-1.0..1.0f64),
        angle in 0.0..3.0f64,
        scale in prop::array::uniform3(0.4..1.6f64),
        shift in prop::array::uniform3(-1.0..1.0f64),
    ) -> DAffine3 {
        let axis = (DVec3::from_array(axis) + DVec3::splat(1e-3)).normalize();
        DAffine3 {
            matrix3: DMat3::from_axis_angle(axis, angle) * DMat3::from_diagonal(DVec3::from_array(scale)),
            translation: DVec3::from_array(shift) * reach,
        }
    }
}

/// Solid angle of the image of a small square of directions around `w`, over that of the square.
fn measured(edit: &Edit, x: Vec3, w: Vec3) -> Option<f32> {
    let (a, b) = w.any_orthonormal_pair();
    let h = 2e-3;
    let at = |d: Vec3| {
        edit.redirect(x, (w + d * h).normalize())
            .map(|turn| turn.direction)
    };
    let along = (at(a)? - at(-a)?) / (2.0 * h);
    let across = (at(b)? - at(-b)?) / (2.0 * h);
    Some(along.cross(across).length())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn turns_have_inverses_and_jacobians(
        kind in prop::sample::select(vec![source::EVERYWHERE, source::BOX, source::BALL]),
        region in affine(1.0),
        map in affine(1.0),
        x in prop::array::uniform3(-1.0..1.0f32),
        u in prop::array::uniform3(-0.8..0.8f64),
    ) {
        let edit = edit(kind, region, map);
        // From some way off, towards a point of the region.
        let x = Vec3::from_array(x) + Vec3::new(0.0, 6.0, 0.0);
        let u = DVec3::from_array(u) * if kind == source::BOX { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
        let w = (region.transform_point3(u).as_vec3() - x).normalize();
        if let Some(turn) = edit.redirect(x, w) {
            prop_assert!((turn.direction.length() - 1.0).abs() < 1e-5);
            let Some(back) = edit.origin(x, turn.direction) else {
                // At the border rounding decides.
                return Ok(());
            };
            prop_assert!(back.direction.distance(w) < 2e-3, "{} {}", back.direction, w);
            prop_assert!((back.jacobian * turn.jacobian - 1.0).abs() < 2e-2);
            if let Some(measured) = measured(&edit, x, w) {
                // Differences say little where a plane is seen from its edge.
                let u = region.inverse().transform_point3(x.as_dvec3());
                let normal = if kind == source::BALL { u } else { DVec3::Z };
                let own = (region.matrix3.inverse().transpose() * normal).normalize().as_vec3();
                let image = (map.matrix3.inverse().transpose() * own.as_dvec3()).normalize().as_vec3();
                let is_steep = kind != source::EVERYWHERE
                    && own.dot(w).abs().min(image.dot(turn.direction).abs()) < 0.2;
                prop_assert!(is_steep || (measured / turn.jacobian - 1.0).abs() < 3e-2, "{measured} {}", turn.jacobian);
            }
        } else {
            // Lines to points of a region meet it, but for planes seen from their edge.
            prop_assert!(kind != source::EVERYWHERE);
        }
    }

    #[test]
    fn points_of_a_box_go_where_the_map_says(
        region in affine(1.0),
        map in affine(1.0),
        u in prop::array::uniform2(-0.99..0.99f64),
    ) {
        let edit = edit(source::BOX, region, map);
        let x = Vec3::new(0.3, 7.0, -0.2);
        let y = region.transform_point3(DVec3::new(u[0], u[1], 0.0));
        let w = (y.as_vec3() - x).normalize();
        let goal = map.transform_point3(y).as_vec3();
        if let Some(turn) = edit.redirect(x, w) {
            prop_assert!(turn.direction.distance((goal - x).normalize()) < 2e-3);
        }
    }
}

#[test]
fn what_misses_the_source_is_left_alone() {
    let edit = edit(
        source::BOX,
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::X),
    );
    let x = Vec3::new(0.0, 0.0, 3.0);
    assert!(edit.redirect(x, -Vec3::Z).is_some());
    assert!(edit.redirect(x, Vec3::Z).is_none());
    assert!(
        edit.redirect(x, Vec3::new(2.0, 0.0, -3.0).normalize())
            .is_none()
    );
    assert!(
        edit.origin(x, Vec3::new(2.5, 0.0, -3.0).normalize())
            .is_none()
    );
    assert!(edit.redirect(Vec3::new(5.0, 0.0, 0.0), -Vec3::X).is_none());
    let ball = self::edit(
        source::BALL,
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::X),
    );
    assert!(
        ball.redirect(Vec3::new(0.2, 0.0, 0.3), Vec3::X).is_none(),
        "within the ball"
    );
    let x = Vec3::new(0.0, 0.0, 2.0);
    // Lines from there touch the ball at 30 degrees.
    for (degrees, is_met) in [(29.5f32, true), (30.5, false)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turn = ball.redirect(x, Vec3::new(sin, 0.0, -cos));
        assert_eq!(turn.is_some(), is_met, "{degrees}");
    }
}
