//! What the tasks of a farm make together.

use super::{Place, channels, render};
use halflight::accel::Accel;
use halflight::farm::FarmError;
use halflight::farm::folder::Folder;
use halflight::farm::merge::{merge_all, merge_node};
use halflight::farm::plan::{Division, Plan, PlannedScene, Request};
use halflight::farm::status::Status;
use halflight::farm::task::TaskOutcome;
use halflight::film::Film;
use halflight::image::exr_output::{ChannelValues, LayeredImage};
use halflight::image::metadata::ImageMetadata;
use halflight::image::read_exr;
use halflight::render::{NoObserver, RunState};
use std::sync::atomic::AtomicBool;

/// The image of one run with all samples of a plan, as floats by channel.
fn one_run(plan: &Plan) -> Vec<(String, Vec<f32>)> {
    let scene = plan.scene.load().expect("the scene");
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let mut whole = plan.share(0);
    whole.count = plan.spp;
    let [width, height] = scene.tables.camera.crop_size;
    let mut film = Film::new(width, height, [0; 2], plan.aovs().expect("layers")).expect("a film");
    halflight::render::render(
        &scene,
        &accel,
        &plan.options(whole),
        &mut film,
        &mut RunState::default(),
        &AtomicBool::new(false),
        &mut NoObserver,
    )
    .expect("a render");
    let metadata = ImageMetadata {
        samples_per_pixel: film.even_samples(),
        ..ImageMetadata::default()
    };
    let image = LayeredImage::from_film(&film, plan.full_size, metadata);
    let mut channels: Vec<_> = image
        .channels
        .into_iter()
        .map(|(name, values)| match values {
            ChannelValues::Float(v) | ChannelValues::Colour(v) => (name, v),
            ChannelValues::Count(v) => (name, v.into_iter().map(|n| n as f32).collect()),
        })
        .collect();
    channels.sort_by(|a, b| a.0.cmp(&b.0));
    channels
}

/// Films hold running means in f64, whose rounding depends on where a film ends: few parts in 1e16. Where that decides how a
/// mean is rounded to f32, a channel differs by its last bit.
fn assert_same_but_rounding(name: &str, values: &[f32], wanted: &[f32]) {
    let mut differing = 0;
    for (i, (&value, &wanted)) in values.iter().zip(wanted).enumerate() {
        let steps = i64::from(value.to_bits()) - i64::from(wanted.to_bits());
        assert!(steps.abs() <= 1, "{name} at {i}: {value:e}, not {wanted:e}");
        differing += u32::from(steps != 0);
    }
    assert!(differing <= 2, "{name}: {differing} values differ");
}

#[test]
fn shares_are_all_samples_once() {
    let place = Place::with_scene();
    for (tasks, spp) in [(1, 1), (4, 21), (21, 21), (7, 1000)] {
        let request = Request {
            spp: Some(spp),
            ..place.request(tasks)
        };
        let plan = Plan::new(place.scene(), &request).expect("a plan");
        let mut next = 0;
        for task in 0..tasks {
            let share = plan.share(task);
            assert_eq!((share.first, share.seed), (next, 5));
            assert!(share.count >= spp / tasks && share.count <= spp / tasks + 1);
            next += share.count;
        }
        assert_eq!(next, spp);
    }
}

#[test]
fn levels_narrow_down_to_one_film() {
    let place = Place::with_scene();
    for (tasks, levels) in [
        (1, vec![1, 1]),
        (3, vec![3, 1]),
        (4, vec![4, 2, 1]),
        (21, vec![21, 7, 3, 1]),
    ] {
        let plan = Plan::new(place.scene(), &place.request(tasks)).expect("a plan");
        assert_eq!(plan.levels(), levels);
    }
}

#[test]
fn tasks_in_any_order_make_the_image_of_one_run() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(8));
    for task in [5, 0, 7, 2, 1, 6, 3, 4] {
        assert_eq!(render(&folder, &plan, task), TaskOutcome::Done);
    }
    merge_all(&folder, &plan).expect("a merge");
    let merged = channels(&plan.output);
    let expected = one_run(&plan);
    assert_eq!(merged.len(), expected.len());
    for ((name, values), (other, wanted)) in merged.iter().zip(&expected) {
        assert_eq!(name, other);
        assert_same_but_rounding(name, values, wanted);
    }
    let image = read_exr(&plan.output).expect("the image");
    assert_eq!(image.attribute("sampleRanges"), Some("5:0..21"));
    assert_eq!(image.attribute("spp"), Some("21"));
    assert!(plan.output.with_extension("png").exists());
}

