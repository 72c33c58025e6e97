//! Textures and frame maps against an independent renderer, and the kinds that it does not have.

mod common;

use common::oracle::relative_error;
use common::tables::{Owned, lobe_record, point, texture};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::frame_map::perturbed_frame;
use halflight_kernel::bsdf::{Bsdf, mode};
use halflight_kernel::math::{Frame, luminance};
use halflight_kernel::scene::texture::{eval_gradient, eval_rgb, eval_scalar, eval_uv};
use halflight_kernel::scene::*;
use proptest::prelude::*;

const IMAGE: [[f32; 3]; 6] = [
    [0.1, 0.2, 0.3],
    [0.9, 0.4, 0.05],
    [0.3, 0.8, 0.6],
    [0.7, 0.15, 0.45],
    [0.25, 0.55, 0.95],
    [0.02, 0.6, 0.33],
];
const TO_UV: [f32; 6] = [1.7320508, -1.5, -0.126_794_93, 1.0, 2.598076, 0.619_615_26];

fn lines(text: &str) -> Vec<Vec<&str>> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| line.split(',').collect())
        .collect()
}

#[test]
fn lookups_match_the_reference() {
    for row in lines(include_str!("oracle/mitsuba/texture.csv")) {
        let v: Vec<f32> = row[2..].iter().map(|x| x.parse().unwrap()).collect();
        let wrap = match row[1] {
            "repeat" => wrap_mode::REPEAT,
            "mirror" => wrap_mode::MIRROR,
            "clamp" => wrap_mode::CLAMP,
            other => panic!("{other}"),
        };
        let filter = if row[0] == "nearest" {
            filter_mode::NEAREST
        } else {
            filter_mode::BILINEAR
        };
        let mut owned = Owned::default();
        let mut index = owned.bitmap(3, &IMAGE, filter, wrap);
        if row[0] == "checkerboard" {
            let mut board = texture(texture_kind::CHECKERBOARD);
            board.color0 = RgbParameter::constant([0.4, 0.1, 0.2]);
            board.color1 = RgbParameter::constant([0.8, 0.6, 0.7]);
            owned.textures.push(board);
            index += 1;
        }
        if row[0] == "to_uv" || row[0] == "checkerboard" {
            owned.textures[index as usize].to_uv = TO_UV;
        }
        let tables = owned.tables();
        let at = point(Vec2::new(v[0], v[1]));
        let color = eval_uv(&tables, index, at.uv);
        let expected = Vec3::new(v[2], v[3], v[4]);
        assert!(
            (color - expected).abs().max_element() < 3e-6,
            "{row:?}: {color}"
        );
        if row[0] == "checkerboard" {
            continue;
        }
        let parameter = ScalarParameter {
            value: 2.0,
            texture: index,
        };
        let scalar = eval_scalar(&tables, &parameter, &at);
        assert!((scalar - 2.0 * v[5]).abs() < 1e-5, "{row:?}: {scalar}");
        let gradient = eval_gradient(&tables, index, &at);
        // The reference's gradient under a rotation is not the derivative of its value (central differences of it
        // say so, and agree with ours): there the differences are the test.
        let expected = if row[0] == "to_uv" {
            let h = 1e-3;
            let value =
                |u, v| f64::from(luminance(eval_uv(&tables, index, at.uv + Vec2::new(u, v))));
            Vec2::new(
                ((value(h, 0.0) - value(-h, 0.0)) / (2.0 * f64::from(h))) as f32,
                ((value(0.0, h) - value(0.0, -h)) / (2.0 * f64::from(h))) as f32,
            )
        } else {
            Vec2::new(v[6], v[7])
        };
        assert!(
            (gradient - expected).abs().max_element() < 3e-3,
            "{row:?}: {gradient} {expected}"
        );
    }
}

