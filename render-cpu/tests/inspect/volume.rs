//! The box of virtual medium.

use crate::{parts, scene, with_view};
use glam::Vec3;
use halflight::inspect::volume::LightVolume;
use halflight::scene::build::Scene;
use halflight_kernel::math::Ray;
use halflight_kernel::transport::light_volume::VoxelGrid;
use std::f64::consts::PI;

/// Light of intensity 3 from the origin over all of the box, in empty space.
const POINT: &str = r#"<sensor type="perspective"/>
    <emitter type="spot"><transform name="to_world"><lookat origin="0, 0, 0" target="1, 0, 0" up="0, 0, 1"/></transform>
        <rgb name="intensity" value="3"/><float name="cutoff_angle" value="41"/><float name="beam_width" value="38"/></emitter>
    <shape type="sphere"><point name="center" value="0, 0, -50"/><float name="radius" value="1"/></shape>"#;

fn measure(scene: &Scene, grid: VoxelGrid, walks: u32, only: Option<&str>) -> LightVolume {
    let parts = parts(scene, only);
    let expressions = parts.view();
    with_view(scene, |view| {
        LightVolume::measure(view, &scene.settings, expressions.as_ref(), grid, walks, 5)
    })
}

fn grid(extinction: f32) -> VoxelGrid {
    VoxelGrid {
        low: Vec3::new(1.0, -0.5, -0.5),
        high: Vec3::new(3.0, 0.5, 0.5),
        counts: [8, 4, 4],
        scattering: 0.3,
        extinction,
    }
}

/// The mean of a function over a voxel, by the midpoint rule.
fn mean(grid: &VoxelGrid, index: usize, f: impl Fn([f64; 3]) -> f64) -> f64 {
    const N: usize = 8;
    let [nx, ny, _] = grid.counts.map(|n| n as usize);
    let cell = [index % nx, index / nx % ny, index / (nx * ny)];
    let mut sum = 0.0;
    for i in 0..N * N * N {
        let at = [i % N, i / N % N, i / (N * N)];
        let p: [f64; 3] = std::array::from_fn(|axis| {
            let size = f64::from(grid.high[axis] - grid.low[axis]) / f64::from(grid.counts[axis]);
            let place = cell[axis] as f64 + (at[axis] as f64 + 0.5) / N as f64;
            f64::from(grid.low[axis]) + place * size
        });
        sum += f(p);
    }
    sum / (N * N * N) as f64
}

/// Fluence rate of the light at the origin behind its way through the medium, which is always entered at x = 1: the box opens less
/// than the lines from the origin do.
fn fluence(p: [f64; 3], extinction: f32) -> f64 {
    let square: f64 = p.iter().map(|x| x * x).sum();
    let way = square.sqrt() * (1.0 - 1.0 / p[0]);
    3.0 / square * (-f64::from(extinction) * way).exp()
}

#[test]
fn voxels_hold_the_fluence_of_a_point_light() {
    let scene = scene(POINT);
    for extinction in [0.0, 0.8] {
        let grid = grid(extinction);
        let volume = measure(&scene, grid, 400_000, None);
        let (mut all, mut all_expected) = (0.0, 0.0);
        for (i, found) in volume.fluence.iter().enumerate() {
            let expected = mean(&grid, i, |p| fluence(p, extinction));
            let ratio = f64::from(found.x) / expected;
            assert!(
                (ratio - 1.0).abs() < 0.08,
                "{extinction} {i}: {found} {expected}"
            );
            all += f64::from(found.x);
            all_expected += expected;
        }
        let ratio = all / all_expected;
        assert!((ratio - 1.0).abs() < 0.01, "{extinction}: {ratio}");
    }
}