#[test]
fn pixels_divided_make_the_image_of_one_run_to_the_bit() {
    let place = Place::with_scene();
    // 24 x 16 pixels are two tiles, one of them narrow; 70 x 40 are fifteen.
    for (size, tasks) in [([24, 16], 2), ([70, 40], 7)] {
        let request = Request {
            division: Division::Pixels,
            output: place.path(&format!("{tasks}.exr")),
            spp: Some(5),
            ..place.request(tasks)
        };
        let scene = PlannedScene {
            size: Some(size),
            ..place.scene()
        };
        let plan = Plan::new(scene, &request).expect("a plan");
        let folder = Folder::of_output(&plan.output);
        folder.create(&plan).expect("a folder");
        for task in (0..tasks).rev() {
            assert_eq!(render(&folder, &plan, task), TaskOutcome::Done);
        }
        merge_all(&folder, &plan).expect("a merge");
        assert!(channels(&plan.output) == one_run(&plan));
        let image = read_exr(&plan.output).expect("the image");
        assert_eq!(image.attribute("sampleRanges"), Some("5:0..5"));
        assert_eq!(image.attribute("spp"), Some("5"));
    }
    for (integrator, tasks, message) in [("path", 3, "2 tiles"), ("bdpt", 2, "all pixels")] {
        let scene = PlannedScene {
            integrator: Some(integrator.to_owned()),
            ..place.scene()
        };
        let request = Request {
            division: Division::Pixels,
            ..place.request(tasks)
        };
        let error = Plan::new(scene, &request).expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn splatted_light_is_divided_by_samples() {
    let place = Place::with_scene();
    let scene = PlannedScene {
        integrator: Some("bdpt".to_owned()),
        ..place.scene()
    };
    let plan = Plan::new(scene, &place.request(4)).expect("a plan");
    let folder = Folder::of_output(&plan.output);
    folder.create(&plan).expect("a folder");
    for task in 0..4 {
        render(&folder, &plan, task);
    }
    merge_all(&folder, &plan).expect("a merge");
    let expected = one_run(&plan);
    for ((name, values), (_, wanted)) in channels(&plan.output).iter().zip(&expected) {
        assert_same_but_rounding(name, values, wanted);
    }
}

#[test]
fn nodes_by_themselves_make_the_same_image() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(7));
    for task in 0..7 {
        render(&folder, &plan, task);
    }
    merge_all(&folder, &plan).expect("a merge");
    let together = channels(&plan.output);
    for level in 1..plan.levels().len() {
        std::fs::remove_dir_all(folder.level(level)).expect("a folder of the merge");
        std::fs::create_dir(folder.level(level)).expect("a folder");
    }
    for (level, &count) in plan.levels().iter().enumerate().skip(1) {
        for node in (0..count).rev() {
            merge_node(&folder, &plan, level, node).expect("a node");
        }
    }
    assert!(together == channels(&plan.output));
    let outside = merge_node(&folder, &plan, 1, 3);
    assert!(matches!(outside, Err(FarmError::Request(_))), "{outside:?}");
}

#[test]
fn seeds_of_their_own_average() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&Request {
        division: Division::Seeds,
        spp: Some(12),
        ..place.request(3)
    });
    for task in 0..3 {
        render(&folder, &plan, task);
    }
    merge_all(&folder, &plan).expect("a merge");
    let image = read_exr(&plan.output).expect("the image");
    assert_eq!(
        image.attribute("sampleRanges"),
        Some("5:0..4 6:0..4 7:0..4")
    );
    let red = image.channel("R").expect("red");
    let runs: Vec<_> = (5..8)
        .map(|seed| {
            let request = Request {
                seed: Some(seed),
                spp: Some(4),
                ..place.request(1)
            };
            let plan = Plan::new(place.scene(), &request).expect("a plan");
            let channels = one_run(&plan);
            channels.into_iter().find(|c| c.0 == "R").expect("red").1
        })
        .collect();
    for (i, &mean) in red.iter().enumerate() {
        let expected = runs.iter().map(|run| f64::from(run[i])).sum::<f64>() / 3.0;
        assert!((f64::from(mean) - expected).abs() <= 1e-6 * expected.abs());
    }
}

#[test]
fn a_repeated_task_renews_its_ancestors_alone() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(9));
    for task in 0..9 {
        render(&folder, &plan, task);
    }
    merge_all(&folder, &plan).expect("a merge");
    let written = |level, index| {
        let metadata = std::fs::metadata(folder.film(level, index)).expect("a film");
        metadata.modified().expect("a time")
    };
    let before = [written(1, 0), written(1, 1), written(2, 0)];
    std::fs::write(folder.film(0, 4), "torn").expect("a writable film");
    let status = Status::of(&folder, &plan, false).expect("a status");
    assert!(!status.is_merged && status.open() == [4]);
    assert_eq!(render(&folder, &plan, 4), TaskOutcome::Done);
    merge_all(&folder, &plan).expect("a merge");
    assert!(
        Status::of(&folder, &plan, true)
            .expect("a status")
            .is_merged
    );
    // The time that a film takes to render is in it, so that a repeated one is another file with the same samples.
    assert_eq!(before[0], written(1, 0));
    assert!(before[1] < written(1, 1) && before[2] < written(2, 0));
}
