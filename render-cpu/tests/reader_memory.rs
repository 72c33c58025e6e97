//! No reader reserves memory that the file cannot fill: peak allocation on small hostile files, by a counting allocator.

use halflight::image::{read_bitmap, read_exr_bytes};
use halflight::measured::merl::Merl;
use halflight::mesh::{obj, ply, serialized};
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, with a count of the bytes in use and their maximum.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on unchanged to the system's allocator; `realloc` and `alloc_zeroed` have defaults that
// call these two.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let in_use = IN_USE.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(in_use, Relaxed);
        // SAFETY: the caller's promises are those that the system's allocator needs.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: `pointer` came from `alloc` above with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Most bytes in use at once during `f`, beyond those in use before.
fn peak_of(f: impl FnOnce()) -> usize {
    let before = IN_USE.load(Relaxed);
    PEAK.store(before, Relaxed);
    f();
    PEAK.load(Relaxed) - before
}

fn ply(format: &str, header: &str, body: &[u8]) -> Vec<u8> {
    let mut file = format!("ply\nformat {format} 1.0\n{header}end_header\n").into_bytes();
    file.extend(body);
    file
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn serialized_file(stream: &[u8]) -> Vec<u8> {
    let mut file = vec![0x1c, 0x04, 0x04, 0x00];
    file.extend(zlib(stream));
    file.extend(0_u64.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    file
}

fn png(width: u32, height: u32) -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(name);
        crc.update(data);
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(name);
        file.extend(data);
        file.extend(crc.sum().to_be_bytes());
    };
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    header.extend([8, 6, 0, 0, 0]);
    chunk(b"IHDR", &header);
    chunk(b"IDAT", &zlib(&[0; 1000]));
    chunk(b"IEND", &[]);
    file
}

/// An OpenEXR header with one float channel of this size and tiles, followed by nothing.
fn exr(width: i32, height: i32, tile: Option<u32>) -> Vec<u8> {
    let mut file = vec![
        0x76,
        0x2f,
        0x31,
        0x01,
        2,
        if tile.is_some() { 2 } else { 0 },
        0,
        0,
    ];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        file.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
        file.extend((value.len() as u32).to_le_bytes());
        file.extend(value);
    };
    let mut channel = b"Y\0".to_vec();
    for word in [2_u32, 0, 1, 1] {
        channel.extend(word.to_le_bytes());
    }
    channel.push(0);
    let window: Vec<u8> = [0, 0, width - 1, height - 1]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    attribute("channels", "chlist", &channel);
    attribute("compression", "compression", &[3]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1_f32.to_le_bytes());
    if let Some(size) = tile {
        let tiles = [&size.to_le_bytes()[..], &size.to_le_bytes(), &[0]].concat();
        attribute("tiles", "tiledesc", &tiles);
    }
    file.extend([0; 64]);
    file
}

/// One test, for the count is of the whole process.
#[test]
fn hostile_files_reserve_little() {
    const LIMIT: usize = 4 << 20;
    // The largest numbers of cells that are taken, and larger ones, without the values.
    for cells in [[180, 180, 360], [i32::MAX; 3]] {
        let mut file: Vec<u8> = cells.iter().flat_map(|n: &i32| n.to_le_bytes()).collect();
        file.resize(4096, 0);
        let peak = peak_of(|| assert!(Merl::read(&file).is_err()));
        assert!(peak < LIMIT, "{cells:?}: {peak} bytes");
    }
    let path = Path::new("hostile.tga");
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let list = "element face 1\nproperty list uint int vertex_indices\n";
    for format in ["ascii", "binary_little_endian"] {
        for count in [1_u64 << 20, 1 << 31, u64::MAX] {
            let vertices = ply(
                format,
                &format!("element vertex {count}\n{xyz}"),
                &[b'1'; 64],
            );
            let faces = format!(
                "element vertex 1\n{xyz}element face {count}\nproperty list uint int vertex_indices\n"
            );
            let faces = ply(format, &faces, b"0 0 0 0 0 0 0 0 0 0 0 0 ");
            let mut body = b"0 0 0 4294967295 0 0 0 ".to_vec();
            if format != "ascii" {
                body = vec![0; 12];
                body.extend([0xff; 8]);
            }
            let long = ply(format, &format!("element vertex 1\n{xyz}{list}"), &body);
            for file in [vertices, faces, long] {
                let peak = peak_of(|| assert!(ply::read(&file, false, path).is_err()));
                assert!(peak < LIMIT, "{format} {count}: {peak} bytes");
            }
        }
    }
    for [vertices, triangles] in [
        [1 << 20, 1],
        [1, 1 << 20],
        [u64::MAX, u64::MAX],
        [1 << 62, 1],
    ] {
        let mut stream = 0x1000_u32.to_le_bytes().to_vec();
        stream.push(0);
        stream.extend(u64::to_le_bytes(vertices));
        stream.extend(u64::to_le_bytes(triangles));
        stream.extend([0; 100]);
        let file = serialized_file(&stream);
        let peak = peak_of(|| assert!(serialized::read(&file, 0, path).is_err()));
        assert!(peak < LIMIT, "{vertices} {triangles}: {peak} bytes");
    }
    // A bomb: a name of 64 MiB in 64 KiB.
    let mut stream = vec![b'a'; 64 << 20];
    stream[..4].fill(0);
    let file = serialized_file(&stream);
    let peak = peak_of(|| assert!(serialized::read(&file, 0, path).is_err()));
    assert!(peak < LIMIT, "bomb: {peak} bytes");

    let text = b"v 0 0 0\nf 4294967295 -2147483648 1\n";
    // The face is left out.
    let peak = peak_of(|| drop(obj::read(text, true, path)));
    assert!(peak < LIMIT, "obj: {peak} bytes");

    for (width, height) in [(9_000, 9_000), (65_535, 65_535), (1 << 30, 1)] {
        let file = png(width, height);
        let peak = peak_of(|| assert!(read_bitmap(&file, true, path).is_err()));
        assert!(peak < LIMIT, "png {width}: {peak} bytes");
    }
    for (width, height, tile) in [
        (9_000, 9_000, None),
        (60_000, 60_000, None),
        (1_000_000_000, 1, None),
        (9_000, 9_000, Some(1)),
        (9_000, 9_000, Some(1 << 16)),
        (4, 4, Some(1 << 16)),
        (4, 4, Some(1 << 30)),
    ] {
        let file = exr(width, height, tile);
        let peak = peak_of(|| assert!(read_exr_bytes(&file, path).is_err()));
        assert!(peak < LIMIT, "exr {width} {tile:?}: {peak} bytes");
    }
}