#[test]
fn rays_gather_the_integral_of_single_scattering() {
    let scene = scene(POINT);
    for extinction in [0.0, 0.8] {
        let fine = VoxelGrid {
            counts: [64, 16, 16],
            ..grid(extinction)
        };
        let volume = measure(&scene, fine, 400_000, None);
        // Across the box at x = 2, and along it.
        for (origin, direction, start, length) in [
            (Vec3::new(2.02, -3.0, 0.02), Vec3::Y, 2.5_f64, 1.0_f64),
            (Vec3::new(-2.0, 0.03, 0.04), Vec3::X, 3.0, 2.0),
        ] {
            let ray = Ray::new(origin, direction);
            let (found, through) = volume.grid.scattered(&volume.fluence, &ray, f32::MAX);
            let e = f64::from(extinction);
            let steps = 2000;
            let at = |i: i32| {
                let t = (f64::from(i) + 0.5) / f64::from(steps) * length;
                let p = origin.as_dvec3() + direction.as_dvec3() * (start + t);
                0.3 / (4.0 * PI) * fluence(p.to_array(), extinction) * (-e * t).exp()
            };
            let expected = (0..steps).map(at).sum::<f64>() * length / f64::from(steps);
            let ratio = f64::from(found.x) / expected;
            assert!(
                (ratio - 1.0).abs() < 0.05,
                "{extinction} {direction}: {found} {expected}"
            );
            assert!((f64::from(through) - (-e * length).exp()).abs() < 1e-5);
        }
    }
}

#[test]
fn expressions_choose_what_lights_the_medium() {
    let mirror = POINT.to_owned()
        + r#"<shape type="rectangle"><transform name="to_world"><scale value="20"/><rotate y="1" angle="-90"/><translate x="4"/></transform>
            <bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>"#;
    let scene = scene(&mirror);
    let of = |only| measure(&scene, grid(0.0), 200_000, only);
    let (direct, mirrored, all) = (of(Some("L E")), of(Some("L S E")), of(None));
    let (mut sum, mut expected) = (0.0, 0.0);
    for i in 0..direct.fluence.len() {
        let both = direct.fluence[i].x + mirrored.fluence[i].x;
        assert!((both / all.fluence[i].x - 1.0).abs() < 1e-4);
        sum += f64::from(mirrored.fluence[i].x);
        // The mirror image of the lamp is at x = 8.
        expected += mean(&grid(0.0), i, |p| {
            3.0 / ((8.0 - p[0]).powi(2) + p[1] * p[1] + p[2] * p[2])
        });
    }
    assert!((sum / expected - 1.0).abs() < 0.05, "{sum} {expected}");
}

#[test]
fn lengths_in_voxels_add_up() {
    let grid = grid(0.0);
    let mut seed = 1_u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
    };
    for _ in 0..2000 {
        let origin = Vec3::new(next(), next(), next()) * 4.0;
        let direction = (Vec3::new(next(), next(), next()) + 1e-3).normalize();
        let ray = Ray::new(origin, direction);
        let mut end = None;
        let mut length = 0.0;
        grid.along(&ray, 5.0, |index, t0, t1| {
            assert!(index < grid.len() && t1 > t0);
            assert!(end.is_none_or(|end: f32| end == t0), "without gaps");
            end = Some(t1);
            length += t1 - t0;
            let middle = origin + direction * (0.5 * (t0 + t1));
            let cell = (middle - grid.low) / (grid.high - grid.low) * Vec3::new(8.0, 4.0, 4.0);
            let [x, y, z] = [index % 8, index / 8 % 4, index / 32].map(|i| i as f32);
            let inside = (cell - Vec3::new(x, y, z)).to_array();
            assert!(
                inside.iter().all(|c| (-1e-3..=1.001).contains(c)),
                "{inside:?}"
            );
        });
        // By slabs.
        let (a, b) = (
            (grid.low - origin) / direction,
            (grid.high - origin) / direction,
        );
        let from = a.min(b).max_element().max(0.0);
        let to = a.max(b).min_element().min(5.0);
        let expected = (to - from).max(0.0);
        assert!((length - expected).abs() < 1e-4, "{length} {expected}");
    }
}
