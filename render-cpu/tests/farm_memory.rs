//! Thousands of tasks merge in the memory of a few films.

use halflight::farm::folder::Folder;
use halflight::farm::merge::merge_all;
use halflight::farm::plan::{Division, Plan, PlannedScene, Request};
use halflight::farm::record::{Record, record_file};
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSet};
use halflight::film::checkpoint::{Progress, write_checkpoint};
use halflight::image::read_exr;
use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts what is allocated, and the most at a time.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const SCENE: &str = r#"<scene version="3.0.0">
    <sensor type="perspective"><float name="fov" value="45"/>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film></sensor>
    <emitter type="constant"/>
</scene>"#;

/// The film that a task would have rendered: one sample per pixel, of the value `task mod 7`.
fn simulate(folder: &Folder, plan: &Plan, task: u32) {
    let mut film = Film::new(16, 16, [0; 2], plan.aovs().expect("layers")).expect("a film");
    for y in 0..16 {
        for x in 0..16 {
            let value = glam::Vec3::splat((task % 7) as f32);
            film.pixel_mut(x, y).add_sample(value);
        }
    }
    let progress = Progress {
        settings: plan.settings_of(plan.share(task)),
        passes: 1,
        next_sample: 1,
        render_seconds: 0.001,
    };
    // Not atomically: nothing reads it meanwhile, and thousands of flushes take long.
    let mut bytes = Vec::new();
    write_checkpoint(&mut bytes, &progress, &film).expect("a checkpoint");
    let path = folder.film(0, task);
    fs::write(&path, &bytes).expect("a writable folder");
    let record = Record {
        sha256: sha256(&bytes),
        bytes: bytes.len() as u64,
        samples: 1,
        seconds: 0.001,
        inputs: Vec::new(),
    };
    let text = serde_json::to_vec(&record).expect("a record");
    fs::write(record_file(&path), text).expect("a writable folder");
}

fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest;
    let digest = sha2::Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Bytes at most held by a merge of `tasks` simulated tasks beyond what was held before; checks the image.
fn most_held(folder: &Path, tasks: u32) -> usize {
    let scene = folder.join("scene.xml");
    fs::write(&scene, SCENE).expect("a writable folder");
    let request = Request {
        output: folder.join(format!("{tasks}.exr")),
        tasks,
        spp: Some(tasks),
        seed: None,
        division: Division::Samples,
        layers: AovSet::NONE.with(Aov::Samples),
        fan_in: 32,
    };
    let planned = PlannedScene {
        file: scene,
        ..PlannedScene::default()
    };
    let plan = Plan::new(planned, &request).expect("a plan");
    let farm = Folder::of_output(&plan.output);
    farm.create(&plan).expect("a folder");
    for task in 0..tasks {
        simulate(&farm, &plan, task);
    }
    let before = HELD.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    merge_all(&farm, &plan).expect("a merge");
    let most = MOST.load(Ordering::Relaxed) - before;

    let image = read_exr(&plan.output).expect("the image");
    let sum: u32 = (0..tasks).map(|task| task % 7).sum();
    let mean = (f64::from(sum) / f64::from(tasks)) as f32;
    assert!(
        image
            .channel("G")
            .expect("green")
            .iter()
            .all(|&v| v == mean)
    );
    let samples = image.channel("samples").expect("samples");
    assert!(samples.iter().all(|&n| n == tasks as f32));
    most
}

/// Run it with `cargo test --release --test farm_memory -- --ignored --nocapture`.
#[test]
#[ignore = "prints the table of docs/farm.md"]
fn table_of_time_and_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    println!("tasks, most bytes held by the merge, seconds with the simulation, bytes on the disk");
    for tasks in [10, 100, 1000, 2000, 10_000] {
        let start = std::time::Instant::now();
        let most = most_held(folder.path(), tasks);
        let farm = Folder(folder.path().join(format!("{tasks}.farm")));
        let levels = farm.plan().expect("a plan").levels();
        let on_disk: u64 = (0..levels.len())
            .flat_map(|level| fs::read_dir(farm.level(level)).expect("a level"))
            .map(|file| file.and_then(|f| f.metadata()).map_or(0, |m| m.len()))
            .sum();
        let seconds = start.elapsed().as_secs_f64();
        println!("{tasks}, {most}, {seconds:.2}, {on_disk}");
    }
}

#[test]
fn two_thousand_tasks_merge_in_the_memory_of_forty() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // What is allocated once, by the first file that is written for instance, is none of the tree's.
    most_held(folder.path(), 8);
    let few = most_held(folder.path(), 40);
    let many = most_held(folder.path(), 2000);
    // Buffers of threads come and go, a few hundred kilobytes of them; a film is 16 KB, 2000 of them would be 33 MB.
    assert!(
        many < few + 512 * 1024,
        "{many} bytes for 2000 tasks, {few} for 40"
    );
}
