//! Host and device find every field of every record at the same place.

mod common;

use common::device;
use halflight_spirv::module::{self, MODULES};
use halflight_spirv::probe::layout::{PATTERN, host};
use halflight_spirv::probe_runner::{EntryPoint, run_once};
use std::ffi::CStr;
use std::path::Path;

type Fields = Vec<(&'static str, &'static str, u32)>;

/// The entry point reads the fields of the second of two records, in the order of `records`.
fn compare(entry: &CStr, records: &[Fields], sizes: &[usize]) {
    let Some(device) = device() else { return };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let probes = MODULES
        .iter()
        .find(|m| m.name == "probes")
        .expect("a module");
    let words = module::words_of(&std::fs::read(probes.path(&root)).expect("a file"));
    let tables: Vec<Vec<u8>> = sizes
        .iter()
        .map(|size| {
            (0..2 * size / 4)
                .flat_map(|i| (PATTERN + i as u32).to_le_bytes())
                .collect()
        })
        .collect();
    let tables: Vec<&[u8]> = tables.iter().map(Vec::as_slice).collect();
    let fields: Fields = records.iter().flatten().copied().collect();
    let entry = EntryPoint {
        module: &words,
        name: entry,
    };
    let found: Vec<u32> = run_once(&device, entry, &tables, &(), 1, fields.len()).expect("a run");
    for ((record, field, word), found) in fields.iter().zip(found) {
        assert_eq!(
            found.wrapping_sub(PATTERN),
            *word,
            "{record}.{field}: the device reads another word of the second record than the host writes"
        );
    }
}

macro_rules! sizes {
    ($($record:ty),*) => { [$(size_of::<$record>()),*] };
}

#[test]
fn scene_tables_have_one_layout() {
    use halflight_kernel::scene::*;
    compare(
        c"probe::layout_tables",
        &[
            host::triangle(),
            host::quadric(),
            host::shape(),
            host::instance(),
            host::material(),
            host::lobe(),
            host::factor(),
            host::frame_map(),
            host::texture(),
            host::emitter(),
            host::node(),
        ],
        &sizes!(
            Triangle,
            Quadric,
            Shape,
            Instance,
            Material,
            LobeRecord,
            WeightFactor,
            FrameMap,
            Texture,
            Emitter,
            BvhNode
        ),
    );
}

#[test]
fn everything_else_has_one_layout() {
    use halflight_kernel::scene::*;
    use halflight_kernel::transport::IntegratorSettings;
    use halflight_spirv::interface::{Dispatch, SceneConstants, WorkItem};
    compare(
        c"probe::layout_parts",
        &[
            host::camera(),
            host::info(),
            host::settings(),
            host::constants(),
            host::item(),
            host::dispatch(),
            host::rgb(),
            host::scalar(),
            host::coat(),
        ],
        &sizes!(
            Camera,
            SceneInfo,
            IntegratorSettings,
            SceneConstants,
            WorkItem,
            Dispatch,
            RgbParameter,
            ScalarParameter,
            CoatRecord
        ),
    );
}