#[test]
fn frame_maps_match_the_reference() {
    let mut rows = 0;
    for row in lines(include_str!("oracle/mitsuba/frame_maps.csv")) {
        let v: Vec<f32> = row[2..].iter().map(|x| x.parse().unwrap()).collect();
        let mut owned = Owned::default();
        let normals = [
            [0.7, 0.6, 0.9],
            [0.4, 0.55, 0.8],
            [0.3, 0.7, 0.95],
            [0.8, 0.2, 0.6],
        ];
        let heights = [
            0.417, 0.720, 0.0, 0.302, 0.147, 0.092, 0.186, 0.346, 0.397, 0.539, 0.419, 0.685,
        ];
        let (kind, map) = if row[0] == "normal" {
            let map = owned.bitmap(2, &normals, filter_mode::BILINEAR, wrap_mode::REPEAT);
            (frame_map_kind::NORMAL, map)
        } else {
            let texels = heights.map(|h| [h; 3]);
            let map = owned.bitmap(4, &texels, filter_mode::BILINEAR, wrap_mode::REPEAT);
            (frame_map_kind::BUMP, map)
        };
        owned.frame_maps.push(FrameMap {
            kind,
            texture: map,
            scale: 0.3,
            parent: NONE,
        });
        let mut record = lobe_record(if row[1] == "diffuse" {
            lobe_kind::DIFFUSE
        } else {
            lobe_kind::ROUGH_CONDUCTOR
        });
        record.frame = 0;
        // Reflects everything at every angle.
        record.eta = RgbParameter::constant([0.0; 3]);
        record.k = RgbParameter::constant([1.0; 3]);
        record.alpha_u = ScalarParameter::constant(0.15);
        record.alpha_v = ScalarParameter::constant(0.6);
        owned.lobes.push(record);
        owned.materials.push(Material {
            first_lobe: 0,
            lobe_count: 1,
            flags: 0,
        });
        let mut at = point(Vec2::new(v[0], v[1]));
        at.dp_du = Vec3::new(1.3, 0.4, 0.2);
        at.dp_dv = Vec3::new(-0.2, 0.9, 0.1);
        at.frame = Frame::from_normal_tangent(Vec3::new(0.1, 0.2, 0.9).normalize(), at.dp_du);
        at.geometric_normal = Vec3::new(0.0, 0.1, 1.0).normalize();
        if row[1] == "conductor" {
            // The reference takes the tangent in world space against the normal in local space: only where both spaces
            // are one does it turn anisotropic lobes as it should.
            at.dp_du = Vec3::new(1.3, 0.0, 0.2);
            at.frame = Frame::LOCAL;
            at.geometric_normal = Vec3::Z;
        }
        let (wi, wo) = (Vec3::new(v[2], v[3], v[4]), Vec3::new(v[5], v[6], v[7]));
        let bsdf = Bsdf::at(&owned.tables(), &at, wi, mode::RADIANCE);
        let (f, p) = bsdf.eval_cosine_pdf(&[], wi, wo);
        // Near the horizons of both normals f32 cosines of a few 1e-4 lose digits.
        let error = relative_error(f.x, v[8], 1e-2).max(relative_error(p, v[9], 1e-2));
        assert!(error < 2e-5, "{row:?}: {f} {p}, relative error {error}");
        rows += 1;
    }
    assert_eq!(rows, 160);
}

#[test]
fn outside_modes_of_the_older_format() {
    for (wrap, outside) in [(wrap_mode::ZERO, 0.0), (wrap_mode::ONE, 1.0)] {
        let mut owned = Owned::default();
        let index = owned.bitmap(3, &IMAGE, filter_mode::NEAREST, wrap);
        let tables = owned.tables();
        for uv in [(-0.1, 0.5), (1.1, 0.5), (0.5, -3.0), (0.5, 1e9)] {
            assert_eq!(
                eval_uv(&tables, index, Vec2::from(uv)),
                Vec3::splat(outside)
            );
        }
        let inside = eval_uv(&tables, index, Vec2::new(0.5, 0.25));
        assert_eq!(inside, Vec3::from(IMAGE[1]));
    }
}

#[test]
fn bytes_are_decoded() {
    let mut owned = Owned {
        texels: vec![0xff_80_40_20],
        data: (0..256).map(|i| (i as f32 / 255.0).powf(2.2)).collect(),
        ..Owned::default()
    };
    for (format, decode) in [
        (texel_format::RGBA8_LINEAR, 1.0),
        (texel_format::RGBA8_SRGB, 2.2),
    ] {
        let mut bytes = texture(texture_kind::BITMAP);
        bytes.data = [0, 1, 1, format, filter_mode::BILINEAR, wrap_mode::REPEAT];
        owned.textures = vec![bytes];
        let color = eval_uv(&owned.tables(), 0, Vec2::new(0.3, 0.8));
        let expected = Vec3::new(32.0, 64.0, 128.0) / 255.0;
        let expected = expected.map(|x| x.powf(decode));
        assert!((color - expected).abs().max_element() < 1e-6, "{color}");
    }
}

