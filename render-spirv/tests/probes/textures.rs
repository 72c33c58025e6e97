//! Texture look-ups: formats of texels, filters, what lies outside, checkerboards and scales.

use super::common::device;
use super::harness::{COUNT, assert_none, check, module};
use super::kernel_common::Random;
use super::kernel_common::tables::{Owned, texture};
use super::random::uniform;
use bytemuck::Zeroable;
use glam::Vec2;
use halflight_kernel::scene::texture::eval_uv;
use halflight_kernel::scene::*;
use halflight_spirv::interface::{Dispatch, SceneConstants, WORKGROUP, WorkItem};
use halflight_spirv::probe_runner::{EntryPoint, run_once};

/// Bitmaps of every format, filter and border, a checkerboard and a scaled texture.
fn textures(random: &mut Random) -> Owned {
    let mut owned = Owned::default();
    for filter in [filter_mode::BILINEAR, filter_mode::NEAREST] {
        for wrap in [
            wrap_mode::REPEAT,
            wrap_mode::MIRROR,
            wrap_mode::CLAMP,
            wrap_mode::ZERO,
            wrap_mode::ONE,
        ] {
            let texels: Vec<[f32; 3]> = (0..5 * 3)
                .map(|_| [random.next_1d(), random.next_1d(), 100.0 * random.next_1d()])
                .collect();
            owned.bitmap(5, &texels, filter, wrap);
        }
    }
    for format in [texel_format::RGBA8_SRGB, texel_format::RGBA8_LINEAR] {
        let mut bytes = texture(texture_kind::BITMAP);
        let first = owned.texels.len() as u32;
        bytes.data = [
            first,
            4,
            4,
            format,
            filter_mode::BILINEAR,
            wrap_mode::REPEAT,
        ];
        bytes.to_uv = [2.0, 0.5, 0.1, -0.3, 1.5, 0.0];
        owned.texels.extend((0..16).map(|_| random.bits() as u32));
        owned.textures.push(bytes);
    }
    let mut board = texture(texture_kind::CHECKERBOARD);
    board.color0 = RgbParameter::constant([0.1, 0.2, 0.3]);
    board.color1 = RgbParameter::textured(0);
    owned.textures.push(board);
    let mut scale = texture(texture_kind::SCALE);
    scale.color0 = RgbParameter {
        value: [2.0, 3.0, 4.0],
        texture: 11,
    };
    owned.textures.push(scale);
    // The linear values of sRGB bytes.
    owned.data = (0..256u16)
        .map(|i| (f32::from(i) / 255.0).powf(2.2))
        .collect();
    owned
}

#[test]
fn textures_agree() {
    let Some(device) = device() else { return };
    let mut random = Random(501);
    let owned = textures(&mut random);
    let kinds = owned.textures.len();
    let edges = [0.0, 1.0, -1.0, 0.5, 0.2, 1e-7, 0.999_999_94, 37.6, -3.3];
    let uvs: Vec<[f32; 2]> = (0..COUNT * kinds)
        .map(|_| {
            [
                uniform(&mut random, &edges, -0.1, 1.1),
                uniform(&mut random, &edges, -0.1, 1.1),
            ]
        })
        .collect();
    let items: Vec<WorkItem> = (0..uvs.len() as u32)
        .map(|slot| WorkItem {
            slot,
            ..WorkItem::zeroed()
        })
        .collect();
    let constants = [SceneConstants::zeroed()];
    // By binding; what textures do not read is empty.
    let mut tables: Vec<&[u8]> = vec![&[]; 19];
    tables[2] = bytemuck::cast_slice(&uvs);
    tables[11] = bytemuck::cast_slice(&owned.textures);
    tables[12] = bytemuck::cast_slice(&owned.texels);
    tables[13] = bytemuck::cast_slice(&owned.data);
    tables[17] = bytemuck::cast_slice(&constants);
    tables[18] = bytemuck::cast_slice(&items);
    let dispatch = Dispatch {
        count: uvs.len() as u32,
        ..Dispatch::default()
    };
    let results: Vec<[f32; 4]> = run_once(
        &device,
        EntryPoint {
            module: &module(),
            name: c"probe_texture::textures",
        },
        &tables,
        &dispatch,
        dispatch.count.div_ceil(WORKGROUP),
        uvs.len(),
    )
    .expect("a run");
    let tables = owned.tables();
    let mut failures = Vec::new();
    for kind in 0..kinds {
        let of_kind = |i: &usize| i % kinds == kind;
        let inputs: Vec<[f32; 2]> = (0..uvs.len()).filter(of_kind).map(|i| uvs[i]).collect();
        let device: Vec<[f32; 4]> = (0..uvs.len()).filter(of_kind).map(|i| results[i]).collect();
        failures.extend(check("texture", &inputs, &device, |uv| {
            let colour = eval_uv(&tables, kind as u32, Vec2::from(*uv));
            [colour.x, colour.y, colour.z, 0.0]
        }));
    }
    assert_none(&failures);
}
