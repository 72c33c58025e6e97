//! Tasks that are killed, files that are torn, plans that contradict their scene.

use super::{Place, channels, render};
use halflight::farm::FarmError;
use halflight::farm::merge::merge_all;
use halflight::farm::plan::{Plan, Request};
use halflight::farm::record::{Record, record_file};
use halflight::farm::status::{Status, TaskState};
use halflight::farm::task::{TaskOutcome, run_task};
use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

#[test]
fn a_stopped_task_goes_on_to_the_same_film() {
    let place = Place::with_scene();
    let request = Request {
        spp: Some(20_000),
        ..place.request(2)
    };
    let (folder, plan) = place.farm(&request);
    let path = folder.film(0, 1);
    let stop = AtomicBool::new(false);
    let outcome = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !path.exists() {
                std::thread::sleep(Duration::from_millis(1));
            }
            stop.store(true, Ordering::Relaxed);
        });
        run_task(&folder, &plan, 1, Duration::ZERO, &stop)
    });
    assert_eq!(outcome.expect("a task"), TaskOutcome::Interrupted);
    let status = Status::of(&folder, &plan, true).expect("a status");
    assert!(
        matches!(status.tasks[1], TaskState::Started(n) if n > 0 && n < 10_000),
        "{status:?}"
    );
    assert_eq!(status.tasks[0], TaskState::Missing);
    assert_eq!(render(&folder, &plan, 1), TaskOutcome::Done);
    let resumed = Record::read(&path).expect("a record").expect("a record");
    let (_, film) = resumed.load(&path).expect("a film").expect("a sound film");

    fs::remove_file(&path).expect("the film");
    fs::remove_file(record_file(&path)).expect("the record");
    render(&folder, &plan, 1);
    let whole = Record::read(&path).expect("a record").expect("a record");
    let (_, expected) = whole.load(&path).expect("a film").expect("a sound film");
    assert!(film == expected);
}

#[test]
fn a_task_that_is_done_is_not_rendered_again() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(2));
    assert_eq!(render(&folder, &plan, 0), TaskOutcome::Done);
    let before = fs::read(folder.film(0, 0)).expect("the film");
    assert_eq!(render(&folder, &plan, 0), TaskOutcome::AlreadyDone);
    assert!(before == fs::read(folder.film(0, 0)).expect("the film"));
}

#[test]
fn a_damaged_checkpoint_is_rendered_again() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(2));
    fs::write(folder.film(0, 0), "HLFILM\r\nand then the disk was full")
        .expect("a writable folder");
    let status = Status::of(&folder, &plan, false).expect("a status");
    assert_eq!(status.tasks, [TaskState::Torn, TaskState::Missing]);
    assert_eq!(render(&folder, &plan, 0), TaskOutcome::Done);
}

#[test]
fn torn_films_are_named_and_rendered_again() {
    let expected = {
        let place = Place::with_scene();
        let (folder, plan) = place.farm(&place.request(8));
        for task in 0..8 {
            render(&folder, &plan, task);
        }
        merge_all(&folder, &plan).expect("a merge");
        channels(&plan.output)
    };
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(8));
    for task in 0..8 {
        render(&folder, &plan, task);
    }

    // Cut off: the length tells.
    let cut = folder.film(0, 2);
    let bytes = fs::read(&cut).expect("a film");
    fs::write(&cut, &bytes[..bytes.len() - 7]).expect("a writable film");
    // A byte of another value: only the digest tells.
    let changed = folder.film(0, 6);
    let mut bytes = fs::read(&changed).expect("a film");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&changed, &bytes).expect("a writable film");

    let quick = Status::of(&folder, &plan, false).expect("a status");
    assert_eq!(quick.having(|t| *t == TaskState::Torn), [2]);
    let status = Status::of(&folder, &plan, true).expect("a status");
    assert_eq!(status.having(|t| *t == TaskState::Torn), [2, 6]);

    let error = merge_all(&folder, &plan).expect_err("a torn film");
    assert!(
        error.to_string().contains("tasks/000002.checkpoint"),
        "{error}"
    );
    render(&folder, &plan, 2);
    let error = merge_all(&folder, &plan).expect_err("another torn film");
    assert!(
        error.to_string().contains("tasks/000006.checkpoint")
            && !error.to_string().contains("000002"),
        "{error}"
    );
    assert_eq!(render(&folder, &plan, 6), TaskOutcome::Done);
    merge_all(&folder, &plan).expect("a merge");
    assert!(expected == channels(&plan.output));
}

#[test]
fn a_merge_names_what_is_missing() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(6));
    render(&folder, &plan, 3);
    let error = merge_all(&folder, &plan).expect_err("missing tasks");
    assert!(
        error.to_string().starts_with("not done yet: 0-2,4-5;"),
        "{error}"
    );
    assert!(!plan.output.exists());
}

#[test]
fn another_scene_is_refused() {
    let place = Place::with_scene();
    let (folder, plan) = place.farm(&place.request(2));
    let text = super::SCENE.replace("9, 8, 7", "9, 8, 6");
    fs::write(place.path("scene.xml"), text).expect("a writable folder");
    let never = AtomicBool::new(false);
    let error =
        run_task(&folder, &plan, 0, Duration::from_secs(30), &never).expect_err("another scene");
    assert!(matches!(error, FarmError::OtherScene { .. }), "{error}");
    assert!(
        error
            .to_string()
            .contains("they differ in the content of the scene"),
        "{error}"
    );
}

#[test]
fn farms_that_make_no_sense_are_refused() {
    let place = Place::with_scene();
    for (request, message) in [
        (place.request(0), "1 to"),
        (place.request(22), "22 tasks cannot share 21 samples"),
        (
            Request {
                fan_in: 1,
                ..place.request(2)
            },
            "at least 2",
        ),
    ] {
        let error = Plan::new(place.scene(), &request).expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
    }
    let (folder, plan) = place.farm(&place.request(2));
    let other = Plan::new(place.scene(), &place.request(3)).expect("a plan");
    let error = folder.create(&other).expect_err("another plan");
    assert!(error.to_string().contains("another plan"), "{error}");
    folder.create(&plan).expect("the same plan");
    let never = AtomicBool::new(false);
    let error = run_task(&folder, &plan, 2, Duration::ZERO, &never).expect_err("no such task");
    assert!(error.to_string().contains("no task 2"), "{error}");
}