#[test]
fn scales_and_boards_nest() {
    let mut owned = Owned::default();
    let image = owned.bitmap(3, &IMAGE, filter_mode::NEAREST, wrap_mode::REPEAT);
    let mut scale = texture(texture_kind::SCALE);
    scale.color0 = RgbParameter {
        value: [2.0, 3.0, 4.0],
        texture: image,
    };
    let mut board = texture(texture_kind::CHECKERBOARD);
    board.color0 = RgbParameter::textured(1);
    board.color1 = RgbParameter::constant([0.25; 3]);
    owned.textures.extend([scale, board]);
    let tables = owned.tables();
    let parameter = RgbParameter {
        value: [1.0, 1.0, 0.5],
        texture: 2,
    };
    let even = eval_rgb(&tables, &parameter, &point(Vec2::new(0.1, 0.1)));
    assert!(
        (even - Vec3::new(0.2, 0.6, 0.6)).abs().max_element() < 1e-6,
        "{even}"
    );
    let odd = eval_rgb(&tables, &parameter, &point(Vec2::new(0.6, 0.1)));
    assert!(
        (odd - Vec3::new(0.25, 0.25, 0.125)).abs().max_element() < 1e-6,
        "{odd}"
    );
    // A texture that contains itself ends.
    owned.textures[1].color0.texture = 1;
    assert_eq!(eval_uv(&owned.tables(), 1, Vec2::ZERO), Vec3::ZERO);
}

#[test]
fn mesh_attributes_follow_the_triangle() {
    let mut owned = Owned {
        triangles: vec![
            Triangle {
                vertices: [7, 8, 9],
                shape: 0,
            },
            Triangle {
                vertices: [9, 8, 10],
                shape: 0,
            },
        ],
        // Vertex colours of vertices 7 to 10 from word 1, face values from word 13.
        data: vec![
            -1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.5, 0.5, 3.0, 4.0,
        ],
        ..Owned::default()
    };
    let mut vertex = texture(texture_kind::VERTEX_ATTRIBUTE);
    vertex.data = [1, 3, 7, 0, 0, 0];
    let mut face = texture(texture_kind::FACE_ATTRIBUTE);
    face.data = [13, 1, 0, 0, 0, 0];
    owned.textures = vec![vertex, face];
    let tables = owned.tables();
    let mut at = point(Vec2::ZERO);
    at.primitive = 1;
    at.barycentric = Vec2::new(0.25, 0.5);
    let color = eval_rgb(&tables, &RgbParameter::textured(0), &at);
    assert_eq!(color, Vec3::new(0.25, 0.5, 0.5));
    assert_eq!(
        eval_rgb(&tables, &RgbParameter::textured(1), &at),
        Vec3::splat(4.0)
    );
    // Off the mesh there is no attribute.
    assert_eq!(eval_uv(&tables, 0, Vec2::ZERO), Vec3::ZERO);
}

