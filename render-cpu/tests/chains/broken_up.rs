//! Where paths are broken up depends on roughness, and the mutation that breaks them up accounts for that.
//!
//! A floor of metal in stripes, smooth and rough, as broad as a step over the film: mutations lead from stripe to stripe, and the
//! probabilities of b and c ([`halflight_kernel::manifold::breakup`]) of both ends differ by up to eighteen times. A small white patch lights the floor,
//! and a lamp the patch, so that all paths have the same vertices. As many steps lead from smooth to rough stripes as back, and as many
//! states are on each of them after the chains as before, as in `stationary`.

use crate::scenes::{scene, with_view};
use crate::stationary::{Cell, keeps, report, weighed};
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::markov::VeachChains;

/// Stripes per pixel of the film, whose steps have a deviation of 0.12 pixels.
const PER_PIXEL: u32 = 8;

/// The kind of stripe where a path meets the floor.
const STRIPES: (&str, Cell) = ("stripes", |o| (o.film.x * PER_PIXEL as f32) as usize % 2);

/// What the floor looks like, and what lights it.
struct Case {
    name: &'static str,
    /// Roughness and reflectance of the smooth stripes; the rough ones have one and one.
    smooth: [f32; 2],
    /// Half the width of the patch.
    patch: f32,
    /// Where the lamp is, seen from the patch: to the right, and along its normal.
    lamp: [f32; 2],
    /// Half the width of the lamp.
    lamp_size: f32,
    /// Whether the floor is seen in a mirror.
    is_mirrored: bool,
}

const CASES: [Case; 3] = [
    // P(b): on the floor are 0.91 of the inner b where it is rough, 0.20 where it is smooth; the others are on the patch.
    Case {
        name: "patch beside a lamp",
        smooth: [0.2, 0.08],
        patch: 0.02,
        lamp: [0.06, 0.06],
        lamp_size: 0.03,
        is_mirrored: false,
    },
    // P(c | b) of b on the floor: the patch 0.38, the lamp, which is four times as far from it, 0.62.
    Case {
        name: "patch far from a lamp",
        smooth: [0.3, 0.1],
        patch: 0.2,
        lamp: [2.0, 2.0],
        lamp_size: 0.3,
        is_mirrored: false,
    },
    // P(c | b) of b at the sensor: behind the mirror the patch has 0.14 where the floor is rough, 0.97 where it is smooth.
    Case {
        name: "mirror",
        smooth: [0.05, 0.01],
        patch: 0.05,
        lamp: [0.06, 0.06],
        lamp_size: 0.03,
        is_mirrored: true,
    },
];

/// Half the width of the floor, which is that of the film.
const HALF: f32 = 0.2;

/// Height of the patch over the floor, and its distance behind it; the floor reflects parallel rays from the camera there.
const PATCH_HEIGHT: f32 = 0.5;

/// Height of the mirror.
const MIRROR_HEIGHT: f32 = 0.4;

fn striped(name: &str, smooth: f32) -> String {
    format!(
        r#"<texture type="checkerboard" name="{name}"><rgb name="color0" value="{smooth}"/><rgb name="color1" value="1"/>
        <transform name="to_uv"><scale x="{}" y="0.4"/></transform></texture>"#,
        8 * PER_PIXEL / 2
    )
}

impl Case {
    fn content(&self) -> String {
        let [alpha, reflectance] = self.smooth;
        let (h, m) = (PATCH_HEIGHT, MIRROR_HEIGHT);
        // Components of the patch's normal, down and to the front.
        let [right, front] = [
            self.lamp[0],
            self.lamp[1] * core::f32::consts::FRAC_1_SQRT_2,
        ];
        let (origin, target, mirror) = if self.is_mirrored {
            let mirror = format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale value="0.25"/><rotate x="1" angle="90"/>
                <translate y="{m}" z="{m}"/></transform><bsdf type="twosided"><bsdf type="conductor"/></bsdf></shape>"#
            );
            let below = format!("0, {}, 1", 2.0 * m - 1.0);
            (below, format!("0, {m}, {m}"), mirror)
        } else {
            ("0, 1, 1".into(), "0, 0, 0".into(), String::new())
        };
        let facing = |from: String, to: String, half: f32| {
            format!(
                r#"<transform name="to_world"><scale value="{half}"/><lookat origin="{from}" target="{to}" up="0, 1, 0"/></transform>"#
            )
        };
        let place = format!("0, {h}, -{h}");
        let camera = facing(origin, target, HALF);
        let patch = facing(place.clone(), "0, 0, 0".into(), self.patch);
        let lamp = facing(
            format!("{right}, {}, {}", h - front, front - h),
            place,
            self.lamp_size,
        );
        format!(
            r#"<sensor type="orthographic">{camera}<film type="hdrfilm"><integer name="width" value="8"/>
            <integer name="height" value="6"/><rfilter type="box"/></film></sensor>
            <shape type="rectangle"><transform name="to_world"><scale value="{HALF}"/><rotate x="1" angle="-90"/></transform>
            <bsdf type="twosided"><bsdf type="roughconductor">{}{}</bsdf></bsdf></shape>
            <shape type="rectangle">{patch}<bsdf type="diffuse"/></shape>
            <shape type="rectangle">{lamp}<emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>{mirror}"#,
            striped("alpha", alpha),
            striped("specular_reflectance", reflectance),
        )
    }
}

#[test]
fn as_many_steps_lead_from_smooth_to_rough_as_back() {
    let mut results = Vec::new();
    for case in &CASES {
        let mut scene = scene(&case.content(), &[]);
        // Lamp, patch, floor, mirror, sensor.
        let edges = if case.is_mirrored { 4 } else { 3 };
        scene.settings.rules.max_depth = edges;
        let settings = IntegratorSettings {
            chains: weighed([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
            ..scene.settings
        };
        with_view(&scene, |view| {
            results.extend(keeps(case.name, &[STRIPES], |group| {
                VeachChains::new(view, &settings, edges, 1, group)
            }));
        });
    }
    report(results);
}