#[test]
fn materials_are_looked_up() {
    let mut owned = Owned::default();
    let mask = owned.bitmap(1, &[[0.25; 3]], filter_mode::NEAREST, wrap_mode::REPEAT);
    let parameter = ScalarParameter {
        value: 1.0,
        texture: mask,
    };
    owned.factors = vec![
        WeightFactor {
            parameter,
            complement: 0,
        },
        WeightFactor {
            parameter,
            complement: 1,
        },
        WeightFactor {
            parameter: ScalarParameter::constant(0.4),
            complement: 0,
        },
    ];
    let mut hole = lobe_record(lobe_kind::NULL);
    (hole.first_factor, hole.factor_count) = (1, 1);
    let mut front = lobe_record(lobe_kind::DIFFUSE);
    (front.first_factor, front.factor_count) = (0, 1);
    let mut back = lobe_record(lobe_kind::DIFFUSE);
    (back.first_factor, back.factor_count) = (1, 2);
    back.flags = lobe_flag::BACK | lobe_flag::FLIP_BACK;
    back.reflectance = RgbParameter::constant([0.5; 3]);
    owned.lobes = vec![hole, front, back];
    owned.materials = vec![Material {
        first_lobe: 0,
        lobe_count: 3,
        flags: material_flag::HAS_NULL,
    }];
    let tables = owned.tables();
    let at = point(Vec2::ZERO);

    let above = Bsdf::at(&tables, &at, Vec3::Z, mode::RADIANCE);
    assert_eq!(above.lobe_count(), 2);
    assert_eq!(above.null_transmittance(), Vec3::splat(0.75));
    let pi = std::f32::consts::PI;
    let f = above.eval_cosine(&[], Vec3::Z, Vec3::Z).x;
    assert!((f - 0.25 / pi).abs() < 1e-6, "{f}");
    assert!(above.has_smooth() && above.has_delta());
    assert_eq!(above.selection(0) + above.selection(1), 1.0);

    let below = Bsdf::at(&tables, &at, -Vec3::Z, mode::RADIANCE);
    let f = below.eval_cosine(&[], -Vec3::Z, -Vec3::Z).x;
    assert!((f - 0.75 * 0.4 * 0.5 / pi).abs() < 1e-6, "{f}");
    assert_eq!(below.eval_cosine(&[], -Vec3::Z, Vec3::Z), Vec3::ZERO);

    let mut nothing = at;
    nothing.material = NONE;
    let black = Bsdf::at(&tables, &nothing, Vec3::Z, mode::RADIANCE);
    assert_eq!(black.sample(&[], Vec3::Z, 0.5, Vec2::ZERO).pdf, 0.0);
}

proptest! {
    /// Every lookup is total, whatever the coordinates.
    #[test]
    fn lookups_are_total(u in prop::num::f32::ANY, v in prop::num::f32::ANY, wrap in 0_u32..5, filter in 0_u32..2) {
        let mut owned = Owned::default();
        let index = owned.bitmap(3, &IMAGE, filter, wrap);
        let color = eval_uv(&owned.tables(), index, Vec2::new(u, v));
        prop_assert!(color.min_element() >= -1e-6 && color.max_element() <= 1.0 + 1e-6, "{color}");
        let gradient = eval_gradient(&owned.tables(), index, &point(Vec2::new(u, v)));
        prop_assert!(gradient.is_finite());
    }

    /// A perturbed frame is orthonormal, on the side of the surface's normal and visible from wi.
    #[test]
    fn perturbed_frames_are_orthonormal(
        heights in prop::array::uniform6(0.0_f32..1.0), u in 0.0_f32..1.0, v in 0.0_f32..1.0,
        scale in -10.0_f32..10.0, x in -1.0_f32..1.0, y in -1.0_f32..1.0,
    ) {
        let mut owned = Owned::default();
        let texels = heights.map(|h| [h; 3]);
        let bump = owned.bitmap(3, &texels, filter_mode::BILINEAR, wrap_mode::REPEAT);
        let normal = owned.bitmap(3, &IMAGE, filter_mode::BILINEAR, wrap_mode::REPEAT);
        owned.frame_maps = vec![
            FrameMap { kind: frame_map_kind::NORMAL, texture: normal, scale: 1.0, parent: NONE },
            FrameMap { kind: frame_map_kind::BUMP, texture: bump, scale, parent: 0 },
        ];
        let wi = Vec3::new(x, y, 0.4).normalize();
        let at = point(Vec2::new(u, v));
        let frame = perturbed_frame(&owned.tables(), 1, &at, wi);
        for (a, b) in [(frame.s, frame.t), (frame.t, frame.n), (frame.n, frame.s)] {
            prop_assert!(a.dot(b).abs() < 1e-5 && (a.length() - 1.0).abs() < 1e-5);
        }
        prop_assert!((frame.s.cross(frame.t) - frame.n).length() < 1e-5);
        let one = perturbed_frame(&owned.tables(), 0, &at, wi);
        // The outer map keeps the side of wi; the inner one does so in the frame of the outer.
        prop_assert!(one.n.dot(wi) * wi.z >= -1e-6 || one.n.z < 0.0);
        prop_assert!(frame.n.dot(wi) * one.n.dot(wi) >= -1e-6);
    }
}
